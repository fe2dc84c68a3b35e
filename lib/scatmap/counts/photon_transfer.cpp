#include "scatmap/counts/photon_transfer.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/counts/dark.h"
#include "scatmap/counts/photon_transfer_linearity.h"
#include "scatmap/counts/temporal_noise.h"

namespace scatmap {
namespace {

constexpr double kGainRange = 0.7;                       // EMVA 1288, 6.6: of saturation
constexpr double kLinearLow = 0.05, kLinearHigh = 0.95;  // 6.7
constexpr double kQuantisation = 1.0 / 12;
constexpr double kOutlierSigmas = 6;

double median_of(std::vector<double> v) {
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

void check(std::span<const TransferLevel> levels) {
  for (const TransferLevel& l : levels) {
    const std::string at = number_text(l.exposure_s) + " s";
    if (l.flats.size() < 2) throw Error({"flats", "fewer than two of one exposure time", at, "pairs of flats"});
    if (l.darks.size() < 2)
      throw Error(
          {"darks", "fewer than two of one exposure time", at, "pairs of darks at every exposure time of the flats"});
    for (const Frame& f : l.flats) require_same_shape(levels.front().flats.front(), f);
    for (const Frame& f : l.darks) require_same_shape(levels.front().flats.front(), f);
  }
  if (levels.size() < 2)
    throw Error(
        {"flats", "fewer than two exposure times", std::to_string(levels.size()), "several, from dark to saturation"});
}

// Straight line y = a + b x, weights 1/u².
struct Line {
  Estimate intercept, slope;
  double chi_squared = 0;  // per degree of freedom; 0 without any
};

Line fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> u) {
  double s = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double w = 1 / (u[i] * u[i]);
    s += w;
    sx += w * x[i];
    sy += w * y[i];
    sxx += w * x[i] * x[i];
    sxy += w * x[i] * y[i];
  }
  const double determinant = s * sxx - sx * sx;
  Line out;
  out.slope = {(s * sxy - sx * sy) / determinant, std::sqrt(s / determinant)};
  out.intercept = {(sxx * sy - sx * sxy) / determinant, std::sqrt(sxx / determinant)};
  double chi = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    chi += std::pow((y[i] - out.intercept.value - out.slope.value * x[i]) / u[i], 2);
  if (x.size() > 2) out.chi_squared = chi / static_cast<double>(x.size() - 2);
  return out;
}

// The largest variance that is followed by a smaller one.
std::optional<double> variance_peak(const std::vector<TransferPoint>& points) {
  const auto top = std::max_element(points.begin(), points.end(),
                                    [](const auto& a, const auto& b) { return a.variance_dn2 < b.variance_dn2; });
  if (top + 1 == points.end()) return std::nullopt;
  return top->mean_dn;
}

// The value that more than half of a frame's pixels have, if there is one: where the converter ends.
std::optional<double> ceiling_of(const Frame& f) {
  const std::vector<double> values(f.dn.begin(), f.dn.end());
  const double middle = median_of(values);
  const auto same = std::count(values.begin(), values.end(), middle);
  if (static_cast<double>(same) < kCeilingShare * static_cast<double>(values.size())) return std::nullopt;
  return middle;
}

std::optional<double> saturation_of(const PhotonTransfer& p, std::span<const TransferLevel> levels) {
  const std::optional<double> peak = variance_peak(p.points);
  if (!peak) return std::nullopt;
  const std::optional<double> ceiling = ceiling_of(levels.back().flats.front());
  if (!ceiling || *ceiling < *peak) return peak;
  // Noise at the ceiling, from the straight line through the peak's level.
  const auto top = std::max_element(p.points.begin(), p.points.end(),
                                    [](const auto& a, const auto& b) { return a.variance_dn2 < b.variance_dn2; });
  const double slope = (top->variance_dn2 - top->dark_variance_dn2) / (top->mean_dn - top->dark_mean_dn);
  const double variance = top->dark_variance_dn2 + slope * (*ceiling - top->dark_mean_dn);
  return std::max(*peak, *ceiling - kCeilingSigmas * std::sqrt(variance));
}

void check_stated(const std::vector<TransferPoint>& points, std::span<const TransferLevel> levels,
                  double saturation_dn) {
  const std::optional<double> ceiling = ceiling_of(levels.back().flats.front());
  if (ceiling && variance_peak(points) && *ceiling < saturation_dn)
    throw Error({"the stated saturation", "is above the value at which most of the brightest flat's pixels end",
                 number_text(saturation_dn), "at most " + number_text(*ceiling) + " DN"});
  const auto reached =
      std::count_if(points.begin(), points.end(), [&](const TransferPoint& p) { return p.mean_dn >= saturation_dn; });
  if (2 * static_cast<std::size_t>(reached) <= points.size()) return;
  throw Error({"the stated saturation", "contradicts the flats, most of which are brighter", number_text(saturation_dn),
               "a value between their brightest level, " + number_text(points.back().mean_dn) +
                   " DN in the mean, and the converter's largest"});
}

// Levels in ascending order of exposure.
void require_growth(const std::vector<TransferPoint>& points, double saturation_dn) {
  constexpr double kNearly = 0.9;  // beyond, a full well may fall
  for (std::size_t i = 1; i < points.size(); ++i) {
    const TransferPoint &a = points[i - 1], &b = points[i];
    if (b.mean_dn - b.dark_mean_dn > kNearly * (a.mean_dn - a.dark_mean_dn) || a.mean_dn > kNearly * saturation_dn)
      continue;
    throw Error({"flats",
                 "of " + number_text(b.exposure_s) + " s are darker than those of " + number_text(a.exposure_s) +
                     " s: are files or exposure times exchanged?",
                 number_text(std::round(b.mean_dn - b.dark_mean_dn)) + " DN above their darks",
                 "more than " + number_text(std::round(a.mean_dn - a.dark_mean_dn))});
  }
}

void count_saturated(PhotonTransfer& out, std::span<const TransferLevel> levels, const PixelUse& use,
                     double saturation_dn) {
  for (std::size_t i = 0; i < levels.size(); ++i) {
    double values = 0, saturated = 0;
    for (const Frame& f : levels[i].flats) {
      for (std::size_t k = 0; k < f.dn.size(); ++k) {
        if (!use[k]) continue;
        values += 1;
        saturated += static_cast<double>(f.dn[k]) >= saturation_dn ? 1 : 0;
      }
    }
    out.points[i].saturated = saturated / values;
  }
}

// A point's means and variances after linearisation: variance times slope².
TransferPoint linearised(const TransferPoint& p, const SensorModel& sensor) {
  const auto slope = [&](double raw) { return sensor.linearised(raw + 0.5) - sensor.linearised(raw - 0.5); };
  const double flat = std::pow(slope(p.mean_dn), 2), dark = std::pow(slope(p.dark_mean_dn), 2);
  TransferPoint out = p;
  out.mean_dn = sensor.linearised(p.mean_dn);
  out.dark_mean_dn = sensor.linearised(p.dark_mean_dn);
  out.variance_dn2 *= flat;
  out.u_variance_dn2 *= flat;
  out.dark_variance_dn2 *= dark;
  return out;
}

// EMVA 1288, 6.6: through the origin.
void fit_gain(PhotonTransfer& out, double saturation_dn) {
  SensorModel sensor;
  sensor.bias_dn = out.bias_dn.value;
  sensor.linearity = out.linearity;
  double xx = 0, xy = 0, count = 0;
  std::vector<TransferPoint> points;
  for (TransferPoint& raw : out.points) {
    raw.used = raw.mean_dn > raw.dark_mean_dn &&
               raw.mean_dn <= raw.dark_mean_dn + kGainRange * (saturation_dn - raw.dark_mean_dn);
    if (!raw.used) continue;
    const TransferPoint p = linearised(raw, sensor);
    points.push_back(p);
    const double x = p.mean_dn - p.dark_mean_dn, y = p.variance_dn2 - p.dark_variance_dn2;
    const double w = 1 / (p.u_variance_dn2 * p.u_variance_dn2);
    xx += w * x * x;
    xy += w * x * y;
    count += 1;
  }
  if (!(xy > 0))
    throw Error(
        {"flats", "their variance does not grow with their mean", {}, "photon noise: uniform light, no saturation"});
  const double k = xy / xx;
  double chi = 0;
  for (const TransferPoint& p : points)
    chi += std::pow((p.variance_dn2 - p.dark_variance_dn2 - k * (p.mean_dn - p.dark_mean_dn)) / p.u_variance_dn2, 2);
  out.chi_squared = count > 1 ? chi / (count - 1) : 0;
  // A curve that is no straight line makes K as uncertain as its scatter says.
  out.gain_dn_per_e = {k, std::sqrt(std::max(1.0, out.chi_squared) / xx)};
}

// Dark level against exposure time.
Line fit_bias(PhotonTransfer& out, double pixels) {
  std::vector<double> t, mean, u;
  for (const TransferPoint& p : out.points) {
    t.push_back(p.exposure_s);
    mean.push_back(p.dark_mean_dn);
    u.push_back(std::sqrt(p.dark_variance_dn2 / pixels));
  }
  Line line = fit_line(t, mean, u);
  // Clocks and temperature move the bias more than noise does.
  const double scatter = std::sqrt(std::max(1.0, line.chi_squared));
  line.intercept.u *= scatter;
  line.slope.u *= scatter;
  out.bias_dn = line.intercept;
  return line;
}

void fit_dark(PhotonTransfer& out, const TemporalNoise& shortest, const Line& bias) {
  const double k = out.gain_dn_per_e.value, relative_k = out.gain_dn_per_e.u / k;
  const double variance = std::max(0.0, shortest.variance - kQuantisation);
  const double sigma = std::sqrt(variance) / k;
  out.dark_noise_e = {sigma, std::hypot(sigma * relative_k, sigma > 0 ? shortest.u_variance() / (2 * sigma * k * k)
                                                                      : std::sqrt(kQuantisation) / k)};
  out.dark_current_e_per_s = {bias.slope.value / k, std::hypot(bias.slope.u / k, bias.slope.value / k * relative_k)};
}

Grid<double> mean_frame(std::span<const Frame> frames) {
  Grid<double> out(frames.front().dn.rows(), frames.front().dn.columns(), 0.0);
  for (const Frame& f : frames) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += f.dn[i] / static_cast<double>(frames.size());
  }
  return out;
}

// Which values stand within so many robust standard deviations; those of whole numbers are not below `least`.
PixelUse ordinary(const Grid<double>& g, double sigmas = kOutlierSigmas, double least = 0) {
  std::vector<double> values(g.begin(), g.end());
  const double median = median_of(values);
  for (double& v : values) v = std::abs(v - median);
  const double limit = sigmas * std::max(least, 1.4826 * median_of(values));
  PixelUse out(g.size());
  for (std::size_t i = 0; i < g.size(); ++i) out[i] = std::abs(g[i] - median) <= limit;
  return out;
}

// Hot pixels end where others do, stuck ones do not.
Grid<double> darks_at_no_exposure(const std::vector<TransferLevel>& levels) {
  const double first_s = levels.front().exposure_s, last_s = levels.back().exposure_s;
  Grid<double> out = mean_frame(levels.front().darks);
  const Grid<double> last = mean_frame(levels.back().darks);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] -= (last[i] - out[i]) * first_s / (last_s - first_s);
  return out;
}

// Removes the least-squares quadratic surface: light is never quite uniform.
void flatten(Grid<double>& g, const PixelUse& use) {
  using Terms = Eigen::Matrix<double, 6, 1>;
  const auto terms = [&](std::size_t i) {
    const auto columns = static_cast<std::size_t>(g.columns());
    const double x = 2.0 * static_cast<double>(i % columns) / g.columns() - 1,
                 y = 2.0 * static_cast<double>(i / columns) / g.rows() - 1;
    return Terms(1, x, y, x * x, x * y, y * y);
  };
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Terms right = Terms::Zero();
  for (std::size_t i = 0; i < g.size(); ++i) {
    if (!use[i]) continue;
    const Terms t = terms(i);
    normal += t * t.transpose();
    right += t * g[i];
  }
  const Terms solution = normal.ldlt().solve(right);
  for (std::size_t i = 0; i < g.size(); ++i) g[i] -= solution.dot(terms(i));
}

// Spatial variance without the temporal noise that is left in a mean of `frames`; u from the number of pixels.
Estimate spatial_variance(const Grid<double>& g, const PixelUse& use, double temporal_variance, double frames) {
  double sum = 0, square = 0, n = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    if (!use[i]) continue;
    sum += g[i];
    square += g[i] * g[i];
    n += 1;
  }
  const double variance = (square - sum * sum / n) / (n - 1);
  // The temporal variance comes from differences, independent of the mean.
  return {variance - temporal_variance / frames, std::hypot(variance, temporal_variance / frames) * std::sqrt(2 / n)};
}

Estimate root(const Estimate& variance) {
  const double sd = std::sqrt(std::max(0.0, variance.value));
  return {sd, sd * sd > variance.u ? variance.u / (2 * sd) : std::sqrt(variance.u)};
}

void non_uniformity(PhotonTransfer& out, std::span<const TransferLevel> levels, double saturation_dn) {
  const double k = out.gain_dn_per_e.value;
  const Grid<double> dark = mean_frame(levels.front().darks);
  const Estimate dark_variance = spatial_variance(dark, ordinary(dark), out.points.front().dark_variance_dn2,
                                                  static_cast<double>(levels.front().darks.size()));
  const Estimate dsnu = root(dark_variance);
  out.dsnu_e = {dsnu.value / k, dsnu.u / k};
  std::size_t half = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const auto off = [&](std::size_t j) {
      return std::abs(out.points[j].mean_dn - 0.5 * (saturation_dn + out.points[j].dark_mean_dn));
    };
    if (off(i) < off(half)) half = i;
  }
  Grid<double> flat = mean_frame(levels[half].flats);
  const PixelUse use = ordinary(flat);
  flatten(flat, use);
  const Estimate flat_variance =
      spatial_variance(flat, use, out.points[half].variance_dn2, static_cast<double>(levels[half].flats.size()));
  const double signal = out.points[half].mean_dn - out.points[half].dark_mean_dn;
  const Estimate prnu = root({flat_variance.value - dark_variance.value, std::hypot(flat_variance.u, dark_variance.u)});
  out.prnu = {prnu.value / signal, prnu.u / signal};
}

// EMVA 1288 R3.1, 6.7: signal against exposure, weights 1/signal², so that deviations are relative.
void linearity(PhotonTransfer& out, double saturation_dn, double pixels) {
  std::vector<double> t, y, noise;
  for (const TransferPoint& p : out.points) {
    const double signal = p.mean_dn - p.dark_mean_dn, range = saturation_dn - p.dark_mean_dn;
    if (signal < kLinearLow * range || signal > kLinearHigh * range) continue;
    t.push_back(p.exposure_s);
    y.push_back(signal);
    noise.push_back(std::sqrt(p.variance_dn2 / pixels) / signal);
  }
  if (t.size() < 3) return;
  const Line line = fit_line(t, y, y);
  double sum = 0, largest = 0, noise2 = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double deviation = std::abs(y[i] / (line.intercept.value + line.slope.value * t[i]) - 1);
    sum += deviation;
    largest = std::max(largest, deviation);
    noise2 += noise[i] * noise[i];
  }
  const double n = static_cast<double>(t.size());
  out.linearity_error = {sum / n, std::sqrt(noise2) / n};
  out.largest_deviation = largest;
}

std::array<double, 4> moments_of(std::span<const Frame> frames, const PixelUse& use, double bias_dn) {
  std::array<double, 4> sum{};
  double count = 0;
  for (const Frame& f : frames) {
    for (std::size_t i = 0; i < f.dn.size(); ++i) {
      if (!use[i]) continue;
      const double x = static_cast<double>(f.dn[i]) - bias_dn, x2 = x * x;
      sum[0] += x;
      sum[1] += x2;
      sum[2] += x2 * x;
      sum[3] += x2 * x2;
      count += 1;
    }
  }
  for (double& s : sum) s /= count;
  return sum;
}

void correction(PhotonTransfer& out, std::span<const TransferLevel> levels, const PixelUse& use, double saturation_dn) {
  std::vector<LinearityPoint> points;
  const double range = saturation_dn - out.bias_dn.value;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const TransferPoint& p = out.points[i];
    const double signal = p.mean_dn - p.dark_mean_dn;
    if (signal < kLinearLow * range || signal > kLinearHigh * range || p.saturated > kMostSaturated) continue;
    LinearityPoint point{p.exposure_s, moments_of(levels[i].flats, use, out.bias_dn.value), 0};
    const std::array<double, 4> dark = moments_of(levels[i].darks, use, out.bias_dn.value);
    for (std::size_t k = 0; k < dark.size(); ++k) point.moment[k] -= dark[k];
    const double values = static_cast<double>(levels[i].flats.size() * levels[i].flats.front().dn.size());
    point.u_relative = std::sqrt(p.variance_dn2 / values) / signal;
    points.push_back(point);
  }
  const std::optional<LinearityFit> fit = fit_linearity(points, range);
  if (!fit) return;
  out.linearity = fit->coefficients;
  out.nonlinearity_left = fit->left();
}

}  // namespace

PhotonTransfer photon_transfer(std::span<const TransferLevel> given, std::optional<double> nominal_saturation_dn,
                               std::optional<double> stated_saturation_dn) {
  check(given);
  std::vector<TransferLevel> levels(given.begin(), given.end());
  std::sort(levels.begin(), levels.end(), [](const auto& a, const auto& b) { return a.exposure_s < b.exposure_s; });
  const PixelUse use = ordinary(darks_at_no_exposure(levels), kDefectSigmas, 1);
  PhotonTransfer out;
  out.left_out_pixels = static_cast<std::size_t>(std::count(use.begin(), use.end(), false));
  if (out.left_out_pixels == use.size()) throw Error({"darks", "hold no number that could be compared", {}, {}});
  TemporalNoise shortest;
  for (const TransferLevel& l : levels) {
    const TemporalNoise flat = temporal_noise(l.flats, use), dark = temporal_noise(l.darks, use);
    if (out.points.empty()) shortest = dark;
    out.points.push_back({l.exposure_s, flat.mean, flat.variance, dark.mean, dark.variance,
                          std::hypot(flat.u_variance(), dark.u_variance()), 0, false});
  }
  if (stated_saturation_dn) check_stated(out.points, levels, *stated_saturation_dn);
  out.saturation_dn = stated_saturation_dn ? stated_saturation_dn : saturation_of(out, levels);
  const double saturation = out.saturation_dn.value_or(nominal_saturation_dn.value_or(out.points.back().mean_dn));
  require_growth(out.points, saturation);
  count_saturated(out, levels, use, saturation);
  const auto pixels = static_cast<double>(use.size() - out.left_out_pixels);
  const Line bias = fit_bias(out, pixels);
  correction(out, levels, use, saturation);
  fit_gain(out, saturation);
  fit_dark(out, shortest, bias);
  non_uniformity(out, levels, saturation);
  linearity(out, saturation, pixels);
  return out;
}

}  // namespace scatmap
