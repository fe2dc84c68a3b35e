// Maps and angle files, as `model --like`, `compare` and `uncertainty` read them.
#include "frame/fits_sums.h"
#include "fuzz/fits_mutator.h"
#include "fuzz/input_file.h"
#include "scatmap/report/map_fits.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // What is changed no longer fits its sums, and would be refused before it is looked at.
  const std::string file = without_fits_sums({reinterpret_cast<const char*>(data), size});
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data());
  return fuzz::run_file("map.fits", bytes, size, [](const auto& path) { scatmap::read_map_fits(path); }) +
         fuzz::run_file("like.fits", bytes, size, [](const auto& path) { scatmap::read_map_view(path); });
}
