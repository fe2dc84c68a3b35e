#pragma once
#include <optional>
#include <string>
#include <vector>

#include "scatmap/brdf/brdf_map.h"

namespace scatmap {

/// Columns and rows of a rectangle of pixels, both ends included.
struct Region {
  int first_column = 0, first_row = 0, last_column = 0, last_row = 0;
};

/// A linear combination Σ weight · f of good pixels.
struct PixelSum {
  std::vector<std::size_t> pixels;  ///< row·columns + column, ascending
  std::vector<double> weights;
};

/// Mean of the region's good pixels. @throws Error if the region leaves the map or holds no good pixel
PixelSum mean_over(const BrdfMap& map, const Region& region);
/// Power scattered into the region, per incident power: Σ f Ω cos theta_s. Over a whole map: the integrated scatter
/// that the detector saw. @throws Error as above
PixelSum power_in(const BrdfMap& map, const Region& region);

/// A structured cause's amount in a sum: signed change at +1 standard deviation.
struct CauseAmount {
  std::string name;  ///< "U_NONLIN", "pose direction 3"
  std::string meaning;
  double amount = 0;
  ScaleCause cause{.half_width = 1, .sensitivity = 1};  ///< what it is one standard deviation of
  bool is_pose = false;
};

/// Value and uncertainty of one PixelSum by cause, all in the sum's unit.
struct SumUncertainty {
  double value = 0;
  double random = 0;
  std::vector<CauseAmount> structured;  ///< the same causes in the same order for every sum of one map
  double scale_relative = 0;            ///< first order; its causes stand in the map's ScaleBudget

  double structured_total() const;
  double without_scale() const;  ///< random and structured together
  double total() const;          ///< with the scale, first order
  double relative_without_scale() const;
  /// Random and pose: what adds to the value. Filters, times and the like multiply it.
  double relative_additive() const;
};

/// The causes that multiply a sum: the map's scale and, with their amounts in this sum, the structured causes but pose.
/// With relative_additive() it gives the sum's distribution (scale_statistics.h). A structured asymmetric cause keeps
/// its two half widths only where its amount is positive.
ScaleBudget factor_budget(const SumUncertainty& u, const ScaleBudget& scale);

/// Uncertainty of sums over a map's pixels: random parts are independent, each structured cause is coherent, the scale
/// common: covariance(p, q) = [p = q] u_random² + Σ s(p) s(q) + f(p) f(q) scale². A map file only has the norm of the
/// pose causes; their signs are computed anew from the instrument in the map and scaled to that norm pixel by pixel.
class MapUncertainty {
 public:
  /// @param map with uncertainties; must outlive this. @throws Error if it has none (a modelled map)
  explicit MapUncertainty(const BrdfMap& map);

  SumUncertainty of(const PixelSum& sum) const;
  /// Covariance of two sums, scale included to first order.
  double covariance(const PixelSum& a, const PixelSum& b) const;

 private:
  Grid<double> smooth_;
  const BrdfMap& map_;
};

/// a/b and its standard uncertainty, first order, with their covariance: the scale cancels.
struct Ratio {
  double value = 0;
  double u = 0;
  double correlation = 0;  ///< of a and b
};
Ratio ratio_of(const MapUncertainty& u, const PixelSum& a, const PixelSum& b);

/// What a set of filters would have to be calibrated to.
struct FilterTarget {
  std::vector<std::string> filters;
  std::optional<double>
      u_od;  ///< standard uncertainty of each; absent: the target is out of reach even with perfect ones
};
/// Which filter calibration brings the total to `target` (relative standard uncertainty): the largest filter alone, the
/// two largest, … until all. @param other relative standard uncertainty of everything but the scale
std::vector<FilterTarget> filter_targets(const ScaleBudget& budget, double other, double target);

}  // namespace scatmap
