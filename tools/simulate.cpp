#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "data-synthetic/simulate.h"
#include "tools/output_options.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::string scene;
  OutputOptions output;
};

void run(const Options& o, const Invocation& invocation) {
  const synth::SimulateResult result = synth::simulate(o.scene, o.output.targets.front(), o.output.overwrite(),
                                                       {invocation.command_line, "scatmap " + version(), {}});
  if (!o.output.json) {
    std::printf("%zu files in %s\n", result.files.size(), o.output.targets.front().c_str());
    return;
  }
  nlohmann::json out{{"folder", utf8_text(o.output.targets.front())}, {"files", nlohmann::json::array()}};
  for (const auto& f : result.files) out["files"].push_back(utf8_text(f.string()));
  std::printf("%s\n", out.dump(2).c_str());
}

}  // namespace

void setup_simulate(CLI::App& app, const Invocation& invocation) {
  auto o = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("simulate", "a scene's truth to raw frames, darks, signature, targets and measurement files");
  verb->add_option("scene", o->scene, "SCENE.toml")->required();
  o->output.add_to(*verb, "folder to make", {});
  verb->callback([o, invocation] { run(*o, invocation); });
}

}  // namespace scatmap::tools
