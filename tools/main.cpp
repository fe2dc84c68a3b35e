#include <signal.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>

#include "scatmap/base/error.h"
#include "scatmap/base/provenance.h"
#include "tools/signals.h"
#include "tools/verbs.h"

namespace {

std::string command_line(int argc, char** argv) {
  std::string text = "scatmap";
  for (int i = 1; i < argc; ++i) text += std::string(" ") + argv[i];
  return text;
}

constexpr int kDone = 0, kBadData = 1, kBadUsage = 2;

int run(int argc, char** argv) {
  CLI::App app{"scatmap: BRDF maps from a bare CCD on a scatterometer's detector arm", "scatmap"};
  app.require_subcommand(1);
  app.set_version_flag("--version", "scatmap " + scatmap::version());
  app.failure_message([](const CLI::App*, const CLI::Error& e) {
    return "scatmap: " + std::string(scatmap::Error({{}, e.what(), {}, {}}).what()) + " (see scatmap --help)\n";
  });
  app.footer(
      "Exit status: 0 done, 1 bad data, 2 bad usage. Files: docs/files.md; angles and signs: docs/conventions.md.");
  const scatmap::tools::Invocation invocation{scatmap::utf8_text(command_line(argc, argv))};
  scatmap::tools::setup_simulate(app, invocation);
  scatmap::tools::setup_spots(app, invocation);
  scatmap::tools::setup_calibrate(app, invocation);
  scatmap::tools::setup_angles(app, invocation);
  scatmap::tools::setup_brdf(app, invocation);
  scatmap::tools::setup_model(app, invocation);
  scatmap::tools::setup_compare(app, invocation);
  scatmap::tools::setup_uncertainty(app, invocation);
  scatmap::tools::setup_sensor(app, invocation);
  scatmap::tools::setup_export(app, invocation);
  scatmap::tools::setup_chart(app, invocation);
  const auto verbs = app.get_subcommands([](const CLI::App*) { return true; });
  const auto named = [&](const CLI::App* verb) { return argv[1] == verb->get_name(); };
  if (argc > 1 && argv[1][0] != '-' && std::none_of(verbs.begin(), verbs.end(), named)) {
    std::fprintf(stderr, "scatmap: %s\n", scatmap::Error({argv[1], "is no verb (see scatmap --help)", {}, {}}).what());
    return kBadUsage;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kDone : kBadUsage;
  }
  return kDone;
}

// A result that did not reach its reader (a full disk behind >) is no success.
int flushed(int status) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  std::fprintf(stderr, "scatmap: standard output: cannot be written\n");
  return kBadData;
}

}  // namespace

int main(int argc, char** argv) {
  signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error like a full disk
  try {
    scatmap::tools::clean_up_on_signals();
    return flushed(run(argc, argv));
  } catch (const scatmap::Error& e) {
    std::fprintf(stderr, "scatmap: %s\n", e.what());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "scatmap: not enough memory\n");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "scatmap: %s\n", e.what());
  }
  return kBadData;
}
