#include "tools/progress_bar.h"

#include <unistd.h>

#include <cstdio>
#include <memory>

namespace scatmap::tools {
namespace {

struct Bar {
  std::string verb;
  ~Bar() { std::fprintf(stderr, "\r\033[K"); }
  void draw(const std::string& step, double done) const {
    constexpr int kWidth = 30;
    std::string cells(static_cast<std::size_t>(kWidth), '.');
    for (int i = 0; i < kWidth && i < done * kWidth; ++i) cells[static_cast<std::size_t>(i)] = '#';
    std::fflush(stdout);  // or the bar lands inside a line of it
    std::fprintf(stderr, "\r\033[K%s [%s] %3.0f %% %s", verb.c_str(), cells.c_str(), 100 * done, step.c_str());
    std::fflush(stderr);
  }
};

}  // namespace

Progress progress_bar(const std::string& verb) {
  if (isatty(STDERR_FILENO) == 0) return {};
  auto bar = std::make_shared<Bar>(Bar{verb});
  return [bar](const std::string& step, double done) { bar->draw(step, done); };
}

}  // namespace scatmap::tools
