// Maps on disk: what is read back is what was written, angles are computed anew, and other readers of FITS and EXR find
// their parts. astropy, fitsverify and OpenCV are run by tests/interop.sh.
#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <fitsio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <random>

#include "scatmap/angles/angle_uncertainty.h"
#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "scatmap/report/fits_file.h"
#include "scatmap/report/map_exr.h"
#include "scatmap/report/map_fits.h"

namespace scatmap {
namespace {
namespace fs = std::filesystem;

BrdfMap example() {
  Instrument in = parse_instrument(
      "[detector]\ncolumns = 31\nrows = 23\npitch_um = [50.1, 49.9]\ndistance_mm = 325.1\nrotation_deg = [0.3, -0.2, "
      "1.1]\n"
      "[sensor]\ngain_e_per_dn = 1.5\nread_noise_e = 8\nsaturation_dn = 65535\n",
      "example");
  BrdfMap map;
  map.instrument = in;
  map.pose = {20.1 * kRadPerDeg, 40.3 * kRadPerDeg};
  map.wavelength_m = 632.8 * kMetrePerNm;
  map.angles = angle_map(in, map.pose);
  map.mask = Grid<Mask>(23, 31, Mask{0});
  map.mask(3, 4) = kSaturated | kBloom;
  map.brdf_per_sr = Grid<double>(23, 31);
  map.u_random_per_sr = Grid<float>(23, 31);
  StructuredCause nonlin{"U_NONLIN", "pixel non-linearity", Grid<float>(23, 31)};
  std::mt19937_64 rng(1);
  for (std::size_t i = 0; i < map.mask.size(); ++i) {
    map.brdf_per_sr[i] =
        map.mask[i] == 0 ? std::exp(std::uniform_real_distribution<double>(-8, 13)(rng)) : std::nan("");
    map.u_random_per_sr[i] = static_cast<float>(0.01 * map.brdf_per_sr[i]);
    nonlin.sensitivity_per_sr[i] = static_cast<float>(-0.02 * map.brdf_per_sr[i]);
  }
  map.structured.push_back(nonlin);
  map.scale.causes = {{"filter nd40", Distribution::kRectangular, 0.2, -kLn10, true},
                      {"signature", Distribution::kNormal, 0.001, -1, false}};
  map.exposures = {
      {"signature", 4.5, {"nd40"}, {{"a.fits", std::string(64, 'a')}}, {{"d.fits", std::string(64, 'd')}}}};
  map.notes = {"a note"};
  map.provenance = {"scatmap brdf m.toml -o x.fits", "scatmap test", {{"m.toml", std::string(64, 'f')}}};
  return map;
}

class MapFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("scatmap-mapfile-" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

TEST_F(MapFile, DoublePrecisionReadsBackBitForBit) {
  const BrdfMap map = example();
  write_map_fits(map, folder_ / "a.fits", Precision::kDouble, Overwrite::kKeep);
  const BrdfMap back = read_map_fits(folder_ / "a.fits");
  for (std::size_t i = 0; i < map.mask.size(); ++i) {
    EXPECT_TRUE(same(map.brdf_per_sr[i], back.brdf_per_sr[i]));
    EXPECT_TRUE(same(map.u_random_per_sr[i], back.u_random_per_sr[i]));
    EXPECT_TRUE(same(map.structured[0].sensitivity_per_sr[i], back.structured.at(0).sensitivity_per_sr[i]));
    EXPECT_EQ(map.mask[i], back.mask[i]);
    EXPECT_TRUE(same(map.angles.theta_s_rad[i], back.angles.theta_s_rad[i]));
  }
  EXPECT_EQ(map.pose.stage_rad, back.pose.stage_rad);
  EXPECT_EQ(map.pose.arm_rad, back.pose.arm_rad);
  for (const GeometryKey& key : geometry_keys())
    EXPECT_EQ(map.instrument.geometry.*key.member, back.instrument.geometry.*key.member) << key.name;
  ASSERT_EQ(back.scale.causes.size(), 2u);
  EXPECT_EQ(back.scale.standard(), map.scale.standard());
  EXPECT_EQ(back.scale.filters_worst_case(), map.scale.filters_worst_case());
  EXPECT_TRUE(back.u_pose_per_sr.empty());
}

TEST_F(MapFile, CorrelatedAndAsymmetricCausesReadBack) {
  BrdfMap map = example();
  map.scale.causes = {{"filter a", Distribution::kNormal, 0.02, kLn10, true, 0},
                      {"laser drift", Distribution::kTriangular, 0.01, 1, false, 0},
                      {"filter b", Distribution::kNormal, 0.03, -kLn10, true, 0},
                      {"filter c", Distribution::kAsymmetric, 0.03, -kLn10, true, 0.01}};
  map.scale.correlation = Eigen::MatrixXd::Identity(4, 4);
  map.scale.correlation(0, 2) = map.scale.correlation(2, 0) = 0.98;
  map.structured[0].cause = {"filter d", Distribution::kRectangular, 0.15, 1, true, 0};
  write_map_fits(map, folder_ / "a.fits", Precision::kSingle, Overwrite::kKeep);
  const BrdfMap back = read_map_fits(folder_ / "a.fits");
  EXPECT_EQ(back.scale.standard(), map.scale.standard());
  EXPECT_EQ(back.scale.correlation_of(2, 0), 0.98);
  EXPECT_EQ(back.scale.causes.at(3).half_width_below, 0.01);
  EXPECT_EQ(back.scale.causes.at(1).distribution, Distribution::kTriangular);
  EXPECT_EQ(back.structured.at(0).cause.distribution, Distribution::kRectangular);
  EXPECT_EQ(back.structured.at(0).cause.half_width, 0.15);
  EXPECT_TRUE(back.structured.at(0).cause.is_filter);
}

TEST_F(MapFile, SinglePrecisionRoundsTheBrdfOnly) {
  const BrdfMap map = example();
  write_map_fits(map, folder_ / "a.fits", Precision::kSingle, Overwrite::kKeep);
  const BrdfMap back = read_map_fits(folder_ / "a.fits");
  for (std::size_t i = 0; i < map.mask.size(); ++i)
    EXPECT_TRUE(same(static_cast<float>(map.brdf_per_sr[i]), back.brdf_per_sr[i]));
}

TEST_F(MapFile, LayoutIsThatOfTheDocs) {
  write_map_fits(example(), folder_ / "a.fits", Precision::kSingle, Overwrite::kKeep);
  fitsfile* f = nullptr;
  int status = 0, count = 0, type = 0;
  ASSERT_EQ(fits_open_diskfile(&f, (folder_ / "a.fits").c_str(), READONLY, &status), 0);
  fits_get_num_hdus(f, &count, &status);
  std::vector<std::string> names;
  for (int i = 1; i <= count; ++i) {
    char name[FLEN_VALUE] = "";
    int data_ok = 0, hdu_ok = 0;
    fits_movabs_hdu(f, i, &type, &status);
    fits_read_key(f, TSTRING, "EXTNAME", name, nullptr, &status);
    fits_verify_chksum(f, &data_ok, &hdu_ok, &status);
    EXPECT_EQ(data_ok, 1) << name;
    EXPECT_EQ(hdu_ok, 1) << name;
    names.emplace_back(name);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"BRDF", "UNCERT", "MASK", "U_RANDOM", "U_NONLIN", "THETA_S_DEG",
                                             "PHI_S_DEG", "SOLID_ANGLE_SR", "COMMON", "FRAMES", "INSTRUMENT"}));
  char text[FLEN_VALUE] = "";
  fits_movabs_hdu(f, 1, &type, &status);
  fits_read_key(f, TSTRING, "BUNIT", text, nullptr, &status);
  EXPECT_STREQ(text, "sr-1");
  fits_movabs_hdu(f, 2, &type, &status);
  fits_read_key(f, TSTRING, "UTYPE", text, nullptr, &status);
  EXPECT_STREQ(text, "StdDevUncertainty");
  fits_close_file(f, &status);
  EXPECT_EQ(status, 0);
}

// Pixels go to the disk in blocks, past CFITSIO: an odd number of them, more than a block, and images that only the
// writer keeps.
TEST_F(MapFile, LargeImagesAreWholeAndSummed) {
  const Instrument in = parse_instrument(
      "[detector]\ncolumns = 301\nrows = 211\npitch_um = [5.5, 5.5]\ndistance_mm = 325.1\n"
      "[calibration]\nparameters = [\"detector.distance_mm\", \"detector.offset_mm.0\"]\n"
      "covariance = [[0.01, 0.002], [0.002, 0.004]]\n",
      "example");
  const Pose pose{20.1 * kRadPerDeg, 40.3 * kRadPerDeg};
  const AngleMap angles = angle_map(in, pose);
  const auto u = angle_uncertainty(in, pose, angles.mask);
  ASSERT_TRUE(u);
  write_angles_fits(angles, in, pose, {}, folder_ / "a.fits", Overwrite::kKeep);
  FitsReader fits(folder_ / "a.fits");
  const Grid<double> theta = fits.image_double("THETA_S_DEG");
  const Grid<float> sigma = fits.image_float("SIGMA_DIRECTION_PX"), phi = fits.image_float("SIGMA_PHI_S_DEG");
  const Grid<Mask> mask = fits.image_mask("MASK");
  ASSERT_EQ(theta.size(), angles.mask.size());
  ASSERT_EQ(sigma.size(), angles.mask.size());
  for (std::size_t i = 0; i < theta.size(); ++i) {
    ASSERT_EQ(theta[i], angles.theta_s_rad[i] * kDegPerRad) << i;
    ASSERT_EQ(sigma[i], u->direction_px[i]) << i;
    ASSERT_EQ(phi[i], static_cast<float>(u->phi_s_rad[i] * kDegPerRad)) << i;
    ASSERT_EQ(mask[i], angles.mask[i]) << i;
  }
  fitsfile* f = nullptr;
  int status = 0, count = 0;
  fits_open_diskfile(&f, (folder_ / "a.fits").c_str(), READONLY, &status);
  fits_get_num_hdus(f, &count, &status);
  EXPECT_EQ(count, 9);
  for (int k = 1; k <= count; ++k) {
    int type = 0, data_ok = 0, hdu_ok = 0;
    fits_movabs_hdu(f, k, &type, &status);
    fits_verify_chksum(f, &data_ok, &hdu_ok, &status);
    EXPECT_EQ(data_ok, 1) << k;
    EXPECT_EQ(hdu_ok, 1) << k;
  }
  fits_close_file(f, &status);
  EXPECT_EQ(status, 0);
}

TEST_F(MapFile, ExistingFileIsKeptAndForeignFilesAreRefused) {
  write_map_fits(example(), folder_ / "a.fits", Precision::kSingle, Overwrite::kKeep);
  const auto before = record_input(folder_ / "a.fits").sha256;
  EXPECT_THROW(write_map_fits(example(), folder_ / "a.fits", Precision::kDouble, Overwrite::kKeep), Error);
  EXPECT_EQ(record_input(folder_ / "a.fits").sha256, before);
  EXPECT_THROW(read_map_fits(fs::path(SCATMAP_TEST_DATA) / "fits" / "a8280271.fits"), Error);
  EXPECT_THROW(read_map_fits(folder_ / "none.fits"), Error);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(MapFile, AngleFileServesLikeAMap) {
  const BrdfMap map = example();
  write_angles_fits(map.angles, map.instrument, map.pose, {}, folder_ / "angles.fits", Overwrite::kKeep);
  const MapView view = read_map_view(folder_ / "angles.fits");
  EXPECT_EQ(view.pose.arm_rad, map.pose.arm_rad);
  EXPECT_EQ(view.instrument.geometry.distance, map.instrument.geometry.distance);
}

TEST_F(MapFile, ExrHasFloatChannelsAndHeaderValues) {
  BrdfMap map = example();
  map.brdf_per_sr(0, 0) = 4.21e5;  // infinity in HALF
  write_map_exr(map, folder_ / "a.exr", Overwrite::kKeep);
  Imf::InputFile file((folder_ / "a.exr").c_str());
  std::vector<std::string> channels;
  for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c) {
    channels.emplace_back(c.name());
    EXPECT_EQ(c.channel().type, Imf::FLOAT);
  }
  EXPECT_EQ(channels, (std::vector<std::string>{"Y", "mask", "phi_s_deg", "solid_angle_sr", "theta_s_deg", "u_nonlin",
                                                "u_random", "uncert"}));
  Grid<float> y(23, 31), theta(23, 31);
  Imf::FrameBuffer buffer;
  buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(y.data()), sizeof(float), 31 * sizeof(float)));
  buffer.insert("theta_s_deg",
                Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(theta.data()), sizeof(float), 31 * sizeof(float)));
  file.setFrameBuffer(buffer);
  file.readPixels(0, 22);
  EXPECT_EQ(y(0, 0), 4.21e5f);
  for (std::size_t i = 0; i < y.size(); ++i) {
    EXPECT_TRUE(same(y[i], static_cast<float>(map.brdf_per_sr[i])));
    EXPECT_EQ(theta[i], static_cast<float>(map.angles.theta_s_rad[i] * kDegPerRad));
  }
  EXPECT_EQ(file.header().typedAttribute<Imf::DoubleAttribute>("theta_i_deg").value(),
            map.angles.theta_i_rad * kDegPerRad);
  EXPECT_EQ(file.header().typedAttribute<Imf::DoubleAttribute>("u_scale_relative").value(), map.scale.standard());
}

}  // namespace
}  // namespace scatmap
