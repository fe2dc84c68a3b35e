// Raw frames in FITS, as `brdf`, `spots` and `sensor` read them.
#include "fuzz/fits_mutator.h"
#include "fuzz/input_file.h"
#include "scatmap/frame/frame.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_file("frame.fits", data, size, [](const auto& path) { scatmap::read_frame(path); });
}
