#include "calib/spots.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>

#include "calib/spots_detect.h"
#include "calib/spots_ml.h"
#include "calib/spots_moments.h"

namespace scatmap::calib {
namespace {

constexpr double kHotWidth_px = 0.35;  // what pairs of hot pixels fit as
constexpr double kFluxSigmas = 5;
constexpr double kFaintSigmas = 12;
constexpr double kBinnedWidth = 4;        // wide spots are summed to this width: it costs 0.3 % of sigma
constexpr std::size_t kLargestGroup = 6;  // spots fitted together

bool overlap(const GaussianSpot& a, const GaussianSpot& b) {
  constexpr double kMargin_px = 4;
  const double reach = kFitReach * (spot_axes(a).major_px + spot_axes(b).major_px) + kMargin_px;
  return std::hypot(a.column_px - b.column_px, a.row_px - b.row_px) < reach;
}

// Candidates whose pixels overlap, directly or through others, are fitted together.
std::vector<std::vector<std::size_t>> groups_of(const std::vector<SpotCandidate>& candidates) {
  std::vector<std::size_t> group(candidates.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (group[i] == group[j] || !overlap(candidates[i].start, candidates[j].start)) continue;
      const std::size_t from = std::max(group[i], group[j]), to = std::min(group[i], group[j]);
      std::replace(group.begin(), group.end(), from, to);
    }
  }
  std::vector<std::vector<std::size_t>> out(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) out[group[i]].push_back(i);
  std::erase_if(out, [](const auto& g) { return g.empty(); });
  return out;
}

// From the coordinates of an image summed over factor × factor pixels to those of the image itself, or back.
double unbinned(double position, int factor) { return position * factor + 0.5 * (factor - 1); }
GaussianSpot rebinned(const GaussianSpot& s, int factor) {
  const double by = 1.0 / factor, shift = 0.5 * (factor - 1);
  return {(s.column_px - shift) * by, (s.row_px - shift) * by, s.flux_e,
          s.column_sd_px * by,        s.shear_px * by,         s.row_sd_px * by};
}

std::string place(const GaussianSpot& s, int factor) {
  char text[64];
  std::snprintf(text, sizeof text, "column %.1f, row %.1f", unbinned(s.column_px, factor), unbinned(s.row_px, factor));
  return std::string("candidate at ") + text;
}

double flux_sigma(const SpotFit& fit, std::size_t spot) {
  const auto i = static_cast<Eigen::Index>(spot) * kSpotParameters + kLogFlux;
  return std::sqrt(fit.covariance(i, i)) * fit.spots[spot].flux_e;
}

// Why a fitted candidate is no spot; empty if it is one.
std::string objection(const SpotFit& fit, std::size_t spot) {
  if (spot_axes(fit.spots[spot]).minor_px < kHotWidth_px) return "is narrower than a spot can be: hot pixels";
  if (!(fit.spots[spot].flux_e > kFluxSigmas * flux_sigma(fit, spot))) return "has a flux below five sigma";
  return {};
}

// How much longer than wide, less three standard uncertainties of that ratio.
double sure_elongation(const SpotFit& fit, std::size_t spot) {
  const SpotAxes axes = spot_axes(fit.spots[spot]);
  const auto at = static_cast<Eigen::Index>(spot) * kSpotParameters;
  const double u = std::sqrt(
      std::max(fit.covariance(at + kLogColumnSd, at + kLogColumnSd) + fit.covariance(at + kLogRowSd, at + kLogRowSd),
               4 * fit.covariance(at + kShear, at + kShear) / (axes.minor_px * axes.minor_px)));
  return axes.major_px / axes.minor_px * (1 - 3 * u);
}

bool touches_edge(const GaussianSpot& s, const SpotImage& image) {
  const double across = 3 * s.column_sd_px, down = 3 * std::hypot(s.shear_px, s.row_sd_px);
  return !(s.column_px - across >= -0.5 && s.column_px + across <= image.net_e.columns() - 0.5 &&
           s.row_px - down >= -0.5 && s.row_px + down <= image.net_e.rows() - 0.5);
}

bool holds_saturation(const GaussianSpot& s, const SpotImage& image) {
  const auto near = [](double centre, double reach, int size) {
    return std::pair{static_cast<int>(std::clamp(centre - reach, 0.0, size - 1.0)),
                     static_cast<int>(std::clamp(centre + reach, 0.0, size - 1.0))};
  };
  const auto [first_row, last_row] = near(s.row_px, 3 * std::hypot(s.shear_px, s.row_sd_px) + 1, image.net_e.rows());
  const auto [first_column, last_column] = near(s.column_px, 3 * s.column_sd_px + 1, image.net_e.columns());
  for (int r = first_row; r <= last_row; ++r) {
    for (int c = first_column; c <= last_column; ++c) {
      if ((image.mask(r, c) & kSaturated) != 0 && (image.mask(r, c) & kHot) == 0) return true;
    }
  }
  return false;
}

SpotFlags flags_of(const SpotImage& image, const SpotFit& fit, std::size_t spot) {
  const GaussianSpot& s = fit.spots[spot];
  SpotFlags flags = 0;
  if (holds_saturation(s, image)) flags |= kSpotSaturated;
  if (touches_edge(s, image)) flags |= kSpotClipped;
  if (sure_elongation(fit, spot) > kElongation) flags |= kSpotElongated;
  if (fit.spots.size() > 1) flags |= kSpotNeighbour;
  if (spot_axes(s).minor_px < 0.6) flags |= kSpotNarrow;
  if (fit.misfit) flags |= kSpotMisfit;
  if (s.flux_e < kFaintSigmas * flux_sigma(fit, spot)) flags |= kSpotFaint;
  return flags;
}

Spot measured(const SpotImage& image, const SpotFit& fit, std::size_t spot) {
  const GaussianSpot& s = fit.spots[spot];
  Spot out;
  out.column_px = s.column_px;
  out.row_px = s.row_px;
  out.covariance_px2 = fit.centre_covariance(spot);
  out.flux_e = s.flux_e;
  out.u_flux_e = flux_sigma(fit, spot);
  out.axes = spot_axes(s);
  out.chi2 = fit.chi2;
  out.degrees_of_freedom = fit.degrees_of_freedom;
  out.flags = flags_of(image, fit, spot);
  return out;
}

// Where the light that a fit leaves unexplained is brightest: a spot as wide as the narrowest one fitted.
GaussianSpot brightest_rest(const SpotImage& image, const SpotFit& fit) {
  const std::vector<PixelGaussian> gaussians(fit.spots.begin(), fit.spots.end());
  const auto rest = [&](int row, int column) {
    double value = image.net_e(row, column) - fit.background_e;
    for (const PixelGaussian& g : gaussians) value -= g.at(column, row).value_e;
    return value;
  };
  double width = HUGE_VAL, best = -HUGE_VAL;
  for (const GaussianSpot& s : fit.spots) width = std::min(width, spot_axes(s).minor_px);
  GaussianSpot out;
  for (int r = 1; r + 1 < image.net_e.rows(); ++r) {
    for (int c = 1; c + 1 < image.net_e.columns(); ++c) {
      const bool near = std::any_of(fit.spots.begin(), fit.spots.end(),
                                    [&](const auto& s) { return s.distance2(c, r) < kFitReach * kFitReach; });
      if (!near || image.mask(r, c) != 0) continue;
      const double sum = rest(r, c) + rest(r - 1, c) + rest(r + 1, c) + rest(r, c - 1) + rest(r, c + 1);
      if (!(sum > best)) continue;
      best = sum;
      out = {static_cast<double>(c),
             static_cast<double>(r),
             2 * std::numbers::pi * width * width * sum / 5,
             width,
             0,
             width};
    }
  }
  return out;
}

// The light of each spot may be two spots': the mean square distance of their places from the one, by their light, in
// every direction, for which way they lie is no better known. A second one farther off is no hidden spot.
SpotFit with_ambiguity(SpotFit fit, const SpotFit& trial) {
  constexpr double kHidden = 2;  // standard deviations of the one
  const GaussianSpot& hidden = trial.spots.back();
  for (std::size_t k = 0; k < fit.spots.size(); ++k) {
    double sum_px2 = 0;
    const bool near = fit.spots[k].distance2(hidden.column_px, hidden.row_px) <= kHidden * kHidden;
    for (const GaussianSpot* s : {&trial.spots[k], near ? &hidden : &trial.spots[k]}) {
      const Eigen::Vector2d shift(s->column_px - fit.spots[k].column_px, s->row_px - fit.spots[k].row_px);
      const double others_e = near ? hidden.flux_e : trial.spots[k].flux_e;
      sum_px2 += s->flux_e / (trial.spots[k].flux_e + others_e) * shift.squaredNorm();
    }
    fit.ambiguity_px2.push_back(sum_px2 * Eigen::Matrix2d::Identity());
  }
  return fit;
}

// Two spots too close for two peaks look like one that is no Gaussian: another is tried where the rest is brightest,
// and kept only if all light is explained then. Light that is no Gaussian at all stays one spot. Where two explain it
// but it does not say how they share it, one spot stays, as uncertain as that.
SpotFit with_hidden_spot(SpotImage& image, const SpotFit& fit) {
  std::vector<GaussianSpot> starts = fit.spots;
  starts.push_back(brightest_rest(image, fit));
  if (!(starts.back().flux_e > 0)) return fit;
  SpotImage trial_image = image;
  SpotFit trial = fit_spots(trial_image, starts);
  if (trial.spots.size() != starts.size() || trial.misfit) return fit;
  if (!trial.converged) return with_ambiguity(fit, trial);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    if (!objection(trial, k).empty()) return with_ambiguity(fit, trial);
  }
  image = std::move(trial_image);
  return trial;
}

// Fits a group, dropping candidates until those that are left are spots. @return their fit; no spot: nothing left
SpotFit fit_group(SpotImage& image, std::vector<GaussianSpot> starts, int factor, std::vector<std::string>& dropped) {
  while (!starts.empty()) {
    SpotFit fit = fit_spots(image, starts);
    std::size_t worst = starts.size() - 1;
    std::string why = fit.converged ? "" : "does not fit a Gaussian";
    for (std::size_t k = 0; fit.converged && k < starts.size() && why.empty(); ++k) {
      why = objection(fit, k);
      worst = k;
    }
    if (why.empty()) return fit.misfit && fit.spots.size() < kLargestGroup ? with_hidden_spot(image, fit) : fit;
    dropped.push_back(place(starts[worst], factor) + " " + why);
    starts.erase(starts.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  return {};
}

void measure_group(const SpotImage& whole, std::vector<GaussianSpot> starts, SpotMethod method, SpotsInFrame& out) {
  double narrowest = HUGE_VAL;
  for (const GaussianSpot& s : starts) narrowest = std::min(narrowest, spot_axes(s).minor_px);
  const int factor = std::max(1, static_cast<int>(std::min(narrowest, 1e4) / kBinnedWidth));
  SpotImage image = factor > 1 ? binned(whole, factor) : whole;
  for (GaussianSpot& s : starts) s = rebinned(s, factor);
  const SpotFit fit = fit_group(image, std::move(starts), factor, out.dropped);
  for (std::size_t k = 0; k < fit.spots.size(); ++k) {
    Spot spot = measured(image, fit, k);
    if (method == SpotMethod::kMoments) {
      const CentroidMoments moments = windowed_centroid(image, fit, k);
      if (!moments.converged) {
        out.dropped.push_back(place(fit.spots[k], factor) + " has no windowed centroid");
        continue;
      }
      spot.column_px = moments.column_px;
      spot.row_px = moments.row_px;
      spot.covariance_px2 = moments.covariance_px2;
    }
    spot.column_px = unbinned(spot.column_px, factor);
    spot.row_px = unbinned(spot.row_px, factor);
    spot.covariance_px2 *= factor * factor;
    spot.axes.major_px *= factor;
    spot.axes.minor_px *= factor;
    spot.background_e = fit.background_e / (factor * factor);
    out.spots.push_back(spot);
  }
}

// Light is never negative: where the background lies below the dark, the dark is too high, and shot noise counts from
// the background. @return what was taken off
double lift_background(SpotImage& image) {
  const double below_e = std::min(0.0, image.background_e);
  for (double& v : image.net_e) v -= below_e;
  image.background_e -= below_e;
  return below_e;
}

}  // namespace

double Spot::sigma_px() const { return std::sqrt(0.5 * covariance_px2.trace()); }

SpotsInFrame find_spots(SpotImage image, SpotMethod method) {
  SpotsInFrame out;
  const double lifted_e = lift_background(image);
  out.hot_pixels = mark_hot_pixels(image);
  fill_hot_pixels(image);
  const std::vector<SpotCandidate> candidates = detect_spots(image);
  for (const auto& group : groups_of(candidates)) {
    std::vector<GaussianSpot> starts;
    for (const std::size_t i : group) {
      if (starts.size() < kLargestGroup)
        starts.push_back(candidates[i].start);
      else
        out.dropped.push_back(place(candidates[i].start, 1) + " is one of too many that overlap");
    }
    measure_group(image, std::move(starts), method, out);
  }
  std::stable_sort(out.spots.begin(), out.spots.end(),
                   [](const Spot& a, const Spot& b) { return a.flux_e > b.flux_e; });
  for (Spot& s : out.spots) s.background_e += lifted_e;
  for (std::size_t i = 1; i < out.spots.size(); ++i) out.spots[i].flags |= kSpotSecondary;
  return out;
}

}  // namespace scatmap::calib
