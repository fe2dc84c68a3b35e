#pragma once
#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace scatmap::test {

struct ToolRun {
  int status = 0;  ///< exit status; −N: ended by signal N (−14: ran longer than kToolLimit_s)
  std::string out;
  std::string err;
};

inline constexpr unsigned kToolLimit_s = 30;

namespace detail {

inline std::array<int, 2> make_pipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  return ends;
}

// Only async-signal-safe calls: between fork and exec. The alarm outlives exec and ends a tool that hangs.
[[noreturn]] inline void become_tool(char* const* argv, char* const* environment, const char* folder, int out,
                                     int err) {
  const int nothing = open("/dev/null", O_RDONLY);
  if (nothing < 0 || chdir(folder) != 0 || dup2(nothing, 0) < 0 || dup2(out, 1) < 0 || dup2(err, 2) < 0) _exit(126);
  alarm(kToolLimit_s);
  execve(argv[0], argv, environment);
  _exit(127);
}

// Both streams together: reading one after the other would block a tool that fills the second.
inline void read_both(int out, int err, ToolRun& run) {
  std::array<pollfd, 2> streams{pollfd{out, POLLIN, 0}, pollfd{err, POLLIN, 0}};
  std::array<char, 4096> buffer{};
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    if (poll(streams.data(), streams.size(), -1) < 0 && errno != EINTR) throw std::runtime_error("poll failed");
    for (std::size_t i = 0; i < streams.size(); ++i) {
      if (streams[i].fd < 0 || streams[i].revents == 0) continue;
      const ssize_t n = read(streams[i].fd, buffer.data(), buffer.size());
      if (n > 0) {
        (i == 0 ? run.out : run.err).append(buffer.data(), static_cast<std::size_t>(n));
      } else if (n == 0 || errno != EINTR) {
        streams[i].fd = -1;
      }
    }
  }
}

inline std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (std::string& t : texts) out.push_back(t.data());
  out.push_back(nullptr);
  return out;
}

}  // namespace detail

/// Runs the tool under test with these arguments in `folder`, without a shell and with empty standard input; its
/// temporary files go to `folder`/tmp.
inline ToolRun run_tool(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  std::vector<std::string> command{SCATMAP_TOOL};
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::vector<std::string> environment{"PATH=/usr/bin:/bin", "LC_ALL=C", "TMPDIR=" + (folder / "tmp").string()};
  const std::vector<char*> argv = detail::pointers(command), envp = detail::pointers(environment);
  const auto out = detail::make_pipe(), err = detail::make_pipe();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) detail::become_tool(argv.data(), envp.data(), folder.c_str(), out[1], err[1]);
  close(out[1]);
  close(err[1]);
  ToolRun run;
  detail::read_both(out[0], err[0], run);
  close(out[0]);
  close(err[0]);
  int ended = 0;
  while (waitpid(child, &ended, 0) < 0 && errno == EINTR) {
  }
  run.status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -WTERMSIG(ended);
  return run;
}

}  // namespace scatmap::test
