#include "calib/spots_ml.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace scatmap::calib {
namespace {

using Eigen::Index;

struct FitPixel {
  int column;
  int row;
  double value_e;
  double floor_e2;
};

GaussianSpot widened(const GaussianSpot& s) {
  constexpr double kMargin_px = 1.5;
  return gaussian_spot(s.column_px, s.row_px, s.flux_e,
                       s.covariance_px2() + kMargin_px * kMargin_px * Eigen::Matrix2d::Identity());
}

std::vector<FitPixel> pixels_around(const SpotImage& image, const std::vector<GaussianSpot>& spots) {
  std::vector<GaussianSpot> windows;
  double first_row = image.net_e.rows(), last_row = -1, first_column = image.net_e.columns(), last_column = -1;
  for (const GaussianSpot& s : spots) {
    const GaussianSpot w = windows.emplace_back(widened(s));
    const double half_rows = kFitReach * std::hypot(w.shear_px, w.row_sd_px), half_columns = kFitReach * w.column_sd_px;
    first_row = std::min(first_row, w.row_px - half_rows);
    last_row = std::max(last_row, w.row_px + half_rows);
    first_column = std::min(first_column, w.column_px - half_columns);
    last_column = std::max(last_column, w.column_px + half_columns);
  }
  const auto clamped = [](double v, int size) { return static_cast<int>(std::clamp(v, 0.0, size - 1.0)); };
  std::vector<FitPixel> out;
  for (int r = clamped(first_row, image.net_e.rows()); r <= clamped(last_row, image.net_e.rows()); ++r) {
    for (int c = clamped(first_column, image.net_e.columns()); c <= clamped(last_column, image.net_e.columns()); ++c) {
      if (image.mask(r, c) != 0) continue;
      const bool inside = std::any_of(windows.begin(), windows.end(), [&](const GaussianSpot& w) {
        return w.distance2(c, r) <= kFitReach * kFitReach;
      });
      if (inside) out.push_back({c, r, image.net_e(r, c), image.floor_e2(r, c)});
    }
  }
  return out;
}

struct Model {
  std::vector<GaussianSpot> spots;
  double background_e = 0;
};

Index parameter_count(const Model& m) { return static_cast<Index>(m.spots.size()) * kSpotParameters + 1; }

struct Normal {
  double log_likelihood = 0;
  Eigen::MatrixXd information;
  Eigen::VectorXd score;
  double chi2 = 0;
};

// Log likelihood relative to an expectation of 0; below 0 its tangent continues as that of normal noise.
double log_likelihood(double value, double expected, double floor) {
  if (expected >= 0) return (value + floor) * std::log1p(expected / floor) - expected;
  return (value - 0.5 * expected) * expected / floor;
}

Normal normal_equations(const std::vector<FitPixel>& pixels, const Model& model) {
  const Index n = parameter_count(model);
  Normal out{0, Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0};
  std::vector<PixelGaussian> gaussians(model.spots.begin(), model.spots.end());
  Eigen::VectorXd gradient(n);
  gradient(n - 1) = 1;
  for (const FitPixel& p : pixels) {
    double expected = model.background_e;
    for (std::size_t k = 0; k < gaussians.size(); ++k) {
      const PixelExpectation e = gaussians[k].at(p.column, p.row);
      expected += e.value_e;
      for (int j = 0; j < kSpotParameters; ++j)
        gradient(static_cast<Index>(k) * kSpotParameters + j) = e.gradient[static_cast<std::size_t>(j)];
    }
    const double variance = p.floor_e2 + std::max(0.0, expected), residual = p.value_e - expected;
    out.log_likelihood += log_likelihood(p.value_e, expected, p.floor_e2);
    out.chi2 += residual * residual / variance;
    out.score += gradient * (residual / variance);
    out.information.selfadjointView<Eigen::Lower>().rankUpdate(gradient, 1 / variance);
  }
  out.information = Eigen::MatrixXd(out.information.selfadjointView<Eigen::Lower>());
  return out;
}

// One step of at most two standard deviations of the spot and a factor e in flux and width.
Model moved(const Model& model, const Eigen::VectorXd& step) {
  Model out = model;
  for (std::size_t k = 0; k < out.spots.size(); ++k) {
    GaussianSpot& s = out.spots[k];
    const auto d = step.segment<kSpotParameters>(static_cast<Index>(k) * kSpotParameters);
    const double across = std::hypot(s.shear_px, s.row_sd_px);
    s.column_px += std::clamp(d(kColumn), -2 * s.column_sd_px, 2 * s.column_sd_px);
    s.row_px += std::clamp(d(kRow), -2 * across, 2 * across);
    s.flux_e *= std::exp(std::clamp(d(kLogFlux), -1.0, 1.0));
    s.column_sd_px *= std::exp(std::clamp(d(kLogColumnSd), -1.0, 1.0));
    s.shear_px += std::clamp(d(kShear), -across, across);
    s.row_sd_px *= std::exp(std::clamp(d(kLogRowSd), -1.0, 1.0));
  }
  out.background_e += step(step.size() - 1);
  return out;
}

bool sane(const Model& m) {
  constexpr double kNarrowest_px = 0.05;
  return std::all_of(m.spots.begin(), m.spots.end(), [](const GaussianSpot& s) {
    return s.column_sd_px > kNarrowest_px && s.row_sd_px > kNarrowest_px && std::isfinite(s.flux_e) &&
           std::isfinite(s.column_px + s.row_px);
  });
}

struct Solution {
  Model model;
  Normal at;
  bool converged = false;
};

Solution maximise(const std::vector<FitPixel>& pixels, const Model& start) {
  constexpr int kMaxIterations = 100;
  constexpr double kDone = 1e-10;  // squared step in standard deviations of the estimate
  Solution s{start, normal_equations(pixels, start), false};
  double damping = 1e-3;
  for (int i = 0; i < kMaxIterations && damping < 1e12; ++i) {
    Eigen::MatrixXd damped = s.at.information;
    damped.diagonal() *= 1 + damping;
    const Eigen::VectorXd step = damped.ldlt().solve(s.at.score);
    if (!step.allFinite()) break;
    const double progress = step.dot(s.at.score);
    const Model trial = moved(s.model, step);
    if (!sane(trial)) {
      damping *= 10;
      continue;
    }
    Normal at = normal_equations(pixels, trial);
    const double noise = 1e-13 * std::abs(s.at.log_likelihood);
    if (at.log_likelihood >= s.at.log_likelihood - noise) {
      s.model = trial;
      s.at = std::move(at);
      damping = std::max(1e-9, damping / 10);
      if (progress < kDone) return {s.model, s.at, true};
    } else {
      damping *= 10;
    }
  }
  return s;
}

double expected_at(const FitPixel& p, const std::vector<PixelGaussian>& gaussians, double background_e) {
  for (const PixelGaussian& g : gaussians) background_e += g.at(p.column, p.row).value_e;
  return background_e;
}

struct Residual {
  double value_e;
  double variance_e2;
};

std::vector<Residual> residuals(const std::vector<FitPixel>& pixels, const Model& model) {
  const std::vector<PixelGaussian> gaussians(model.spots.begin(), model.spots.end());
  std::vector<Residual> out;
  for (const FitPixel& p : pixels) {
    const double expected = expected_at(p, gaussians, model.background_e);
    out.push_back({p.value_e - expected, p.floor_e2 + std::max(0.0, expected)});
  }
  return out;
}

// The variance to add to every pixel that brings chi2 down to the degrees of freedom; 0 if it is there already.
double model_error_e2(const std::vector<Residual>& rest, double degrees_of_freedom) {
  const auto chi2 = [&](double extra) {
    double sum = 0;
    for (const Residual& r : rest) sum += r.value_e * r.value_e / (r.variance_e2 + extra);
    return sum;
  };
  if (!(chi2(0) > degrees_of_freedom)) return 0;
  double low = 0, high = 1;
  while (chi2(high) > degrees_of_freedom) high *= 4;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (chi2(middle) > degrees_of_freedom ? low : high) = middle;
  }
  return high;
}

// Residuals in standard deviations, where they are fitted; NaN elsewhere, and along a border of one pixel.
struct ResidualImage {
  int first_column;
  int first_row;
  Grid<double> sigmas;

  double& at(const FitPixel& p) { return sigmas(p.row - first_row + 1, p.column - first_column + 1); }
};

ResidualImage residual_image(const std::vector<FitPixel>& pixels, const Model& model) {
  const auto [left, right] = std::minmax_element(pixels.begin(), pixels.end(),
                                                 [](const auto& a, const auto& b) { return a.column < b.column; });
  const auto [top, bottom] =
      std::minmax_element(pixels.begin(), pixels.end(), [](const auto& a, const auto& b) { return a.row < b.row; });
  ResidualImage out{
      left->column, top->row, {bottom->row - top->row + 3, right->column - left->column + 3, std::nan("")}};
  const std::vector<Residual> values = residuals(pixels, model);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    out.at(pixels[i]) = values[i].value_e / std::sqrt(values[i].variance_e2);
  return out;
}

// Stands out, up or down, while its four neighbours do not follow.
bool stands_alone(const Grid<double>& sigmas, int row, int column) {
  constexpr double kNeighbourShare = 0.2;
  const double sign = std::copysign(1.0, sigmas(row, column)), value = sign * sigmas(row, column);
  if (!(value > kHotPixelSigmas)) return false;
  double sum = 0, count = 0;
  for (const double n :
       {sigmas(row - 1, column), sigmas(row + 1, column), sigmas(row, column - 1), sigmas(row, column + 1)}) {
    if (!std::isfinite(n)) continue;
    sum += sign * n;
    count += 1;
  }
  return count >= 2 && sum < kNeighbourShare * value * count;
}

// Residuals that stand alone are hot or dead pixels or cosmic hits. Many of them are none: then the light is no
// Gaussian.
std::size_t drop_hot(SpotImage& image, std::vector<FitPixel>& pixels, const Model& model) {
  const ResidualImage rest = residual_image(pixels, model);
  const auto hot = [&](const FitPixel& p) {
    return stands_alone(rest.sigmas, p.row - rest.first_row + 1, p.column - rest.first_column + 1);
  };
  const auto found = static_cast<std::size_t>(std::count_if(pixels.begin(), pixels.end(), hot));
  if (found == 0 || found * 100 > pixels.size()) return 0;
  for (const FitPixel& p : pixels) {
    if (hot(p)) image.mask(p.row, p.column) |= kHot;
  }
  return std::erase_if(pixels, hot);
}

// Light that is no Gaussian: its error enters as one variance for all pixels, so that the weights, and with them the
// centre, do not hang on the noise that happens to be there.
Solution with_model_error(std::vector<FitPixel>& pixels, Solution solution) {
  constexpr int kRounds = 3;
  const double dof = static_cast<double>(pixels.size()) - static_cast<double>(parameter_count(solution.model));
  std::vector<FitPixel> noise_only = pixels;
  for (int i = 0; i < kRounds && solution.converged; ++i) {
    const double extra = model_error_e2(residuals(noise_only, solution.model), dof);
    for (std::size_t k = 0; k < pixels.size(); ++k) pixels[k].floor_e2 = noise_only[k].floor_e2 + extra;
    solution = maximise(pixels, solution.model);
  }
  return solution;
}

double share_of_axis(const Model& a, const Model& b) {
  double largest = 0;
  for (std::size_t k = 0; k < a.spots.size(); ++k) {
    const auto& p = a.spots[k];
    const auto& q = b.spots[k];
    largest = std::max({largest, std::abs(p.column_sd_px / q.column_sd_px - 1), std::abs(p.row_sd_px / q.row_sd_px - 1),
                        std::sqrt(p.distance2(q.column_px, q.row_px))});
  }
  return largest;
}

// The window follows the spot until both agree. nullopt: too few pixels.
std::optional<Solution> fit_in_moving_window(const SpotImage& image, Model model, std::vector<FitPixel>& pixels) {
  constexpr int kMaxWindows = 8;
  constexpr double kSameWindow = 0.1;  // of the spot's width
  std::optional<Solution> solution;
  for (int i = 0; i < kMaxWindows; ++i) {
    const Model window = model;
    pixels = pixels_around(image, window.spots);
    if (static_cast<Index>(pixels.size()) <= parameter_count(model)) return std::nullopt;
    solution = maximise(pixels, model);
    if (!solution->converged) break;
    model = solution->model;
    if (share_of_axis(model, window) < kSameWindow) break;
  }
  return solution;
}

constexpr double kMisfitSigmas = 5;  // of the scatter of chi2

}  // namespace

Eigen::Matrix2d SpotFit::centre_covariance(std::size_t spot) const {
  const auto at = static_cast<Index>(spot) * kSpotParameters;
  return covariance.block<2, 2>(at, at) + ambiguity_of(spot);
}

Eigen::Matrix2d SpotFit::ambiguity_of(std::size_t spot) const {
  return spot < ambiguity_px2.size() ? ambiguity_px2[spot] : Eigen::Matrix2d::Zero();
}

SpotFit fit_spots(SpotImage& image, std::vector<GaussianSpot> start) {
  SpotFit out;
  std::vector<FitPixel> pixels;
  std::optional<Solution> solution = fit_in_moving_window(image, {std::move(start), image.background_e}, pixels);
  if (!solution) return out;
  const Index n = parameter_count(solution->model);
  const auto judge = [&] {
    out.chi2 = solution->at.chi2;
    out.degrees_of_freedom = static_cast<int>(pixels.size()) - static_cast<int>(n);
    const double ratio = out.chi2 / out.degrees_of_freedom;
    out.misfit = out.degrees_of_freedom < 1 || ratio > 1 + kMisfitSigmas * std::sqrt(2.0 / out.degrees_of_freedom);
    if (out.misfit) solution = with_model_error(pixels, *solution);
  };
  const std::vector<FitPixel> all = pixels;
  judge();
  if (solution->converged && drop_hot(image, pixels, solution->model) > 0) {
    pixels = all;
    std::erase_if(pixels, [&](const FitPixel& p) { return image.mask(p.row, p.column) != 0; });
    solution = maximise(pixels, solution->model);
    judge();
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(solution->at.information);
  out.spots = solution->model.spots;
  out.background_e = solution->model.background_e;
  out.covariance = factor.solve(Eigen::MatrixXd::Identity(n, n));
  const bool definite =
      factor.isPositive() && out.covariance.allFinite() && (out.covariance.diagonal().array() > 0).all();
  out.converged = solution->converged && definite && out.degrees_of_freedom > 0;
  return out;
}

}  // namespace scatmap::calib
