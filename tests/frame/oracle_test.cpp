// Real files made by other programs. The expected values come from astropy 5.2.1 (FITS) and NumPy (PGM), not from
// scatmap. This does not prove that every camera's files can be read: four FITS and two PGM files are a small sample.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "frame/frame_files.h"

namespace {

using frame_files::refusal;
using scatmap::Frame;

const std::filesystem::path kOracle = SCATMAP_TEST_DATA;

struct Summary {
  long long sum;
  float least, most;
  std::ptrdiff_t first_most;
  float top_left, top_right, bottom_left, bottom_right;
};

void expect_summary(const Frame& frame, const Summary& expected) {
  const auto& dn = frame.dn;
  const auto sum = std::accumulate(dn.begin(), dn.end(), 0LL, [](long long s, float v) { return s + std::llround(v); });
  EXPECT_EQ(sum, expected.sum);
  EXPECT_EQ(*std::min_element(dn.begin(), dn.end()), expected.least);
  const auto most = std::max_element(dn.begin(), dn.end());
  EXPECT_EQ(*most, expected.most);
  EXPECT_EQ(std::distance(dn.begin(), most), expected.first_most);
  EXPECT_EQ(dn(0, 0), expected.top_left);
  EXPECT_EQ(dn(0, dn.columns() - 1), expected.top_right);
  EXPECT_EQ(dn(dn.rows() - 1, 0), expected.bottom_left);
  EXPECT_EQ(dn(dn.rows() - 1, dn.columns() - 1), expected.bottom_right);
}

TEST(FrameOracle, SaaoCcdFrame) {
  const Frame frame = scatmap::read_frame(kOracle / "fits/a8280271.fits");
  ASSERT_EQ(frame.dn.rows(), 520);
  ASSERT_EQ(frame.dn.columns(), 536);
  expect_summary(frame, {82501207, 187, 1715, 65732, 187, 215, 212, 216});
  EXPECT_EQ(frame.dn(10, 20), 303);
  EXPECT_EQ(frame.quantum_dn, 1);
  EXPECT_EQ(frame.header.exposure_s, 150.04);
  EXPECT_EQ(frame.header.date, "2013-07-13");
  EXPECT_FALSE(frame.header.gain_e_per_dn.has_value()) << "GAIN must not be taken for EGAIN";
  EXPECT_FALSE(frame.header.saturation_dn.has_value());
  EXPECT_FALSE(frame.header.row_order.has_value());
}

TEST(FrameOracle, MaximDlFrameWithWcs) {
  const Frame frame = scatmap::read_frame(kOracle / "fits/sip-wcs.fit");
  ASSERT_EQ(frame.dn.rows(), 50);
  ASSERT_EQ(frame.dn.columns(), 100);
  expect_summary(frame, {16048727, 3132, 5045, 4841, 3192, 3202, 3201, 3144});
  EXPECT_EQ(frame.dn(10, 20), 3220);
  EXPECT_EQ(frame.header.exposure_s, 120.0);
  EXPECT_EQ(frame.header.date, "2011-09-01T02:09:05");
}

TEST(FrameOracle, MultiExtensionFilesAreRefusedWithTheirCount) {
  for (const char* name : {"flat-mef.fits", "science-mef.fits"}) {
    const std::string said = refusal(kOracle / "fits" / name);
    EXPECT_NE(said.find("holds several images, got 3 (HDU 2, HDU 3, HDU 4)"), std::string::npos) << said;
  }
}

TEST(FrameOracle, HeNeSpot8Bit) {
  const Frame frame = scatmap::read_frame(kOracle / "frames/t-hene.pgm");
  ASSERT_EQ(frame.dn.rows(), 960);
  ASSERT_EQ(frame.dn.columns(), 1280);
  expect_summary(frame, {13135912, 0, 212, 641929, 193, 0, 2, 0});
}

TEST(FrameOracle, Tem00Spot16Bit) {
  const Frame frame = scatmap::read_frame(kOracle / "frames/TEM00_200mm.pgm");
  ASSERT_EQ(frame.dn.rows(), 960);
  ASSERT_EQ(frame.dn.columns(), 1280);
  expect_summary(frame, {3756170384, 1600, 56592, 385282, 17112, 2576, 2048, 2320});
}

}  // namespace
