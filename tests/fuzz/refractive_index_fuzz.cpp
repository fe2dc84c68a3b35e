// Material files of refractiveindex.info.
#include "scatmap/model/refractive_index.h"

#include "fuzz/input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_text(data, size, [](const std::string& text) {
    for (const double wavelength_m : {0.4e-6, 0.6328e-6}) {
      fuzz::run([&] { scatmap::parse_refractive_index(text, "a.yml", wavelength_m); });
    }
  });
}
