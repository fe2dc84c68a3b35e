// model.toml.
#include "fuzz/input_file.h"
#include "scatmap/model/model_toml.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_text(data, size, [](const std::string& text) { scatmap::parse_model(text, "m.toml"); });
}
