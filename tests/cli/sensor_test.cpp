// The verb sensor on files: the shipped scene of flats gives back the sensor that the simulator drew, within what the
// verb claims, as an instrument file that `brdf` would take. Does not prove the claims' statistics
// (tests/counts/photon_transfer_test.cpp).
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/lab.h"
#include "data-synthetic/scene.h"
#include "scatmap/angles/instrument.h"
#include "scatmap/counts/sensor_model.h"

namespace scatmap::test {
namespace {

const std::string kFlats = std::string(SCATMAP_SOURCE_DIR) + "/data-synthetic/scenes/flats.toml";

class SensorVerb : public testing::Test {
 protected:
  SensorVerb() : lab_(fs::path(testing::TempDir()) / ("scatmap-sensor-" + std::to_string(getpid()))) {
    fs::create_directories(lab_.folder() / "tmp");
  }
  ~SensorVerb() override {
    std::error_code ignored;
    fs::remove_all(lab_.folder(), ignored);
  }
  ToolRun run(const std::vector<std::string>& arguments) const { return run_tool(arguments, lab_.folder()); }

  /// sensor, with all frames of the data set whose names pass.
  std::vector<std::string> command(const std::string& output) const {
    std::vector<std::string> flats, darks;
    for (const auto& entry : fs::directory_iterator(lab_.path("flats/frames"))) {
      const std::string name = entry.path().filename().string();
      (name.find("_dark_") == std::string::npos ? flats : darks).push_back("flats/frames/" + name);
    }
    std::vector<std::string> out{"sensor"};
    out.insert(out.end(), flats.begin(), flats.end());
    out.emplace_back("--darks");
    out.insert(out.end(), darks.begin(), darks.end());
    out.insert(out.end(), {"--instrument", "flats/instrument.toml", "-o", output});
    return out;
  }

  Lab lab_;
};

TEST_F(SensorVerb, FindsTheSensorOfTheShippedScene) {
  ASSERT_EQ(run({"simulate", kFlats, "-o", "flats"}).status, 0);
  const synth::Scene scene = synth::read_scene(kFlats);
  std::vector<std::string> arguments = command("measured.toml");
  arguments.emplace_back("--json");
  const ToolRun done = run(arguments);
  ASSERT_EQ(done.status, 0) << done.err;
  const auto json = nlohmann::json::parse(done.out);
  const auto expect = [&](const char* name, double truth) {
    const double u = json.at(name).at("u");
    EXPECT_GT(u, 0) << name;
    EXPECT_NEAR(json.at(name).at("value").get<double>(), truth, 3 * u) << name;
  };
  expect("gain_dn_per_e", 1 / scene.sensor.gain_e_per_dn);
  expect("dark_noise_e", std::hypot(scene.sensor.read_noise_e, std::sqrt(scene.sensor.dark_e_per_s * 0.01)));
  const double pixels = scene.bench.rows * scene.bench.columns;  // the standard's mean dark signal is over all of them
  expect("dark_current_e_per_s",
         scene.sensor.dark_e_per_s + scene.sensor.hot_pixels * scene.sensor.hot_e_per_s / pixels);
  expect("bias_dn", scene.sensor.bias_dn);
  expect("prnu", scene.flats->prnu_percent / 100);

  // What the file's correction makes of the bent sensor is proportional to the charge.
  const Instrument measured = read_instrument(lab_.path("measured.toml"));
  const double full_dn = scene.sensor.saturation_dn - scene.sensor.bias_dn;
  const Sensor& sensor = measured.sensor;
  const SensorModel model{1, 0, sensor.saturation_dn.value(), sensor.bias_dn, sensor.linearity};
  const auto seen_per_charge = [&](double share) {
    const double charge_dn = share * full_dn;
    const double bent_dn = charge_dn * (1 + scene.sensor.nonlinearity_percent / 100 * share);
    return (model.linearised(scene.sensor.bias_dn + bent_dn) - scene.sensor.bias_dn) / charge_dn;
  };
  EXPECT_EQ(sensor.header_gain_e_per_dn, scene.nominal_sensor.gain_e_per_dn);
  ASSERT_FALSE(sensor.linearity.empty());
  EXPECT_NEAR(seen_per_charge(0.9) / seen_per_charge(0.1), 1, 2 * sensor.nonlinearity_percent / 100);
  EXPECT_LT(sensor.nonlinearity_percent, 0.2);  // five times better than the sensor itself
  EXPECT_NEAR(*sensor.saturation_dn, scene.sensor.saturation_dn, 0.02 * scene.sensor.saturation_dn);
}

TEST_F(SensorVerb, FlatsAmongTheDarksAreRefused) {
  ASSERT_EQ(run({"simulate", kFlats, "-o", "flats"}).status, 0);
  std::vector<std::string> arguments = command("measured.toml");
  fs::copy_file(lab_.path("flats/frames/flat3_001.fits"), lab_.path("mistaken.fits"));
  arguments.insert(std::find(arguments.begin(), arguments.end(), "--instrument"), "mistaken.fits");
  const ToolRun done = run(arguments);
  EXPECT_EQ(done.status, 1);
  EXPECT_NE(done.err.find("mistaken.fits: IMAGETYP"), std::string::npos) << done.err;
  EXPECT_FALSE(fs::exists(lab_.path("measured.toml")));
}

}  // namespace
}  // namespace scatmap::test
