// The fused pass against the exact chain (reduce, merge, angle_map, division, pose_uncertainty) on frames that have
// everything that can go wrong in a frame; both against a reduction written here. Same bytes for any number of threads.
// Does not prove that the exact chain is right: tests/flow/frames_to_brdf does, by statistics against the truth.
#include "scatmap/brdf/fused.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>

#include "scatmap/base/stream_copy.h"
#include "scatmap/base/units.h"
#include "scatmap/brdf/merge.h"
#include "scatmap/brdf/pose_uncertainty.h"
#include "tests/counts/made_frames.h"
#include "tests/support/random_instrument.h"

namespace scatmap {
namespace {

using test::kSensor;
constexpr double kExposure_s = 0.4, kFactor = 3e-6;

struct Scene {
  Instrument instrument;
  Pose pose;
  std::vector<Frame> frames;
  MasterDark dark;
  SensorModel sensor = kSensor;
  PixelResponse response{};

  SampleView view() const { return sample_view(instrument, pose); }
};

Instrument instrument_of(int rows, int columns) {
  Instrument in;
  in.rows = rows;
  in.columns = columns;
  in.geometry.distance = 0.325;
  in.geometry.pixel_column = in.geometry.pixel_row = 1.5e-4;
  in.geometry.rotation_yaw = 0.03;
  in.geometry.rotation_roll = -0.02;
  in.calibration = Calibration{{"detector.distance_mm", "stage.zero_deg", "detector.offset_mm.1"}, {}};
  in.calibration->covariance = Eigen::Vector3d(0.25, 1e-6, 1e-4).asDiagonal();
  return in;
}

Grid<double> peak(int rows, int columns) {
  Grid<double> e(rows, columns);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double x = c - 0.4 * columns, y = r - 0.6 * rows;
      e(r, c) = 3 + 3e5 * std::exp(-(x * x + y * y) / 18) + 2000 * std::exp(-(x * x + y * y) / 900);
    }
  }
  return e;
}

Scene scene(int rows, int columns, int frames, std::uint64_t seed, double arm_deg = 80) {
  std::mt19937_64 rng(seed);
  Scene s{instrument_of(rows, columns), {40 * kRadPerDeg, arm_deg * kRadPerDeg}, {}, {}};
  auto darks = test::made_frames(5, Grid<double>(rows, columns, 0.0), 4, kSensor, rng);
  s.frames = test::made_frames(frames, peak(rows, columns), 4, kSensor, rng);
  const auto spoil = [&](int count, auto&& what) {
    for (int k = 0; k < count; ++k)
      what(static_cast<int>(rng() % static_cast<unsigned>(rows)),
           static_cast<int>(rng() % static_cast<unsigned>(columns)));
  };
  const int some = rows * columns / 300;
  spoil(some, [&](int r, int c) {  // hot
    for (auto* list : {&darks, &s.frames}) {
      for (Frame& f : *list) f.dn(r, c) += 4000;
    }
  });
  spoil(some, [&](int r, int c) { s.frames[0].dn(r, c) += 500; });       // cosmic
  spoil(some, [&](int r, int c) { s.frames.back().dn(r, c) = 65535; });  // saturated
  spoil(some, [&](int r, int c) { s.frames[0].dn(r, c) = std::nanf(""); });
  spoil(some, [&](int r, int c) { darks[1].dn(r, c) += 300; });  // cosmic in a dark
  spoil(rows * columns > 100 ? 1 : 0, [&](int, int) {            // a dead corner: no good neighbour
    for (int r = 0; r < std::min(rows, 9); ++r) {
      for (int c = 0; c < std::min(columns, 7); ++c) s.frames[0].dn(r, c) = std::nanf("");
    }
  });
  s.dark = combine_darks(darks, kSensor);
  return s;
}

struct Exact {
  FusedPlanes<double> planes;
  Grid<double> expected_f;
};

Exact exact(const Scene& s) {
  const Counts counts = reduce(s.frames, s.dark, s.sensor, s.response, kExposure_s);
  const std::vector<ScaledCounts> one{{&counts, kFactor, 0}};
  const Merged merged = merge(one);
  const AngleMap angles = angle_map(s.instrument, s.pose);
  const int rows = counts.mask.rows(), columns = counts.mask.columns();
  Exact out{{{rows, columns}, {rows, columns}, {}, {rows, columns}, {rows, columns}, {}}, {rows, columns}};
  for (std::size_t i = 0; i < merged.mask.size(); ++i) {
    const double projected = angles.solid_angle_sr[i] * std::cos(angles.theta_s_rad[i]),
                 f = merged.value[i] / projected;
    Mask mask = static_cast<Mask>(merged.mask[i] | angles.mask[i]);
    if (mask == 0 && !std::isfinite(f)) mask = kNoData;
    out.planes.mask[i] = mask;
    out.planes.brdf_per_sr[i] = mask == 0 ? f : std::nan("");
    out.planes.u_random_per_sr[i] =
        mask == 0 ? static_cast<float>(std::sqrt(merged.variance[i]) / projected) : std::nanf("");
    out.expected_f[i] = mask == 0 ? merged.expected[i] / projected : std::nan("");
  }
  if (s.instrument.calibration) {
    out.planes.u_pose_per_sr = *pose_uncertainty(s.instrument, s.pose, out.expected_f);
    for (std::size_t i = 0; i < out.planes.mask.size(); ++i)
      out.planes.u_total_per_sr[i] = std::hypot(out.planes.u_random_per_sr[i], out.planes.u_pose_per_sr[i]);
  } else {
    out.planes.u_total_per_sr = out.planes.u_random_per_sr;
  }
  return out;
}

template <class T = float>
FusedPlanes<T> fused(const Scene& s, const AngleMap* angles = nullptr) {
  FusedPlanes<T> out;
  const SampleView view = s.view();
  std::optional<PoseTiles> pose;
  if (s.instrument.calibration)
    pose.emplace(view, calibration_changes(s.instrument, s.pose), s.instrument.rows, s.instrument.columns);
  fused_map({s.frames, s.dark, s.sensor, s.response, kExposure_s, kFactor}, {view, angles, pose ? &*pose : nullptr},
            {.with_total = true, .with_expected = true}, out);
  return out;
}

template <class T>
void expect_close(const Grid<T>& a, const Grid<T>& b, double relative, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(std::isnan(a[i]), std::isnan(b[i])) << what << " " << i;
    if (std::isnan(a[i])) continue;
    ASSERT_LE(std::abs(a[i] - b[i]), relative * std::abs(b[i])) << what << " " << i;
  }
}

void expect_pose_close(const Grid<float>& u_pose, const FusedPlanes<double>& exact) {
  ASSERT_EQ(u_pose.size(), exact.u_pose_per_sr.size());
  for (std::size_t i = 0; i < u_pose.size(); ++i) {
    const float a = u_pose[i], b = exact.u_pose_per_sr[i];
    ASSERT_EQ(std::isnan(a), std::isnan(b)) << "u_pose " << i;
    if (std::isnan(a)) continue;
    ASSERT_LE(std::abs(a - b), kFusedPoseMaxError * exact.u_total_per_sr[i]) << "u_pose " << i;
  }
}

template <class T>
std::size_t expect_agreement(const Scene& s, const FusedPlanes<T>& f) {
  const Exact e = exact(s);
  std::size_t good = 0;
  for (std::size_t i = 0; i < e.planes.mask.size(); ++i) {
    EXPECT_EQ(f.mask[i], e.planes.mask[i]) << i;
    good += f.mask[i] == 0;
  }
  const double frames = static_cast<double>(s.frames.size());
  for (std::size_t i = 0; i < f.mask.size(); ++i) {
    EXPECT_EQ(std::isnan(f.brdf_per_sr[i]), f.mask[i] != 0) << i;
    if (f.mask[i] != 0) continue;
    const double truth = e.planes.brdf_per_sr[i];
    EXPECT_LE(std::abs(f.brdf_per_sr[i] - truth),
              kFusedBrdfMaxError * (std::abs(truth) + std::sqrt(frames) * e.planes.u_random_per_sr[i]))
        << i;
  }
  expect_close(f.u_random_per_sr, e.planes.u_random_per_sr, kFusedUncertaintyMaxError, "u_random");
  expect_pose_close(f.u_pose_per_sr, e.planes);
  expect_close(f.u_total_per_sr, e.planes.u_total_per_sr, kFusedPoseMaxError, "u_total");
  for (std::size_t i = 0; i < f.mask.size(); ++i) {  // may be near 0, so beside its own uncertainty
    EXPECT_EQ(std::isnan(f.expected_per_sr[i]), std::isnan(e.expected_f[i])) << i;
    if (f.mask[i] != 0) continue;
    EXPECT_LE(std::abs(f.expected_per_sr[i] - e.expected_f[i]),
              3e-6 * (std::abs(f.brdf_per_sr[i]) + f.u_random_per_sr[i]))
        << i;
  }
  return good;
}

TEST(Fused, AgreesWithTheExactChainOnSpoiltFrames) {
  std::uint64_t seed = 1;
  for (const auto& [rows, columns] : {std::pair{150, 700}, {64, 64}, {65, 513}, {129, 40}, {200, 1025}}) {
    for (const int frames : {1, 2, 3, 6}) {
      const Scene s = scene(rows, columns, frames, seed++);
      EXPECT_GT(expect_agreement(s, fused(s)), static_cast<std::size_t>(rows * columns / 2)) << rows << "x" << columns;
    }
  }
}

// Planes of kStreamedBytes and more are written past the caches, at odd places in their lines; and pixels as fine as
// the paper's take the way without a division.
TEST(Fused, LargeFramesOfFinePixels) {
  Scene s = scene(2001, 1999, 1, 50);
  s.instrument.geometry.pixel_column = s.instrument.geometry.pixel_row = 5.5e-6;
  const FusedPlanes<float> f = fused(s);
  EXPECT_GE(f.mask.size() * (4 + 3 * 4 + 2), kStreamedBytes);
  EXPECT_GT(expect_agreement(s, f), f.mask.size() / 2);
}

TEST(Fused, PlanesInDoubleHoldTheSame) {
  const Scene s = scene(150, 700, 3, 60);
  const FusedPlanes<double> f = fused<double>(s);
  EXPECT_GT(expect_agreement(s, f), f.mask.size() / 2);
  const FusedPlanes<float> narrow = fused(s);
  for (std::size_t i = 0; i < f.mask.size(); ++i)
    ASSERT_TRUE(f.brdf_per_sr[i] == static_cast<double>(narrow.brdf_per_sr[i]) || f.mask[i] != 0) << i;
}

TEST(Fused, SmallFrames) {
  std::uint64_t seed = 100;
  for (const auto& [rows, columns] : {std::pair{1, 1}, {1, 30}, {30, 1}, {2, 2}, {3, 5}, {5, 4}}) {
    Scene s = scene(rows, columns, 3, seed++);
    expect_agreement(s, fused(s));
    s.instrument.calibration.reset();
    expect_agreement(s, fused(s));
  }
}

TEST(Fused, FlatLinearityAndBadPixels) {
  Scene s = scene(140, 300, 4, 200);
  s.sensor.linearity = {1e-7, -3e-13};
  Frame flat{Grid<float>(140, 300), 1, "flat", {}};
  for (std::size_t i = 0; i < flat.dn.size(); ++i) flat.dn[i] = 1000 + static_cast<float>(i % 97);
  flat.dn(20, 30) = 0;
  flat.dn(21, 30) = -5;
  flat.dn(139, 299) = std::nanf("");
  flat.dn(70, 70) = 1e-38f;  // the quotient overflows to no harm, or gives no data
  s.response.flat = normalised_flat(flat);
  s.response.bad = Grid<Mask>(140, 300, Mask{0});
  s.response.bad(139, 0) = s.response.bad(0, 299) = s.response.bad(50, 51) = kBad;
  const FusedPlanes<float> f = fused(s);
  expect_agreement(s, f);
  EXPECT_EQ(f.mask(50, 51) & kBad, kBad);
  EXPECT_EQ(f.mask(20, 30) & kFlatInvalid, kFlatInvalid);
}

TEST(Fused, HorizonInsideTheFrameAndAcrossRows) {
  for (const double roll : {0.0, 0.7, 1.5}) {
    Scene s = scene(120, 200, 2, 300, 130);
    s.instrument.geometry.rotation_roll = roll;
    const FusedPlanes<float> f = fused(s);
    const std::size_t good = expect_agreement(s, f);
    EXPECT_GT(good, 1000u);
    std::size_t below = 0;
    for (const Mask m : f.mask) below += (m & kBelowHorizon) != 0;
    EXPECT_GT(below, 1000u);
  }
}

TEST(Fused, AnglesGivenInPlaceOfTheView) {
  const Scene s = scene(100, 300, 2, 400, 129);
  const AngleMap angles = angle_map(s.instrument, s.pose);
  expect_agreement(s, fused(s, &angles));
}

TEST(Fused, SameBytesForAnyNumberOfThreads) {
  const Scene s = scene(300, 400, 3, 500);
  const FusedPlanes<float> two = fused(s);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const FusedPlanes<float> one = fused(s);
  const auto same = [](const auto& a, const auto& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
  };
  EXPECT_TRUE(same(one.brdf_per_sr, two.brdf_per_sr));
  EXPECT_TRUE(same(one.u_random_per_sr, two.u_random_per_sr));
  EXPECT_TRUE(same(one.u_pose_per_sr, two.u_pose_per_sr));
  EXPECT_TRUE(same(one.u_total_per_sr, two.u_total_per_sr));
  EXPECT_TRUE(same(one.mask, two.mask));
}

TEST(Fused, SameBytesFromSixteenBitFrames) {
  Scene wide = scene(130, 700, 3, 650);
  Scene narrow = wide;
  for (std::size_t k = 0; k < wide.frames.size(); ++k) {
    Grid<std::uint16_t> counts(130, 700);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const float v = std::as_const(wide.frames[k]).dn[i];
      counts[i] = static_cast<std::uint16_t>(v > 0 ? std::min(std::round(v), 65535.0f) : 0);
      wide.frames[k].dn[i] = static_cast<float>(counts[i]);
    }
    narrow.frames[k].dn = std::move(counts);
  }
  const FusedPlanes<float> a = fused(wide), b = fused(narrow);
  ASSERT_EQ(a.brdf_per_sr.size(), b.brdf_per_sr.size());
  EXPECT_EQ(std::memcmp(a.brdf_per_sr.data(), b.brdf_per_sr.data(), a.brdf_per_sr.size() * sizeof(float)), 0);
  EXPECT_EQ(std::memcmp(a.u_total_per_sr.data(), b.u_total_per_sr.data(), a.u_total_per_sr.size() * sizeof(float)), 0);
  EXPECT_EQ(std::memcmp(a.mask.data(), b.mask.data(), a.mask.size() * sizeof(Mask)), 0);
}

// What float cannot hold is no number, and says so.
TEST(Fused, QuotientsThatOverflowAreMasked) {
  const Scene s = scene(60, 80, 2, 700);
  const FusedPlanes<double> plain = fused<double>(s);
  const double largest = *std::max_element(plain.brdf_per_sr.begin(), plain.brdf_per_sr.end(), [](double a, double b) {
    return (std::isnan(a) ? 0 : a) < (std::isnan(b) ? 0 : b);
  });
  const double more = 10 * static_cast<double>(std::numeric_limits<float>::max()) / largest;
  const SampleView view = s.view();
  FusedPlanes<double> f;
  fused_map({s.frames, s.dark, s.sensor, s.response, kExposure_s, kFactor * more}, {view}, {}, f);
  std::size_t over = 0, good = 0;
  for (std::size_t i = 0; i < f.mask.size(); ++i) {
    if (plain.mask[i] != 0) continue;
    const double truth = plain.brdf_per_sr[i] * more / static_cast<double>(std::numeric_limits<float>::max());
    if (std::abs(truth - 1) < 1e-6) continue;
    EXPECT_EQ(f.mask[i], truth > 1 ? kNoData : 0) << i;
    EXPECT_EQ(std::isnan(f.brdf_per_sr[i]), truth > 1) << i;
    EXPECT_EQ(std::isnan(f.u_random_per_sr[i]), truth > 1) << i;
    truth > 1 ? ++over : ++good;
  }
  EXPECT_GT(over, 10u);
  EXPECT_GT(good, 1000u);
}

// The divisor from its definition: pixel area, cosines and distance, in long double.
TEST(Fused, DividesByTheProjectedSolidAngle) {
  const Scene s = scene(40, 60, 1, 600);
  const FusedPlanes<float> f = fused(s);
  const Counts counts = reduce(s.frames, s.dark, s.sensor, s.response, kExposure_s);
  const SampleView view = s.view();
  int checked = 0;
  for (int r = 0; r < 40; ++r) {
    for (int c = 0; c < 60; ++c) {
      if (f.mask(r, c) != 0) continue;
      const Vector3<long double> d = view.pixel(c, r).cast<long double>();
      const long double distance = d.norm(), cos_theta = d.z() / distance,
                        omega = view.pixel_area_m2 * view.detector_normal.cast<long double>().dot(d) / distance /
                                (distance * distance);
      const auto truth = static_cast<double>(counts.rate_dn_per_s(r, c) * kFactor / (omega * cos_theta));
      EXPECT_LE(std::abs(f.brdf_per_sr(r, c) - truth), kFusedBrdfMaxError * (std::abs(truth) + f.u_random_per_sr(r, c)))
          << r << "," << c;
      ++checked;
    }
  }
  EXPECT_GT(checked, 1500);
}

}  // namespace
}  // namespace scatmap
