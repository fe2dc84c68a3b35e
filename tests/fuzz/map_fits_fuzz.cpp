// Maps and angle files, as `model --like`, `compare` and `uncertainty` read them.
#include "fuzz/fits_mutator.h"
#include "fuzz/input_file.h"
#include "scatmap/report/map_fits.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_file("map.fits", data, size, [](const auto& path) { scatmap::read_map_fits(path); }) +
         fuzz::run_file("like.fits", data, size, [](const auto& path) { scatmap::read_map_view(path); });
}
