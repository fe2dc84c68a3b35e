#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace scatmap::tools {

/// Errors seen so far. One that is not a number counts as infinite: a method that returns NaN where its reference does
/// not has failed.
class ErrorSample {
 public:
  void add(double error, int column, int row) {
    const double magnitude = std::isnan(error) ? HUGE_VAL : std::abs(error);
    if (errors_.empty() || magnitude > largest_) {
      largest_ = magnitude;
      column_ = column;
      row_ = row;
    }
    errors_.push_back(magnitude);
  }
  std::size_t size() const { return errors_.size(); }
  double largest() const { return largest_; }
  double percentile(double p) const {
    std::vector<double> sorted = errors_;
    const auto at = static_cast<std::ptrdiff_t>(p / 100 * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), sorted.begin() + at, sorted.end());
    return sorted[static_cast<std::size_t>(at)];
  }
  std::string worst_at() const { return "column " + std::to_string(column_) + ", row " + std::to_string(row_); }

 private:
  std::vector<double> errors_;
  double largest_ = 0;
  int column_ = 0, row_ = 0;
};

}  // namespace scatmap::tools
