#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "scatmap/base/error.h"
#include "tools/chart/spot_regimes.h"
#include "tools/chart/stability.h"

namespace scatmap::tools {
namespace {

using calib::Spot;
using calib::SpotFlags;
using calib::SpotMethod;
using calib::SpotsInFrame;

constexpr int kFrames = 12;

struct Method {
  const char* name;
  SpotMethod method;
};

constexpr Method kMethods[] = {{"ml", SpotMethod::kMaximumLikelihood}, {"moments", SpotMethod::kMoments}};

std::string flag_names(SpotFlags flags) {
  std::string out;
  for (const calib::SpotFlag& f : calib::kSpotFlags) {
    if ((flags & f.bit) != 0) out += (out.empty() ? "" : ", ") + std::string(f.name);
  }
  return out;
}

// Each spot's; of light as good as one Gaussian's a line of them.
std::vector<Eigen::Vector2d> true_centres(const SpotRegime& regime) {
  constexpr int kSteps = 100;
  std::vector<Eigen::Vector2d> out;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double flux = 0;
  for (const SpotLight& l : regime.scene.spots) {
    out.emplace_back(l.column_px, l.row_px);
    sum += l.flux_e * out.back();
    flux += l.flux_e;
  }
  const Eigen::Vector2d first = out.front(), along = sum / flux - first;
  for (int i = 1; regime.as_one && i <= kSteps; ++i) out.emplace_back(first + i / static_cast<double>(kSteps) * along);
  return out;
}

// Error of the worse axis in its stated standard uncertainty, from the nearest true centre; NaN stays NaN.
double error_in_sigmas(const Spot& s, const std::vector<Eigen::Vector2d>& centres) {
  double nearest = HUGE_VAL;
  for (const Eigen::Vector2d& centre : centres) {
    const Eigen::Vector2d off = (Eigen::Vector2d(s.column_px, s.row_px) - centre).cwiseAbs();
    const Eigen::Vector2d in_sigmas = off.cwiseQuotient(s.covariance_px2.diagonal().cwiseSqrt());
    if (!std::isfinite(in_sigmas.sum())) return NAN;
    nearest = std::min(nearest, in_sigmas.maxCoeff());
  }
  return nearest;
}

struct Judged {
  double worst = 0;
  int frames = 0;  // with a spot
  SpotFlags flags = 0;
  std::string refusal;
};

// The strongest spot of each frame: what becomes a target.
Judged judged(const SpotRegime& regime, SpotMethod method) {
  const Grid<double> light = expected_light_e(regime.scene);
  const std::vector<Eigen::Vector2d> centres = true_centres(regime);
  Judged out;
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    const SpotsInFrame found = measured(regime.scene, exposed(regime.scene, light, 100 + i), method);
    if (found.spots.empty()) {
      out.refusal = found.dropped.empty() ? "nothing stands out" : found.dropped.front();
      continue;
    }
    const Spot& s = found.spots.front();
    const double error = error_in_sigmas(s, centres);
    ++out.frames;
    out.flags |= s.flags;
    if (!(error <= out.worst)) out.worst = error;
  }
  return out;
}

// Change of the answer over that of the truth when every spot moves by (step, step), under the same noise.
double amplification(const SpotScene& scene, SpotMethod method, double step_px) {
  SpotScene stepped = scene;
  for (SpotLight& l : stepped.spots) {
    l.column_px += step_px;
    l.row_px += step_px;
  }
  const auto answer = [&](const SpotScene& s) { return measured(s, exposed(s, expected_light_e(s), 100), method); };
  const SpotsInFrame before = answer(scene), after = answer(stepped);
  if (before.spots.empty() || after.spots.empty()) return NAN;
  const Spot& from = before.spots.front();
  double nearest = HUGE_VAL;  // the order of two alike may change
  for (const Spot& to : after.spots)
    nearest = std::min(nearest, std::hypot(to.column_px - from.column_px, to.row_px - from.row_px));
  return nearest / (std::numbers::sqrt2 * step_px);
}

void judge(const SpotRegime& regime, SpotMethod method, StabilityCell& cell) {
  constexpr double kUlp_px = 0x1p-19, kSigma_px = 0.01;  // frames are float32: the last place of a column of 24
  const Judged j = judged(regime, method);
  if (j.frames == 0 && regime.expectation != SpotExpectation::kFound) {
    cell.verdict = Verdict::kRefuses;
    cell.reason = j.refusal;
    return;
  }
  cell.worst_error = j.worst;
  cell.amplification_ulp = amplification(regime.scene, method, kUlp_px);
  cell.amplification_sigma = amplification(regime.scene, method, kSigma_px);
  if (regime.expectation == SpotExpectation::kNone) {
    cell.reason = "a spot where there is none";
  } else if (j.frames < kFrames && regime.expectation == SpotExpectation::kFound) {
    cell.reason = "no spot in some frames: " + j.refusal;
  } else if (j.worst <= cell.bound) {
    cell.verdict = Verdict::kHolds;
    if (j.flags != 0) cell.reason = "flagged " + flag_names(j.flags);
    if (j.frames < kFrames) cell.reason += std::string(cell.reason.empty() ? "" : "; ") + "some frames: " + j.refusal;
  }
}

}  // namespace

std::vector<StabilityCell> stability_spots() {
  // Standard uncertainties, shape errors too small to see included: one number in two million lies beyond by chance.
  constexpr double kBound = 5;
  std::vector<StabilityCell> out;
  for (const SpotRegime& regime : spot_regimes()) {
    for (const auto& [name, method] : kMethods) {
      StabilityCell cell;
      cell.job = "spots";
      cell.regime = regime.name;
      cell.method = name;
      cell.unit = "sigma";
      cell.bound = kBound;
      try {
        judge(regime, method, cell);
      } catch (const Error& e) {
        cell.verdict = regime.expectation == SpotExpectation::kNone ? Verdict::kRefuses : Verdict::kFails;
        cell.reason = e.what();
      }
      out.push_back(cell);
    }
  }
  return out;
}

}  // namespace scatmap::tools
