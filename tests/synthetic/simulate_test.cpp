// A whole scene: which files appear, that they appear whole or not at all, that their numbers obey the measurement
// equation, and that the seed fixes every pixel. Does not prove that the library reads them (the flow tests do).
#include "data-synthetic/simulate.h"

#include <fitsio.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "data-synthetic/scene.h"
#include "scatmap/base/error.h"
#include "scatmap/base/toml_file.h"

namespace scatmap::synth {
namespace {
namespace fs = std::filesystem;

const std::string kScene = R"(kind = "brdf"
seed = 5
wavelength_nm = 632.8
stage_deg = 20.0
arm_deg = 40.0
[detector]
columns = 120
rows = 100
pitch_um = [100.0, 100.0]
distance_mm = 325.0
[beam]
signature_diameter_mm = 1.5
[sensor]
gain_e_per_dn = 1.5
read_noise_e = 8.0
bias_dn = 300.0
saturation_dn = 65535.0
[nominal.detector]
distance_mm = 326.0
[laser]
electrons_per_s = 1e12
drift_percent = 10.0
drift_tolerance_percent = 0.5
[filters.nd40]
od = 4.0
true_od = 4.1
tolerance_percent = 5.0
[signature]
exposure_s = 0.1
frames = 2
darks = 3
filters = ["nd40"]
[[exposure]]
exposure_s = 0.5
frames = 2
darks = 2
filters = []
[[term]]
kind = "lambertian"
rho = 0.9
)";

class Simulate : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("simulate_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directory(folder_);
    write("scene.toml", kScene);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  SimulateResult run(const std::string& out, Overwrite overwrite = Overwrite::kKeep,
                     const std::string& scene = "scene.toml") {
    Provenance provenance;
    provenance.command_line = "scatmap simulate";
    return simulate(folder_ / scene, folder_ / out, overwrite, provenance);
  }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  std::string text_of(const std::string& name) const {
    std::ostringstream out;
    out << std::ifstream(folder_ / name, std::ios::binary).rdbuf();
    return out.str();
  }

  fs::path folder_;
};

std::vector<double> image(const fs::path& path, const std::string& hdu) {
  int status = 0;
  fitsfile* file = nullptr;
  fits_open_diskfile(&file, path.c_str(), READONLY, &status);
  std::string name = hdu;
  if (!hdu.empty()) fits_movnam_hdu(file, IMAGE_HDU, name.data(), 0, &status);
  std::array<long, 2> size{};
  fits_get_img_size(file, 2, size.data(), &status);
  std::vector<double> out(static_cast<std::size_t>(size[0] * size[1]));
  fits_read_img(file, TDOUBLE, 1, static_cast<LONGLONG>(out.size()), nullptr, out.data(), nullptr, &status);
  fits_close_file(file, &status);
  EXPECT_EQ(status, 0) << path << " " << hdu;
  return out;
}

double sum_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum;
}

TEST_F(Simulate, WritesWhatALabHas) {
  const auto result = run("out");
  for (const char* name :
       {"instrument.toml", "measurement.toml", "model.toml", "frames/signature_001.fits",
        "frames/signature_dark_003.fits", "frames/exposure1_002.fits", "frames/exposure1_dark_002.fits",
        "truth/brdf.fits", "truth/instrument.toml", "truth/pose.toml", "truth/scene.toml"}) {
    EXPECT_TRUE(fs::is_regular_file(folder_ / "out" / name)) << name;
  }
  EXPECT_EQ(result.files.size(), 9U + 7U);
  for (const auto& file : result.files) EXPECT_TRUE(fs::is_regular_file(file)) << file;
  EXPECT_EQ(text_of("out/truth/scene.toml"), kScene);
  EXPECT_EQ(TomlTable::read(folder_ / "out/instrument.toml").table("detector").number("distance_mm"), 326);
  EXPECT_EQ(TomlTable::read(folder_ / "out/truth/instrument.toml").table("detector").number("distance_mm"), 325);
  const auto measurement = TomlTable::read(folder_ / "out/measurement.toml");
  EXPECT_EQ(measurement.table("filters").table("nd40").number("od"), 4);
  EXPECT_FALSE(measurement.table("filters").table("nd40").has("true_od"));
  EXPECT_EQ(measurement.table("laser").number("drift_percent"), 0.5);
}

TEST_F(Simulate, SignatureHoldsTheBeamsElectrons) {
  run("out");
  const double light = sum_of(image(folder_ / "out/frames/signature_001.fits", ""));
  const double dark = sum_of(image(folder_ / "out/frames/signature_dark_001.fits", ""));
  const double expected_e = 1e12 * 0.1 * std::pow(10, -4.1);
  // Shot noise and two frames' read noise and quantisation.
  const double sigma_e = std::sqrt(expected_e + 12000 * 2 * (64 + 2.25 / 12));
  EXPECT_NEAR((light - dark) * 1.5, expected_e, 4.5 * sigma_e);
}

TEST_F(Simulate, ExpectedElectronsInvertTheMeasurementEquation) {
  run("out");
  const fs::path truth = folder_ / "out/truth/brdf.fits";
  const auto f = image(truth, "TRUTH_BRDF"), theta = image(truth, "THETA_S_DEG"),
             omega = image(truth, "SOLID_ANGLE_SR");
  const auto electrons = image(truth, "EXPECTED_E_1"), phi = image(truth, "PHI_S_DEG");
  const double pi = std::acos(-1.0);
  const double beam_e = 1e12 * 1.1 * 0.5;
  for (std::size_t i = 0; i < f.size(); ++i) {
    ASSERT_NEAR(f[i], 0.9 / pi, 1e-15);
    ASSERT_NEAR(electrons[i] / (f[i] * omega[i] * std::cos(theta[i] * pi / 180) * beam_e), 1, 1e-13);
    ASSERT_NEAR(phi[i], 180, 4.5);
  }
  const auto light = image(folder_ / "out/frames/exposure1_001.fits", "");
  double sum_e = 0, expected_e = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    sum_e += (light[i] - 300) * 1.5;
    expected_e += electrons[i];
  }
  EXPECT_NEAR(sum_e, expected_e, 4.5 * std::sqrt(expected_e + 12000 * 64.2));
}

TEST_F(Simulate, SameSeedSameBitsOtherSeedOtherBits) {
  run("a");
  run("b");
  std::string other = kScene;
  other.replace(other.find("seed = 5"), 8, "seed = 6");
  write("other.toml", other);
  run("c", Overwrite::kKeep, "other.toml");
  EXPECT_EQ(text_of("a/frames/exposure1_001.fits"), text_of("b/frames/exposure1_001.fits"));
  EXPECT_NE(image(folder_ / "a/frames/exposure1_001.fits", ""), image(folder_ / "c/frames/exposure1_001.fits", ""));
  EXPECT_NE(image(folder_ / "a/frames/exposure1_001.fits", ""), image(folder_ / "a/frames/exposure1_002.fits", ""));
}

TEST_F(Simulate, KeepsWhatIsThere) {
  run("out");
  EXPECT_THROW(run("out"), Error);
  run("out", Overwrite::kForce);
  write("out/note.txt", "mine");
  EXPECT_THROW(run("out", Overwrite::kForce), Error);
  EXPECT_EQ(text_of("out/note.txt"), "mine");
  fs::create_directory(folder_ / "empty");
  EXPECT_NO_THROW(run("empty/"));
  fs::create_directory(folder_ / "home");
  write("home/letter.txt", "dear");
  EXPECT_THROW(run("home", Overwrite::kForce), Error);
  EXPECT_EQ(text_of("home/letter.txt"), "dear");
  write("file", "x");
  EXPECT_THROW(run("file", Overwrite::kForce), Error);
  EXPECT_EQ(entries(), 5U);  // scene, out, empty, home, file: no temporary is left
}

TEST_F(Simulate, LeavesNothingWhenItFails) {
  std::string missed = kScene;
  missed.replace(missed.find("exposure_s = 0.1"), 16, "exposure_s = 0.1\narm_deg = 170.0");
  write("scene.toml", missed);
  EXPECT_THROW(run("out"), Error);
  EXPECT_EQ(entries(), 1U);
  EXPECT_THROW(run("no/such/folder/out"), Error);
}

TEST_F(Simulate, RefusesWhatItDoesNotKnow) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = kScene;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  for (const auto& text : {with("rho = 0.9", "rho = 0.9\nm = 1.0"), with("od = 4.0", "od = 4.0\ncolour = 1"),
                           with("filters = [\"nd40\"]", "filters = [\"nd50\"]"), with("tolerance_percent = 5.0", ""),
                           with("kind = \"brdf\"", "kind = \"lens\""), with("distance_mm = 325.0", "distance_mm = -1"),
                           with("columns = 120", ""), with("kind = \"lambertian\"", "kind = \"magic\""),
                           with("distance_mm = 326.0", "distance = 326.0")}) {
    EXPECT_THROW(parse_scene(text, "scene.toml"), Error) << text;
  }
  EXPECT_NO_THROW(parse_scene(kScene, "scene.toml"));
}

TEST_F(Simulate, ShippedScenesAreValid) {
  int scenes = 0;
  for (const auto& entry : fs::directory_iterator(std::string(SCATMAP_SOURCE_DIR) + "/data-synthetic/scenes")) {
    EXPECT_NO_THROW(read_scene(entry.path())) << entry.path();
    ++scenes;
  }
  EXPECT_GE(scenes, 15);
}

TEST_F(Simulate, MirrorTargetsScatterAboutTheTruth) {
  write("mirror.toml", R"(kind = "mirror"
seed = 8
wavelength_nm = 632.8
[detector]
columns = 2000
rows = 2000
pitch_um = [10.0, 10.0]
distance_mm = 325.0
[stage]
encoder_sigma_deg = 0.01
[arm]
encoder_sigma_deg = 0.02
[sensor]
gain_e_per_dn = 1.5
read_noise_e = 8.0
bias_dn = 300.0
saturation_dn = 65535.0
[targets]
sigma_px = 0.2
direct_arm_deg = [179.5, 180.0, 180.5]
[[targets.grid]]
stage_deg = [10, 12, 14, 16, 18, 20, 22, 24, 26, 28]
arm_offset_deg = [-1, -0.5, 0, 0.5, 1]
tilt_deg = [-0.4, 0, 0.4]
)");
  run("out", Overwrite::kKeep, "mirror.toml");
  std::istringstream seen(text_of("out/targets.csv")), truth(text_of("out/truth/targets.csv"));
  std::string a, b;
  std::getline(seen, a);
  std::getline(truth, b);
  EXPECT_EQ(a, "kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px,mount");
  double squares = 0, stage_squares = 0, arm_squares = 0;
  int count = 0;
  const auto fields = [](const std::string& text) {
    std::vector<std::string> out;
    std::istringstream in(text);
    for (std::string field; std::getline(in, field, ',');) out.push_back(field);
    return out;
  };
  while (std::getline(seen, a) && std::getline(truth, b)) {
    const auto x = fields(a), y = fields(b);
    for (const std::size_t i : {4U, 5U}) squares += std::pow((std::stod(x[i]) - std::stod(y[i])) / 0.2, 2);
    stage_squares += std::pow((std::stod(y[1]) - std::stod(x[1])) / 0.01, 2);
    arm_squares += std::pow((std::stod(y[2]) - std::stod(x[2])) / 0.02, 2);
    ++count;
  }
  EXPECT_EQ(count, 153);
  EXPECT_NEAR(stage_squares / count, 1, 4.5 * std::sqrt(2.0 / count));
  EXPECT_NEAR(arm_squares / count, 1, 4.5 * std::sqrt(2.0 / count));
  EXPECT_NEAR(squares / (2 * count), 1, 4.5 * std::sqrt(2.0 / (2 * count)));
}

}  // namespace
}  // namespace scatmap::synth
