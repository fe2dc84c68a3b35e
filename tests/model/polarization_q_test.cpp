// Rayleigh-Rice factors against NIST SCATMECH (each complex amplitude), Fresnel's reflectances at specular,
// reciprocity, and the limits at normal incidence and normal scatter. Not proven: that Rayleigh-Rice is the right
// polarisation law for a real surface, or anything for absorbing incident media.
#include "scatmap/model/polarization_q.h"

#include <gtest/gtest.h>

#include <complex>
#include <limits>
#include <vector>

#include "model/oracle_rows.h"
#include "model/scene.h"

namespace scatmap {
namespace {

using test::direction_deg;
using test::oracle_rows;
using test::Row;
using test::source_deg;
using Complex = std::complex<double>;

const std::vector<Complex> kIndices{{1.4, 0}, {3.6, 0}, {3.60363, 0.153}, {0.0562, 4.2762}, {0.7, 0}};

Complex element(const Row& row, const std::string& name) { return {row.at("re_" + name), row.at("im_" + name)}; }

void expect_amplitude(const Complex& value, const Complex& oracle, const char* name, const Row& row) {
  EXPECT_LE(std::abs(value - oracle), 1e-11 * std::abs(oracle))
      << name << " n " << row.at("n") << " k " << row.at("k") << " theta_i " << row.at("theta_i") << " theta_s "
      << row.at("theta_s") << " phi_s " << row.at("phi_s");
}

TEST(PolarizationQ, AgreesWithScatmech) {
  const auto rows = oracle_rows("polarization_q.csv");
  ASSERT_EQ(rows.size(), 1000U);
  for (const Row& row : rows) {
    const Complex n(row.at("n"), row.at("k"));
    const auto wi = source_deg(row.at("theta_i")), ws = direction_deg(row.at("theta_s"), row.at("phi_s"));
    const PolarizationQ q = polarization_amplitudes(n, wi, ws);
    expect_amplitude(q.q_pp, element(row, "pp"), "pp", row);
    expect_amplitude(q.q_ss, element(row, "ss"), "ss", row);
    expect_amplitude(q.q_ps, element(row, "ps"), "p in, s out", row);
    expect_amplitude(q.q_sp, element(row, "sp"), "s in, p out", row);
    EXPECT_NEAR(polarization_q(n, wi, ws, Polarization::kUnpolarized) / row.at("sum_abs2"), 1, 1e-11);
    EXPECT_NEAR(polarization_q(n, wi, ws, Polarization::kS) / (2 * (row.at("abs2_ss") + row.at("abs2_sp"))), 1, 1e-11);
    EXPECT_NEAR(polarization_q(n, wi, ws, Polarization::kP) / (2 * (row.at("abs2_pp") + row.at("abs2_ps"))), 1, 1e-11);
  }
}

TEST(PolarizationQ, IsFresnelAtSpecular) {
  const auto rows = oracle_rows("fresnel.csv");
  ASSERT_EQ(rows.size(), 450U);
  for (const Row& row : rows) {
    const Complex n(row.at("n"), row.at("k"));
    const double theta = row.at("theta_i"), rs = row.at("Rs"), rp = row.at("Rp");
    const auto wi = source_deg(theta), ws = direction_deg(theta, 0);
    EXPECT_NEAR(polarization_q(n, wi, ws, Polarization::kUnpolarized), rs + rp, 1e-12 * (rs + rp)) << theta;
    EXPECT_NEAR(polarization_q(n, wi, ws, Polarization::kS), 2 * rs, 1e-12 * rs) << theta;
    EXPECT_NEAR(polarization_q(n, wi, ws, Polarization::kP), 2 * rp, 1e-12 * rp + 1e-15) << theta;
  }
}

TEST(PolarizationQ, IsReciprocal) {
  for (const Complex n : kIndices) {
    const auto a = direction_deg(25, 170), b = direction_deg(61, 32);
    const PolarizationQ ab = polarization_amplitudes(n, a, b), ba = polarization_amplitudes(n, b, a);
    EXPECT_LE(std::abs(std::abs(ab.q_sp) - std::abs(ba.q_ps)), 1e-14 * std::abs(ab.q_sp));
    EXPECT_LE(std::abs(std::abs(ab.q_ps) - std::abs(ba.q_sp)), 1e-14 * std::abs(ab.q_ps));
    EXPECT_LE(std::abs(ab.q_ss - ba.q_ss), 1e-14 * std::abs(ab.q_ss));
    EXPECT_LE(std::abs(ab.q_pp - ba.q_pp), 1e-14 * std::abs(ab.q_pp));
    EXPECT_GT(std::abs(std::abs(ab.q_sp) - std::abs(ab.q_ps)), 1e-3 * std::abs(ab.q_sp)) << "the pair is not special";
  }
}

TEST(PolarizationQ, DependsOnAzimuthDifferenceOnly) {
  for (const Complex n : kIndices) {
    const double q = polarization_q(n, direction_deg(35, 180), direction_deg(50, 20), Polarization::kS);
    const double turned = polarization_q(n, direction_deg(35, 180 + 77), direction_deg(50, 20 + 77), Polarization::kS);
    EXPECT_NEAR(turned, q, 1e-14 * q);
  }
}

TEST(PolarizationQ, VanishesWithoutContrast) {
  EXPECT_EQ(polarization_q(1.0, source_deg(30), direction_deg(50, 20), Polarization::kUnpolarized), 0);
}

TEST(PolarizationQ, BrewsterAngleHasNoPInPlane) {
  const double brewster_deg = std::atan2(1.5, 1.0) * kDegPerRad;
  EXPECT_LE(polarization_q(1.5, source_deg(brewster_deg), direction_deg(brewster_deg, 0), Polarization::kP), 1e-28);
}

// n < 1 beyond the critical angle of both directions: sqrt(e − sin²) is imaginary, and reflection at specular is total.
TEST(PolarizationQ, TotalReflection) {
  EXPECT_NEAR(polarization_q(0.7, source_deg(60), direction_deg(60, 0), Polarization::kUnpolarized), 2, 1e-14);
}

TEST(PolarizationQ, IsContinuousAtTheNormal) {
  const Vector3<double> z(0, 0, 1);
  for (const Complex n : kIndices) {
    const auto tilted = direction_deg(40, 25);
    for (const double azimuth_deg : {0.0, 90.0, 200.0}) {
      for (const double theta_deg : {1e-9, 1e-150, 1e-300}) {
        const auto near_z = direction_deg(theta_deg, azimuth_deg);
        const double at = polarization_q(n, z, tilted, Polarization::kUnpolarized);
        EXPECT_NEAR(polarization_q(n, near_z, tilted, Polarization::kUnpolarized), at, 1e-9 * at);
        for (const auto laser : {Polarization::kUnpolarized, Polarization::kS, Polarization::kP}) {
          const double scattered = polarization_q(n, tilted, z, laser);
          EXPECT_NEAR(polarization_q(n, tilted, near_z, laser), scattered, 1e-9 * scattered);
        }
      }
    }
  }
}

// At normal incidence s lies along y and p along x: what x-polarised light sends towards +x leaves as p.
TEST(PolarizationQ, NormalIncidenceTakesSAlongY) {
  const Vector3<double> z(0, 0, 1);
  const Complex n(3.60363, 0.153);
  const PolarizationQ forward = polarization_amplitudes(n, z, direction_deg(30, 0));
  const PolarizationQ sideways = polarization_amplitudes(n, z, direction_deg(30, 90));
  EXPECT_EQ(std::abs(forward.q_sp), 0);
  EXPECT_EQ(std::abs(forward.q_ps), 0);
  EXPECT_LE(std::abs(sideways.q_ss), 1e-16);
  EXPECT_LE(std::abs(sideways.q_pp), 1e-16);
  EXPECT_NEAR(std::abs(sideways.q_sp), std::abs(forward.q_pp), 1e-15);
  EXPECT_NEAR(std::abs(sideways.q_ps), std::abs(forward.q_ss), 1e-15);
}

TEST(PolarizationQ, NormalIncidenceAndScatterIsFresnel) {
  const Vector3<double> z(0, 0, 1);
  for (const Complex n : kIndices) {
    const double fresnel = std::norm((n - 1.0) / (n + 1.0));
    EXPECT_NEAR(polarization_q(n, z, z, Polarization::kUnpolarized), 2 * fresnel, 1e-15);
  }
}

TEST(PolarizationQ, NanInNanOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 3; ++i) {
    auto ws = direction_deg(30, 10);
    ws[i] = nan;
    EXPECT_TRUE(std::isnan(polarization_q(3.6, source_deg(20), ws, Polarization::kUnpolarized))) << i;
    EXPECT_TRUE(std::isnan(polarization_q(3.6, ws, source_deg(20), Polarization::kUnpolarized))) << i;
  }
}

}  // namespace
}  // namespace scatmap
