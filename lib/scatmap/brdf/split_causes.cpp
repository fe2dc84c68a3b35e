#include "scatmap/brdf/split_causes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "scatmap/base/parallel.h"

namespace scatmap {
namespace {

constexpr double kNegligible = 1e-6;  // relative change of f below which a tied cause is left out

std::string extension_name(const std::string& cause) {
  std::string name = "U_";
  for (const char c : cause)
    name += std::isalnum(static_cast<unsigned char>(c)) ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
                                                        : '_';
  return name;
}

// f × (Σ share · loading_e + loading of the non-linearity · its change), row by row so that it stays in the cache.
StructuredCause structured(std::string name, std::string meaning, const Eigen::VectorXd& loading,
                           double of_nonlinearity, const CauseImages& in) {
  const int rows = in.expected_per_sr.rows(), columns = in.expected_per_sr.columns();
  StructuredCause out{std::move(name), std::move(meaning), Grid<float>(rows, columns)};
  const bool one = in.merged.share.empty();  // one exposure has all of every pixel
  for_each_row(rows, [&](int row) {
    float* u = out.sensitivity_per_sr.row(row).data();
    std::fill(u, u + columns, one ? static_cast<float>(loading[0]) : 0.0f);
    const auto add = [&](const Grid<float>& image, double factor) {
      const float* from = image.row(row).data();
      const auto f = static_cast<float>(factor);
      for (int c = 0; c < columns; ++c) u[c] += f * from[c];
    };
    for (Eigen::Index e = 0; !one && e < loading.size(); ++e) {
      if (loading[e] != 0) add(in.merged.share[static_cast<std::size_t>(e)], loading[e]);
    }
    if (!in.nonlinearity.empty() && of_nonlinearity != 0) add(in.nonlinearity, of_nonlinearity);
    const double* f = in.expected_per_sr.row(row).data();
    for (int c = 0; c < columns; ++c) u[c] *= static_cast<float>(f[c]);
  });
  return out;
}

// Causes that act alike on every exposure, without those that overlaps have tied to others.
void add_common(const ExposureCauses& causes, bool measured, BrdfMap& map) {
  for (std::size_t k = 0; k < causes.causes.size(); ++k) {
    if (!causes.is_common(k) || (measured && causes.is_measurable(k))) continue;
    ScaleCause cause = causes.causes[k];
    cause.sensitivity = causes.sensitivity(0, static_cast<Eigen::Index>(k));
    if (cause.sensitivity == 0) continue;
    map.scale.causes.push_back(std::move(cause));
  }
}

void add_as_stated(const ExposureCauses& causes, const CauseImages& images, BrdfMap& map) {
  for (std::size_t k = 0; k < causes.causes.size(); ++k) {
    if (causes.is_common(k)) continue;
    const ScaleCause& cause = causes.causes[k];
    const Eigen::VectorXd loading = causes.sensitivity.col(static_cast<Eigen::Index>(k)) * cause.standard();
    map.structured.push_back(structured(extension_name(cause.name), cause.name, loading, 0, images));
    map.structured.back().cause = cause;
  }
  if (images.nonlinearity.empty()) return;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(causes.sensitivity.rows());
  map.structured.push_back(structured("U_NONLIN", "pixel non-linearity", none, 1, images));
}

// Covariance of the exposures' ln factors and, last, of the non-linearity; and how the common part depends on them.
struct Tied {
  Eigen::MatrixXd covariance;
  Eigen::VectorXd common;  // weights of the exposures and the non-linearity in the common part
  double common_variance = 0;
};

Tied tie(const Eigen::MatrixXd& sensitivity, const Eigen::MatrixXd& covariance) {
  const Eigen::Index exposures = sensitivity.rows(), causes = sensitivity.cols();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(exposures + 1, causes + 1);
  all.topLeftCorner(exposures, causes) = sensitivity;
  all(exposures, causes) = 1;
  Tied out{all * covariance * all.transpose(), Eigen::VectorXd::Zero(exposures + 1), 0};
  const Eigen::VectorXd with_nonlinearity = out.covariance.col(exposures).head(exposures);
  Eigen::MatrixXd given =
      out.covariance.topLeftCorner(exposures, exposures) - with_nonlinearity * with_nonlinearity.transpose();
  given.diagonal().array() += 1e-16 + 1e-12 * given.trace();  // an exposure without any cause is known exactly
  const Eigen::VectorXd solved = given.ldlt().solve(Eigen::VectorXd::Ones(exposures));
  out.common_variance = 1 / solved.sum();
  out.common.head(exposures) = solved * out.common_variance;
  out.common[exposures] = -with_nonlinearity.dot(out.common.head(exposures));
  return out;
}

void add_tied_scale(const ExposureCauses& causes, const std::vector<Eigen::Index>& tied,
                    const Eigen::VectorXd& sensitivity, const Eigen::MatrixXd& covariance, BrdfMap& map) {
  const auto first = static_cast<Eigen::Index>(map.scale.causes.size());
  const Eigen::VectorXd sd = covariance.diagonal().cwiseSqrt();
  std::vector<Eigen::Index> kept;  // with the non-linearity as the last candidate
  for (std::size_t k = 0; k <= tied.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (!(std::abs(sensitivity[i]) * sd[i] > kNegligible)) continue;
    kept.push_back(i);
    ScaleCause cause{"pixel non-linearity in the overlaps", Distribution::kNormal, sd[i], sensitivity[i], false, 0};
    if (k < tied.size()) {
      const ScaleCause& stated = causes.causes[static_cast<std::size_t>(tied[k])];
      cause.name = stated.name;
      cause.is_filter = stated.is_filter;
    }
    map.scale.causes.push_back(std::move(cause));
  }
  const auto count = static_cast<Eigen::Index>(kept.size());
  const Eigen::VectorXd inverse = sd(kept).cwiseInverse();
  Eigen::MatrixXd correlation = inverse.asDiagonal() * covariance(kept, kept) * inverse.asDiagonal();
  correlation.diagonal().setOnes();
  map.scale.correlation = Eigen::MatrixXd::Identity(first + count, first + count);
  map.scale.correlation.bottomRightCorner(count, count) = correlation;
}

void add_measured(const ExposureCauses& causes, const OverlapSolution& overlap, const CauseImages& images,
                  BrdfMap& map) {
  std::vector<Eigen::Index> tied, with_nonlinearity;
  for (std::size_t k = 0; k < causes.causes.size(); ++k) {
    if (causes.is_measurable(k)) tied.push_back(static_cast<Eigen::Index>(k));
  }
  with_nonlinearity = tied;
  with_nonlinearity.push_back(overlap.covariance.rows() - 1);
  const Eigen::MatrixXd sensitivity = causes.sensitivity(Eigen::all, tied),
                        covariance = overlap.covariance(with_nonlinearity, with_nonlinearity);
  const Tied t = tie(sensitivity, covariance);
  const Eigen::Index exposures = sensitivity.rows();
  Eigen::VectorXd of_causes(covariance.rows());
  of_causes << sensitivity.transpose() * t.common.head(exposures), t.common[exposures];
  add_tied_scale(causes, tied, of_causes, covariance, map);

  Eigen::VectorXd ones = Eigen::VectorXd::Ones(exposures + 1);
  ones[exposures] = 0;
  Eigen::MatrixXd rest = t.covariance - t.common_variance * ones * ones.transpose();
  if (images.nonlinearity.empty()) rest = rest.topLeftCorner(exposures, exposures).eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(rest);
  for (Eigen::Index j = rest.rows() - 1; j >= 0; --j) {
    if (!(solver.eigenvalues()[j] > kNegligible * kNegligible)) continue;
    const Eigen::VectorXd loading = solver.eigenvectors().col(j) * std::sqrt(solver.eigenvalues()[j]);
    const std::string number = std::to_string(rest.rows() - j);
    map.structured.push_back(structured("U_OVERLAP_" + number, "exposures as tied by their overlaps, part " + number,
                                        loading.head(exposures), images.nonlinearity.empty() ? 0 : loading[exposures],
                                        images));
  }
}

}  // namespace

void split_causes(const ExposureCauses& causes, const OverlapSolution* overlap, const CauseImages& images,
                  BrdfMap& map) {
  add_common(causes, overlap != nullptr, map);
  if (overlap == nullptr) {
    add_as_stated(causes, images, map);
  } else {
    add_measured(causes, *overlap, images, map);
  }
}

}  // namespace scatmap
