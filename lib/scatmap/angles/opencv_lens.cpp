#include "scatmap/angles/opencv_lens.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scatmap/angles/lens_kernel.h"

namespace scatmap {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kPart = 192;  // of a row, on the stack

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

// One ray to a thousandth of what near starts need; nullopt where it does not come about.
std::optional<kernel::LensStep> solved(const OpencvLens& lens, double column, double row, double x, double y) {
  constexpr int kMost = 6;
  constexpr double kNear_px = 1e-3;
  for (int step = 0; step < kMost; ++step) {
    const kernel::LensStep next = kernel::newton_step(lens, column, row, x, y);
    if (next.residual_px <= kNear_px && next.determinant > 0) return next;
    x = next.x;
    y = next.y;
  }
  return std::nullopt;
}

// The parabola through the rays of the part's ends and middle.
std::optional<kernel::LensStart> near_start(const OpencvLens& lens, int row, int first, std::size_t n) {
  constexpr std::size_t kShortest = 32;
  if (n < kShortest) return std::nullopt;
  const double half = 0.5 * static_cast<double>(n - 1);
  const auto undistorted = [&](double column) {
    return solved(lens, column, row, (column - lens.cx) / lens.fx, (row - lens.cy) / lens.fy);
  };
  const auto a = undistorted(first), b = undistorted(first + half), c = undistorted(first + 2 * half);
  if (!a || !b || !c) return std::nullopt;
  const auto slope = [half](double p, double q, double r) { return (-3 * p + 4 * q - r) / (2 * half); };
  const auto bend = [half](double p, double q, double r) { return (p - 2 * q + r) / (2 * half * half); };
  return kernel::LensStart{a->x, slope(a->x, b->x, c->x), bend(a->x, b->x, c->x),
                           a->y, slope(a->y, b->y, c->y), bend(a->y, b->y, c->y)};
}

// Distance from the axis, of the rays that there are.
double farthest(const Part& part, std::size_t n) {
  std::array<double, 8> most2{};  // side by side: one maximum after the other would take as long as the rays
  std::size_t i = 0;
  for (; i + most2.size() <= n; i += most2.size()) {
    for (std::size_t k = 0; k < most2.size(); ++k) {
      const double r2 = part.x[i + k] * part.x[i + k] + part.y[i + k] * part.y[i + k];
      most2[k] = most2[k] < r2 ? r2 : most2[k];
    }
  }
  for (; i < n; ++i) most2[0] = std::max(most2[0], part.x[i] * part.x[i] + part.y[i] * part.y[i]);
  return std::sqrt(*std::max_element(most2.begin(), most2.end()));
}

void unproject_part(const OpencvLens& lens, UnfoldedDisc& disc, int row, int first, std::size_t n, Part& part) {
  const kernel::LensStart far{(first - lens.cx) / lens.fx, 1 / lens.fx, 0, (row - lens.cy) / lens.fy, 0, 0};
  const auto met_at = [&](std::size_t i) {
    return part.residual_px[i] <= accepted_px(lens, first + static_cast<double>(i), row) && part.determinant[i] > 0;
  };
  const auto near = near_start(lens, row, first, n);
  const auto run = [&](auto unproject, const kernel::LensStart& start) {
    unproject(lens, row, first, start, n, part.x.data(), part.y.data(), part.determinant.data(),
              part.residual_px.data());
  };
  near ? run(kernel::run_unproject_near, *near) : run(kernel::run_unproject_far, far);
  // Where the parabola was not near enough at an end, more steps for all cost less than single ones for some.
  if (near && !(met_at(0) && met_at(n - 1) && met_at(n / 4) && met_at(n - 1 - n / 4)))
    run(kernel::run_unproject_far, *near);
  const bool unfolded = disc.holds(farthest(part, n));
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

template <class Work>
void for_parts(ColumnRange columns, Work&& work) {
  for (int first = columns.first; first < columns.last; first += static_cast<int>(kPart)) {
    const std::size_t n = std::min(kPart, static_cast<std::size_t>(columns.last - first));
    work(first, n, static_cast<std::size_t>(first - columns.first));
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
  UnfoldedDisc disc(lens);
  for_parts(columns, [&](int first, std::size_t n, std::size_t at) {
    unproject_part(lens, disc, row, first, n, part);
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
  UnfoldedDisc disc(lens);
  for_parts(columns, [&](int first, std::size_t n, std::size_t at) {
    unproject_part(lens, disc, row, first, n, part);
    kernel::run_ray_angles(matrix, n, part.x.data(), part.y.data(), angles.theta.data(), angles.phi.data(),
                           angles.z.data());
    write_part(lens, part, angles, n, at, out);
  });
}

}  // namespace scatmap
