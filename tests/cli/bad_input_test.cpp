// Bad inputs: the tool must end with status 1 (bad data) or 2 (bad usage), say what is wrong in one line of standard
// error that names file and key, print nothing on standard output, and leave every file in its folder as it was.
// Does not prove that every bad input is refused, that a message helps beyond the parts looked for, or that nothing is
// left outside the folder and TMPDIR. Running out of memory, disk or files: tests/faults.
#include "cli/bad_answers.h"
#include "cli/bad_calibrations.h"
#include "cli/bad_frames.h"
#include "cli/bad_instruments.h"
#include "cli/bad_measurements.h"
#include "cli/bad_models.h"
#include "cli/bad_scenes.h"
#include "cli/bad_spots.h"
#include "cli/bad_usage.h"

namespace scatmap::test {
namespace {

/// What the tool gets wrong today: cases of the tables that are printed and not asserted, so that nothing is hidden.
const std::set<std::string> kKnownWrong{};

std::vector<std::vector<BadInput>> all_tables() {
  return {bad_usage(),   bad_outputs(),       bad_scenes(),      bad_instruments(),  bad_measurements(),
          bad_frames(),  bad_models(),        bad_comparisons(), bad_calibrations(), bad_spots(),
          bad_sensors(), bad_uncertainties(), bad_charts()};
}

TEST(BadInput, Usage) { check_table(bad_usage(), kKnownWrong); }
TEST(BadInput, Outputs) { check_table(bad_outputs(), kKnownWrong); }
TEST(BadInput, Scenes) { check_table(bad_scenes(), kKnownWrong); }
TEST(BadInput, Instruments) { check_table(bad_instruments(), kKnownWrong); }
TEST(BadInput, Measurements) { check_table(bad_measurements(), kKnownWrong); }
TEST(BadInput, Frames) { check_table(bad_frames(), kKnownWrong); }
TEST(BadInput, Models) { check_table(bad_models(), kKnownWrong); }
TEST(BadInput, Comparisons) { check_table(bad_comparisons(), kKnownWrong); }

TEST(BadInput, Calibrations) { check_table(bad_calibrations(), kKnownWrong); }
TEST(BadInput, Spots) { check_table(bad_spots(), kKnownWrong); }
TEST(BadInput, Sensors) { check_table(bad_sensors(), kKnownWrong); }
TEST(BadInput, Uncertainties) { check_table(bad_uncertainties(), kKnownWrong); }
TEST(BadInput, Charts) { check_table(bad_charts(), kKnownWrong); }

TEST(BadInput, EveryCaseHasItsOwnNameAndTheKnownWrongOnesAreCases) {
  std::set<std::string> names;
  for (const auto& table : all_tables()) {
    for (const BadInput& bad : table) EXPECT_TRUE(names.insert(bad.name).second) << bad.name;
  }
  for (const std::string& name : kKnownWrong) EXPECT_TRUE(names.contains(name)) << name;
  std::printf("%zu bad inputs, %zu of them known to be answered wrongly\n", names.size(), kKnownWrong.size());
}

// The checks themselves must be able to fail.
TEST(BadInput, ChecksSeeWhatIsWrong) {
  EXPECT_TRUE(is_one_message("scatmap: a.toml:3: m: is missing\n"));
  EXPECT_FALSE(is_one_message("scatmap: a.toml:3: m: is missing"));
  EXPECT_FALSE(is_one_message("scatmap: a.toml\nRun with --help\n"));
  EXPECT_FALSE(is_one_message("a.toml:3: m: is missing\n"));
  EXPECT_FALSE(is_one_message(""));
  const std::vector<std::string> wanted{"changed b", "wrote c", "removed a"};
  EXPECT_EQ(changes({{"a", "1"}, {"b", "2"}}, {{"b", "3"}, {"c", "4"}}), wanted);

  const LabMaker maker;
  const std::vector<std::string> good{"brdf", "measurement.toml", "-o", "out.fits"};
  const BadInput not_bad{"a good input", good, nothing(), 1, {"measurement.toml"}};
  const std::vector<std::string> found = complaints(not_bad, maker);
  const auto says = [&](const char* what) {
    return std::any_of(found.begin(), found.end(), [&](const std::string& f) { return f.starts_with(what); });
  };
  EXPECT_TRUE(says("wrote out.fits"));
  EXPECT_TRUE(says("exit status 0 instead of 1"));
  EXPECT_TRUE(says("no single line"));
  EXPECT_TRUE(says("standard output"));
  EXPECT_TRUE(says("message lacks 'measurement.toml'"));
}

}  // namespace
}  // namespace scatmap::test
