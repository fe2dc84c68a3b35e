// instrument.toml; what is read must be written and read again to the same numbers.
#include "fuzz/input_file.h"
#include "scatmap/angles/instrument.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_text(data, size, [](const std::string& text) {
    const scatmap::Instrument in = scatmap::parse_instrument(text, "i.toml");
    const scatmap::Instrument again = [&] {
      try {
        return scatmap::parse_instrument(scatmap::to_toml(in), "again.toml");
      } catch (const scatmap::Error&) {
        std::abort();
      }
    }();
    if (again.geometry.distance != in.geometry.distance) std::abort();
  });
}
