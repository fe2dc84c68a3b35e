// Time of a calibration and of its parts, beside OpenCV's pose refinement and a least-squares fit of the same residuals
// with numerical derivatives.
#include <benchmark/benchmark.h>
#include <ceres/ceres.h>
#include <tbb/global_control.h>

#include <opencv2/calib3d.hpp>
#include <random>

#include "calib/bootstrap.h"
#include "calib/calibrate.h"
#include "calib/linearisation.h"
#include "calib/solve.h"
#include "calib/start.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

const std::vector<const char*> kEleven{"detector.distance_mm",    "detector.offset_mm.0",    "detector.offset_mm.1",
                                       "detector.rotation_deg.0", "detector.rotation_deg.1", "detector.rotation_deg.2",
                                       "stage.zero_deg",          "arm.axis_offset_mm.1",    "arm.axis_tilt_deg.0",
                                       "sample.tilt_deg",         "sample.height_mm"};

Instrument nominal_instrument() {
  Instrument in;
  in.columns = 3296;
  in.rows = 2472;
  in.geometry.distance = 0.325;
  in.geometry.pixel_column = in.geometry.pixel_row = 5.5e-6;
  in.arm_encoder_sigma_rad = in.stage_encoder_sigma_rad = 0.0005 * kRadPerDeg;
  return in;
}

// Spots of a bench that is a little off, with noise. Only their number matters here.
TargetList targets_of(std::size_t count) {
  std::mt19937_64 rng(7);
  std::normal_distribution<double> normal;
  const auto within = [&](double size) { return std::uniform_real_distribution<double>(-size, size)(rng); };
  TargetList list{"targets.csv", {""}, {}};
  for (std::size_t i = 0; i < count; ++i) {
    Target t;
    t.kind = i % 10 == 9 ? TargetKind::kDirect : TargetKind::kSpecular;
    t.stage_rad = (35 + within(25)) * kRadPerDeg;
    t.arm_rad = (t.kind == TargetKind::kDirect ? std::numbers::pi : 2 * t.stage_rad) + within(1) * kRadPerDeg;
    t.tilt_rad = t.kind == TargetKind::kDirect ? 0 : within(0.5) * kRadPerDeg;
    t.sigma_px = 0.05;
    list.targets.push_back(t);
  }
  const ParameterTable table(nominal_instrument(), list, {});
  const TargetModel model(table, list);
  Eigen::VectorXd truth = table.nominal();
  for (const char* const name : kEleven) {
    const Eigen::Index i = table.find(name).value();
    truth[i] += 0.5 * table[i].prior_sigma * normal(rng);
  }
  for (std::size_t i = 0; i < count; ++i) {
    Target& t = list.targets[i];
    const Trace trace = model.trace(truth, i).value();
    const Eigen::Vector2d encoder(normal(rng), normal(rng));
    Eigen::Vector2d spot = trace.pixel + 0.05 * Eigen::Vector2d(normal(rng), normal(rng));
    spot += trace.jacobian.col(kStageZeroColumn) * encoder[0] * nominal_instrument().stage_encoder_sigma_rad;
    spot += trace.jacobian.col(kArmZeroColumn) * encoder[1] * nominal_instrument().arm_encoder_sigma_rad;
    t.column_px = spot[0];
    t.row_px = spot[1];
  }
  return list;
}

FitSet eleven(const ParameterTable& table, const Eigen::VectorXd& start) {
  FitSet set;
  for (const char* const name : kEleven) {
    const Eigen::Index i = table.find(name).value();
    set.push_back({i, start[i], table[i].prior_sigma, {}, 0});
  }
  return set;
}

// Closed-form start, least squares, covariance.
void ColdStart(benchmark::State& state) {
  const TargetList list = targets_of(static_cast<std::size_t>(state.range(0)));
  int iterations = 0;
  for (auto _ : state) {
    const ParameterTable table(nominal_instrument(), list, {});
    const Start start = starts(table, list).front();
    const TargetModel model(start.table, list);
    const FitSet set = eleven(start.table, start.values);
    const Used used = all_targets(list);
    const Solution s = solve(model, used, set, start.values).value();
    iterations = s.iterations;
    benchmark::DoNotOptimize(uncertainty(linearise(model, used, s.whitening, set, s.values)).value());
  }
  state.counters["iterations"] = iterations;
}
BENCHMARK(ColdStart)->Arg(100)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond);

// All that the verb does: start, outliers, selection, observability, leave-one-out.
void Calibrate(benchmark::State& state) {
  const TargetList list = targets_of(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(calibrate(list, nominal_instrument()));
}
BENCHMARK(Calibrate)->Arg(100)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond);

// One trial of a Monte Carlo: new noise, from the solution.
void Resolve(benchmark::State& state) {
  TargetList list = targets_of(static_cast<std::size_t>(state.range(0)));
  const TargetList original = list;
  const ParameterTable table(nominal_instrument(), list, {});
  const TargetModel model(table, list);
  const FitSet set = eleven(table, table.nominal());
  const Used used = all_targets(list);
  const Eigen::VectorXd solution = solve(model, used, set, table.nominal()).value().values;
  std::mt19937_64 rng(8);
  std::normal_distribution<double> normal;
  for (auto _ : state) {
    for (std::size_t i = 0; i < list.targets.size(); ++i) {
      list.targets[i].column_px = original.targets[i].column_px + 0.05 * normal(rng);
      list.targets[i].row_px = original.targets[i].row_px + 0.05 * normal(rng);
    }
    benchmark::DoNotOptimize(solve(model, used, set, solution).value());
  }
}
BENCHMARK(Resolve)->Arg(200)->Unit(benchmark::kMillisecond);

// Trials of the parametric bootstrap on one thread: everything that is not held, priors and targets drawn anew.
void BootstrapTrials(benchmark::State& state) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const TargetList list = targets_of(static_cast<std::size_t>(state.range(0)));
  const CalibrationResult result = calibrate(list, nominal_instrument());
  const int trials = static_cast<int>(state.range(1));
  int failed = 0;
  for (auto _ : state) failed = bootstrap(list, result, {BootstrapKind::kParametric, trials, 3}).failed;
  state.counters["failed"] = failed;
  state.counters["parameters"] = static_cast<double>(result.set.size());
}
BENCHMARK(BootstrapTrials)->Args({200, 10000})->Unit(benchmark::kMillisecond)->Iterations(1);

struct Spot {
  const TargetModel* model;
  const FitSet* set;
  const Eigen::VectorXd* values;
  std::size_t target;

  bool operator()(double const* const* x, double* r) const {
    Eigen::VectorXd v = *values;
    for (std::size_t k = 0; k < set->size(); ++k) v[(*set)[k].index] = (*set)[k].origin + (*set)[k].scale * x[0][k];
    const auto trace = model->trace(v, target);
    if (!trace) return false;
    r[0] = (trace->pixel[0] - model->list().targets[target].column_px) / 0.05;
    r[1] = (trace->pixel[1] - model->list().targets[target].row_px) / 0.05;
    return true;
  }
};

void NumericDerivatives(benchmark::State& state) {
  const TargetList list = targets_of(static_cast<std::size_t>(state.range(0)));
  const ParameterTable table(nominal_instrument(), list, {});
  const TargetModel model(table, list);
  for (auto _ : state) {
    const Start start = starts(table, list).front();
    const FitSet set = eleven(table, start.values);
    std::vector<double> x(set.size(), 0);
    ceres::Problem problem;
    for (std::size_t i = 0; i < list.targets.size(); ++i) {
      auto* cost = new ceres::DynamicNumericDiffCostFunction<Spot>(new Spot{&model, &set, &start.values, i});
      cost->AddParameterBlock(static_cast<int>(set.size()));
      cost->SetNumResiduals(2);
      problem.AddResidualBlock(cost, nullptr, x.data());
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    options.function_tolerance = 1e-11;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    benchmark::DoNotOptimize(x.data());
  }
}
BENCHMARK(NumericDerivatives)->Arg(300)->Unit(benchmark::kMillisecond);

// OpenCV's six-parameter pose of as many points seen through the same focal length; no stage, no covariance.
void OpenCvRefine(benchmark::State& state) {
  std::mt19937_64 rng(9);
  std::normal_distribution<double> normal;
  const auto within = [&](double size) { return std::uniform_real_distribution<double>(-size, size)(rng); };
  const double focal_px = 0.325 / 5.5e-6;
  const cv::Mat camera = (cv::Mat_<double>(3, 3) << focal_px, 0, 1647.5, 0, focal_px, 1235.5, 0, 0, 1);
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (int i = 0; i < state.range(0); ++i) {
    const cv::Point3d p(within(0.02), within(0.02), 1 + within(0.2));
    points.push_back(p);
    pixels.emplace_back(focal_px * p.x / p.z + 1647.5 + 0.05 * normal(rng),
                        focal_px * p.y / p.z + 1235.5 + 0.05 * normal(rng));
  }
  for (auto _ : state) {
    cv::Mat rotation = (cv::Mat_<double>(3, 1) << 0.01, -0.01, 0.02),
            shift = (cv::Mat_<double>(3, 1) << 0.001, 0.001, 0.02);
    cv::solvePnPRefineLM(points, pixels, camera, cv::noArray(), rotation, shift);
    benchmark::DoNotOptimize(rotation.data);
  }
}
BENCHMARK(OpenCvRefine)->Arg(300)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace scatmap::calib

BENCHMARK_MAIN();
