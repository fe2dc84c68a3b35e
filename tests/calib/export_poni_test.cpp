// pyFAI's geometry: our reading of it against values computed by pyFAI and mpmath (tests/oracle/pyfai_poses.csv), and
// the export and its way back. Does not prove that every version of pyFAI reads the file.
#include "calib/export_poni.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "calib/instrument_from_poni.h"
#include "scatmap/angles/angle_map.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "support/random_instrument.h"

namespace scatmap::calib {
namespace {

TEST(Poni, PixelPlacesEqualPyfais) {
  std::ifstream file(SCATMAP_TEST_DATA "/pyfai_poses.csv");
  std::string line;
  std::getline(file, line);
  int rows = 0;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::string text;
    std::getline(fields, text, ',');
    std::vector<double> v;
    while (std::getline(fields, text, ',')) v.push_back(std::stod(text));
    ASSERT_EQ(v.size(), 21u);
    const Poni p{static_cast<int>(v[1]), static_cast<int>(v[0]), v[2], v[3], v[4], v[5], v[6], v[7], v[8], v[9]};
    const Eigen::Vector3d t = p.pixel_m(v[11], v[10]);
    EXPECT_LE((t - Eigen::Vector3d(v[12], v[13], v[14])).norm(), 1e-15 * (1 + t.norm())) << line;
    ++rows;
  }
  EXPECT_EQ(rows, 8 * 24);
}

Instrument bench(bool flip_columns, bool flip_rows) {
  Instrument in = parse_instrument(
      "[detector]\ncolumns = 64\nrows = 48\npitch_um = [226.5, 230.1]\ndistance_mm = 324.3\noffset_mm = [2.1, -1.7]\n"
      "rotation_deg = [1.35, -2.42, 3.28]\n[arm]\nzero_deg = 0.6\n[sample]\ntilt_deg = 0.7\nheight_mm = 0.11\n",
      "bench");
  in.flip_columns = flip_columns;
  in.flip_rows = flip_rows;
  return in;
}

// 2theta and chi as pyFAI would compute them from the file are theta_s and phi_s, and the way back gives the same
// vectors.
TEST(Poni, ExportGivesScatterAnglesAndComesBack) {
  for (const auto& [flip_columns, flip_rows] : {std::pair{false, false}, {true, false}, {false, true}, {true, true}}) {
    const Instrument in = bench(flip_columns, flip_rows);
    const SampleView view = sample_view(in, {20 * kRadPerDeg, 55 * kRadPerDeg});
    const PoniExport out = poni_at_spot(view, in.columns, in.rows);
    const Poni read = parse_poni(to_poni(out, "a test"), "text");
    EXPECT_EQ(read.columns, in.columns);
    EXPECT_EQ(read.rows, in.rows);
    for (const auto& [c, r] : {std::pair{0, 0}, {63, 5}, {30, 47}}) {
      const Eigen::Vector3d t = read.pixel_m(c, r);
      const double tth = std::atan2(std::hypot(t.x(), t.y()), t.z()), chi = std::atan2(t.x(), t.y());
      const PixelAngles a = pixel_angles(view, c, r);
      EXPECT_NEAR(tth, a.theta_s_rad, 1e-14);
      const double phi = out.axes == PoniAxes::kYxz ? chi + std::numbers::pi : 1.5 * std::numbers::pi - chi;
      EXPECT_NEAR(std::remainder(phi - a.phi_s_rad, 2 * std::numbers::pi), 0, 1e-13);
    }
    const SampleView back = view_from_poni({read, out.axes}, view.to_source);
    EXPECT_LE((back.origin - view.origin).norm(), 1e-15);
    EXPECT_LE((back.column_step - view.column_step).norm(), 1e-18);
    EXPECT_LE((back.row_step - view.row_step).norm(), 1e-18);
    EXPECT_LE((back.detector_normal - view.detector_normal).norm(), 1e-14);
    EXPECT_GT(read.distance_m, 0);
  }
}

// Instrument to .poni text to instrument: every number of the detector comes back, for benches with everything askew.
TEST(Poni, InstrumentComesBackThroughAFile) {
  std::mt19937_64 rng(77);
  for (int trial = 0; trial < 60; ++trial) {
    const scatmap::test::RandomBench bench = scatmap::test::random_bench(rng, 1);
    const Instrument& in = bench.instrument;
    const Pose pose = bench.pose();
    const SampleView view = sample_view(in, pose);
    const Poni poni = parse_poni(to_poni(poni_at_spot(view, in.columns, in.rows), ""), "text");
    Instrument like = in;
    like.geometry.offset_x = like.geometry.offset_y = like.geometry.rotation_pitch = 0;
    like.geometry.rotation_yaw = 0.3;
    like.geometry.rotation_roll = -0.2;
    like.geometry.distance = 1;
    like.geometry.pixel_column = like.geometry.pixel_row = 1e-5;
    const Instrument back = instrument_from_poni(poni, like, pose);
    for (const GeometryKey& key : geometry_keys())
      EXPECT_NEAR(back.geometry.*key.member, in.geometry.*key.member, 1e-13) << key.name << " of trial " << trial;
    EXPECT_FALSE(back.calibration.has_value());
  }
}

TEST(Poni, InstrumentOfAnotherSizeIsRefused) {
  const Instrument in = bench(false, false);
  Poni poni = poni_at_spot(sample_view(in, {0.3, 0.8}), in.columns, in.rows).poni;
  poni.rows += 1;
  EXPECT_THROW(instrument_from_poni(poni, in, {0.3, 0.8}), Error);
}

TEST(Poni, ReadsVersion1AndRefusesTheRest) {
  const std::string v1 =
      "# Nota\nPixelSize1: 1e-04\nPixelSize2: 2e-04\nDistance: 0.25\nPoni1: 0.1\nPoni2: -0.2\nRot1: 0.1\nRot2: "
      "0.2\nRot3: 0\nWavelength: 1e-10\n";
  EXPECT_EQ(parse_poni(v1, "v1").column_pitch_m, 2e-4);
  const auto refusal = [](const std::string& text) {
    try {
      parse_poni(text, "file.poni");
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(refusal("").find("is empty"), std::string::npos);
  EXPECT_NE(refusal(v1 + "Distance: 0.3\n").find("file.poni:11"), std::string::npos);
  EXPECT_NE(refusal("Distance 3\n").find("file.poni:1: has no colon"), std::string::npos);
  EXPECT_NE(refusal("poni_version: 2\nDetector: Pilatus1M\nDetector_config: {}\nDistance: 1\n").find("pixel1"),
            std::string::npos);
  EXPECT_NE(refusal("poni_version: 2.1\nDetector_config: {\"pixel1\": 1e-4, \"pixel2\": 1e-4}\n").find("poni_version"),
            std::string::npos);
  EXPECT_NE(refusal("poni_version: 2\nDetector_config: {\"pixel1\": 1e-4, \"pixel2\": 1e-4, \"orientation\": 2}\n")
                .find("orientation"),
            std::string::npos);
  EXPECT_NE(refusal("PixelSize1: 1e-4\nPixelSize2: x\n").find("PixelSize2"), std::string::npos);
}

// Numbers that do not fit an int were read as other numbers, and printing a value nested without end overflowed the
// stack.
TEST(ExportPoni, RefusesShapesThatAreNone) {
  const auto said = [](const std::string& shape) {
    try {
      parse_poni("poni_version: 2\nDetector_config: {\"pixel1\": 1e-4, \"pixel2\": 1e-4, " + shape +
                     "}\nDistance: 1\nPoni1: 0\nPoni2: 0\nRot1: 0\nRot2: 0\nRot3: 0\n",
                 "a.poni");
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(said("\"max_shape\": [4, 6]"), "accepted");
  for (const char* shape : {"[4294967297, 6]", "[4, -6]", "[0, 6]", "[4, 6.5]", "[18446744073709551615, 6]", "[4]"}) {
    EXPECT_NE(said(std::string("\"max_shape\": ") + shape).find("max_shape"), std::string::npos) << shape;
  }
  const std::string deep = std::string(1000000, '[') + std::string(1000000, ']');
  EXPECT_NE(said("\"max_shape\": " + deep).find("max_shape"), std::string::npos);
  EXPECT_NE(said("\"orientation\": " + deep).find("orientation"), std::string::npos);
}

}  // namespace
}  // namespace scatmap::calib
