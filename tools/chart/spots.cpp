#include "tools/chart/spots.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <optional>
#include <random>

#include "calib/spots.h"
#include "tools/chart/error_sample.h"
#include "tools/chart/timing.h"

namespace scatmap::tools {
namespace {

constexpr int kSide = 48, kFrames = 400;
constexpr double kReadNoise_e = 5, kWidth_px = 1.7, kBackground_e = 3;

// Round and Gaussian, integrated over pixels; written apart from the fit's own.
struct Light {
  double column = 0, row = 0, flux_e = 0, width_px = kWidth_px, background_e = kBackground_e;

  double on_pixel(int c, int r) const {
    const auto share = [&](double from_centre) {
      const double scale = 1 / (width_px * std::numbers::sqrt2);
      return 0.5 * (std::erfc((from_centre - 0.5) * scale) - std::erfc((from_centre + 0.5) * scale));
    };
    return background_e + flux_e * share(c - column) * share(r - row);
  }
};

// Bound on the standard deviation of (column, row) together, flux, width and background unknown too.
double cramer_rao_px(const Light& light) {
  constexpr double Light::*kFree[] = {&Light::column, &Light::row, &Light::flux_e, &Light::width_px,
                                      &Light::background_e};
  Eigen::Matrix<double, 5, 5> information = Eigen::Matrix<double, 5, 5>::Zero();
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c) {
      Eigen::Matrix<double, 5, 1> slope;
      for (Eigen::Index k = 0; k < 5; ++k) {
        const double step = k == 2 ? 1e-3 * light.flux_e : 1e-3;
        Light up = light, down = light;
        up.*kFree[k] += step;
        down.*kFree[k] -= step;
        slope[k] = (up.on_pixel(c, r) - down.on_pixel(c, r)) / (2 * step);
      }
      information += slope * slope.transpose() / (light.on_pixel(c, r) + kReadNoise_e * kReadNoise_e);
    }
  }
  const Eigen::Matrix<double, 5, 5> covariance = information.inverse();
  return std::sqrt(covariance(0, 0) + covariance(1, 1));
}

struct Shot {
  Light truth;
  calib::SpotImage image;
};

Shot shot_of(double flux_e, std::mt19937_64& rng) {
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::normal_distribution<double> normal;
  Shot out{{kSide / 2 + place(rng), kSide / 2 + place(rng), flux_e},
           {Grid<double>(kSide, kSide), Grid<double>(kSide, kSide), Grid<Mask>(kSide, kSide, 0), kBackground_e}};
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c) {
      const auto light = std::poisson_distribution<long long>(out.truth.on_pixel(c, r))(rng);
      out.image.net_e(r, c) = static_cast<double>(light) + kReadNoise_e * normal(rng);
      out.image.floor_e2(r, c) = kReadNoise_e * kReadNoise_e;
    }
  }
  return out;
}

using Place = std::optional<Eigen::Vector2d>;

Place found(const calib::SpotImage& image, calib::SpotMethod method) {
  const calib::SpotsInFrame f = calib::find_spots(image, method);
  if (f.spots.empty()) return std::nullopt;
  return Eigen::Vector2d(f.spots.front().column_px, f.spots.front().row_px);
}

// What is often done: the mean place of everything above a tenth of the highest pixel.
Place centre_of_gravity(const calib::SpotImage& image) {
  const double floor =
      image.background_e + 0.1 * (*std::max_element(image.net_e.begin(), image.net_e.end()) - image.background_e);
  double sum = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c) {
      const double above = image.net_e(r, c) - floor;
      if (!(above > 0)) continue;
      sum += above;
      moment += above * Eigen::Vector2d(c, r);
    }
  }
  if (!(sum > 0)) return std::nullopt;
  return moment / sum;
}

// And the vertex of a parabola through the logarithms of the highest pixel and its neighbours.
Place log_parabola(const calib::SpotImage& image) {
  const auto highest = std::max_element(image.net_e.begin(), image.net_e.end()) - image.net_e.begin();
  const int r = static_cast<int>(highest) / kSide, c = static_cast<int>(highest) % kSide;
  if (r < 1 || c < 1 || r + 1 >= kSide || c + 1 >= kSide) return std::nullopt;
  const auto log_at = [&](int row, int column) {
    return std::log(std::max(image.net_e(row, column) - image.background_e, 1.0));
  };
  const auto vertex = [](double before, double at, double after) {
    return 0.5 * (before - after) / (before - 2 * at + after);
  };
  return Eigen::Vector2d(c + vertex(log_at(r, c - 1), log_at(r, c), log_at(r, c + 1)),
                         r + vertex(log_at(r - 1, c), log_at(r, c), log_at(r + 1, c)));
}

struct Method {
  const char* name;
  std::function<Place(const calib::SpotImage&)> run;
  bool rival;
  const char* note;
};

std::vector<Method> methods() {
  return {{"ml", [](const calib::SpotImage& i) { return found(i, calib::SpotMethod::kMaximumLikelihood); }, false,
           "finding, fit and covariance"},
          {"moments", [](const calib::SpotImage& i) { return found(i, calib::SpotMethod::kMoments); }, false,
           "the same, then windowed moments: no assumption on the shape"},
          {"centre of gravity above a tenth", centre_of_gravity, true, "no uncertainty, no hot pixels, no neighbours"},
          {"parabola of logarithms", log_parabola, true, "no uncertainty, no hot pixels, no neighbours"}};
}

ChartRow row_of(const Method& method, double flux_e, const std::vector<Shot>& shots, double seconds) {
  ChartRow row;
  row.method = method.name;
  char size[32];
  std::snprintf(size, sizeof size, "%.0e electrons", flux_e);
  row.size = size;
  row.rival = method.rival;
  row.time = with_threads(1, [&] {
    return time_per_item(shots.size(), seconds, [&] {
      for (const Shot& s : shots) {
        const Place place = method.run(s.image);
        keep(&place);
      }
    });
  });
  double error2 = 0, bound2 = 0;
  int missed = 0;
  ErrorSample errors;
  for (const Shot& s : shots) {
    const double bound = cramer_rao_px(s.truth);
    const Place place = method.run(s.image);
    if (!place) {
      ++missed;
      continue;
    }
    const double error = (*place - Eigen::Vector2d(s.truth.column, s.truth.row)).norm();
    errors.add(error / bound, static_cast<int>(s.truth.column), static_cast<int>(s.truth.row));
    error2 += error * error;
    bound2 += bound * bound;
  }
  row.largest_error = std::sqrt(error2 / bound2);
  row.p99_error = errors.percentile(99);
  row.note = method.note + std::string(missed > 0 ? "; missed " + std::to_string(missed) : "");
  return row;
}

}  // namespace

std::vector<Chart> chart_spots(const ChartSettings& settings) {
  Chart chart{"spots",
              "Centroids of spots: error over what the light allows",
              "spot",
              "centroid error (rms) over the Cramér-Rao bound",
              "",
              "the simulated centre, 400 frames of 48 x 48 pixels",
              {},
              {},
              {{"Cramér-Rao bound", 1}}};
  for (const double flux_e : {1e3, 1e4, 1e6, 1e7, 1e5}) {  // the picture shows the last
    std::mt19937_64 rng(17);
    std::vector<Shot> shots;
    for (int i = 0; i < kFrames; ++i) shots.push_back(shot_of(flux_e, rng));
    for (const Method& method : methods())
      chart.rows.push_back(row_of(method, flux_e, shots, settings.seconds_per_method / 5));
  }
  return {chart};
}

}  // namespace scatmap::tools
