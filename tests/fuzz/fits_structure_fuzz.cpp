// The check of a FITS file's layout, which stands before CFITSIO.
#include "scatmap/frame/fits_structure.h"

#include "fuzz/fits_mutator.h"
#include "fuzz/input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_file("a.fits", data, size, [](const auto& path) { scatmap::check_fits_structure(path); });
}
