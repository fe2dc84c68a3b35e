// targets.csv; what is read must be written and read again to the same numbers.
#include "calib/targets.h"

#include "fuzz/input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_text(data, size, [](const std::string& text) {
    const auto list = scatmap::calib::parse_targets(text, "t.csv");
    const auto again = scatmap::calib::parse_targets(scatmap::calib::to_csv(list), "again.csv");
    if (again.targets.size() != list.targets.size()) std::abort();
    for (std::size_t i = 0; i < list.targets.size(); ++i) {
      if (again.targets[i].column_px != list.targets[i].column_px) std::abort();
      if (again.targets[i].stage_rad != list.targets[i].stage_rad) std::abort();
    }
  });
}
