// measurement.toml, beside an instrument.toml that is right.
#include "scatmap/brdf/measurement.h"

#include "fuzz/input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile kFile("measurement.toml");
  static const bool kReady = [] {
    kFile.beside("instrument.toml",
                 "[detector]\ncolumns = 8\nrows = 6\npitch_um = [5.5, 5.5]\ndistance_mm = 325\n"
                 "[sensor]\ngain_e_per_dn = 1.5\nread_noise_e = 8\nsaturation_dn = 65535\n");
    return true;
  }();
  if (kReady) kFile.fill(data, size);
  return fuzz::run([] {
    const scatmap::Measurement m = scatmap::read_measurement(kFile.path());
    for (const scatmap::Exposure& e : m.exposures) scatmap::exposure_scale(m, e, {0.01, {}});
  });
}
