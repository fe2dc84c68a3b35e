#pragma once
#include <signal.h>
#include <sys/resource.h>

#include <optional>

#include "cli/run_tool.h"

namespace scatmap::test {

/// Limits that the kernel sets a tool (setrlimit); unset ones are inherited.
struct Limits {
  std::optional<rlim_t> open_files, memory_bytes, file_bytes;
};

/// The tool, started and left running, so that it can be killed or limited. Without a shell, standard input empty.
class RunningTool {
 public:
  RunningTool(std::vector<std::string> arguments, const std::filesystem::path& folder, const Limits& limits = {})
      : out_(detail::make_pipe()), err_(detail::make_pipe()) {
    arguments.insert(arguments.begin(), SCATMAP_TOOL);
    std::vector<std::string> environment{"PATH=/usr/bin:/bin", "LC_ALL=C", "TMPDIR=" + (folder / "tmp").string()};
    const std::vector<char*> argv = detail::pointers(arguments), envp = detail::pointers(environment);
    child_ = fork();
    if (child_ < 0) throw std::runtime_error("fork failed");
    if (child_ == 0) become(argv.data(), envp.data(), folder.c_str(), limits);
    close(out_[1]);
    close(err_[1]);
  }
  RunningTool(const RunningTool&) = delete;
  RunningTool& operator=(const RunningTool&) = delete;
  ~RunningTool() {
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    wait();
  }

  void kill(int signal) const { ::kill(child_, signal); }

  ToolRun wait() {
    ToolRun run;
    detail::read_both(out_[0], err_[0], run);
    close(out_[0]);
    close(err_[0]);
    int ended = 0;
    while (waitpid(child_, &ended, 0) < 0 && errno == EINTR) {
    }
    child_ = 0;
    run.status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -WTERMSIG(ended);
    return run;
  }

 private:
  static void limit(int resource, const std::optional<rlim_t>& value) {
    if (!value) return;
    const rlimit both{*value, *value};
    if (setrlimit(static_cast<decltype(RLIMIT_AS)>(resource), &both) != 0) _exit(125);
  }
  // Only async-signal-safe calls: between fork and exec.
  [[noreturn]] void become(char* const* argv, char* const* envp, const char* folder, const Limits& limits) const {
    const int nothing = open("/dev/null", O_RDONLY);
    if (nothing < 0 || chdir(folder) != 0 || dup2(nothing, 0) < 0 || dup2(out_[1], 1) < 0 || dup2(err_[1], 2) < 0)
      _exit(126);
    close(nothing);
    alarm(120);
    limit(RLIMIT_NOFILE, limits.open_files);
    limit(RLIMIT_AS, limits.memory_bytes);
    limit(RLIMIT_FSIZE, limits.file_bytes);
    execve(argv[0], argv, envp);
    _exit(127);
  }

  std::array<int, 2> out_, err_;
  pid_t child_ = 0;
};

inline ToolRun run_limited(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                           const Limits& limits) {
  return RunningTool(arguments, folder, limits).wait();
}

}  // namespace scatmap::test
