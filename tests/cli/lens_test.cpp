// The verbs with detector.lens_cameramodel: a lens file that is the exact pinhole of the bare CCD gives what the bare
// CCD gives, from angles to compare; what a lens rules out is left out or refused in words. Does not prove the lens
// models themselves (tests/angles/lens_test.cpp).
#include <gtest/gtest.h>

#include <cmath>

#include "calib/export_cameramodel.h"
#include "cli/lab.h"
#include "scatmap/base/units.h"
#include "scatmap/report/map_fits.h"

namespace scatmap::test {
namespace {

constexpr double kStage_deg = 20, kArm_deg = 40;

// The lab's instrument, and the same with its pinhole as a lens beside it.
class LensLab : public testing::Test {
 protected:
  LensLab() : lab_(maker().fresh_copy()) {
    const Instrument in = read_instrument(lab_.path("instrument.toml"));
    const SampleView view = sample_view(in, {kStage_deg * kRadPerDeg, kArm_deg * kRadPerDeg});
    lab_.write("pinhole.cameramodel", calib::to_cameramodel(calib::pinhole_at_spot(view, in.columns, in.rows), ""));
    lab_.write("lensed.toml", lab_.read("instrument.toml"));
    lab_.replace("lensed.toml", "rows = 64", "rows = 64\nlens_cameramodel = \"pinhole.cameramodel\"");
    lab_.write("lensed_measurement.toml", lab_.read("measurement.toml"));
    lab_.replace("lensed_measurement.toml", "\"instrument.toml\"", "\"lensed.toml\"");
  }
  static const LabMaker& maker() {
    static const LabMaker kMaker;
    return kMaker;
  }
  ToolRun run(const std::vector<std::string>& arguments) const { return run_tool(arguments, lab_.folder()); }
  void expect_done(const std::vector<std::string>& arguments) const {
    const ToolRun r = run(arguments);
    ASSERT_EQ(r.status, 0) << arguments.front() << ": " << r.err;
  }
  ToolRun angles(const std::string& instrument) const {
    return run({"angles", instrument, "--stage-deg", "20", "--arm-deg", "40", "-o", "out.fits"});
  }
  void expect_refused(const ToolRun& r, const std::vector<std::string>& says) const {
    EXPECT_EQ(r.status, 1);
    for (const std::string& s : says) EXPECT_NE(r.err.find(s), std::string::npos) << s << " is not in: " << r.err;
    EXPECT_FALSE(fs::exists(lab_.path("out.fits")));
  }

  Lab lab_;
};

double largest_relative(const Grid<double>& a, const Grid<double>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double error = std::abs(a[i] - b[i]) / std::abs(b[i]);
    if (std::isnan(a[i]) && std::isnan(b[i])) continue;
    worst = error <= worst ? worst : error;  // NaN stays
  }
  return worst;
}

TEST_F(LensLab, PinholeLensGivesTheBareDetectorsMaps) {
  expect_done({"brdf", "lensed_measurement.toml", "--precision", "double", "-o", "lens.fits"});
  expect_done({"brdf", "measurement.toml", "--precision", "double", "-o", "bare.fits"});
  expect_done({"model", "model.toml", "--like", "lens.fits", "--precision", "double", "-o", "lens_model.fits"});
  expect_done({"model", "model.toml", "--like", "bare.fits", "--precision", "double", "-o", "bare_model.fits"});
  for (const char* kind : {"", "_model"}) {
    const BrdfMap lens = read_map_fits(lab_.path("lens" + std::string(kind) + ".fits"));
    const BrdfMap bare = read_map_fits(lab_.path("bare" + std::string(kind) + ".fits"));
    ASSERT_TRUE(lens.instrument.lens_cameramodel.has_value());
    ASSERT_TRUE(std::equal(lens.mask.begin(), lens.mask.end(), bare.mask.begin()));
    EXPECT_LE(largest_relative(lens.angles.theta_s_rad, bare.angles.theta_s_rad), 1e-12);
    EXPECT_LE(largest_relative(lens.angles.solid_angle_sr, bare.angles.solid_angle_sr), 1e-6);
    EXPECT_LE(largest_relative(lens.brdf_per_sr, bare.brdf_per_sr), kind[0] == '_' ? 1e-8 : 1e-6);
  }
}

TEST_F(LensLab, CompareFindsTheSameFeaturesInSameDirections) {
  lab_.write("lobe.toml",
             "wavelength_nm = 512\npolarization = \"s\"\n[[term]]\nkind = \"microfacet\"\nrho = 0.5\nm = 0.004\nn = "
             "[1.5, 0.25]\n");
  expect_done({"brdf", "lensed_measurement.toml", "-o", "lens.fits"});
  expect_done({"model", "lobe.toml", "--like", "lens.fits", "-o", "lens_lobe.fits"});
  expect_done({"model", "lobe.toml", "--like", "maps/measured.fits", "-o", "bare_lobe.fits"});
  expect_done({"compare", "lens.fits", "lens_lobe.fits", "-o", "lens_compared"});
  const BrdfMap lens = read_map_fits(lab_.path("lens_lobe.fits")), bare = read_map_fits(lab_.path("bare_lobe.fits"));
  const Comparison a = compare(lens, lens), b = compare(bare, bare);
  EXPECT_LE(compare(lens, bare).direction_difference_px, 1e-6);
  ASSERT_EQ(b.measured.peaks.size(), 1U);
  ASSERT_EQ(a.measured.peaks.size(), 1U);
  EXPECT_NEAR(a.measured.peaks[0].theta_s_deg, b.measured.peaks[0].theta_s_deg, 1e-5);
  EXPECT_NEAR(a.measured.peaks[0].phi_s_deg, b.measured.peaks[0].phi_s_deg, 1e-4);
  ASSERT_EQ(a.columns.size(), 1U);
  for (std::size_t i = 0; i < b.columns[0].measured.size(); ++i)
    EXPECT_NEAR(a.columns[0].measured.angle_deg[i], b.columns[0].measured.angle_deg[i], 1e-5);
}

// Another pose than the one the pinhole was made at: arm and rays turn together, as a camera on the arm does.
TEST_F(LensLab, LensTurnsWithTheArm) {
  expect_done({"angles", "lensed.toml", "--stage-deg", "20", "--arm-deg", "47", "-o", "turned.fits"});
  const MapView seen = read_map_view(lab_.path("turned.fits"));
  const AngleMap turned = angle_map(seen.instrument, seen.pose),
                 straight = angle_map(seen.instrument, {kStage_deg * kRadPerDeg, kArm_deg * kRadPerDeg});
  const auto at = [](const AngleMap& m) {
    return direction_from_angles<double>(m.theta_s_rad(20, 31), m.phi_s_rad(20, 31));
  };
  const Vector3<double> moved = rotation_y<double>(7 * kRadPerDeg) * at(straight);
  EXPECT_LE(angle_between<double>(moved, at(turned)), 1e-12);
}

TEST_F(LensLab, FileSaysWhichLensAndNoFlatProjection) {
  ASSERT_EQ(angles("lensed.toml").status, 0);
  const std::string bytes = lab_.read("out.fits");
  EXPECT_NE(bytes.find("LENSSHA"), std::string::npos);
  EXPECT_EQ(bytes.find("SCLN-TAN"), std::string::npos);
  EXPECT_NE(lab_.read("maps/angles.fits").find("SCLN-TAN"), std::string::npos);
  // A lens that is no longer the same makes the map's directions unknown.
  lab_.replace("pinhole.cameramodel", "'imagersize'", "# another byte\n    'imagersize'");
  const ToolRun r = run({"model", "model.toml", "--like", "out.fits", "-o", "late.fits"});
  EXPECT_EQ(r.status, 1);
  EXPECT_NE(r.err.find("has changed since"), std::string::npos) << r.err;
}

TEST_F(LensLab, WrongLensFilesAreNamed) {
  lab_.replace("lensed.toml", "\"pinhole.cameramodel\"", "\"nowhere.cameramodel\"");
  expect_refused(angles("lensed.toml"), {"lensed.toml:", "detector.lens_cameramodel", "does not exist", "nowhere"});
  lab_.replace("lensed.toml", "\"nowhere.cameramodel\"", "3");
  expect_refused(angles("lensed.toml"), {"detector.lens_cameramodel"});
  lab_.replace("lensed.toml", "lens_cameramodel = 3", "lens_cameramodel = \"pinhole.cameramodel\"");
  lab_.replace("pinhole.cameramodel", "[ 64, 64 ]", "[ 64, 63 ]");
  expect_refused(angles("lensed.toml"), {"lensed.toml", "pinhole.cameramodel: imagersize", "64 x 63", "64 x 64"});
  lab_.write("pinhole.cameramodel", "no model\n");
  expect_refused(angles("lensed.toml"), {"pinhole.cameramodel", "no camera model", "expected '{'"});
}

TEST_F(LensLab, CalibrationOfALensIsRefusedAndItsUncertaintyLeftOut) {
  lab_.write("targets.csv",
             "kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px\nspecular,20,40,0,31.5,31.5,0.05\n");
  const ToolRun r = run({"calibrate", "targets.csv", "--instrument", "lensed.toml", "-o", "out.toml"});
  EXPECT_EQ(r.status, 1);
  EXPECT_NE(r.err.find("lensed.toml: detector.lens_cameramodel"), std::string::npos) << r.err;
  const std::string calibration = "\n[calibration]\nparameters = [\"detector.distance_mm\"]\ncovariance = [[0.01]]\n";
  lab_.write("lensed.toml", lab_.read("lensed.toml") + calibration);
  expect_done({"brdf", "lensed_measurement.toml", "-o", "lens.fits"});
  const BrdfMap map = read_map_fits(lab_.path("lens.fits"));
  EXPECT_TRUE(map.u_pose_per_sr.empty());
  EXPECT_NE(lab_.read("lens.fits").find("pose uncertainty is left out"), std::string::npos);
  lab_.write("instrument.toml", lab_.read("instrument.toml") + calibration);
  expect_done({"brdf", "measurement.toml", "-o", "bare.fits"});
  EXPECT_FALSE(read_map_fits(lab_.path("bare.fits")).u_pose_per_sr.empty());
}

}  // namespace
}  // namespace scatmap::test
