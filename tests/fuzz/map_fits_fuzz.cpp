// Maps and angle files, as `model --like`, `compare` and `uncertainty` read them.
#include "fuzz/fits_mutator.h"
#include "fuzz/input_file.h"
#include "scatmap/report/map_fits.h"

// What is changed no longer fits its sums, and would be refused before it is looked at.
static std::string without_sums(std::string file) {
  for (std::size_t at = 0; at + 80 <= file.size(); at += 80) {
    if (file.compare(at, 9, "CHECKSUM=") == 0 || file.compare(at, 9, "DATASUM =") == 0) file[at] = 'X';
  }
  return file;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string file = without_sums({reinterpret_cast<const char*>(data), size});
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data());
  return fuzz::run_file("map.fits", bytes, size, [](const auto& path) { scatmap::read_map_fits(path); }) +
         fuzz::run_file("like.fits", bytes, size, [](const auto& path) { scatmap::read_map_view(path); });
}
