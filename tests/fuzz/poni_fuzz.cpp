// pyFAI's .poni files; what is read must be written and read again.
#include "calib/export_poni.h"

#include "fuzz/input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_text(data, size, [](const std::string& text) {
    const scatmap::calib::Poni poni = scatmap::calib::parse_poni(text, "a.poni");
    const std::string written = scatmap::calib::to_poni({poni, scatmap::calib::PoniAxes::kYxz}, "");
    if (scatmap::calib::parse_poni(written, "again.poni").distance_m != poni.distance_m) std::abort();
  });
}
