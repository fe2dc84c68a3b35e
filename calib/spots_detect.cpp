#include "calib/spots_detect.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "scatmap/base/parallel.h"

namespace scatmap::calib {
namespace {

struct Smoothed {
  Grid<double> value_e;
  double noise_share = 1;  // standard deviation left of a pixel's white noise
  double background_e = 0;
  double scatter_e = 0;  // robust, of the smoothed image
  double floor_e2 = 0;   // of a pixel, before smoothing

  double noise_at(double level_e) const {
    return std::max(scatter_e, noise_share * std::sqrt(floor_e2 + std::max(0.0, level_e)));
  }
};

std::vector<double> gaussian_kernel(double sigma_px) {
  const int reach = static_cast<int>(std::ceil(3 * sigma_px));
  std::vector<double> k;
  for (int i = -reach; i <= reach; ++i) k.push_back(std::exp(-0.5 * i * i / (sigma_px * sigma_px)));
  const double sum = std::accumulate(k.begin(), k.end(), 0.0);
  for (double& v : k) v /= sum;
  return k;
}

// Beyond the edge the edge pixel goes on.
Grid<double> convolved(const Grid<double>& in, const std::vector<double>& kernel) {
  const int reach = static_cast<int>(kernel.size() / 2);
  Grid<double> across(in.rows(), in.columns()), out(in.rows(), in.columns());
  for_each_row(in.rows(), [&](int r) {
    for (int c = 0; c < in.columns(); ++c) {
      double sum = 0;
      for (int k = -reach; k <= reach; ++k)
        sum += kernel[static_cast<std::size_t>(k + reach)] * in(r, std::clamp(c + k, 0, in.columns() - 1));
      across(r, c) = sum;
    }
  });
  for_each_row(in.rows(), [&](int r) {
    for (int c = 0; c < in.columns(); ++c) out(r, c) = 0;
    for (int k = -reach; k <= reach; ++k) {
      const double w = kernel[static_cast<std::size_t>(k + reach)];
      const auto from = across.row(std::clamp(r + k, 0, in.rows() - 1));
      auto to = out.row(r);
      for (std::size_t c = 0; c < from.size(); ++c) to[c] += w * from[c];
    }
  });
  return out;
}

double sampled_median(const Grid<double>& values, double centre, bool absolute) {
  std::vector<double> sample;
  const std::size_t stride = std::max<std::size_t>(1, values.size() / 100003);
  for (std::size_t i = 0; i < values.size(); i += stride)
    sample.push_back(absolute ? std::abs(values[i] - centre) : values[i]);
  const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
  std::nth_element(sample.begin(), middle, sample.end());
  return *middle;
}

Smoothed smooth(const SpotImage& image, double sigma_px) {
  const std::vector<double> kernel = gaussian_kernel(sigma_px);
  Smoothed out;
  out.value_e = convolved(image.net_e, kernel);
  out.noise_share = std::inner_product(kernel.begin(), kernel.end(), kernel.begin(), 0.0);
  out.background_e = sampled_median(out.value_e, 0, false);
  constexpr double kNormalPerMad = 1.4826;
  out.scatter_e = kNormalPerMad * sampled_median(out.value_e, out.background_e, true);
  out.floor_e2 = sampled_median(image.floor_e2, 0, false);
  return out;
}

// Height of the highest peak in units of its own noise.
double best_peak(const Smoothed& s) {
  const double peak = *std::max_element(s.value_e.begin(), s.value_e.end());
  return (peak - s.background_e) / s.noise_at(s.background_e);
}

// Standard deviation of a Gaussian that has as many pixels above half of its peak: hardly changed by speckle.
double peak_width_px(const Smoothed& s) {
  const double peak = *std::max_element(s.value_e.begin(), s.value_e.end());
  const double half = s.background_e + 0.5 * (peak - s.background_e);
  const auto above = std::count_if(s.value_e.begin(), s.value_e.end(), [half](double v) { return v > half; });
  return std::sqrt(static_cast<double>(above) / (2 * std::numbers::pi * std::numbers::ln2));
}

// Smallest smoothing that shows something clearly, else the one that shows most. A wide spot is smoothed by a fifth of
// its width, so that speckle is not taken for spots.
Smoothed best_smoothing(const SpotImage& image) {
  constexpr double kClear = 2 * kDetectionSigmas, kSpeckleShare = 0.2;
  const double widest = std::min(16.0, 0.125 * std::min(image.net_e.rows(), image.net_e.columns()));
  Smoothed best = smooth(image, 1);
  double height = best_peak(best);
  if (height >= kClear) {
    const double sigma = std::min(kSpeckleShare * peak_width_px(best), widest);
    return sigma > 1 ? smooth(image, sigma) : best;
  }
  for (double sigma = 2; sigma <= widest; sigma *= 2) {
    Smoothed wider = smooth(image, sigma);
    const double h = best_peak(wider);
    if (h <= height) continue;
    best = std::move(wider);
    height = h;
    if (height >= kClear) break;
  }
  return best;
}

// Basins of the peaks above a threshold: pixels are flooded from the highest down, and where two basins meet the lower
// is swallowed unless its peak stands high enough above the saddle.
class Basins {
 public:
  explicit Basins(const Smoothed& smoothed) : s_(smoothed), parent_(smoothed.value_e.size(), kDry) {
    const double threshold = s_.background_e + kDetectionSigmas * s_.noise_at(s_.background_e);
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < parent_.size(); ++i) {
      if (s_.value_e[i] > threshold) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return s_.value_e[a] > s_.value_e[b]; });
    for (const std::size_t i : order) flood(i);
  }

  /// Pixels of each basin, by the index of its peak.
  std::map<std::size_t, std::vector<std::size_t>> pixels() {
    std::map<std::size_t, std::vector<std::size_t>> out;
    for (std::size_t i = 0; i < parent_.size(); ++i) {
      if (parent_[i] != kDry) out[root(i)].push_back(i);
    }
    return out;
  }

 private:
  static constexpr std::size_t kDry = static_cast<std::size_t>(-1);

  // A root is its basin's peak: the first pixel flooded there.
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  bool stands_apart(double peak, double saddle) const {
    const double height = peak - s_.background_e;
    return peak - saddle >= std::max(kSaddleShare * height, kSaddleSigmas * s_.noise_at(height));
  }

  void flood(std::size_t i) {
    const int columns = s_.value_e.columns(), rows = s_.value_e.rows();
    const int r = static_cast<int>(i) / columns, c = static_cast<int>(i) % columns;
    std::vector<std::size_t> met;
    for (int rr = std::max(0, r - 1); rr <= std::min(rows - 1, r + 1); ++rr) {
      for (int cc = std::max(0, c - 1); cc <= std::min(columns - 1, c + 1); ++cc) {
        const std::size_t j =
            static_cast<std::size_t>(rr) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(cc);
        if (j != i && parent_[j] != kDry) met.push_back(root(j));
      }
    }
    std::sort(met.begin(), met.end());
    met.erase(std::unique(met.begin(), met.end()), met.end());
    std::stable_sort(met.begin(), met.end(),
                     [&](std::size_t a, std::size_t b) { return s_.value_e[a] > s_.value_e[b]; });
    parent_[i] = met.empty() ? i : met.front();
    for (std::size_t k = 1; k < met.size(); ++k) {
      if (!stands_apart(s_.value_e[met[k]], s_.value_e[i])) parent_[met[k]] = met.front();
    }
  }

  const Smoothed& s_;
  std::vector<std::size_t> parent_;
};

SpotCandidate candidate(const SpotImage& image, const Smoothed& s, std::size_t peak,
                        const std::vector<std::size_t>& pixels) {
  const auto columns = static_cast<std::size_t>(image.net_e.columns());
  double sum = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  SpotCandidate out;
  for (const std::size_t i : pixels) {
    const double w = std::max(0.0, image.net_e[i] - s.background_e);
    const Eigen::Vector2d at(static_cast<double>(i % columns), static_cast<double>(i / columns));
    sum += w;
    mean += w * at;
    square += w * at * at.transpose();
    out.saturated_px += (image.mask[i] & kSaturated) != 0 ? 1 : 0;
  }
  mean /= sum;
  constexpr double kNarrowestStart_px2 = 0.5;
  const Eigen::Matrix2d covariance =
      square / sum - mean * mean.transpose() + kNarrowestStart_px2 * Eigen::Matrix2d::Identity();
  out.start = gaussian_spot(mean.x(), mean.y(), sum, covariance);
  out.height_e = s.value_e[peak] - s.background_e;
  out.peak_sigmas = out.height_e / s.noise_at(s.background_e);
  return out;
}

}  // namespace

std::vector<SpotCandidate> detect_spots(const SpotImage& image) {
  const Smoothed smoothed = best_smoothing(image);
  std::vector<SpotCandidate> out;
  for (const auto& [peak, pixels] : Basins(smoothed).pixels()) {
    SpotCandidate c = candidate(image, smoothed, peak, pixels);
    if (c.start.flux_e > 0) out.push_back(c);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.start.flux_e > b.start.flux_e; });
  if (out.empty()) return out;
  const double limit = kSecondaryShare * out.front().height_e;
  std::erase_if(out, [&](const SpotCandidate& c) { return c.height_e < limit; });
  return out;
}

}  // namespace scatmap::calib
