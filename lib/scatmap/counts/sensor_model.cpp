#include "scatmap/counts/sensor_model.h"

#include <charconv>
#include <cmath>
#include <sstream>
#include <string>

#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"

namespace scatmap {

double SensorModel::linearised(double raw_dn) const {
  const double x = raw_dn - bias_dn;
  double factor = 0;
  for (auto c = linearity.rbegin(); c != linearity.rend(); ++c) factor = (factor + *c) * x;
  return bias_dn + x * (1 + factor);
}

Grid<float> normalised_flat(const Frame& flat) {
  double sum = 0;
  std::size_t count = 0;
  for (const float v : flat.dn) {
    if (std::isfinite(v) && v > 0) {
      sum += v;
      ++count;
    }
  }
  if (count == 0) throw Error({flat.file.string(), "is no flat field: no pixel is positive", {}, {}});
  Grid<float> out(flat.dn.rows(), flat.dn.columns());
  const double mean = sum / static_cast<double>(count);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(flat.dn[i] / mean);
  return out;
}

Grid<Mask> bad_pixels_from_frame(const Frame& frame) {
  Grid<Mask> out(frame.dn.rows(), frame.dn.columns());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = frame.dn[i] != 0 ? kBad : Mask{0};
  return out;
}

namespace {

int parse_coordinate(const std::string& text, int limit, const std::string& where, const char* what) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 0 || value >= limit) {
    throw Error({where, std::string(what) + " is not a pixel of the detector", "'" + text + "'",
                 "an integer from 0 to " + std::to_string(limit - 1)});
  }
  return value;
}

}  // namespace

Grid<Mask> read_bad_pixel_list(const std::filesystem::path& path, int rows, int columns) {
  std::istringstream text(read_text_file(path));
  std::string line;
  if (!std::getline(text, line) || line != "column_px,row_px") {
    throw Error({path.string() + ":1", "has the wrong header", "'" + line + "'", "column_px,row_px"});
  }
  Grid<Mask> out(rows, columns, Mask{0});
  for (int number = 2; std::getline(text, line); ++number) {
    if (line.empty()) continue;
    const std::string where = path.string() + ":" + std::to_string(number);
    const auto comma = line.find(',');
    if (comma == std::string::npos) throw Error({where, "has no comma", "'" + line + "'", "column,row"});
    const int column = parse_coordinate(line.substr(0, comma), columns, where, "column_px");
    const int row = parse_coordinate(line.substr(comma + 1), rows, where, "row_px");
    out(row, column) = kBad;
  }
  return out;
}

}  // namespace scatmap
