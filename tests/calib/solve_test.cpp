// The solver's own statements: covariance against ceres::Covariance on a well-conditioned problem, encoder errors
// shared by repeated frames, priors as measurements. Does not prove the statistics; monte_carlo_test does.
#include "calib/solve.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "bench.h"
#include "calib/linearisation.h"

namespace scatmap::calib::test {
namespace {

Lab fine_lab() {
  Lab lab{plain_bench(), {{"", 0.1, 0.05}}, full_plan()};
  lab.bench.offset_mm = {0.3, -0.2};
  lab.bench.arm_encoder_sigma_deg = lab.bench.stage_encoder_sigma_deg = 0.0005;
  return lab;
}

FitSet set_of(const ParameterTable& table, const std::vector<const char*>& names) {
  FitSet set;
  for (const char* const name : names) {
    const Parameter& p = table[table.find(name).value()];
    set.push_back({table.find(name).value(), p.nominal, p.prior_sigma, {}, p.nominal});
  }
  return set;
}

// The same residuals once more, one block per target, numerical derivatives, for Ceres to judge.
struct SpotResidual {
  const TargetModel* model;
  const FitSet* set;
  Eigen::VectorXd values;
  std::size_t target;
  Eigen::Matrix2d factor;

  bool operator()(double const* const* x, double* r) const {
    Eigen::VectorXd v = values;
    for (std::size_t k = 0; k < set->size(); ++k) v[(*set)[k].index] = (*set)[k].origin + (*set)[k].scale * x[0][k];
    const auto trace = model->trace(v, target);
    if (!trace) return false;
    const Target& t = model->list().targets[target];
    Eigen::Map<Eigen::Vector2d>(r, 2) = factor * (trace->pixel - Eigen::Vector2d(t.column_px, t.row_px));
    return true;
  }
};

TEST(Solve, SolutionAndCovarianceAgreeWithCeres) {
  std::mt19937_64 rng(331);
  const Lab lab = fine_lab();
  const TargetList list = observe(lab, rng);
  const Instrument nominal = believed(lab.bench);
  const ParameterTable table(nominal, list, {});
  const TargetModel model(table, list);
  const FitSet set =
      set_of(table, {"detector.distance_mm", "detector.offset_mm.0", "detector.offset_mm.1", "detector.rotation_deg.2",
                     "stage.zero_deg", "sample.tilt_deg", "sample.height_mm"});
  const Used used = all_targets(list);
  const auto solution = solve(model, used, set, table.nominal());
  ASSERT_TRUE(solution.has_value());
  const auto own = uncertainty(linearise(model, used, solution->whitening, set, solution->values));
  ASSERT_TRUE(own.has_value());

  std::vector<double> x(set.size(), 0);
  ceres::Problem problem;
  for (std::size_t i = 0; i < list.targets.size(); ++i) {
    const Eigen::Matrix2d c = model.covariance(list.targets[i], *model.trace(solution->values, i));
    const Eigen::Matrix2d factor = Eigen::Matrix2d(c.llt().matrixL()).inverse();
    auto* cost = new ceres::DynamicNumericDiffCostFunction<SpotResidual, ceres::RIDDERS>(
        new SpotResidual{&model, &set, solution->values, i, factor});
    cost->AddParameterBlock(static_cast<int>(set.size()));
    cost->SetNumResiduals(2);
    problem.AddResidualBlock(cost, nullptr, x.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = 1e-15;
  options.parameter_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  ceres::Covariance::Options covariance_options;
  covariance_options.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance covariance(covariance_options);
  const std::vector<std::pair<const double*, const double*>> blocks{{x.data(), x.data()}};
  ASSERT_TRUE(covariance.Compute(blocks, &problem));
  const auto n = static_cast<Eigen::Index>(set.size());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> theirs(n, n);
  ASSERT_TRUE(covariance.GetCovarianceBlock(x.data(), x.data(), theirs.data()));
  for (Eigen::Index a = 0; a < n; ++a) {
    const Fitted& f = set[static_cast<std::size_t>(a)];
    const double sigma = std::sqrt(own->covariance(a, a));
    EXPECT_NEAR((solution->values[f.index] - f.origin) / f.scale, x[static_cast<std::size_t>(a)], 1e-3 * sigma)
        << table[f.index].name;
    for (Eigen::Index b = 0; b < n; ++b) {
      EXPECT_NEAR(own->covariance(a, b), theirs(a, b), 1e-5 * std::sqrt(theirs(a, a) * theirs(b, b)));
    }
  }
}

double sigma_of(const Lab& lab, const char* name, const std::vector<const char*>& names) {
  const TargetList list = observe_exactly(lab);
  const Instrument nominal = believed(lab.bench);
  const ParameterTable table(nominal, list, {});
  const TargetModel model(table, list);
  const FitSet set = set_of(table, names);
  const Used used = all_targets(list);
  Eigen::VectorXd values(table.size());
  const std::vector<double> truth = true_values(lab);
  for (Eigen::Index i = 0; i < table.size(); ++i) values[i] = truth[static_cast<std::size_t>(i)] * table[i].unit;
  const auto u = uncertainty(linearise(model, used, model.whitening(values, used).value(), set, values));
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (std::string(names[k]) == name)
      return std::sqrt(u.value().covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)));
  }
  return std::nan("");
}

// A hundred frames of one setting average the centroids, not the encoder; a hundred settings average both.
TEST(Solve, RepeatedFramesShareOneEncoderError) {
  const std::vector<const char*> names{"stage.zero_deg"};
  const auto lab_of = [](std::vector<Command> commands) {
    Lab lab{plain_bench(), {{"", 0, 0}}, std::move(commands), 0.2};
    lab.bench.arm_encoder_sigma_deg = lab.bench.stage_encoder_sigma_deg = 0.002;
    return lab;
  };
  const Command here = mirror(20), there = mirror(20, 1e-7);
  std::vector<Command> repeated(100, here), settings;
  for (int i = 0; i < 50; ++i) {
    settings.push_back(here);
    settings.push_back(there);
  }
  const double one = sigma_of(lab_of({here}), "stage.zero_deg", names);
  const double hundred_frames = sigma_of(lab_of(repeated), "stage.zero_deg", names);
  const double hundred_settings = sigma_of(lab_of(settings), "stage.zero_deg", names);
  EXPECT_NEAR(hundred_settings / one, 0.1, 1e-3);
  // Column shift 2 per stage degree, 1 per arm degree: sigma of the zero is sqrt(4 + 1)/2 of one encoder's.
  const double encoder_only = std::sqrt(5.0) / 2 * 0.002 / 0.5;  // in the parameter's scale, 0.5 degrees
  EXPECT_NEAR(hundred_frames, encoder_only, 1e-3 * encoder_only);
  EXPECT_GT(hundred_frames, 0.9 * one);
}

// With no targets that see it a prior comes back as it was; with targets the information adds.
TEST(Solve, PriorsAreMeasurements) {
  std::mt19937_64 rng(332);
  const Lab lab = fine_lab();
  const TargetList list = observe(lab, rng);
  const ParameterTable table(believed(lab.bench), list, {});
  const TargetModel model(table, list);
  const Used used = all_targets(list);
  FitSet set = set_of(table, {"detector.distance_mm", "detector.offset_mm.0", "detector.offset_mm.1", "stage.zero_deg",
                              "sample.tilt_deg"});
  const auto free = solve(model, used, set, table.nominal());
  ASSERT_TRUE(free.has_value());
  const double variance = uncertainty(linearise(model, used, free->whitening, set, free->values))->covariance(0, 0);
  const double x_free = (free->values[0] - set[0].origin) / set[0].scale;
  const double prior = std::sqrt(variance) * set[0].scale;
  set[0].prior_sigma = prior;
  set[0].prior_centre = free->values[0] + 4 * prior;
  const auto held = solve(model, used, set, table.nominal());
  ASSERT_TRUE(held.has_value());
  const Linearisation at = linearise(model, used, held->whitening, set, held->values);
  EXPECT_NEAR(uncertainty(at)->covariance(0, 0), variance / 2, 1e-3 * variance);
  EXPECT_NEAR((held->values[0] - set[0].origin) / set[0].scale - x_free, 2 * std::sqrt(variance),
              1e-2 * std::sqrt(variance));
}

TEST(Solve, SingularSetsGiveNoNumber) {
  const Lab lab = fine_lab();
  const TargetList list = observe_exactly(lab);
  const ParameterTable table(believed(lab.bench), list, {});
  const TargetModel model(table, list);
  const Used used = all_targets(list);
  const FitSet set = set_of(table, {"detector.distance_mm", "detector.offset_mm.0", "detector.rotation_deg.0",
                                    "detector.rotation_deg.1", "detector.rotation_deg.2", "arm.zero_deg"});
  const Linearisation at = linearise(model, used, model.whitening(table.nominal(), used).value(), set, table.nominal());
  EXPECT_FALSE(uncertainty(at).has_value());
  const std::string names = singular_names(at, table);
  EXPECT_NE(names.find("arm.zero_deg"), std::string::npos) << names;
  EXPECT_NE(names.find("detector.rotation_deg.1"), std::string::npos) << names;
}

}  // namespace
}  // namespace scatmap::calib::test
