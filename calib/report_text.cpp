#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "calib/report.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

// printf into the end of a string.
[[gnu::format(printf, 2, 3)]] void add(std::string& text, const char* format, ...) {
  char line[1024];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  text += line;
}

void add_directions(const CalibrationResult& r, std::string& text) {
  text += "direction of a pixel, standard uncertainty of the calibration alone:\n";
  for (const DirectionSigma& d : r.directions) {
    add(text, "  stage %8.3f deg, %-26s %9.4f mrad (%.5f deg); %.3f px across columns, %.3f px across rows\n",
        d.point.pose.stage_rad * kDegPerRad, (d.point.where + ":").c_str(), d.rad * 1e3, d.rad * kDegPerRad,
        d.column_px, d.row_px);
  }
  const Instrument& in = r.instrument;
  if (in.arm_encoder_sigma_rad > 0 || in.stage_encoder_sigma_rad > 0) {
    add(text, "  each setting of the motors adds its own encoder error: arm %.5f deg, stage %.5f deg\n",
        in.arm_encoder_sigma_rad * kDegPerRad, in.stage_encoder_sigma_rad * kDegPerRad);
  }
}

void add_parameters(const CalibrationResult& r, std::string& text) {
  add(text, "\n%-28s %14s %14s %12s  how\n", "parameter", "nominal", "value", "sigma");
  for (const ParameterResult& p : r.parameters) {
    add(text, "%-28s %14.7g %14.7g ", p.name.c_str(), p.nominal, p.value);
    if (p.outcome == Outcome::kLeftOut) {
      add(text, "%12.3g  left out, not needed: may shift directions by %.3f px\n", p.sigma, p.bound_px);
    } else if (p.outcome == Outcome::kHeld) {
      add(text, "%12s  held\n", "-");
    } else if (p.outcome == Outcome::kCarried) {
      add(text, "%12.3g  carried: mostly its prior, sigma %.3g\n", p.sigma, *p.prior_sigma);
    } else {
      add(text, p.prior_sigma ? "%12.3g  fitted, with a prior of sigma %.3g\n" : "%12.3g  fitted\n", p.sigma,
          p.prior_sigma.value_or(0));
    }
  }
}

void add_correlations(const CalibrationResult& r, std::string& text) {
  constexpr double kStrong = 0.9;
  std::string lines;
  for (Eigen::Index a = 0; a < r.covariance.rows(); ++a) {
    for (Eigen::Index b = 0; b < a; ++b) {
      const double c = r.covariance(a, b) / std::sqrt(r.covariance(a, a) * r.covariance(b, b));
      if (!(std::abs(c) > kStrong)) continue;
      add(lines, "  %+.4f  %s, %s\n", c,
          r.parameters[static_cast<std::size_t>(r.set[static_cast<std::size_t>(b)].index)].name.c_str(),
          r.parameters[static_cast<std::size_t>(r.set[static_cast<std::size_t>(a)].index)].name.c_str());
    }
  }
  if (!lines.empty()) text += "\ncorrelations above 0.9:\n" + lines;
}

void add_quality(const CalibrationResult& r, std::string& text) {
  text += "\nchi-square:\n";
  for (const ChiSquare& c : r.chi2) {
    if (!(c.degrees > 1e-6)) continue;
    add(text, "  %-26s %10.2f for %8.2f degrees of freedom: %.3f\n", c.part.c_str(), c.value, c.degrees,
        c.value / c.degrees);
  }
  if (std::isfinite(r.left_out_rms))
    add(text, "leave-one-out residuals: %.3f standard deviations rms\n", r.left_out_rms);
  add(text, "condition %.3g, %d iterations\n", r.condition, r.iterations);
}

void add_targets(const TargetList& list, const CalibrationResult& r, std::string& text) {
  std::string lines;
  for (std::size_t i = 0; i < r.targets.size(); ++i) {
    const TargetResult& t = r.targets[i];
    if (t.used) continue;
    const std::string name = label(list, list.targets[i]);
    if (!t.residual_px.allFinite()) {
      add(lines, "  %s: its beam never meets the detector\n", name.c_str());
    } else {
      add(lines, "  %s: off by (%+.2f, %+.2f) px, %.1f standard deviations\n", name.c_str(), -t.residual_px[0],
          -t.residual_px[1], t.distance);
    }
  }
  if (!lines.empty()) text += "\ntargets left out:\n" + lines;
}

}  // namespace

const char* to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::kFitted:
      return "fitted";
    case Outcome::kCarried:
      return "carried";
    case Outcome::kLeftOut:
      return "left out";
    case Outcome::kHeld:
      return "held";
  }
  return "";
}

std::string report_text(const TargetList& list, const CalibrationResult& result) {
  std::string text;
  add_directions(result, text);
  if (!result.findings.empty()) text += "\n";
  for (const std::string& f : result.findings) text += "note: " + f + "\n";
  for (const BlindDirection& b : result.observability.blind) text += "note: " + sentence(b) + "\n";
  add_parameters(result, text);
  add_correlations(result, text);
  add_quality(result, text);
  add_targets(list, result, text);
  return text;
}

}  // namespace scatmap::calib
