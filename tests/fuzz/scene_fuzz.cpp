// scene.toml.
#include "data-synthetic/scene.h"
#include "fuzz/input_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::run_text(data, size, [](const std::string& text) { scatmap::synth::parse_scene(text, "s.toml"); });
}
