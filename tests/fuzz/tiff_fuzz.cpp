// Raw frames in TIFF.
#include "fuzz/input_file.h"
#include "scatmap/frame/frame.h"
#include "scatmap/frame/read_tiff.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_file("frame.tiff", data, size, [](const auto& path) { scatmap::read_tiff(path); }) +
         fuzz::run_file("any", data, size, [](const auto& path) { scatmap::read_frame(path); });
}
