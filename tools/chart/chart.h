#pragma once
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "scatmap/angles/instrument.h"
#include "scatmap/model/model.h"

namespace scatmap::tools {

/// What a job is charted on.
struct ChartSettings {
  Instrument instrument;
  Pose pose;
  Model model;
  double seconds_per_method = 0.5;  ///< how long a method is timed
};

/// Time per item of many runs.
struct Timing {
  double minimum_ns = std::numeric_limits<double>::quiet_NaN();
  double spread_ns = 0;                                        ///< from the minimum to the 90th percentile
  double first_ns = std::numeric_limits<double>::quiet_NaN();  ///< of the first run: fresh memory, cold caches
};

/// One method measured at one size.
struct ChartRow {
  std::string method;
  std::string size;  ///< "1024 x 1024"
  int threads = 1;
  bool rival = false;  ///< somebody else's code
  Timing time;
  double largest_error = std::numeric_limits<double>::quiet_NaN();  ///< in the chart's error unit
  double p99_error = std::numeric_limits<double>::quiet_NaN();
  std::optional<double> largest_error_rad;  ///< the same in radians, where that has a meaning
  std::string worst_at;                     ///< where the largest error stands: "column 3, row 7"
  std::optional<double> bound;              ///< in the chart's error unit
  std::string note;
};

/// A line across the chart: the calibration's uncertainty, the time that memory alone takes.
struct ChartLine {
  std::string label;
  double value;
};

/// Time against error of every method of one job.
struct Chart {
  std::string job;  ///< also the name of its files
  std::string title;
  std::string item;        ///< what the time is per: "pixel", "direction", "trial"
  std::string error_name;  ///< "direction error"
  std::string error_unit;  ///< "px"; "" for relative errors
  std::string reference;   ///< what the errors are against
  std::vector<ChartRow> rows;
  std::vector<ChartLine> time_lines;   ///< ns per item
  std::vector<ChartLine> error_lines;  ///< error unit
};

}  // namespace scatmap::tools
