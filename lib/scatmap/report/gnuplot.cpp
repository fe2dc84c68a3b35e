#include "scatmap/report/gnuplot.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <sstream>
#include <system_error>

#include "scatmap/base/error.h"
#include "scatmap/base/temporary_folder.h"

namespace scatmap {
namespace fs = std::filesystem;
namespace {

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

fs::path find_gnuplot() {
  const char* folders = std::getenv("PATH");
  std::istringstream list(folders ? folders : "");
  for (std::string folder; std::getline(list, folder, ':');) {
    const fs::path program = fs::path(folder) / "gnuplot";
    std::error_code ignored;
    if (!folder.empty() && fs::is_regular_file(program, ignored) && access(program.c_str(), X_OK) == 0) return program;
  }
  throw Error({"gnuplot", "is not installed, and pictures are made with it", {}, "the package gnuplot-nox"});
}

// Exit status of `gnuplot -d script` in the folder; -d keeps a user's start-up file out. Standard error goes to a file.
int run(const fs::path& program, const fs::path& folder, const std::string& script, const fs::path& messages) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  std::string name = "gnuplot", defaults = "-d", file = script;
  char* const arguments[] = {name.data(), defaults.data(), file.data(), nullptr};
  pid_t child = 0;
  // scatmap may have signals blocked to end in order; gnuplot must hear them.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  const int failed = posix_spawn(&child, program.c_str(), &actions, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw Error({program.string(), std::string("cannot be started: ") + std::strerror(failed), {}, {}});
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) throw Error({program.string(), std::string("was lost: ") + std::strerror(errno), {}, {}});
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// gnuplot prints the command, a caret under the place and then `"FILE" line N: what is wrong`.
std::string first_message(const fs::path& messages) {
  std::istringstream text(read_text_file(messages));
  std::string first;
  for (std::string line; std::getline(text, line);) {
    const std::size_t at = line.find("line ");
    const std::size_t colon = at == std::string::npos ? at : line.find(": ", at);
    if (colon != std::string::npos) return line.substr(at);
    if (first.empty() && line.find_first_not_of(" \t^") != std::string::npos) first = line;
  }
  return first.empty() ? "no message" : first;
}

std::string terminal(const fs::path& target, const Plot& plot) {
  const std::string extension = target.extension().string();
  const std::string size = " size " + std::to_string(plot.width_px) + "," + std::to_string(plot.height_px);
  if (extension == ".png") return "pngcairo" + size + " enhanced font 'Sans,12' background '#ffffff'";
  if (extension == ".svg") return "svg" + size + " enhanced font 'Sans,15' background '#ffffff'";
  throw Error({target.string(), "names no picture format", "extension '" + extension + "'", ".png or .svg"});
}

// Names are written with "./" so that none begins with a character that gnuplot takes for a pipe.
std::string whole_script(const fs::path& target, const Plot& plot, const fs::path& data_name) {
  std::string text = "# Makes the picture of the same name: run gnuplot on this file in its folder.\n";
  text += "set encoding utf8\ndata = " + gnuplot_text("./" + data_name.string()) + "\n";
  text += "set terminal " + terminal(target, plot) + "\n";
  text += "set output " + gnuplot_text("./" + target.filename().string()) + "\n";
  return text + plot.script + "\nunset output\n";
}

void copy_to(const fs::path& from, const OutputFile& to) {
  std::error_code failed;
  fs::copy_file(from, to.temporary(), failed);
  if (failed) throw Error({to.target().string(), "cannot be written: " + failed.message(), {}, {}});
}

}  // namespace

std::string gnuplot_text(std::string_view text) {
  constexpr std::string_view kPlain = " .,;:()+-*/=_%";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    const bool plain = u >= 0x80 || std::isalnum(u) || kPlain.find(c) != std::string_view::npos;
    if (plain) {
      quoted += c;
    } else if (is_control(c)) {
      quoted += ' ';
    } else {
      quoted +=
          {'\\', static_cast<char>('0' + u / 64), static_cast<char>('0' + u / 8 % 8), static_cast<char>('0' + u % 8)};
    }
  }
  return quoted + "\"";
}

void write_picture(const Plot& plot, const fs::path& target, const PictureOptions& options) {
  const std::string name = target.filename().string();
  if (std::any_of(name.begin(), name.end(), is_control)) {
    throw Error({target.string(), "a picture's name must not hold control characters", {}, {}});
  }
  const fs::path data_name = target.stem().string() + ".dat", script_name = target.stem().string() + ".gp";
  const std::string script = whole_script(target, plot, data_name);
  OutputFile picture(target, options.overwrite);
  std::optional<OutputFile> kept_script, kept_data;
  if (options.keep_script) {
    kept_script.emplace(fs::path(target).replace_filename(script_name), options.overwrite);
    kept_data.emplace(fs::path(target).replace_filename(data_name), options.overwrite);
  }

  const fs::path program = find_gnuplot();
  const TemporaryFolder folder(fs::temp_directory_path(), target.string());
  write_text_file(folder.path() / data_name, plot.data, Overwrite::kKeep);
  write_text_file(folder.path() / "script", script, Overwrite::kKeep);
  const fs::path messages = folder.path() / "messages";
  const int status = run(program, folder.path(), "script", messages);
  std::error_code ignored;
  const fs::path made = folder.path() / name;
  if (status != 0 || !fs::exists(made, ignored) || fs::file_size(made, ignored) == 0) {
    throw Error({target.string(), "gnuplot failed: " + first_message(messages), {}, {}});
  }

  copy_to(made, picture);
  if (options.keep_script) {
    copy_to(folder.path() / "script", *kept_script);
    copy_to(folder.path() / data_name, *kept_data);
    kept_data->commit();
    kept_script->commit();
  }
  picture.commit();
}

}  // namespace scatmap
