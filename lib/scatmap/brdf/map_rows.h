#pragma once
#include <span>

#include "scatmap/base/mask.h"

/// Vector loops over rows of a map.
namespace scatmap {

/// Square root of the sum of squares over several rows, pixel by pixel.
void norm_of_rows(std::span<const float* const> parts, int pixels, float* out);

struct RowSummary {
  double good, largest;
  double sum, count;  ///< of u/f where f > 10 u
};
/// Over the pixels of mask 0.
RowSummary summarise_row(const double* f, const float* u, const Mask* mask, int pixels);

/// Adds the values of mask 0, and their number.
void add_good(const double* value, const Mask* mask, int pixels, double* sum, double* count);
/// Largest mean of three neighbours, those from k to k + 2 for k from 0 on; −infinity where nothing is counted.
double largest_mean_of_three(const double* sum, const double* count, int means);

}  // namespace scatmap
