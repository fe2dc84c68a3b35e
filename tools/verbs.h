#pragma once
#include <CLI/CLI.hpp>
#include <string>

/// One function per verb, each in its own file: adds the subcommand and its options; running it is the subcommand's callback.
/// Callbacks throw scatmap::Error; only main catches.
namespace scatmap::tools {

struct Invocation {
  std::string command_line;  ///< as typed, for provenance
};

void setup_simulate(CLI::App& app, const Invocation& invocation);
void setup_angles(CLI::App& app, const Invocation& invocation);
void setup_brdf(CLI::App& app, const Invocation& invocation);
void setup_model(CLI::App& app, const Invocation& invocation);
void setup_compare(CLI::App& app, const Invocation& invocation);
void setup_uncertainty(CLI::App& app, const Invocation& invocation);
void setup_sensor(CLI::App& app, const Invocation& invocation);
void setup_spots(CLI::App& app, const Invocation& invocation);
void setup_calibrate(CLI::App& app, const Invocation& invocation);
void setup_export(CLI::App& app, const Invocation& invocation);
void setup_chart(CLI::App& app, const Invocation& invocation);

}  // namespace scatmap::tools
