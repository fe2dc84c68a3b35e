// A real camera's frame as a user's own would go through: 16-bit PGM of a TEM00 spot with a black level near 1600, as
// sample frame and as signature. Laser spots on a camera are no BRDF; what is checked is that the chain's own number is
// the one that follows from the pixels: both frames are equal, so Σ f Ω cosθ over the spot is the ratio of
// transmittances.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "scatmap/base/error.h"
#include "scatmap/base/output_file.h"
#include "scatmap/brdf/from_frames.h"

namespace scatmap {
namespace {
namespace fs = std::filesystem;

constexpr const char* kInstrument = R"([detector]
columns = 1280
rows = 960
pitch_um = [3.75, 3.75]
distance_mm = 200
[sensor]
gain_e_per_dn = 0.2
read_noise_e = 4
saturation_dn = 65520
)";

class RealFrames : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("scatmap-real-" + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write_text_file(folder_ / "instrument.toml", kInstrument, Overwrite::kForce);
  }
  void TearDown() override { fs::remove_all(folder_); }

  BrdfResult reduce(const std::string& frame, const std::string& dark, const std::string& sample_filters) const {
    const std::string sample_dark = dark.substr(0, dark.find("aperture"));
    const std::string file = std::string("\"") + SCATMAP_TEST_DATA + "/frames/" + frame + "\"";
    const std::string text =
        "instrument = \"instrument.toml\"\nwavelength_nm = 632.8\nstage_deg = 20\narm_deg = 40\n"
        "[filters.nd20]\nod = 2.0\ntolerance_od = 0.02\n"
        "[signature]\nframes = [" +
        file + "]\n" + dark +
        "exposure_s = 0.01\nfilters = [\"nd20\"]\n"
        "[[exposure]]\nframes = [" +
        file + "]\n" + sample_dark + "exposure_s = 0.01\nfilters = [" + sample_filters + "]\n";
    write_text_file(folder_ / "measurement.toml", text, Overwrite::kForce);
    return brdf_from_frames(read_measurement(folder_ / "measurement.toml"));
  }
  fs::path folder_;
};

double reflected(const BrdfResult& r) {
  double sum = 0;
  for (std::size_t i = 0; i < r.map.mask.size(); ++i) {
    const int row = static_cast<int>(i) / r.map.mask.columns(), column = static_cast<int>(i) % r.map.mask.columns();
    if (r.map.mask[i] != 0 || std::hypot(row - r.signature.row, column - r.signature.column) > r.signature.radius_px)
      continue;
    sum += (r.map.brdf_per_sr[i]) * r.map.angles.solid_angle_sr[i] * std::cos(r.map.angles.theta_s_rad[i]);
  }
  return sum;
}

TEST_F(RealFrames, SixteenBitSpotWithABlackLevel) {
  const std::string dark = "dark_level_dn = 1600\nu_dark_level_dn = 5\n";
  const BrdfResult same = reduce("TEM00_200mm.pgm", dark, "\"nd20\"");
  EXPECT_EQ(same.map.scale.filters_worst_case(), 0);  // the same filter in both
  EXPECT_GT(same.signature.radius_px, 10);
  // The signature subtracts the ring's residual background, the map does not: they part by background × pixels.
  const double background =
      same.signature.background_dn_per_s * 3.14159265 * same.signature.radius_px * same.signature.radius_px;
  EXPECT_NEAR(reflected(same) - background / same.signature.rate_dn_per_s, 1, 2e-3);
  const BrdfResult without = reduce("TEM00_200mm.pgm", dark, "");
  EXPECT_NEAR(reflected(without) / reflected(same), 0.01, 1e-8);
}

// The 8-bit beam is 300 px wide in a frame of 960 rows: six beam radii do not fit, and that is what the user is told.
TEST_F(RealFrames, BeamTooWideForTheFrameIsRefusedUnlessTheUserChoosesTheAperture) {
  const std::string dark = "dark_level_dn = 0\nu_dark_level_dn = 1\n";
  try {
    reduce("t-hene.pgm", dark, "\"nd20\"");
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("cut off by the frame's edge"), std::string::npos) << e.what();
  }
  const BrdfResult r = reduce("t-hene.pgm", dark + "aperture_radius_px = 300\n", "\"nd20\"");
  EXPECT_EQ(r.signature.radius_px, 300);
  EXPECT_NEAR(reflected(r), 1, 0.02);  // less the ring's share of the beam's own wings
}

}  // namespace
}  // namespace scatmap
