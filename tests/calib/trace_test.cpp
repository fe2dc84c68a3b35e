// The forward model against the simulator's long double truth: spots of random benches, and every derivative against
// central differences of that truth. Does not prove the truth itself (tests/synthetic does, case by case).
#include "calib/trace.h"

#include <gtest/gtest.h>

#include <functional>

#include "bench.h"

namespace scatmap::calib::test {
namespace {

constexpr int kBenches = 300;

Shot shot_of(const synth::Bench& b, const Command& c) {
  return {c.direct ? TargetKind::kDirect : TargetKind::kSpecular, c.stage_deg * kRadPerDeg, c.arm_deg * kRadPerDeg,
          (b.sample_tilt_deg + c.tilt_deg) * kRadPerDeg, b.sample_height_mm * 1e-3};
}

std::optional<synth::PixelPoint> true_hit(const synth::Bench& b, const Command& c) {
  const synth::TruthGeometry truth(b, c.stage_deg, c.arm_deg, c.tilt_deg);
  return c.direct ? truth.direct_hit() : truth.mirror_hit();
}

struct Case {
  synth::Bench bench;
  Command command;
};

Case random_case(std::mt19937_64& rng) {
  const auto within = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); };
  Case out{scatmap::test::random_bench(rng, 2).truth, {}};
  const double stage = within(-70, 70);
  out.command = within(0, 1) < 0.25 ? beam(180 + within(-5, 5)) : mirror(stage, within(-5, 5), within(-2, 2));
  return out;
}

TEST(Trace, SpotsAreThoseOfTheTruth) {
  std::mt19937_64 rng(311);
  int hits = 0;
  for (int i = 0; i < kBenches; ++i) {
    const Case c = random_case(rng);
    const auto truth = true_hit(c.bench, c.command);
    const Instrument in = scatmap::test::instrument_of(c.bench);
    const auto traced = Tracer(in.geometry, in).trace(shot_of(c.bench, c.command));
    ASSERT_EQ(truth.has_value(), traced.has_value()) << i;
    if (!truth) continue;
    ++hits;
    const double scale = 1 + std::hypot(traced->pixel[0], traced->pixel[1]);
    EXPECT_NEAR(traced->pixel[0], static_cast<double>(truth->column_px), 1e-13 * scale + 1e-10);
    EXPECT_NEAR(traced->pixel[1], static_cast<double>(truth->row_px), 1e-13 * scale + 1e-10);
  }
  EXPECT_GT(hits, kBenches / 2);
}

// File-unit fields of a bench in the order of geometry_keys().
std::vector<std::function<double&(synth::Bench&)>> fields() {
  using B = synth::Bench;
  return {[](B& b) -> double& { return b.distance_mm; },        [](B& b) -> double& { return b.offset_mm[0]; },
          [](B& b) -> double& { return b.offset_mm[1]; },       [](B& b) -> double& { return b.rotation_deg[0]; },
          [](B& b) -> double& { return b.rotation_deg[1]; },    [](B& b) -> double& { return b.rotation_deg[2]; },
          [](B& b) -> double& { return b.pitch_um[0]; },        [](B& b) -> double& { return b.pitch_um[1]; },
          [](B& b) -> double& { return b.arm_zero_deg; },       [](B& b) -> double& { return b.axis_offset_mm[0]; },
          [](B& b) -> double& { return b.axis_offset_mm[1]; },  [](B& b) -> double& { return b.axis_tilt_deg[0]; },
          [](B& b) -> double& { return b.axis_tilt_deg[1]; },   [](B& b) -> double& { return b.stage_zero_deg; },
          [](B& b) -> double& { return b.beam_offset_mm[0]; },  [](B& b) -> double& { return b.beam_offset_mm[1]; },
          [](B& b) -> double& { return b.beam_elevation_deg; }, [](B& b) -> double& { return b.sample_tilt_deg; },
          [](B& b) -> double& { return b.sample_height_mm; }};
}

// Fourth-order central difference per file unit; the step is the difference that the doubles really have.
std::array<long double, 2> difference(const Case& c, const std::function<double&(synth::Bench&)>& field) {
  constexpr double kStep = 1e-3;
  const auto slope = [&](double step) -> std::array<long double, 2> {
    synth::Bench plus = c.bench, minus = c.bench;
    field(plus) += step;
    field(minus) -= step;
    const auto a = true_hit(plus, c.command), b = true_hit(minus, c.command);
    const long double h = static_cast<long double>(field(plus)) - field(minus);
    return {(a->column_px - b->column_px) / h, (a->row_px - b->row_px) / h};
  };
  const auto wide = slope(2 * kStep), narrow = slope(kStep);
  return {(4 * narrow[0] - wide[0]) / 3, (4 * narrow[1] - wide[1]) / 3};
}

TEST(Trace, DerivativesAreThoseOfTheTruth) {
  std::mt19937_64 rng(312);
  const auto all = fields();
  ASSERT_EQ(all.size(), kGeometryKeyCount);
  for (int i = 0; i < kBenches; ++i) {
    const Case c = random_case(rng);
    if (!true_hit(c.bench, c.command)) continue;
    const Instrument in = scatmap::test::instrument_of(c.bench);
    const auto traced = Tracer(in.geometry, in).trace(shot_of(c.bench, c.command));
    ASSERT_TRUE(traced.has_value());
    for (std::size_t k = 0; k < all.size(); ++k) {
      const bool of_mirror = k == 13 || k == 17 || k == 18;
      const std::array<long double, 2> expected =
          c.command.direct && of_mirror ? std::array<long double, 2>{0, 0} : difference(c, all[k]);
      for (Eigen::Index axis = 0; axis < 2; ++axis) {
        const double got = traced->jacobian(axis, static_cast<Eigen::Index>(k)) * geometry_keys()[k].unit;
        const double want = static_cast<double>(expected[static_cast<std::size_t>(axis)]);
        EXPECT_NEAR(got, want, 1e-8 * (1 + std::abs(want)))
            << geometry_keys()[k].name << ", axis " << axis << ", case " << i;
      }
    }
  }
}

// An error of a motor is a change of its commanded angle.
TEST(Trace, EncoderDerivativesAreThoseOfTheMotors) {
  std::mt19937_64 rng(313);
  for (int i = 0; i < kBenches; ++i) {
    const Case c = random_case(rng);
    if (c.command.direct || !true_hit(c.bench, c.command)) continue;
    const Instrument in = scatmap::test::instrument_of(c.bench);
    const auto traced = Tracer(in.geometry, in).trace(shot_of(c.bench, c.command));
    constexpr double kStepDeg = 1e-4;
    for (const bool stage : {true, false}) {
      Case a = c, b = c;
      (stage ? a.command.stage_deg : a.command.arm_deg) += kStepDeg;
      (stage ? b.command.stage_deg : b.command.arm_deg) -= kStepDeg;
      const auto plus = true_hit(a.bench, a.command), minus = true_hit(b.bench, b.command);
      const Eigen::Vector2d got = traced->jacobian.col(stage ? kStageZeroColumn : kArmZeroColumn) * kRadPerDeg;
      const double want = static_cast<double>((plus->column_px - minus->column_px) / (2 * kStepDeg));
      EXPECT_NEAR(got[0], want, 1e-6 * (1 + std::abs(want)));
    }
  }
}

TEST(Trace, MissesAreMisses) {
  const Instrument in = scatmap::test::instrument_of(plain_bench());
  const Tracer tracer(in.geometry, in);
  const auto shot = [](bool direct, double stage_deg, double arm_deg) {
    return Shot{direct ? TargetKind::kDirect : TargetKind::kSpecular, stage_deg * kRadPerDeg, arm_deg * kRadPerDeg, 0,
                0};
  };
  EXPECT_TRUE(tracer.trace(shot(true, 0, 180)).has_value());
  EXPECT_FALSE(tracer.trace(shot(true, 0, 0)).has_value()) << "the arm looks into the source";
  EXPECT_FALSE(tracer.trace(shot(true, 0, 90)).has_value()) << "the beam runs along the detector";
  EXPECT_TRUE(tracer.trace(shot(false, 20, 40)).has_value());
  EXPECT_FALSE(tracer.trace(shot(false, 20, 220)).has_value()) << "the detector is behind the mirror";
  EXPECT_FALSE(tracer.trace(shot(false, 120, 240)).has_value()) << "the mirror is lit from behind";
}

}  // namespace
}  // namespace scatmap::calib::test
