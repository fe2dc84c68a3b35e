#include "scatmap/base/number_text.h"

#include <array>
#include <charconv>
#include <cmath>

namespace scatmap {

std::string number_text(double value) {
  if (value == 0 && std::signbit(value)) return "-0.0";  // TOML reads "-0" as the integer 0
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string number_text_in_unit(double inside, double unit) {
  const double nearest = inside / unit;
  double down = nearest, up = nearest;
  for (int step = 0; step < 3; ++step) {
    if (down * unit == inside) return number_text(down);
    if (up * unit == inside) return number_text(up);
    down = std::nextafter(down, -HUGE_VAL);
    up = std::nextafter(up, HUGE_VAL);
  }
  return number_text(nearest);
}

}  // namespace scatmap
