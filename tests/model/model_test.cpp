// The prepared model as a whole: against an independent evaluation in long double (angles by atan2 instead of
// components, the tilt by cross products instead of rotations), the rules for the horizon and NaN, and that terms add
// up. Not proven: anything about the equations themselves (the reference takes the same ones); the other tests of this
// room do.
#include "scatmap/model/model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>

#include "model/scene.h"
#include "scatmap/base/error.h"

namespace scatmap {
namespace {

using test::direction_deg;
using test::source_deg;
using Long = long double;
using LongComplex = std::complex<Long>;
using LongVector = Vector3<Long>;
constexpr Long kPi = std::numbers::pi_v<Long>;

Long square(Long x) { return x * x; }

// Q of Eq. 5 from polar angles and the azimuth difference.
Long reference_q(LongComplex n, Long theta_i, Long theta_s, Long delta, Polarization laser) {
  const LongComplex e = n * n, gi = std::sqrt(e - square(std::sin(theta_i))),
                    gs = std::sqrt(e - square(std::sin(theta_s)));
  const Long ci = std::cos(theta_i), cs = std::cos(theta_s);
  const LongComplex ss = (gi - ci) * (gs - cs) / (e - 1.0L) * std::cos(delta);
  const LongComplex sp = (gi - ci) * gs / (e * cs + gs) * std::sin(delta);
  const LongComplex ps = (gs - cs) * gi / (e * ci + gi) * std::sin(delta);
  const LongComplex pp = (e - 1.0L) * (e * std::sin(theta_i) * std::sin(theta_s) - gi * gs * std::cos(delta)) /
                         (e * ci + gi) / (e * cs + gs);
  const Long s = std::norm(ss) + std::norm(sp), p = std::norm(pp) + std::norm(ps);
  if (laser == Polarization::kUnpolarized) return s + p;
  return 2 * (laser == Polarization::kS ? s : p);
}

Long reference(const MicrofacetTerm& t, const Model& model, const LongVector& wi, const LongVector& ws) {
  const Long tilt = t.dtheta_rad, azimuth = Long(t.dphi_rad) + Long(model.phi_ref_rad);
  const LongVector n(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
  const LongVector first = n.cross(LongVector(0.3L, 1, 0.2L)).normalized(), second = n.cross(first), u = wi + ws;
  const auto theta = [&](const LongVector& v) { return std::atan2(n.cross(v).norm(), n.dot(v)); };
  const auto phi = [&](const LongVector& v) { return std::atan2(second.dot(v), first.dot(v)); };
  const Long theta_i = theta(wi), theta_s = theta(ws), theta_h = theta(u);
  const Long delta = theta_i == 0 || theta_s == 0 ? 0 : phi(ws) - phi(wi) - kPi;
  const Long q = reference_q(LongComplex(t.n), theta_i, theta_s, delta, model.polarization);
  return t.rho * q / (2 * square(std::cos(theta_i) + std::cos(theta_s))) * std::exp(-square(std::tan(theta_h) / t.m)) /
         (kPi * square(t.m) * square(square(std::cos(theta_h))));
}

struct StripesReference {
  Long value = 0, envelope = 0;
};

StripesReference reference(const StripesTerm& t, const Model& model, const LongVector& wi, const LongVector& ws) {
  const LongVector u = wi + ws;
  const Long theta_h = polar_angle(u), phi_h = std::atan2(u.y(), u.x()) - Long(model.phi_ref_rad);
  const Long x = std::sin(theta_h) * std::cos(phi_h), y = std::sin(theta_h) * std::sin(phi_h);
  const Long waves = t.form == StripesForm::kPaper ? 2 * y * std::cos(polar_angle(wi)) / model.wavelength_m
                                                   : y * u.norm() / model.wavelength_m;
  const Long phase = kPi * t.b_m * waves, sinc = phase == 0 ? 1 : std::sin(phase) / phase;
  const Long envelope = t.rho * std::exp(-square(Long(test::kDistance_m) * x / t.c_m));
  return {envelope * square(std::cos(kPi * t.a_m * waves) * sinc), envelope};
}

// Error of every term and of the sum, within 1e-12 of the value; beside a zero of cos², 1e-12 of the pattern's
// envelope.
void expect_reference(const Model& model, const Vector3<double>& wi, const Vector3<double>& ws, int& compared) {
  const PreparedModel prepared(model, wi, test::kDistance_m);
  const LongVector long_wi = wi.cast<Long>(), long_ws = ws.cast<Long>();
  Long sum = 0, tolerance = 0;
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    StripesReference r;
    if (const auto* microfacet = std::get_if<MicrofacetTerm>(&model.terms[i])) {
      r.value = r.envelope = reference(*microfacet, model, long_wi, long_ws);
    } else {
      r = reference(std::get<StripesTerm>(model.terms[i]), model, long_wi, long_ws);
    }
    if (r.envelope > 1e-290L) ++compared;
    const Long allowed = 1e-12L * r.envelope + 1e-300L;
    EXPECT_LE(std::abs(prepared.term(i, ws) - r.value), allowed) << "term " << i << " value " << r.value;
    sum += r.value;
    tolerance += allowed;
  }
  EXPECT_LE(std::abs(prepared(ws) - sum), tolerance);
}

TEST(PreparedModel, AgreesWithLongDoubleAcrossTheFrame) {
  std::mt19937_64 random(20210901);
  std::uniform_real_distribution<double> frame(-1, 1), log_scale(-3, 0);
  int compared = 0;
  for (const double theta_i_deg : {0.0, 20.0, 40.0, 60.0, 75.0}) {
    for (const double phi_ref_deg : {0.0, 33.0, 90.0}) {
      const Model model = test::paper_model(phi_ref_deg);
      for (int k = 0; k < 400; ++k) {
        const double scale = test::kHalfHeight_m * std::pow(10, log_scale(random));
        const auto ws = test::sensor_direction(theta_i_deg, scale * frame(random), scale * frame(random));
        expect_reference(model, source_deg(theta_i_deg), ws, compared);
      }
    }
  }
  EXPECT_GT(compared, 6000);
}

TEST(PreparedModel, AgreesWithLongDoubleOnTheOffsetPeak) {
  std::mt19937_64 random(20210902);
  std::normal_distribution<double> normal(0, 6 * 2e-4);
  int compared = 0;
  for (const double theta_i_deg : {0.0, 20.0, 60.0}) {
    const auto wi = source_deg(theta_i_deg);
    for (int k = 0; k < 500; ++k) {
      const Vector3<double> n2 =
          (direction_deg(0.5, 45) + Vector3<double>(normal(random), normal(random), 0)).normalized();
      const Vector3<double> ws = 2 * n2.dot(wi) * n2 - wi;
      expect_reference(test::paper_model(), wi, ws, compared);
    }
  }
  EXPECT_GT(compared, 1500);
}

// Wide lobes, complex and small indices, polarised lasers, large tilts, directions all over the hemisphere.
TEST(PreparedModel, AgreesWithLongDoubleOverTheHemisphere) {
  std::mt19937_64 random(20210903);
  std::uniform_real_distribution<double> turn(0, 360), polar(0, 89);
  int compared = 0;
  for (const auto laser : {Polarization::kUnpolarized, Polarization::kS, Polarization::kP}) {
    Model model = test::one_term(MicrofacetTerm{1, 0.3, {3.60363, 0.153}, 0, 0}, 25);
    model.polarization = laser;
    model.terms.push_back(MicrofacetTerm{0.5, 0.4, {0.0562, 4.2762}, 0, 0});
    model.terms.push_back(MicrofacetTerm{0.5, 0.5, {0.8, 0}, 0, 0});
    model.terms.push_back(MicrofacetTerm{0.5, 0.5, {1.5, 0}, 0.05, -2});
    model.terms.push_back(StripesTerm{10, 2e-6, 3e-7, 0.4, StripesForm::kGrating});
    for (int k = 0; k < 1000; ++k) {
      const auto wi = direction_deg(std::min(polar(random), 85.0), turn(random));
      expect_reference(model, wi, direction_deg(std::min(polar(random), 85.0), turn(random)), compared);
    }
  }
  EXPECT_GT(compared, 12000);
}

TEST(PreparedModel, LimitsAreFinite) {
  const Vector3<double> z(0, 0, 1);
  int compared = 0;
  for (const auto& [wi, ws] :
       {std::pair{z, z}, std::pair{z, direction_deg(0.01, 30)}, std::pair{direction_deg(0.01, 77), z},
        std::pair{source_deg(89.9), direction_deg(89.9, 0)}}) {
    expect_reference(test::paper_model(), wi, ws, compared);
    EXPECT_GT(PreparedModel(test::paper_model(), wi, test::kDistance_m)(ws), 0);
  }
  EXPECT_GT(compared, 6);
}

TEST(PreparedModel, IsTheSumOfItsTerms) {
  Model model = test::paper_model();
  for (const std::size_t lobe : {0U, 1U}) std::get<MicrofacetTerm>(model.terms[lobe]).m = 0.01;  // so that they overlap
  model.terms.push_back(LambertianTerm{0.3});
  const PreparedModel prepared(model, source_deg(20), test::kDistance_m);
  ASSERT_EQ(prepared.term_count(), 4U);
  const auto ws = direction_deg(20.01, 0.02);
  EXPECT_NEAR(prepared.term(3, ws), 0.3 / std::numbers::pi, 1e-16);
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    Model alone = model;
    alone.terms = {model.terms[i]};
    const double value = PreparedModel(alone, source_deg(20), test::kDistance_m)(ws);
    EXPECT_GT(value, 0) << i;
    EXPECT_EQ(prepared.term(i, ws), value);
    sum += value;
  }
  EXPECT_NEAR(prepared(ws), sum, 1e-15 * sum);
  EXPECT_THROW(static_cast<void>(prepared.term(4, ws)), std::out_of_range);
}

TEST(PreparedModel, IsNanBelowTheHorizonAndForNan) {
  Model model = test::paper_model();
  model.terms = {LambertianTerm{1}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto wi = source_deg(20), ws = direction_deg(30, 10);
  const auto value = [&](const Vector3<double>& i, const Vector3<double>& s) {
    return PreparedModel(model, i, test::kDistance_m)(s);
  };
  EXPECT_FALSE(std::isnan(value(wi, ws)));
  EXPECT_TRUE(std::isnan(value(wi, {1, 0, 0})));
  EXPECT_TRUE(std::isnan(value(wi, direction_deg(91, 0))));
  EXPECT_TRUE(std::isnan(value({1, 0, 0}, ws)));
  EXPECT_TRUE(std::isnan(value(direction_deg(100, 180), ws)));
  for (int i = 0; i < 3; ++i) {
    auto bad = ws;
    bad[i] = nan;
    EXPECT_TRUE(std::isnan(value(wi, bad)));
    EXPECT_TRUE(std::isnan(value(bad, ws)));
    EXPECT_TRUE(std::isnan(PreparedModel(model, wi, test::kDistance_m).term(0, bad)));
  }
}

TEST(PreparedModel, RefusesAnImpossibleDistance) {
  for (const double distance_m : {0.0, -0.3, std::numeric_limits<double>::quiet_NaN(), HUGE_VAL}) {
    EXPECT_THROW(PreparedModel(test::paper_model(), source_deg(20), distance_m), Error);
  }
}

}  // namespace
}  // namespace scatmap
