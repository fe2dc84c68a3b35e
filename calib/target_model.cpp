#include "calib/target_model.h"

#include <Eigen/Cholesky>
#include <array>
#include <numeric>

namespace scatmap::calib {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using EncoderJacobian = Eigen::Matrix2d;  // columns: stage, arm

EncoderJacobian encoder_jacobian(const Trace& trace) {
  EncoderJacobian j;
  j << trace.jacobian.col(kStageZeroColumn), trace.jacobian.col(kArmZeroColumn);
  return j;
}

Eigen::Vector2d encoder_variance(const Instrument& array) {
  return {array.stage_encoder_sigma_rad * array.stage_encoder_sigma_rad,
          array.arm_encoder_sigma_rad * array.arm_encoder_sigma_rad};
}

Eigen::MatrixXd inverse_factor(const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  return llt.matrixL().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

Eigen::Matrix2d inverse_factor2(const Eigen::Matrix2d& c) {
  const double a = std::sqrt(c(0, 0)), b = c(1, 0) / a, d = std::sqrt(c(1, 1) - b * b);
  Eigen::Matrix2d inverse;
  inverse << 1 / a, 0, -b / (a * d), 1 / d;
  return inverse;
}

template <class Block>
void whiten(const WhiteningBlock& block, Block rows) {
  if (block.count == 1) {
    const double w00 = block.single(0, 0), w10 = block.single(1, 0), w11 = block.single(1, 1);
    rows.row(1) = w10 * rows.row(0) + w11 * rows.row(1);
    rows.row(0) *= w00;
  } else {
    rows = (block.several * rows).eval();
  }
}

// Where each fitted parameter stands in a target's Jacobian: its key, or none for another mount's.
Eigen::Index key_of(Eigen::Index index, const Target& target) {
  if (index < kBenchParameters) return index;
  const Eigen::Index key = index - 2 * static_cast<Eigen::Index>(target.mount);
  const bool own = target.kind == TargetKind::kSpecular && (key == kTiltColumn || key == kHeightColumn);
  return own ? key : -1;
}

}  // namespace

Used all_targets(const TargetList& list) {
  Used used(list.targets.size());
  std::iota(used.begin(), used.end(), std::size_t{0});
  return used;
}

Shot TargetModel::shot_of(const Eigen::VectorXd& values, const Target& t) const {
  if (t.kind == TargetKind::kDirect) return {t.kind, t.stage_rad, t.arm_rad, 0, 0};
  const double tilt = values[ParameterTable::index_of_key(kTiltColumn, t.mount)];
  return {t.kind, t.stage_rad, t.arm_rad, tilt + t.tilt_rad,
          values[ParameterTable::index_of_key(kHeightColumn, t.mount)]};
}

bool TargetModel::same_setting(const Target& a, const Target& b) const {
  return a.kind == b.kind && a.mount == b.mount && a.stage_rad == b.stage_rad && a.arm_rad == b.arm_rad &&
         a.tilt_rad == b.tilt_rad;
}

std::optional<Trace> TargetModel::trace(const Eigen::VectorXd& values, std::size_t target) const {
  const Tracer tracer(table_.geometry(values), table_.array());
  return tracer.trace(shot_of(values, list_.targets[target]));
}

Eigen::Matrix2d TargetModel::covariance(const Target& target, const Trace& trace) const {
  const EncoderJacobian j = encoder_jacobian(trace);
  Eigen::Matrix2d c = j * encoder_variance(table_.array()).asDiagonal() * j.transpose();
  c.diagonal().array() += target.sigma_px * target.sigma_px;
  return c;
}

std::optional<Whitening> TargetModel::whitening(const Eigen::VectorXd& values, const Used& used) const {
  const Tracer tracer(table_.geometry(values), table_.array());
  const Eigen::Vector2d variance = encoder_variance(table_.array());
  Whitening out;
  std::vector<EncoderJacobian> jacobians;
  for (std::size_t i = 0; i < used.size(); i += out.back().count) {
    const Target& first = list_.targets[used[i]];
    std::size_t count = 1;
    while (i + count < used.size() && same_setting(first, list_.targets[used[i + count]])) ++count;
    const auto trace = tracer.trace(shot_of(values, first));
    if (!trace) return std::nullopt;
    out.emplace_back();
    out.back().first = i;
    out.back().count = count;
    if (count == 1) {
      out.back().single = inverse_factor2(covariance(first, *trace));
      continue;
    }
    // One setting, one place on the detector: all its targets move alike with the encoders.
    const EncoderJacobian j = encoder_jacobian(*trace);
    const Eigen::Matrix2d common = j * variance.asDiagonal() * j.transpose();
    const auto n = static_cast<Eigen::Index>(count);
    Eigen::MatrixXd joint = common.replicate(n, n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const double sigma = list_.targets[used[i + static_cast<std::size_t>(k)]].sigma_px;
      joint.diagonal().segment<2>(2 * k).array() += sigma * sigma;
    }
    out.back().several = inverse_factor(joint);
  }
  return out;
}

bool TargetModel::evaluate(const Eigen::VectorXd& values, const Used& used, const Whitening& whitening,
                           const FitSet& set, double* residuals, double* jacobian) const {
  const Tracer tracer(table_.geometry(values), table_.array());
  const auto rows = static_cast<Eigen::Index>(2 * used.size()), columns = static_cast<Eigen::Index>(set.size());
  Eigen::Map<Eigen::VectorXd> r(residuals, rows);
  for (std::size_t i = 0; i < used.size(); ++i) {
    const Target& target = list_.targets[used[i]];
    const auto trace = tracer.trace(shot_of(values, target));
    if (!trace) return false;
    const auto row = static_cast<Eigen::Index>(2 * i);
    r[row] = trace->pixel[0] - target.column_px;
    r[row + 1] = trace->pixel[1] - target.row_px;
    if (jacobian == nullptr) continue;
    double* const first = jacobian + row * columns;
    for (std::size_t k = 0; k < set.size(); ++k) {
      const Eigen::Index key = key_of(set[k].index, target);
      first[k] = key < 0 ? 0 : trace->jacobian(0, key) * set[k].scale;
      first[k + set.size()] = key < 0 ? 0 : trace->jacobian(1, key) * set[k].scale;
    }
  }
  for (const WhiteningBlock& block : whitening) {
    const auto first = static_cast<Eigen::Index>(2 * block.first), count = static_cast<Eigen::Index>(2 * block.count);
    whiten(block, r.segment(first, count));
    if (jacobian != nullptr) whiten(block, Eigen::Map<RowMajor>(jacobian, rows, columns).middleRows(first, count));
  }
  return true;
}

}  // namespace scatmap::calib
