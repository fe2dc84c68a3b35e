#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "scatmap/base/error.h"
#include "scatmap/base/output_folder.h"
#include "scatmap/report/gnuplot.h"
#include "tools/chart/chart_output.h"
#include "tools/chart/jobs.h"
#include "tools/chart/scene.h"
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
  return names;
}

bool asked_for(const std::vector<std::string>& jobs, std::string_view name) {
  return std::any_of(jobs.begin(), jobs.end(), [&](const std::string& j) { return j == "all" || j == name; });
}

nlohmann::json to_json(const Chart& chart) {
  nlohmann::json rows = nlohmann::json::array();
  for (const ChartRow& r : chart.rows) {
    rows.push_back({{"method", r.method},
                    {"rival", r.rival},
                    {"size", r.size},
                    {"threads", r.threads},
                    {"ns_min", r.time.minimum_ns},
                    {"ns_spread", r.time.spread_ns},
                    {"largest_error", r.largest_error},
                    {"p99_error", r.p99_error},
                    {"bound", r.bound ? nlohmann::json(*r.bound) : nlohmann::json()},
                    {"pareto", on_pareto_front(chart, r)}});
  }
  return {{"job", chart.job}, {"error_unit", chart.error_unit}, {"per", chart.item}, {"rows", rows}};
}

void run(const Options& o) {
  OutputFolder folder(o.output.targets.front(), "charts.csv", o.output.overwrite());
  const auto given = [](const std::string& text) {
    return text.empty() ? std::nullopt : std::optional<std::string>(text);
  };
  ChartSettings settings = chart_settings(given(o.scene), given(o.model));
  settings.seconds_per_method = o.seconds;
  std::string csv;
  nlohmann::json json = nlohmann::json::array();
  for (const ChartJob& job : chart_jobs()) {
    if (!asked_for(o.jobs, job.name)) continue;
    std::fprintf(stderr, "measuring %s\n", std::string(job.name).c_str());
    for (const Chart& chart : job.measure(settings)) {
      if (!o.output.json) std::printf("%s\n", chart_text(chart).c_str());
      json.push_back(to_json(chart));
      const std::string rows = chart_csv(chart);
      csv += csv.empty() ? rows : rows.substr(rows.find('\n') + 1);
      for (const char* const extension : {".svg", ".png"})
        write_picture(chart_plot(chart), folder.temporary() / (chart.job + extension));
    }
  }
  write_text_file(folder.temporary() / "charts.csv", csv, Overwrite::kKeep);
  folder.commit();
  if (o.output.json) std::printf("%s\n", json.dump(2).c_str());
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
  o->output.add_to(*verb, "folder to make: one picture in SVG and PNG per chart, charts.csv", {});
  verb->callback([o] { run(*o); });
}

}  // namespace scatmap::tools
