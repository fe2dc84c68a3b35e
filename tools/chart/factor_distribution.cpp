#include "tools/chart/factor_distribution.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace scatmap::tools {
namespace {

using Long = long double;

// Distribution function of Σ w_i (U_i − 1/2), U_i uniform on (0, 1).
class RectangularSum {
 public:
  explicit RectangularSum(const std::vector<Long>& widths) : count_(widths.size()) {
    Long total = 0;
    for (const Long w : widths) {
      total += w;
      scale_ *= w;
    }
    for (std::size_t i = 1; i <= count_; ++i) scale_ *= static_cast<Long>(i);
    half_ = total / 2;
    for (std::size_t corner = 0; corner < (std::size_t{1} << count_); ++corner) {
      Long sum = 0, sign = 1;
      for (std::size_t i = 0; i < count_; ++i) {
        if ((corner >> i & 1U) == 0) continue;
        sum += widths[i];
        sign = -sign;
      }
      corners_.emplace_back(sum, sign);
    }
  }

  double below(Long x) const {
    if (count_ == 0) return x >= 0 ? 1 : 0;
    if (x >= half_) return 1;
    if (x > 0) return 1 - below(-x);  // symmetric; few terms on the lower side
    Long sum = 0;
    for (const auto& [corner, sign] : corners_) {
      const Long d = x + half_ - corner;
      if (d > 0) sum += sign * std::pow(d, static_cast<Long>(count_));
    }
    return static_cast<double>(sum / scale_);
  }

 private:
  std::size_t count_;
  Long scale_ = 1, half_ = 0;
  std::vector<std::pair<Long, Long>> corners_;
};

// ∫ φ(z) f(z) dz by the trapezoidal rule, which converges exponentially here; once at z = 0 without any spread.
template <class Function>
double over_normal(bool spread, Function&& f) {
  if (!spread) return f(0.0);
  constexpr int kSteps = 800;
  constexpr double kReach = 8.5, kStep = 2 * kReach / kSteps;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double z = -kReach + i * kStep;
    sum += std::exp(-z * z / 2) * f(z);
  }
  return sum * kStep / std::sqrt(2 * std::numbers::pi);
}

}  // namespace

double probability_within(const ScaleBudget& budget, double relative_normal, const FactorInterval& interval) {
  std::vector<Long> widths;
  double normal2 = 0;
  for (const ScaleCause& c : budget.causes) {
    if (c.distribution == Distribution::kNormal) {
      normal2 += c.standard() * c.standard();
    } else {
      widths.push_back(2 * std::abs(static_cast<Long>(c.sensitivity) * c.half_width));
    }
  }
  const RectangularSum sum(widths);
  const double u = std::sqrt(normal2);
  return over_normal(relative_normal > 0, [&](double z) {
    const double by = 1 + relative_normal * z;
    // Of F/by, which is positive; a negative `by` turns the interval round.
    const auto below = [&](double factor) {
      if (!(factor > 0)) return 0.0;
      return over_normal(u > 0, [&](double y) { return sum.below(std::log(factor) - u * y); });
    };
    return std::abs(below(interval.high / by) - below(interval.low / by));
  });
}

}  // namespace scatmap::tools
