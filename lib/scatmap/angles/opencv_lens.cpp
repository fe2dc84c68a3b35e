#include "scatmap/angles/opencv_lens.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scatmap/angles/lens_kernel.h"

namespace scatmap {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kPart = 96;  // of a row, on the stack

struct Part {
  std::array<double, kPart> x, y, determinant, residual_px;
};

// Less than the bound: the residual itself is rounded.
constexpr double kAccepted_px = 0.7 * kLensMaxError_px;

double accepted_px(const OpencvLens& lens, double column, double row) {
  constexpr double kUnits = 4 * std::numeric_limits<double>::epsilon();
  return std::max(kAccepted_px, kUnits * (std::abs(column - lens.cx) + std::abs(row - lens.cy)));
}

bool meets(const OpencvLens& lens, double column, double row, const kernel::LensStep& at) {
  return at.residual_px <= std::max(accepted_px(lens, column, row), 2 * at.rounding_px);
}

// Tangent of twice the angle: distances from the axis in even steps of the angle of view.
double tangent_of_double(double tangent) { return 2 * tangent / (1 - tangent * tangent); }
double tangent_of_half(double tangent) { return tangent / (1 + std::sqrt(1 + tangent * tangent)); }

// Unfolded all the way from the lens's axis.
bool on_first_branch(const OpencvLens& lens, double x, double y) {
  const double radius = std::hypot(x, y);
  if (!(radius > 0)) return kernel::unfolded_at(lens, x, y) > 0;
  const double half = tangent_of_half(radius);
  for (int i = 1; i <= kLensFoldSteps; ++i) {
    const double share = tangent_of_double(half * i / kLensFoldSteps) / radius;
    if (!(kernel::unfolded_at(lens, share * x, share * y) > 0)) return false;
  }
  return true;
}

// Newton steps from a start until the pixel is met.
kernel::LensStep stepped(const OpencvLens& lens, double column, double row, kernel::LensStep at, int most) {
  for (int i = 0; i < most && !meets(lens, column, row, at) && std::isfinite(at.x) && std::isfinite(at.y); ++i)
    at = kernel::newton_step(lens, column, row, at.x, at.y);
  return at;
}

// By way of the pixels between the lens's centre and this one: what Newton's method jumps over it cannot miss.
kernel::LensStep followed(const OpencvLens& lens, double column, double row) {
  constexpr int kNear = 3, kLast = 30;
  kernel::LensStep at{0, 0, 1, HUGE_VAL};
  for (int i = 1; i <= kLensFoldSteps && kernel::unfolded_at(lens, at.x, at.y) > 0; ++i) {
    const double share = static_cast<double>(i) / kLensFoldSteps;
    const double c = lens.cx + share * (column - lens.cx), r = lens.cy + share * (row - lens.cy);
    at.residual_px = HUGE_VAL;
    at = stepped(lens, c, r, at, i < kLensFoldSteps ? kNear : kLast);
  }
  return at;
}

// Steps until the pixel is met; NaN if it never is, or only where the lens's image folds back.
void finish(const OpencvLens& lens, double column, double row, std::size_t i, Part& part) {
  constexpr int kMost = 30;
  const auto found = [&](const kernel::LensStep& s) {
    return meets(lens, column, row, s) && s.determinant > 0 && on_first_branch(lens, s.x, s.y);
  };
  kernel::LensStep at =
      stepped(lens, column, row, {part.x[i], part.y[i], part.determinant[i], part.residual_px[i]}, kMost);
  if (!found(at)) at = followed(lens, column, row);
  const bool good = found(at);
  part.x[i] = good ? at.x : kNaN;
  part.y[i] = good ? at.y : kNaN;
  part.determinant[i] = at.determinant;
}

// A disc about the axis that is known to be unfolded; it is made anew when rays leave it.
class UnfoldedDisc {
 public:
  explicit UnfoldedDisc(const OpencvLens& lens) : lens_(lens) {}

  bool holds(double radius) {
    if (radius <= radius_) return true;
    if (radius >= beyond_ || !std::isfinite(radius)) return false;
    constexpr double kMargin = 1.1;  // so that the next part of a row asks for no more
    const double half = tangent_of_half(kMargin * radius);
    std::array<double, kLensFoldSteps> r, stretch;
    for (std::size_t i = 0; i < r.size(); ++i)
      r[i] = tangent_of_double(half * static_cast<double>(i + 1) / kLensFoldSteps);
    kernel::run_least_stretch(lens_, r.size(), r.data(), stretch.data());
    for (std::size_t i = 0; i < r.size(); ++i) {
      if (!(stretch[i] > 0)) {
        beyond_ = r[i];
        break;
      }
      radius_ = std::max(radius_, r[i]);
    }
    return radius <= radius_;
  }

 private:
  const OpencvLens& lens_;
  double radius_ = 0, beyond_ = HUGE_VAL;
};

// The pinhole's rays.
kernel::LensStart far_start(const OpencvLens& lens, int row, const kernel::LensColumns& columns) {
  return {(columns.first - lens.cx) / lens.fx, columns.step / lens.fx, {0, 1}, {(row - lens.cy) / lens.fy}};
}

// The polynomial through values at u = 0, 1, 2, 3, 4.
std::array<double, 5> quartic(const double* f) {
  const double d1 = f[1] - f[0], d2 = f[2] - 2 * f[1] + f[0], d3 = f[3] - 3 * f[2] + 3 * f[1] - f[0],
               d4 = f[4] - 4 * f[3] + 6 * f[2] - 4 * f[1] + f[0];
  return {f[0], d1 - d2 / 2 + d3 / 3 - d4 / 4, d2 / 2 - d3 / 2 + 11 * d4 / 24, d3 / 6 - d4 / 4, d4 / 24};
}

double fifth_difference(const double* f) { return f[5] - 5 * f[4] + 10 * f[3] - 10 * f[2] + 5 * f[1] - f[0]; }

// Rays at even nodes along a row, five to each part: from the quartics through them the other rays are a step or two
// away.
class RowNodes {
 public:
  static constexpr std::size_t kMostParts = 32;

  RowNodes(const OpencvLens& lens, int row, int first, std::size_t parts) {
    // One node beyond, which may lie off the frame, tells the error.
    const kernel::LensColumns nodes{static_cast<double>(first), kSpacing, kIntervals * parts + 2};
    kernel::run_unproject_far(lens, row, nodes, far_start(lens, row, nodes), x_.data(), y_.data(), determinant_.data(),
                              residual_px_.data());
  }

  struct Start {
    kernel::LensStart at;
    double error;  ///< of x and y, estimated
  };
  // nullopt where a node has no ray.
  std::optional<Start> start(std::size_t part) const {
    constexpr double kMet_px = 1e-3;
    const std::size_t node = kIntervals * part;
    for (std::size_t k = node; k <= node + kIntervals + 1; ++k) {
      if (!(residual_px_[k] <= kMet_px && determinant_[k] > 0)) return std::nullopt;
    }
    constexpr double kShare = 0.031;  // the largest |u (u − 1) … (u − 4)|/5! between the nodes
    const double *x = x_.data() + node, *y = y_.data() + node;
    return Start{{0, 1 / kSpacing, quartic(x), quartic(y)},
                 kShare * (std::abs(fifth_difference(x)) + std::abs(fifth_difference(y)))};
  }

 private:
  static constexpr std::size_t kIntervals = 4, kNodes = kIntervals * kMostParts + 2;
  static constexpr double kSpacing = static_cast<double>(kPart) / kIntervals;
  std::array<double, kNodes> x_, y_, determinant_, residual_px_;
};

void unproject_part(const OpencvLens& lens, UnfoldedDisc& disc, int row, int first, std::size_t n,
                    const std::optional<RowNodes::Start>& start, Part& part) {
  const kernel::LensColumns columns{static_cast<double>(first), 1, n};
  const auto met_at = [&](std::size_t i) {
    return part.residual_px[i] <= accepted_px(lens, first + static_cast<double>(i), row) && part.determinant[i] > 0;
  };
  const auto run = [&](auto unproject, const kernel::LensStart& from) {
    unproject(lens, row, columns, from, part.x.data(), part.y.data(), part.determinant.data(), part.residual_px.data());
  };
  constexpr double kClose = 1e-8, kNear = 2e-5;  // each step about squares the error
  if (start && start->error < kClose) {
    run(kernel::run_unproject_close, start->at);
  } else if (start && start->error < kNear) {
    run(kernel::run_unproject_near, start->at);
  } else {
    run(kernel::run_unproject_far, start ? start->at : far_start(lens, row, columns));
  }
  // The least that any column of the part accepts.
  const double nearest = std::clamp(lens.cx, columns.first, columns.first + static_cast<double>(n - 1));
  const auto judge = [&] {
    return kernel::run_judge(n, accepted_px(lens, nearest, row), part.x.data(), part.y.data(), part.determinant.data(),
                             part.residual_px.data());
  };
  kernel::LensJudgement judged = judge();
  // Where the start was not near enough, more steps for all cost less than single ones for some.
  if (!judged.met && start && start->error < kNear &&
      !(met_at(0) && met_at(n - 1) && met_at(n / 4) && met_at(n - 1 - n / 4))) {
    run(kernel::run_unproject_far, start->at);
    judged = judge();
  }
  const bool unfolded = disc.holds(std::sqrt(judged.farthest2));
  if (judged.met && unfolded) return;
  for (std::size_t i = 0; i < n; ++i) {
    const bool met = met_at(i);
    if (!met || !(unfolded || disc.holds(std::hypot(part.x[i], part.y[i]))))
      finish(lens, first + static_cast<double>(i), row, i, part);
  }
}

// A pixel's area on the plane z = 1, 1/(fx fy det), seen from the camera.
double solid_angle(const OpencvLens& lens, const Part& part, std::size_t i) {
  const double r2 = 1 + part.x[i] * part.x[i] + part.y[i] * part.y[i];
  return 1 / (std::abs(lens.fx * lens.fy) * part.determinant[i] * r2 * std::sqrt(r2));
}

struct RayAngles {
  std::array<double, kPart> theta, phi, z;
};

// Copies what is wanted; pixels without a ray or below the horizon get NaN.
void write_part(const OpencvLens& lens, const Part& part, const RayAngles& a, std::size_t n, std::size_t at,
                const AngleRow<double>& out) {
  const auto place = static_cast<std::ptrdiff_t>(at);
  if (!out.theta_s_rad.empty()) {
    std::copy_n(a.theta.begin(), n, out.theta_s_rad.begin() + place);
    std::copy_n(a.phi.begin(), n, out.phi_s_rad.begin() + place);
  }
  if (!out.mask.empty()) std::fill_n(out.mask.begin() + place, n, Mask{0});
  if (!out.solid_angle_sr.empty()) {
    for (std::size_t i = 0; i < n; ++i) out.solid_angle_sr[at + i] = solid_angle(lens, part, i);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (a.z[i] > 0) continue;  // no ray: z is NaN
    for (const std::span<double> span : {out.theta_s_rad, out.phi_s_rad, out.solid_angle_sr}) {
      if (!span.empty()) span[at + i] = kNaN;
    }
    if (!out.mask.empty()) out.mask[at + i] = std::isnan(a.z[i]) ? kNoData : kBelowHorizon;
  }
}

// Calls work(n, place) for parts of a row whose rays are in `part`.
template <class Work>
void for_parts(const OpencvLens& lens, int row, ColumnRange columns, Part& part, Work&& work) {
  UnfoldedDisc disc(lens);
  constexpr int kLength = static_cast<int>(kPart), kMost = kLength * static_cast<int>(RowNodes::kMostParts);
  for (int from = columns.first; from < columns.last; from += kMost) {
    const int last = std::min(from + kMost, columns.last);
    const RowNodes nodes(lens, row, from, (static_cast<std::size_t>(last - from) + kPart - 1) / kPart);
    for (int first = from; first < last; first += kLength) {
      const auto n = static_cast<std::size_t>(std::min(kLength, last - first));
      unproject_part(lens, disc, row, first, n, nodes.start(static_cast<std::size_t>((first - from) / kLength)), part);
      work(n, static_cast<std::size_t>(first - columns.first));
    }
  }
}

}  // namespace

std::optional<OpencvLens> opencv_lens(std::string_view model, std::span<const double> intrinsics) {
  const std::array<std::pair<std::string_view, std::size_t>, 4> kinds{
      {{"LENSMODEL_OPENCV4", 4}, {"LENSMODEL_OPENCV5", 5}, {"LENSMODEL_OPENCV8", 8}, {"LENSMODEL_OPENCV12", 12}}};
  for (const auto& [name, count] : kinds) {
    if (model != name || intrinsics.size() != count + 4) continue;
    OpencvLens lens{intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3], {}};
    std::copy(intrinsics.begin() + 4, intrinsics.end(), lens.k.begin());
    return lens;
  }
  return std::nullopt;
}

void unproject_row(const OpencvLens& lens, int row, ColumnRange columns, const LensRow& out) {
  Part part;
  for_parts(lens, row, columns, part, [&](std::size_t n, std::size_t at) {
    std::copy_n(part.x.begin(), n, out.x.data() + at);
    std::copy_n(part.y.begin(), n, out.y.data() + at);
    if (out.solid_angle_sr.empty()) return;
    for (std::size_t i = 0; i < n; ++i) out.solid_angle_sr[at + i] = solid_angle(lens, part, i);
  });
}

void lens_angle_row(const OpencvLens& lens, const Matrix3<double>& m, int row, ColumnRange columns,
                    const AngleRow<double>& out) {
  const double matrix[9] = {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
  Part part;
  RayAngles angles;
  for_parts(lens, row, columns, part, [&](std::size_t n, std::size_t at) {
    kernel::run_ray_angles(matrix, n, part.x.data(), part.y.data(), angles.theta.data(), angles.phi.data(),
                           angles.z.data());
    write_part(lens, part, angles, n, at, out);
  });
}

}  // namespace scatmap
