// The truth's model against SCATMECH's polarization factors, Fresnel's law, integrals over the hemisphere, the grating
// equation, and the numbers printed in the paper (Small, Butler and Marciniak, Opt. Express 29, 35501, 2021, section
// 4.4.2). Does not prove that the paper's model describes a solar cell.
#include "data-synthetic/truth_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "data-synthetic/truth_geometry.h"

namespace scatmap::synth {
namespace {

constexpr double kHalfHeight_mm = 6.798;  // 2472 pixels of 5.5 µm

Vec3 source(double theta_i_deg) { return turn_y({0, 0, 1}, -theta_i_deg); }
Vec3 scattered(double theta_deg, double azimuth_deg) { return turn_z(turn_y({0, 0, 1}, theta_deg), azimuth_deg); }

ModelTruth model_of(const std::vector<Term>& terms) {
  ModelTruth model;
  model.wavelength_nm = 632.8;
  model.distance_mm = 325;
  model.terms = terms;
  return model;
}

Term microfacet(double rho, double m, double n_re, double n_im = 0) {
  Term t;
  t.kind = TermKind::kMicrofacet;
  t.rho = rho;
  t.m = m;
  t.n_re = n_re;
  t.n_im = n_im;
  return t;
}

Term paper_stripes() {
  Term t;
  t.kind = TermKind::kStripes;
  t.rho = 300;
  t.a_um = 800;
  t.b_um = 10;
  t.c_um = 40;
  return t;
}

Term paper_offset() {
  Term t = microfacet(0.7, 2e-4, 1.4);
  t.dtheta_deg = 0.5;
  t.dphi_deg = 45;
  return t;
}

// Pixel `right_mm`, `down_mm` from the boresight at the specular setting.
Vec3 on_sensor(double theta_i_deg, double right_mm, double down_mm) {
  return unit(turn_y({right_mm, down_mm, 325}, theta_i_deg));
}

TEST(TruthModel, PolarizationFactorsAgreeWithScatmech) {
  std::ifstream file(std::string(SCATMAP_TEST_DATA) + "/polarization_q.csv");
  ASSERT_TRUE(file.good());
  int rows = 0;
  for (std::string text; std::getline(file, text);) {
    if (text.empty() || text[0] == '#' || text[0] == 'n') continue;
    std::replace(text.begin(), text.end(), ',', ' ');
    std::istringstream in(text);
    std::vector<double> v;
    for (double x = 0; in >> x;) v.push_back(x);
    ASSERT_EQ(v.size(), 18U);
    const auto q = polarization_factors({v[0], v[1]}, source(v[2]), scattered(v[3], v[4]));
    const double scale = v[17];
    EXPECT_NEAR(static_cast<double>(q.pp), v[13], 1e-12 * scale) << text;
    EXPECT_NEAR(static_cast<double>(q.ss), v[14], 1e-12 * scale) << text;
    EXPECT_NEAR(static_cast<double>(q.ps), v[15], 1e-12 * scale) << text;
    EXPECT_NEAR(static_cast<double>(q.sp), v[16], 1e-12 * scale) << text;
    ++rows;
  }
  EXPECT_EQ(rows, 1000);
}

TEST(TruthModel, SpecularValueIsFresnelsAtNormalIncidence) {
  // Rs = Rp = ((n − 1)/(n + 1))², cos θ = 1: ρ R/(4 π m²); for silver-like n the modulus.
  const Vec3 up{0, 0, 1};
  const double expected = 0.5 * std::pow(2.6 / 4.6, 2) / (4 * std::acos(-1.0) * 1e-6);
  const auto plain = model_of({microfacet(0.5, 1e-3, 3.6)});
  EXPECT_NEAR(static_cast<double>(brdf_per_sr(plain, up, up)) / expected, 1, 1e-14);
  const double metal_r =
      std::norm((std::complex<double>(0.05625, 4.27603) - 1.0) / (std::complex<double>(0.05625, 4.27603) + 1.0));
  const auto metal = model_of({microfacet(0.5, 1e-3, 0.05625, 4.27603)});
  const double metal_expected = 0.5 * metal_r / (4 * std::acos(-1.0) * 1e-6);
  EXPECT_NEAR(static_cast<double>(brdf_per_sr(metal, up, up)) / metal_expected, 1, 1e-14);
}

TEST(TruthModel, UnpolarizedIsTheMeanOfTheTwoPolarizations) {
  ModelTruth model = model_of({microfacet(1, 0.1, 1.5, 0.3)});
  const Vec3 wi = source(30), ws = scattered(35, 8);
  const long double mean = brdf_per_sr(model, wi, ws);
  model.polarization = Polarization::kS;
  const long double s = brdf_per_sr(model, wi, ws);
  model.polarization = Polarization::kP;
  const long double p = brdf_per_sr(model, wi, ws);
  EXPECT_NEAR(static_cast<double>((s + p) / 2 / mean), 1, 1e-15);
  EXPECT_GT(s, p);
}

TEST(TruthModel, LambertianReflectsRho) {
  Term t;
  t.rho = 0.3;
  const auto model = model_of({t});
  constexpr int kSteps = 400;
  long double sum = 0;
  // ∫ f cosθ dΩ with midpoints in cosθ and azimuth; f does not depend on the azimuth.
  for (int i = 0; i < kSteps; ++i) {
    const long double cosine = (i + 0.5L) / kSteps;
    const Vec3 ws{std::sqrt(1 - cosine * cosine), 0, cosine};
    sum += brdf_per_sr(model, source(40), ws) * cosine * 2 * kPi / kSteps;
  }
  EXPECT_NEAR(static_cast<double>(sum), 0.3, 1e-14);
}

TEST(TruthModel, FacetSlopesAreNormalised) {
  // ∫ D cosθh dωh = 1, D read off the model at normal incidence by dividing out Q/[2(cosθi + cosθs)²].
  const double m = 0.05;
  const auto model = model_of({microfacet(1, m, 1.4)});
  constexpr int kSteps = 4000;
  long double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const long double theta_h = (i + 0.5L) * 0.5L / kSteps;  // to 0.5 rad, ten times m
    const Vec3 ws{std::sin(2 * theta_h), 0, std::cos(2 * theta_h)};
    const auto q = polarization_factors(1.4L, {0, 0, 1}, ws);
    const long double optics = (q.ss + q.sp + q.ps + q.pp) / 2 / ((1 + ws.z) * (1 + ws.z));
    const long double facets = brdf_per_sr(model, {0, 0, 1}, ws) / optics;
    sum += facets * std::cos(theta_h) * 2 * kPi * std::sin(theta_h) * 0.5L / kSteps;
  }
  EXPECT_NEAR(static_cast<double>(sum), 1, 1e-6);
}

TEST(TruthModel, OffsetPeakLiesWhereItsMirrorReflects) {
  // A facet whose normal is (sin Δθ cos Δφ, sin Δθ sin Δφ, cos Δθ) reflects the beam there; the bars' angle adds to Δφ.
  ModelTruth model = model_of({paper_offset()});
  for (const double phi_ref_deg : {0.0, 45.0, 90.0}) {
    model.phi_ref_deg = phi_ref_deg;
    const Vec3 wi = source(40), n2 = scattered(0.5, 45 + phi_ref_deg);
    const Vec3 mirrored = 2 * dot(wi, n2) * n2 - wi;
    const Vec3 h = unit(wi + mirrored);
    EXPECT_NEAR(static_cast<double>(length(h - n2)), 0, 1e-17);
    const long double peak = brdf_per_sr(model, wi, mirrored);
    for (const double azimuth_deg : {0.0, 90.0, 180.0, 270.0}) {
      const Vec3 beside = unit(mirrored + turn_z({1e-4L, 0, 0}, azimuth_deg));
      EXPECT_LT(brdf_per_sr(model, wi, beside), peak);
    }
    EXPECT_GT(peak, 7e4);
  }
}

// Largest value near a place on the sensor, in steps of 4 µm.
double peak_near(const ModelTruth& model, double theta_i_deg, double right_mm, double down_mm) {
  double best = 0;
  for (int i = -100; i <= 100; ++i) {
    for (int j = -100; j <= 100; ++j) {
      const Vec3 ws = on_sensor(theta_i_deg, right_mm + i * 4e-3, down_mm + j * 4e-3);
      best = std::max(best, static_cast<double>(brdf_per_sr(model, source(theta_i_deg), ws)));
    }
  }
  return best;
}

TEST(TruthModel, PaperPeaks) {
  const auto model = model_of({paper_offset(), microfacet(0.015, 2e-4, 3.6), paper_stripes()});
  EXPECT_NEAR(peak_near(model, 20, 0, 0) / 1.11e4, 1, 0.01);
  EXPECT_NEAR(peak_near(model, 60, 0, 0) / 3.91e4, 1, 0.01);
  EXPECT_NEAR(peak_near(model, 20, 4.02, 3.76) / 4.44e4, 1, 0.01);
  EXPECT_NEAR(peak_near(model, 60, 4.02, 1.98) / 4.19e5, 1, 0.01);
}

// Maxima of the stripes along +y from the centre to the sensor's edge: on each row the best column, so that the curved
// pattern at 60° is followed.
std::vector<double> stripe_maxima(double theta_i_deg) {
  const auto model = model_of({paper_stripes()});
  std::vector<double> ridge;
  for (double down_mm = 0; down_mm <= kHalfHeight_mm; down_mm += 2.5e-3) {
    double best = 0;
    for (double right_mm = -0.2; right_mm <= 0.4; right_mm += 4e-3) {
      best = std::max(best, static_cast<double>(
                                brdf_per_sr(model, source(theta_i_deg), on_sensor(theta_i_deg, right_mm, down_mm))));
    }
    ridge.push_back(best);
  }
  std::vector<double> maxima;
  for (std::size_t i = 1; i + 1 < ridge.size(); ++i) {
    if (ridge[i] > ridge[i - 1] && ridge[i] >= ridge[i + 1]) maxima.push_back(ridge[i]);
  }
  return maxima;
}

TEST(TruthModel, PaperStripesHave26MaximaFallingTo209) {
  for (const double theta_i_deg : {20.0, 60.0}) {
    const auto maxima = stripe_maxima(theta_i_deg);
    ASSERT_EQ(maxima.size(), 26U) << theta_i_deg;
    EXPECT_NEAR(maxima.front(), 300, 1);
    EXPECT_NEAR(maxima.back(), 209, 1.5) << theta_i_deg;
    EXPECT_TRUE(std::is_sorted(maxima.rbegin(), maxima.rend()));
  }
}

TEST(TruthModel, WithoutTheFactorThereAre14And26Maxima) {
  // cos²(π a ȳ/(λ z̄)) has a maximum at every whole a·hy/λ.
  const auto orders = [](double theta_i_deg) {
    const Vec3 h = unit(source(theta_i_deg) + on_sensor(theta_i_deg, 0, kHalfHeight_mm));
    return std::floor(800 * static_cast<double>(h.y) / 0.6328);
  };
  EXPECT_EQ(orders(20), 14);
  EXPECT_EQ(orders(60), 26);
}

TEST(TruthModel, GratingFormObeysTheGratingEquation) {
  // Bars out of the plane of incidence: maxima at sin θs = sin θi + k λ/a.
  Term t = paper_stripes();
  t.grating = true;
  t.c_um = 1e9;
  ModelTruth model = model_of({t});
  model.phi_ref_deg = 90;
  for (const int k : {-20, -3, 1, 7, 25}) {
    const double sine = std::sin(static_cast<double>(40 * kPi / 180)) + k * 0.6328 / 800;
    const Vec3 ws{sine, 0, std::sqrt(1 - static_cast<long double>(sine) * sine)};
    const double x = 10.0 * k / 800 * std::acos(-1.0);
    const double envelope = 300 * std::pow(std::sin(x) / x, 2);
    EXPECT_NEAR(static_cast<double>(brdf_per_sr(model, source(40), ws)) / envelope, 1, 1e-9) << k;
  }
}

TEST(TruthModel, FormsAgreeAtTheCentreOfTheBand) {
  Term paper = paper_stripes(), grating = paper_stripes();
  grating.grating = true;
  const Vec3 wi = source(20), ws = on_sensor(20, 0, 0.2);
  const double a = static_cast<double>(brdf_per_sr(model_of({paper}), wi, ws));
  const double b = static_cast<double>(brdf_per_sr(model_of({grating}), wi, ws));
  EXPECT_GT(a, 1);
  EXPECT_NEAR(a / b, 1, 1e-5);
}

}  // namespace
}  // namespace scatmap::synth
