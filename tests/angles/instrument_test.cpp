// Instrument files: text keeps doubles bit for bit; what is wrong is refused with file, line and key.
#include "scatmap/angles/instrument.h"

#include <gtest/gtest.h>

#include "scatmap/base/error.h"
#include "tests/support/random_instrument.h"

namespace scatmap {
namespace {

const char* const kMinimal = R"([detector]
columns = 100
rows = 80
pitch_um = [5.5, 5.5]
distance_mm = 325.0
)";

TEST(Instrument, MissingKeysAreZero) {
  const Instrument in = parse_instrument(kMinimal, "bench.toml");
  EXPECT_EQ(in.geometry.distance, 325.0 * 1e-3);
  EXPECT_EQ(in.geometry.beam_elevation, 0);
  EXPECT_FALSE(in.sensor.gain_e_per_dn.has_value());
  EXPECT_FALSE(in.calibration.has_value());
}

TEST(Instrument, TextKeepsEveryBit) {
  std::mt19937_64 rng(12);
  for (int i = 0; i < 200; ++i) {
    // Through text once, so that every number is one that a file can hold.
    Instrument first = parse_instrument(to_toml(test::random_bench(rng, 3).instrument), "first");
    first.sensor = {1.0 / 3, 7.7, 65535.0, 0.3, 300.1, {1e-7, -2.2e-13}, 0.1};
    first.calibration =
        Calibration{{"detector.distance_mm", "arm.zero_deg"}, Eigen::Matrix2d{{1.0 / 7, 1e-9}, {1e-9, 3e-6}}};
    const Instrument second = parse_instrument(to_toml(first), "second");
    for (const GeometryKey& key : geometry_keys())
      EXPECT_EQ(first.geometry.*key.member, second.geometry.*key.member) << key.name;
    EXPECT_EQ(first.flip_columns, second.flip_columns);
    EXPECT_EQ(first.sensor.gain_e_per_dn, second.sensor.gain_e_per_dn);
    EXPECT_EQ(first.sensor.linearity, second.sensor.linearity);
    EXPECT_EQ(second.sensor.header_gain_e_per_dn, 0.1);
    EXPECT_EQ(first.calibration->covariance, second.calibration->covariance);
    EXPECT_EQ(first.calibration->parameters, second.calibration->parameters);
  }
}

struct BadCase {
  const char* text;  // replaces or follows the minimal file
  bool append;
  const char* expected;  // part of the message
};

TEST(Instrument, RefusesWithFileLineAndKey) {
  const BadCase cases[] = {
      {"[detector]\ncolumns = 0\nrows = 80\npitch_um = [5, 5]\ndistance_mm = 300\n", false,
       "bench.toml:2: detector.columns"},
      {"[detector]\ncolumns = 100.5\nrows = 80\npitch_um = [5, 5]\ndistance_mm = 300\n", false, "an integer from 1"},
      {"[detector]\ncolumns = 100\nrows = 80\npitch_um = [5, 5]\ndistance_mm = 0\n", false,
       "bench.toml:5: detector.distance_mm"},
      {"[detector]\ncolumns = 100\nrows = 80\npitch_um = [5, 5]\ndistance_mm = nan\n", false, "out of range"},
      {"[detector]\ncolumns = 100\nrows = 80\npitch_um = [5, -5]\ndistance_mm = 300\n", false, "detector.pitch_um"},
      {"[detector]\ncolumns = 100\nrows = 80\npitch_um = 5\ndistance_mm = 300\n", false, "an array of 2 numbers"},
      {"[detector]\ncolumns = 100\nrows = 80\npitch_um = [5, 5, 5]\ndistance_mm = 300\n", false, "3 elements"},
      {"[detector]\nrows = 80\npitch_um = [5, 5]\ndistance_mm = 300\n", false, "detector.columns: is missing"},
      {"[arm]\nzero_deg = 0\n", false, "detector: is missing"},
      {"[detector\n", false, "bench.toml:1: is not valid TOML"},
      {"rotation_deg = [1, 2]\n", true, "detector.rotation_deg"},
      {"rotation_deg = [1, 2, 400]\n", true, "detector.rotation_deg: is out of range"},
      {"flip_rows = 1\n", true, "true or false"},
      {"distance_m = 3\n", true, "detector.distance_m: is not a known key"},
      {"[ram]\nzero_deg = 0\n", true, "ram: is not a known key"},
      {"[arm]\nzero = 0\n", true, "arm.zero: is not a known key"},
      {"[arm]\nzero_deg = \"1\"\n", true, "has the wrong type, got a string"},
      {"[sample]\ntilt_deg = 90\n", true, "sample.tilt_deg"},
      {"[sensor]\ngain_e_per_dn = 0\n", true, "sensor.gain_e_per_dn"},
      {"[sensor]\nread_noise_e = -1\n", true, "sensor.read_noise_e"},
      {"[calibration]\nparameters = [\"detector.size\"]\ncovariance = [[1]]\n", true, "detector.size"},
      {"[calibration]\nparameters = [\"arm.zero_deg\", \"arm.zero_deg\"]\ncovariance = [[1, 0], [0, 1]]\n", true,
       "twice"},
      {"[calibration]\nparameters = [\"arm.zero_deg\"]\ncovariance = [[1, 0]]\n", true, "2 columns"},
      {"[calibration]\nparameters = [\"arm.zero_deg\"]\ncovariance = []\n", true, "0 rows"},
      {"[calibration]\nparameters = [\"arm.zero_deg\"]\ncovariance = [[-1]]\n", true, "negative variance"},
      {"[calibration]\nparameters = [\"arm.zero_deg\", \"stage.zero_deg\"]\ncovariance = [[1, 0.5], [0.4, 1]]\n", true,
       "not symmetric"},
      {"[calibration]\nparameters = [\"arm.zero_deg\", \"stage.zero_deg\"]\ncovariance = [[1, 2], [2, 1]]\n", true,
       "positive semi-definite"},
  };
  for (const BadCase& c : cases) {
    const std::string text = c.append ? std::string(kMinimal) + c.text : c.text;
    try {
      parse_instrument(text, "bench.toml");
      ADD_FAILURE() << "accepted: " << c.text;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(c.expected), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).rfind("bench.toml", 0), 0u) << e.what();
    }
  }
}

// Texts of a file that is read come back as they were: they were once written without codes for quotes and line breaks.
TEST(Instrument, TextsComeBackWhateverTheyHold) {
  const std::string text =
      "[detector]\ncolumns = 3\nrows = 2\npitch_um = [5, 5]\ndistance_mm = 325\n[calibration]\n"
      "parameters = [\"arm.zero_deg\"]\ncovariance = [[1.0]]\n"
      "[[calibration.left_out]]\nname = \"a\\\"b\"\nreason = \"1\\n[x]\\\\ \\u007f \u00e4\"\n";
  const Instrument once = parse_instrument(text, "a.toml");
  const Instrument again = parse_instrument(to_toml(once), "b.toml");
  ASSERT_EQ(again.calibration.value().left_out.size(), 1u);
  EXPECT_EQ(again.calibration->left_out[0].name, "a\"b");
  EXPECT_EQ(again.calibration->left_out[0].reason, "1\n[x]\\ \x7f \u00e4");
}

}  // namespace
}  // namespace scatmap
