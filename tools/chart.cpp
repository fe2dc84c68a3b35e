#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "scatmap/base/error.h"
#include "scatmap/base/output_folder.h"
#include "scatmap/base/provenance.h"
#include "scatmap/report/gnuplot.h"
#include "tools/chart/bounds.h"
#include "tools/chart/chart_output.h"
#include "tools/chart/jobs.h"
#include "tools/chart/scene.h"
#include "tools/chart/stability.h"
#include "tools/output_options.h"
#include "tools/verbs.h"

namespace scatmap::tools {
namespace {

struct Options {
  std::vector<std::string> jobs;
  std::string scene;
  std::string model;
  double seconds = 0.5;
  OutputOptions output;
};

std::vector<std::string> job_names() {
  std::vector<std::string> names{"all"};
  for (const ChartJob& job : chart_jobs()) names.emplace_back(job.name);
  names.emplace_back("stability");
  names.emplace_back("bounds");
  return names;
}

bool asked_for(const std::vector<std::string>& jobs, std::string_view name) {
  return std::any_of(jobs.begin(), jobs.end(), [&](const std::string& j) { return j == "all" || j == name; });
}

nlohmann::json to_json(const Chart& chart) {
  nlohmann::json rows = nlohmann::json::array();
  for (const ChartRow& r : chart.rows) {
    rows.push_back(
        {{"method", r.method},
         {"rival", r.rival},
         {"size", r.size},
         {"threads", r.threads},
         {"ns_min", r.time.minimum_ns},
         {"ns_spread", r.time.spread_ns},
         {"ns_first", r.time.first_ns},
         {"largest_error", r.largest_error},
         {"p99_error", r.p99_error},
         {"largest_error_rad", r.largest_error_rad ? nlohmann::json(*r.largest_error_rad) : nlohmann::json()},
         {"bound", r.bound ? nlohmann::json(*r.bound) : nlohmann::json()},
         {"pareto", on_pareto_front(chart, r)}});
  }
  return {{"job", chart.job}, {"error_unit", chart.error_unit}, {"per", chart.item}, {"rows", rows}};
}

nlohmann::json to_json(const StabilityCell& c) {
  return {{"job", c.job},
          {"regime", c.regime},
          {"method", c.method},
          {"worst_error", c.worst_error},
          {"bound", c.bound},
          {"unit", c.unit},
          {"amplification_ulp", c.amplification_ulp},
          {"amplification_sigma", c.amplification_sigma},
          {"verdict", to_string(c.verdict)},
          {"reason", utf8_text(c.reason)}};
}

// What `chart` found, and where it goes.
struct Findings {
  std::string csv = chart_csv({});  // its header line
  nlohmann::json charts = nlohmann::json::array();
  nlohmann::json stability = nlohmann::json::array();
  std::vector<StabilityCell> cells;
};

void write_both(const Plot& plot, const std::filesystem::path& folder, const std::string& name) {
  for (const char* const extension : {".svg", ".png"}) write_picture(plot, folder / (name + extension));
}

void announce(std::string_view job) {
  std::fflush(stdout);  // or the line lands inside a table
  std::fprintf(stderr, "measuring %s\n", std::string(job).c_str());
}

void measure(const ChartJob& job, const ChartSettings& settings, const Options& o, const OutputFolder& folder,
             Findings& out) {
  announce(job.name);
  for (const Chart& chart : job.measure(settings)) {
    if (!o.output.json) std::printf("%s\n", chart_text(chart).c_str());
    out.charts.push_back(to_json(chart));
    const std::string rows = chart_csv(chart);
    out.csv += rows.substr(rows.find('\n') + 1);
    write_both(chart_plot(chart), folder.temporary(), chart.job);
  }
}

void measure_stability(const Options& o, const OutputFolder& folder, Findings& out) {
  announce("stability");
  const std::vector<StabilityCell>& cells = out.cells = stability_matrix();
  if (!o.output.json) std::printf("%s\n", stability_text(cells).c_str());
  std::vector<std::string> jobs;
  for (const StabilityCell& c : cells) {
    out.stability.push_back(to_json(c));
    if (jobs.empty() || jobs.back() != c.job) jobs.push_back(c.job);
  }
  write_text_file(folder.temporary() / "stability.csv", stability_csv(cells), Overwrite::kKeep);
  for (const std::string& job : jobs) write_both(stability_plot(cells, job), folder.temporary(), "stability-" + job);
}

// Stability and bounds have their own scenes.
void check_scene_is_used(const Options& o) {
  if (o.scene.empty() && o.model.empty()) return;
  const char* const option = o.scene.empty() ? "--model" : "--scene";
  const bool used = std::any_of(chart_jobs().begin(), chart_jobs().end(),
                                [&](const ChartJob& job) { return asked_for(o.jobs, job.name); });
  if (!used) throw CLI::ValidationError(option, "is not used: stability and bounds have scenes of their own");
  if (asked_for(o.jobs, "stability"))
    std::fprintf(stderr, "note: %s is not used for stability, which has scenes of its own\n", option);
}

void run(const Options& o) {
  check_scene_is_used(o);
  OutputFolder folder(o.output.targets.front(), "charts.csv", o.output.overwrite());
  const auto given = [](const std::string& text) {
    return text.empty() ? std::nullopt : std::optional<std::string>(text);
  };
  ChartSettings settings = chart_settings(given(o.scene), given(o.model));
  settings.seconds_per_method = o.seconds;
  Findings out;
  for (const ChartJob& job : chart_jobs()) {
    if (asked_for(o.jobs, job.name)) measure(job, settings, o, folder, out);
  }
  if (asked_for(o.jobs, "stability")) measure_stability(o, folder, out);
  if (asked_for(o.jobs, "bounds") && !o.output.json) std::printf("%s\n", bounds_table().c_str());
  write_text_file(folder.temporary() / "bounds.md", bounds_table(), Overwrite::kKeep);
  write_text_file(folder.temporary() / "charts.csv", out.csv, Overwrite::kKeep);
  folder.commit();
  if (o.output.json) {
    const nlohmann::json all{
        {"machine", machine_text()}, {"charts", out.charts}, {"stability", out.stability}, {"bounds", bounds_json()}};
    std::printf("%s\n", all.dump(2).c_str());
  }
  std::fflush(stdout);
  require_no_failure(out.cells);
}

}  // namespace

void setup_chart(CLI::App& app, const Invocation&) {
  auto o = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("chart", "speed against accuracy of every method of a job, on this machine");
  verb->add_option("job", o->jobs, "job or jobs, or all")->required()->check(CLI::IsMember(job_names()));
  verb->add_option("--scene", o->scene, "measurement.toml whose instrument and pose to chart on; default the paper's");
  verb->add_option("--model", o->model, "model.toml to chart on; default the paper's");
  verb->add_option("--seconds", o->seconds, "how long each method is timed")
      ->check(CLI::Range(0.01, 60.0) & finite_number())
      ->capture_default_str();
  o->output.add_to(*verb, "folder to make: one picture in SVG and PNG per chart, charts.csv, bounds.md", {});
  verb->callback([o] { run(*o); });
}

}  // namespace scatmap::tools
