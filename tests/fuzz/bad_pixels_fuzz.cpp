// Lists of bad pixels, as `brdf` reads them.
#include "fuzz/input_file.h"
#include "scatmap/counts/sensor_model.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_file("bad.csv", data, size, [](const auto& path) { scatmap::read_bad_pixel_list(path, 64, 48); });
}
