#include <cmath>
#include <random>

#include "data-synthetic/truth_model.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "scatmap/compare/model_map.h"
#include "scatmap/model/model_toml.h"
#include "tools/chart/scene.h"
#include "tools/chart/stability.h"

namespace scatmap::tools {
namespace {

using synth::ModelTruth;
using synth::TermKind;

struct Setup {
  ModelTruth model;
  synth::Bench bench;
  double stage_deg = 20, arm_deg = 40;
};

struct Regime {
  const char* name;
  Setup setup;
};

synth::Term lobe(double m, double n_re = 1.5, double n_im = 0, double dtheta_deg = 0, double dphi_deg = 0) {
  synth::Term t;
  t.kind = TermKind::kMicrofacet;
  t.rho = 0.5;
  t.m = m;
  t.n_re = n_re;
  t.n_im = n_im;
  t.dtheta_deg = dtheta_deg;
  t.dphi_deg = dphi_deg;
  return t;
}

synth::Term stripes(double a_um, double b_um, double c_um, bool grating = false) {
  synth::Term t;
  t.kind = TermKind::kStripes;
  t.rho = 300;
  t.a_um = a_um;
  t.b_um = b_um;
  t.c_um = c_um;
  t.grating = grating;
  return t;
}

synth::Term floor_term() {
  synth::Term t;
  t.rho = 0.05;
  return t;
}

// A frame that spans `span_rad` of scatter angle about the arm's direction.
Setup scene(std::vector<synth::Term> terms, double span_rad, double stage_deg, double arm_deg) {
  Setup s;
  s.model.wavelength_nm = 632.8;
  s.model.distance_mm = 325;
  s.model.terms = std::move(terms);
  s.bench.columns = 97;
  s.bench.rows = 61;
  s.bench.distance_mm = 325;
  s.bench.pitch_um = {325e3 * span_rad / 97, 325e3 * span_rad / 97};
  s.stage_deg = stage_deg;
  s.arm_deg = arm_deg;
  return s;
}
Setup at_peak(std::vector<synth::Term> terms, double span_rad) { return scene(std::move(terms), span_rad, 20, 40); }

template <class Change>
Setup changed(Setup s, Change change) {
  change(s.model);
  return s;
}

std::vector<synth::Term> paper_terms() {
  synth::Term offset = lobe(2e-4, 1.4, 0, 0.5, 45), centre = lobe(2e-4, 3.6);
  offset.rho = 0.7;
  centre.rho = 0.015;
  return {offset, centre, stripes(800, 10, 40), floor_term()};
}

std::vector<Regime> lobe_regimes() {
  return {
      {"paper's scene, theta_i 20 deg", at_peak(paper_terms(), 0.055)},
      {"paper's scene, theta_i 60 deg", scene(paper_terms(), 0.055, 60, 120)},
      {"paper's scene, phi_ref 77 deg",
       changed(at_peak(paper_terms(), 0.055), [](ModelTruth& m) { m.phi_ref_deg = 77; })},
      {"theta_h to 1e-12 rad, m = 2e-4", at_peak({lobe(2e-4)}, 4e-12)},
      {"theta_h to 1e-8 rad, m = 2e-4", at_peak({lobe(2e-4)}, 4e-8)},
      {"theta_h to 1e-3 rad, m = 2e-4", at_peak({lobe(2e-4)}, 4e-3)},
      {"m = 1e-6, its lobe", at_peak({lobe(1e-6)}, 2e-5)},
      {"m = 1e-6, the whole frame (exp underflows)", at_peak({lobe(1e-6)}, 0.055)},
      {"m = 0.01", at_peak({lobe(0.01)}, 0.2)},
      {"m = 1", at_peak({lobe(1)}, 1.5)},
      {"m = 10", at_peak({lobe(10)}, 1.5)},
      {"theta_h near 90 deg, m = 10", scene({lobe(10)}, 0.02, 89.4, 0)},
      {"specular at theta_i = 89.5 deg", scene({lobe(0.1)}, 0.02, 89.5, 178.6)},
      {"retro-reflection", scene({lobe(0.5), floor_term()}, 0.2, 30, 0)},
      {"theta_s through 90 deg", scene({lobe(1), floor_term()}, 0.05, 50, 139.5)},
      {"theta_i = 0", scene({lobe(0.1), floor_term()}, 0.2, 0, 5)},
      {"tilted facet lit at its horizon", scene({lobe(1, 1.5, 0, 60, 180)}, 0.3, 29, 29)},
      {"facet tilted by 1e-10 deg", at_peak({lobe(2e-4, 1.5, 0, 1e-10, 45)}, 4e-3)},
  };
}

std::vector<Regime> factor_regimes() {
  const auto s_light = [](ModelTruth& m) { m.polarization = synth::Polarization::kS; };
  const auto p_light = [](ModelTruth& m) { m.polarization = synth::Polarization::kP; };
  return {
      {"n = 1 + 1e-9", at_peak({lobe(0.1, 1 + 1e-9)}, 0.2)},
      {"n = 1 (Q = 0)", at_peak({lobe(0.1, 1)}, 0.2)},
      {"n = 0.5, total reflection", scene({lobe(0.1, 0.5)}, 0.2, 60, 120)},
      {"n = 0.5, at the critical angle", scene({lobe(0.1, 0.5)}, 0.05, 30, 60)},
      {"strong metal, n = 0.1 + 30i", scene({lobe(0.1, 0.1, 30)}, 0.2, 60, 120)},
      {"metal, s light, out of plane", changed(scene({lobe(0.5, 1.37, 7.62)}, 0.8, 40, 70), s_light)},
      {"p light at Brewster's angle",
       changed(scene({lobe(0.1, 1.5)}, 0.1, 56.30993247402021, 112.61986494804043), p_light)},
  };
}

std::vector<Regime> stripe_regimes() {
  return {
      {"stripes, sinc at 0", at_peak({stripes(800, 10, 40)}, 1e-9)},
      {"stripes, sinc through its zeros", at_peak({stripes(800, 400, 1e5)}, 0.055)},
      {"stripes, 1e3 periods from the axis", at_peak({stripes(6e4, 10, 1e6)}, 0.055)},
      {"stripes, 1e6 periods from the axis", at_peak({stripes(6e7, 10, 1e6)}, 0.055)},
      {"stripes, 1e9 periods from the axis", at_peak({stripes(6e10, 10, 1e6)}, 0.055)},
      {"stripes, narrow along (exp underflows)", at_peak({stripes(800, 10, 0.5)}, 0.055)},
      {"stripes by the grating, phi_ref 90 deg",
       changed(scene({stripes(800, 10, 4000, true)}, 0.055, 60, 120), [](ModelTruth& m) { m.phi_ref_deg = 90; })},
  };
}

// One row of a frame of 16384 x 16384 pixels whose maps would take gigabytes.
Setup large_frame_row(int row) {
  constexpr int kSide = 16384;
  constexpr double kPitch_um = 5.5;
  Setup s = at_peak(paper_terms(), 0.055);
  s.bench.columns = kSide;
  s.bench.rows = 1;
  s.bench.pitch_um = {kPitch_um, kPitch_um};
  s.bench.offset_mm[1] = (row - 0.5 * (kSide - 1)) * kPitch_um * 1e-3;
  return s;
}

std::vector<Regime> large_regimes() {
  return {{"16384 x 16384 frame, its first row", large_frame_row(0)},
          {"16384 x 16384 frame, a middle row", large_frame_row(8192)},
          {"16384 x 16384 frame, its last row", large_frame_row(16383)}};
}

std::vector<Regime> regimes() {
  std::vector<Regime> out = lobe_regimes();
  for (const auto& more : {factor_regimes(), stripe_regimes(), large_regimes()})
    out.insert(out.end(), more.begin(), more.end());
  return out;
}

Term term_of(const synth::Term& t) {
  switch (t.kind) {
    case TermKind::kMicrofacet:
      return MicrofacetTerm{t.rho, t.m, {t.n_re, t.n_im}, t.dtheta_deg * kRadPerDeg, t.dphi_deg * kRadPerDeg};
    case TermKind::kStripes:
      return StripesTerm{t.rho, t.a_um * 1e-6, t.b_um * 1e-6, t.c_um * 1e-6,
                         t.grating ? StripesForm::kGrating : StripesForm::kPaper};
    case TermKind::kLambertian:
      break;
  }
  return LambertianTerm{t.rho};
}

Model model_of(const ModelTruth& truth) {
  Model out;
  out.wavelength_m = truth.wavelength_nm * 1e-9;
  out.polarization = truth.polarization == synth::Polarization::kS   ? Polarization::kS
                     : truth.polarization == synth::Polarization::kP ? Polarization::kP
                                                                     : Polarization::kUnpolarized;
  out.phi_ref_rad = truth.phi_ref_deg * kRadPerDeg;
  for (const synth::Term& t : truth.terms) out.terms.push_back(term_of(t));
  return out;
}

std::vector<FrameModelOptions> methods() {
  constexpr double kTolerance = 1e-6;
  std::vector<FrameModelOptions> out;
  for (const ModelMethod m : {ModelMethod::kCulled, ModelMethod::kSingle, ModelMethod::kVector, ModelMethod::kExact})
    out.push_back({m, kTolerance, false});
  return out;
}

Pose pose_of(const Setup& s) { return {s.stage_deg * kRadPerDeg, s.arm_deg * kRadPerDeg}; }

BrdfMap evaluated(const FrameModelOptions& method, const Setup& s) {
  return model_map(model_of(s.model), instrument_of(s.bench), pose_of(s), method);
}

// The method's own, and what rounding the directions adds to any.
double bound_of(const FrameModelOptions& method, const Setup& s) {
  const SampleView view = sample_view(instrument_of(s.bench), pose_of(s));
  return model_error_bound(method) +
         model_rounding_error(model_of(s.model), view.to_source, s.bench.distance_mm * 1e-3);
}

// A direction rounded to double, wherever that leaves it.
synth::Vec3 rounded(const synth::Vec3& v, std::mt19937_64& rng) {
  const auto component = [&](long double x) { return x + (rng() % 2 == 0 ? -0x1p-54L : 0x1p-54L); };
  return synth::unit({component(v.x), component(v.y), component(v.z)});
}

// The truth per pixel; NaN where there is none. `rounding`: with directions as far off as rounding them to double makes
// them.
Grid<double> truth_of(const Setup& s, std::mt19937_64* rounding = nullptr) {
  const synth::TruthGeometry geometry(s.bench, s.stage_deg, s.arm_deg);
  Grid<double> out(s.bench.rows, s.bench.columns);
  for (int row = 0; row < s.bench.rows; ++row) {
    for (int column = 0; column < s.bench.columns; ++column) {
      const auto pixel = geometry.pixel(column, row);
      if (!pixel) {
        out(row, column) = NAN;
        continue;
      }
      synth::Vec3 from = geometry.to_source(), to = pixel->direction;
      if (rounding) {
        from = rounded(from, *rounding);
        to = rounded(to, *rounding);
      }
      out(row, column) = static_cast<double>(synth::brdf_per_sr(s.model, from, to));
    }
  }
  return out;
}

double peak_of(const Grid<double>& f) {
  double peak = 0;
  for (const double v : f) {
    if (v > peak) peak = v;
  }
  return peak;
}

// Relative to the larger of the value and 1e-6 of the peak.
double difference(const Grid<double>& a, const Grid<double>& b, double peak) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(b[i]) && std::isnan(a[i])) continue;
    const double scale = std::max(std::abs(b[i]), 1e-6 * peak);
    const double d = a[i] == b[i] ? 0 : std::abs(a[i] - b[i]) / scale;
    if (!(d <= largest)) largest = d;
  }
  return largest;
}

// Everything the answer depends on, moved by `step(value, typical)`.
template <class Step>
Setup moved(Setup s, Step step) {
  constexpr double kAngle = 1e-7, kShare = 1e-6;
  for (double* v : {&s.stage_deg, &s.arm_deg, &s.model.phi_ref_deg}) *v = step(*v, kAngle);
  for (double* v : {&s.bench.distance_mm, &s.bench.pitch_um[0], &s.bench.pitch_um[1], &s.model.wavelength_nm})
    *v = step(*v, kShare * *v);
  for (synth::Term& t : s.model.terms) {
    for (double* v : {&t.dtheta_deg, &t.dphi_deg}) *v = step(*v, kAngle);
    for (double* v : {&t.rho, &t.m, &t.a_um, &t.b_um, &t.c_um}) *v = *v == 0 ? 0 : step(*v, kShare * *v);
    if (t.n_re != 1 || t.n_im != 0) t.n_re = step(t.n_re, kShare * t.n_re);
  }
  return s;
}

// A regime's truth, and how far it moves with its inputs: the same for every method.
struct Truth {
  Grid<double> plain;
  double peak;
  Setup by_ulp, by_sigma;
  double ulp, sigma;
};

Truth moved_truth(const Setup& s) {
  std::mt19937_64 rng(5);
  Truth t{truth_of(s), 0, {}, {}, 0, 0};
  t.peak = peak_of(t.plain);
  t.by_ulp = moved(s, [&](double v, double) { return std::nextafter(v, rng() % 2 == 0 ? -HUGE_VAL : HUGE_VAL); });
  t.by_sigma = moved(s, [&](double v, double typical) { return v + (rng() % 2 == 0 ? -typical : typical); });
  t.ulp = std::max(difference(truth_of(t.by_ulp), t.plain, t.peak), difference(truth_of(s, &rng), t.plain, t.peak));
  t.sigma = difference(truth_of(t.by_sigma), t.plain, t.peak);
  return t;
}

StabilityCell cell_of(const Regime& regime, const FrameModelOptions& method, const Truth& truth) {
  StabilityCell cell;
  cell.job = "model";
  cell.regime = regime.name;
  cell.method = model_method_name(method.method);
  const Setup& s = regime.setup;
  cell.bound = bound_of(method, s);
  const BrdfMap answer = evaluated(method, s);
  cell.worst_error = difference(answer.brdf_per_sr, truth.plain, truth.peak);
  const auto answer_moves = [&](const Setup& to) {
    return difference(evaluated(method, to).brdf_per_sr, answer.brdf_per_sr, truth.peak);
  };
  cell.amplification_ulp = answer_moves(truth.by_ulp) / truth.ulp;
  cell.amplification_sigma = answer_moves(truth.by_sigma) / truth.sigma;
  if (truth.sigma == 0) cell.reason = "amplification: none, the truth does not move with the inputs";
  constexpr double kRoundingSteps = 8;  // directions are rounded when made, normalised, added and turned
  if (cell.worst_error <= cell.bound) {
    cell.verdict = Verdict::kHolds;
  } else if (cell.worst_error <= kRoundingSteps * truth.ulp) {
    cell.verdict = Verdict::kIllConditioned;
  }
  return cell;
}

}  // namespace

std::vector<StabilityCell> stability_model() {
  std::vector<StabilityCell> out;
  for (const Regime& regime : regimes()) {
    const Truth truth = moved_truth(regime.setup);
    for (const FrameModelOptions& method : methods()) out.push_back(cell_of(regime, method, truth));
  }
  return out;
}

}  // namespace scatmap::tools
