#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <string>

#include "scatmap/angles/lens.h"
#include "scatmap/angles/opencv_lens.h"
#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"
#include "tools/chart/lens_truth.h"
#include "tools/chart/stability.h"

namespace scatmap::tools {
namespace {

struct Setup {
  OpencvLens lens;
  int columns = 31, rows = 21;
  int first_column = 0, first_row = 0;  // of the pixels asked for
};

struct Regime {
  const char* name;
  Setup setup;
};

// A frame of about 50 degrees, centre beside a pixel's.
Setup with(std::array<double, 12> k) { return {{30, 29.5, 15.3, 10.2, k}}; }

template <class Change>
Setup changed(Setup s, Change change) {
  change(s);
  return s;
}

constexpr std::array<double, 12> kWide{-0.25, 0.06, 1e-3, -2e-3, 0.01, 0.02, -0.01, 0.004};

std::vector<Regime> regimes() {
  const auto centred = [](double off_px) {
    return changed(with(kWide), [&](Setup& s) {
      s.lens.cx = 15 + off_px;
      s.lens.cy = 10 + off_px;
    });
  };
  return {
      {"wide-angle lens, eight parameters", with(kWide)},
      {"no distortion", with({})},
      {"distortion of 1e-300", with({1e-300, 1e-300, 1e-300, 1e-300})},
      {"strong barrel, k1 = -0.3", with({-0.3})},
      {"strong barrel, k4 = 3", with({0, 0, 0, 0, 0, 3})},
      {"strong pincushion, k1 = 2", with({2})},
      {"strong pincushion, k4 = -1, near its pole", with({0, 0, 0, 0, 0, -1})},
      {"denominator 0 within the frame", with({0, 0, 0, 0, 0, -6})},
      {"denominator 0, positive again farther out", with({0, 0, 0, 0, 0, -6, 0, 9})},
      {"tangential only, 0.02", with({0, 0, 0.02, -0.02})},
      {"tangential only, 0.2: folds back", with({0, 0, 0.2, -0.2})},
      {"folds back within the frame", with({-2})},
      {"folds back and grows again", with({-2, 1.6})},
      {"folds back twice", with({-2, 1.6, 0, 0, -0.2})},
      {"folds back at the centre, tangential", with({-2, 1.6, 0.01, 0.02})},
      {"a pixel on the principal point", centred(0)},
      {"principal point 1e-12 px off a pixel", centred(1e-12)},
      {"principal point 1e5 px off the frame", changed(with({}), [](Setup& s) { s.lens.cx = 1e5; })},
      {"pixels 1e3 px off the frame", changed(with(kWide), [](Setup& s) { s.first_column = s.first_row = 1000; })},
      {"pixels 1e9 px off the frame, no distortion",
       changed(with({}), [](Setup& s) { s.first_column = s.first_row = 1000000000; })},
      {"focal lengths of 1e9 px", changed(with(kWide), [](Setup& s) { s.lens.fx = s.lens.fy = 1e9; })},
      {"focal lengths of 1 px", changed(with({}), [](Setup& s) { s.lens.fx = s.lens.fy = 1; })},
      {"focal lengths of 1e-3 px", changed(with({}), [](Setup& s) { s.lens.fx = s.lens.fy = 1e-3; })},
      {"focal length negative (mirrored)", changed(with(kWide), [](Setup& s) { s.lens.fx = -s.lens.fx; })},
      {"one pixel", changed(with(kWide), [](Setup& s) { s.columns = s.rows = 1; })},
      {"one row", changed(with(kWide), [](Setup& s) { s.rows = 1; })},
  };
}

struct Rays {
  Grid<double> x, y;  // NaN: none
};

Rays by_newton(const Setup& s) {
  Rays out{{s.rows, s.columns}, {s.rows, s.columns}};
  for (int r = 0; r < s.rows; ++r)
    unproject_row(s.lens, s.first_row + r, {s.first_column, s.first_column + s.columns},
                  {out.x.row(r), out.y.row(r), {}});
  return out;
}

Rays by_angles(const Setup& s) {
  Rays out{{s.rows, s.columns}, {s.rows, s.columns}};
  Grid<double> theta(s.rows, s.columns), phi(s.rows, s.columns);
  Grid<Mask> mask(s.rows, s.columns);
  for (int r = 0; r < s.rows; ++r) {
    AngleRow<double> row;
    row.theta_s_rad = theta.row(r);
    row.phi_s_rad = phi.row(r);
    row.mask = mask.row(r);
    lens_angle_row(s.lens, Matrix3<double>::Identity(), s.first_row + r, {s.first_column, s.first_column + s.columns},
                   row);
  }
  for (std::size_t i = 0; i < theta.size(); ++i) {
    // A number that is masked, or none that is not, is made to fail.
    const bool consistent = std::isnan(theta[i]) == (mask[i] != 0);
    const double tangent = consistent ? std::tan(theta[i]) : HUGE_VAL;
    out.x[i] = -tangent * std::cos(phi[i]);
    out.y[i] = -tangent * std::sin(phi[i]);
  }
  return out;
}

// Through a camera model file: whole frames only.
Rays by_file(const Setup& s, LensInverse inverse) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("scatmap-stability-" + std::to_string(getpid()) + ".cameramodel");
  write_text_file(file, cameramodel_of(s.lens, s.columns, s.rows), Overwrite::kForce);
  std::optional<LensRays> rays;
  try {
    rays = load_lens_rays(file, s.columns, s.rows, inverse);
  } catch (...) {
    std::filesystem::remove(file);
    throw;
  }
  std::filesystem::remove(file);
  Rays out{{s.rows, s.columns}, {s.rows, s.columns}};
  for (std::size_t i = 0; i < out.x.size(); ++i) {
    const Vector3<double>& d = rays->direction[i];
    out.x[i] = d.x() / d.z();
    out.y[i] = d.y() / d.z();
  }
  return out;
}

struct Method {
  const char* name;
  std::function<Rays(const Setup&)> rays;
  bool of_file = false;  // whole frames only
  bool of_angles = false;
  bool of_mrcal = false;  // to compare: scatmap takes its own inverse for these models
};

std::vector<Method> methods() {
  return {{"rays", by_newton},
          {"angles", by_angles, false, true},
          {".cameramodel", [](const Setup& s) { return by_file(s, LensInverse::kFastest); }, true},
          {"mrcal_unproject", [](const Setup& s) { return by_file(s, LensInverse::kMrcal); }, true, false, true}};
}

using Truth = std::vector<std::optional<LensPoint>>;

Truth truth_of(const Setup& s) {
  Truth out;
  for (int r = 0; r < s.rows; ++r) {
    for (int c = 0; c < s.columns; ++c) out.push_back(true_ray(s.lens, s.first_column + c, s.first_row + r));
  }
  return out;
}

// kLensMaxError_px as its comment widens it, and what angles and mrcal's search add.
double allowed_px(const Setup& s, const Method& m, const LensPoint& ray, double column, double row) {
  constexpr double kUnits = 4 * std::numeric_limits<double>::epsilon(), kMrcal_px = 1e-6;
  const double rounding = rounding_px(s.lens, ray);
  double out =
      std::max({kLensMaxError_px, kUnits * (std::abs(column - s.lens.cx) + std::abs(row - s.lens.cy)), 2 * rounding});
  if (m.of_file) out += 3 * rounding;  // unit vectors
  if (m.of_angles) out += 2 * kVectorMaxError_rad * pixels_per_rad(s.lens, ray);
  return m.of_mrcal ? std::max(out, kMrcal_px) : out;
}

// Fills the error and the bound of the pixel that comes nearest to its bound, or exceeds it most.
void compare(const Setup& s, const Method& m, const Rays& rays, const Truth& truth, StabilityCell& cell) {
  constexpr double kSameBranch = 1e-3;
  double worst = -1;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool given = !std::isnan(rays.x[i]);
    if (given != truth[i].has_value()) {
      cell.reason = given ? "a ray where there is none" : "no ray where there is one";
      continue;
    }
    if (!given) continue;
    const double column = s.first_column + static_cast<double>(i % static_cast<std::size_t>(s.columns)),
                 row = s.first_row + static_cast<double>(i / static_cast<std::size_t>(s.columns));
    const LensPoint p = projected(s.lens, rays.x[i], rays.y[i]);
    const double error = static_cast<double>(std::hypot(p.x - column, p.y - row)),
                 allowed = allowed_px(s, m, *truth[i], column, row);
    const long double apart = std::hypot(rays.x[i] - truth[i]->x, rays.y[i] - truth[i]->y);
    if (!(apart <= kSameBranch * (1 + std::hypot(truth[i]->x, truth[i]->y)))) cell.reason = "a ray of another branch";
    if (error / allowed <= worst) continue;
    worst = error / allowed;
    cell.worst_error = error;
    cell.bound = allowed;
  }
}

// Every parameter moved by `step(value, typical)`.
template <class Step>
Setup moved(Setup s, Step step) {
  constexpr double kFocal = 1e-6, kCentre_px = 1e-3, kCoefficient = 1e-6;
  for (double* v : {&s.lens.fx, &s.lens.fy}) *v = step(*v, kFocal * *v);
  for (double* v : {&s.lens.cx, &s.lens.cy}) *v = step(*v, std::min(kCentre_px, kFocal * std::abs(s.lens.fx)));
  for (std::size_t i = 0; i < 8; ++i) s.lens.k[i] = step(s.lens.k[i], kCoefficient);
  return s;
}

// A regime with its truth, and both as every parameter moves.
struct Case {
  Setup setup;
  Truth truth;
};
struct Cases {
  Case plain, by_ulp, by_sigma;
};

Cases cases_of(const Setup& s) {
  std::mt19937_64 rng(8);
  const auto sign = [&rng] { return rng() % 2 == 0 ? -1.0 : 1.0; };
  const auto with_truth = [](const Setup& setup) { return Case{setup, truth_of(setup)}; };
  return {with_truth(s),
          with_truth(moved(s, [&](double v, double) { return v == 0 ? v : std::nextafter(v, sign() * HUGE_VAL); })),
          with_truth(moved(s, [&](double v, double typical) { return v + sign() * typical; }))};
}

double amplification(const Method& m, const Rays& rays, const Truth& truth, const Case& stepped) {
  const Rays after = m.rays(stepped.setup);
  double answer = 0;
  long double change = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto& moved_truth = stepped.truth[i];
    if (!truth[i] || !moved_truth || std::isnan(rays.x[i]) || std::isnan(after.x[i])) continue;
    answer = std::max(answer, std::hypot(after.x[i] - rays.x[i], after.y[i] - rays.y[i]));
    change = std::max(change, std::hypot(moved_truth->x - truth[i]->x, moved_truth->y - truth[i]->y));
  }
  return change > 0 ? answer / static_cast<double>(change) : std::numeric_limits<double>::quiet_NaN();
}

void judge(const Cases& cases, const Method& m, StabilityCell& cell) {
  const auto& [s, truth] = cases.plain;
  if (m.of_file && (s.first_column != 0 || s.first_row != 0))
    throw Error({"camera model", "has a frame of its own, which begins at (0, 0)", {}, {}});
  const Rays rays = m.rays(s);
  compare(s, m, rays, truth, cell);
  cell.amplification_ulp = amplification(m, rays, truth, cases.by_ulp);
  cell.amplification_sigma = amplification(m, rays, truth, cases.by_sigma);
  if (cell.reason.empty() && cell.worst_error <= cell.bound) {
    cell.verdict = Verdict::kHolds;
    if (std::isnan(cell.amplification_sigma))
      cell.reason = "amplification by sigma: none, no pixel keeps its ray when the distortion moves off 0";
  } else if (m.of_mrcal) {
    cell.verdict = Verdict::kFallsBack;
    if (!cell.reason.empty()) cell.worst_error = std::numeric_limits<double>::quiet_NaN();
    cell.reason =
        (cell.reason.empty() ? "beyond its bound" : cell.reason) + ": scatmap takes its own inverse for this model";
  }
}

// Files with a lens that mrcal's reader or ours does not take.
bool may_refuse(const Setup& s, const Method& m) {
  return m.of_file && (s.first_column != 0 || s.first_row != 0 || s.lens.fx < 0);
}

}  // namespace

std::vector<StabilityCell> stability_lens() {
  std::vector<StabilityCell> out;
  for (const Regime& regime : regimes()) {
    const Cases cases = cases_of(regime.setup);
    for (const Method& method : methods()) {
      StabilityCell cell;
      cell.job = "lens";
      cell.regime = regime.name;
      cell.method = method.name;
      cell.unit = "px";
      try {
        judge(cases, method, cell);
      } catch (const Error& e) {
        cell.verdict = method.of_mrcal || may_refuse(regime.setup, method) ? Verdict::kRefuses : Verdict::kFails;
        cell.reason = e.what();
        if (const auto at = cell.reason.find(".cameramodel: "); at != std::string::npos) cell.reason.erase(0, at + 1);
      }
      out.push_back(cell);
    }
  }
  return out;
}

}  // namespace scatmap::tools
