// mrcal's .cameramodel files, as detector.lens_cameramodel names them: our check, then mrcal's own reader.
#include "fuzz/input_file.h"
#include "scatmap/angles/lens.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_file("a.cameramodel", data, size, [](const auto& path) { scatmap::load_lens_rays(path, 6, 4); });
}
