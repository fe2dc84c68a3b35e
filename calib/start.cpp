#include "calib/start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/rotation.h"
#include "scatmap/base/units.h"

namespace scatmap::calib {
namespace {

using Complex = std::complex<double>;

constexpr Eigen::Index kDistance = 0, kOffsetX = 1, kOffsetY = 2, kRoll = 5;

struct Ray {
  std::size_t target;
  std::size_t group;  // mount, or the number of mounts for the direct beam
  Complex slope;      // of the predicted beam, arm axes
  Complex spot;       // on the detector from its centre, m, flips not applied
  double cos_incidence = 1;
};

// z = alpha s + shift[group], s conjugated when mirrored.
struct Similarity {
  bool mirrored = false;
  Complex alpha;
  std::vector<Complex> shift;
  std::vector<std::size_t> near;  // places in the list of rays
  double rms_m = 0;

  Complex slope(const Ray& ray) const { return mirrored ? std::conj(ray.slope) : ray.slope; }
};

std::optional<Ray> ray_of(const ParameterTable& table, const TargetList& list, std::size_t i) {
  const Geometry<double> g = table.geometry(table.nominal());
  const Target& t = list.targets[i];
  const Vector3<double> to_source(0, std::sin(g.beam_elevation), std::cos(g.beam_elevation));
  Vector3<double> along = -to_source;
  Ray ray{i, table.mounts(), {}, {}, 1};
  if (t.kind == TargetKind::kSpecular) {
    const double tilt = table[ParameterTable::index_of_key(kTiltColumn, t.mount)].nominal + t.tilt_rad;
    const Vector3<double> n = rotation_y<double>(t.stage_rad + g.stage_zero) * rotation_x<double>(tilt).col(2);
    ray.cos_incidence = n.dot(to_source);
    ray.group = t.mount;
    if (!(ray.cos_incidence > 0)) return std::nullopt;
    along = 2 * ray.cos_incidence * n - to_source;
  }
  const Matrix3<double> lab_from_arm = rotation_x<double>(g.arm_axis_tilt_x) * rotation_z<double>(g.arm_axis_tilt_z) *
                                       rotation_y<double>(t.arm_rad + g.arm_zero);
  const Vector3<double> on_arm = lab_from_arm.transpose() * along;
  constexpr double kWidestSlope = 1;  // 45 degrees: no detector is that large, no label that wrong is worth keeping
  if (!(on_arm.z() > 0 && std::hypot(on_arm.x(), on_arm.y()) < kWidestSlope * on_arm.z())) return std::nullopt;
  ray.slope = {on_arm.x() / on_arm.z(), on_arm.y() / on_arm.z()};
  const Instrument& a = table.array();
  ray.spot = {(t.column_px - 0.5 * (a.columns - 1)) * g.pixel_column, (t.row_px - 0.5 * (a.rows - 1)) * g.pixel_row};
  return ray;
}

Complex median(std::vector<Complex> v) {
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end(), [](Complex a, Complex b) { return a.real() < b.real(); });
  const double x = middle->real();
  std::nth_element(v.begin(), middle, v.end(), [](Complex a, Complex b) { return a.imag() < b.imag(); });
  return {x, middle->imag()};
}

class Finder {
 public:
  Finder(const ParameterTable& table, std::vector<Ray> rays) : table_(table), rays_(std::move(rays)) {
    const Geometry<double> g = table.geometry(table.nominal());
    const Instrument& a = table.array();
    tolerance_m_ = kNear * std::hypot(a.columns * g.pixel_column, a.rows * g.pixel_row);
    nominal_distance_ = g.distance;
    const double sign = a.flip_columns ? -1 : 1;
    nominal_mirrored_ = a.flip_columns != a.flip_rows;
    // Detector from arm, seen as one complex factor: x + iy turns by −roll, and the flips negate or conjugate.
    nominal_alpha_ = sign * std::polar(g.distance, nominal_mirrored_ ? g.rotation_roll : -g.rotation_roll);
  }

  /// The better handedness, then the other.
  std::array<Similarity, 2> both() const {
    const Similarity nominal = fitted(nominal_mirrored_);
    const Similarity other = fitted(!nominal_mirrored_);
    // Spots on a line are as good either way; only a clear win overrules the file.
    const bool more = static_cast<double>(other.near.size()) > 1.2 * static_cast<double>(nominal.near.size()) + 1;
    const bool closer =
        other.near.size() >= nominal.near.size() && other.near.size() > 2 && other.rms_m < 0.3 * nominal.rms_m;
    if (more || closer) return {other, nominal};
    return {nominal, other};
  }

 private:
  static constexpr double kNear = 0.05;  // of the array's diagonal: covers what the similarity leaves out

  std::vector<std::size_t> largest_group() const {
    std::vector<std::vector<std::size_t>> groups(table_.mounts() + 1);
    for (std::size_t i = 0; i < rays_.size(); ++i) groups[rays_[i].group].push_back(i);
    return *std::max_element(groups.begin(), groups.end(),
                             [](const auto& a, const auto& b) { return a.size() < b.size(); });
  }

  std::vector<std::size_t> agreeing(const Similarity& s, const std::vector<std::size_t>& among) const {
    std::vector<std::size_t> out;
    for (const std::size_t i : among) {
      if (std::abs(rays_[i].spot - s.alpha * s.slope(rays_[i]) - s.shift[rays_[i].group]) < tolerance_m_)
        out.push_back(i);
    }
    return out;
  }

  bool plausible(Complex alpha) const {
    constexpr double kFactor = 3;
    const double distance = std::abs(alpha);
    return distance > nominal_distance_ / kFactor && distance < nominal_distance_ * kFactor;
  }

  // Least squares over some rays, each group with its own shift.
  void refine(Similarity& s, const std::vector<std::size_t>& among) const {
    std::vector<Complex> slope(table_.mounts() + 1), spot(slope);
    std::vector<double> count(slope.size(), 0);
    for (const std::size_t i : among) {
      slope[rays_[i].group] += s.slope(rays_[i]);
      spot[rays_[i].group] += rays_[i].spot;
      count[rays_[i].group] += 1;
    }
    Complex cross = 0;
    double square = 0;
    for (const std::size_t i : among) {
      const std::size_t g = rays_[i].group;
      const Complex ds = s.slope(rays_[i]) - slope[g] / count[g];
      cross += std::conj(ds) * (rays_[i].spot - spot[g] / count[g]);
      square += std::norm(ds);
    }
    const double spread = std::sqrt(square / static_cast<double>(std::max<std::size_t>(among.size(), 1)));
    if (spread * nominal_distance_ > 0.2 * tolerance_m_ && plausible(cross / square)) s.alpha = cross / square;
    for (std::size_t g = 0; g < count.size(); ++g) {
      if (count[g] > 0) s.shift[g] = (spot[g] - s.alpha * slope[g]) / count[g];
    }
  }

  void shift_groups(Similarity& s) const {
    for (std::size_t g = 0; g < s.shift.size(); ++g) {
      std::vector<Complex> left;
      for (const Ray& ray : rays_) {
        if (ray.group == g) left.push_back(ray.spot - s.alpha * s.slope(ray));
      }
      if (!left.empty()) s.shift[g] = median(left);
    }
  }

  Similarity ransac(bool mirrored, const std::vector<std::size_t>& group) const {
    Similarity best;
    best.mirrored = mirrored;
    best.alpha = mirrored == nominal_mirrored_ ? nominal_alpha_ : std::conj(nominal_alpha_);
    best.shift.assign(table_.mounts() + 1, 0);
    shift_groups(best);
    best.near = agreeing(best, group);
    constexpr int kDraws = 150;
    std::mt19937_64 rng(20381);
    Similarity trial = best;
    for (int draw = 0; draw < kDraws && group.size() > 2 && best.near.size() < group.size(); ++draw) {
      const Ray& a = rays_[group[rng() % group.size()]];
      const Ray& b = rays_[group[rng() % group.size()]];
      const Complex ds = trial.slope(a) - trial.slope(b);
      if (!(std::abs(ds) * nominal_distance_ > tolerance_m_)) continue;
      trial.alpha = (a.spot - b.spot) / ds;
      if (!plausible(trial.alpha)) continue;
      trial.shift[a.group] = a.spot - trial.alpha * trial.slope(a);
      trial.near = agreeing(trial, group);
      if (trial.near.size() > best.near.size()) best = trial;
    }
    return best;
  }

  Similarity fitted(bool mirrored) const {
    const std::vector<std::size_t> group = largest_group();
    std::vector<std::size_t> all(rays_.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    Similarity s = ransac(mirrored, group);
    const std::vector<Complex> kept = s.shift;
    shift_groups(s);
    s.shift[rays_[group.front()].group] = kept[rays_[group.front()].group];
    s.near = agreeing(s, all);
    for (int round = 0; round < 2 && !s.near.empty(); ++round) {
      refine(s, s.near);
      s.near = agreeing(s, all);
    }
    double sum = 0;
    for (const std::size_t i : s.near)
      sum += std::norm(rays_[i].spot - s.alpha * s.slope(rays_[i]) - s.shift[rays_[i].group]);
    s.rms_m = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(s.near.size(), 1)));
    return s;
  }

  const ParameterTable& table_;
  std::vector<Ray> rays_;
  double tolerance_m_ = 0;
  double nominal_distance_ = 0;
  bool nominal_mirrored_ = false;
  Complex nominal_alpha_;
};

struct Orientation {
  bool flip_columns, flip_rows;
  double roll_rad;
};

double turn_between(double a, double b) { return std::abs(std::remainder(a - b, 2 * std::numbers::pi)); }

// Of the two pairs of flips with the similarity's handedness, the one whose roll is nearer to the nominal.
Orientation orientation_of(const Similarity& s, double nominal_roll, const Instrument& array) {
  const auto roll = [&](bool columns) {
    const double sign = columns ? -1 : 1;
    const double angle = (s.mirrored ? 1 : -1) * std::arg(sign * s.alpha);
    return nominal_roll + std::remainder(angle - nominal_roll, 2 * std::numbers::pi);
  };
  const double kept = roll(array.flip_columns), turned = roll(!array.flip_columns);
  const bool columns = turn_between(kept, nominal_roll) <= turn_between(turned, nominal_roll) + 1e-9
                           ? array.flip_columns
                           : !array.flip_columns;
  return {columns, s.mirrored != columns, columns == array.flip_columns ? kept : turned};
}

void describe(const Orientation& o, double nominal_roll, const Instrument& nominal,
              std::vector<std::string>& findings) {
  const double turn_deg = turn_between(o.roll_rad, nominal_roll) * kDegPerRad;
  const bool mirrored = (o.flip_columns != o.flip_rows) != (nominal.flip_columns != nominal.flip_rows);
  if (mirrored && turn_deg > 45) {
    findings.push_back(
        "columns and rows are swapped against the instrument file (in targets.csv, or the detector is turned by 90 "
        "degrees "
        "and read out mirrored); fitted as a roll of " +
        number_text(std::round(o.roll_rad * kDegPerRad)) + " degrees with a flip");
    return;
  }
  if (o.flip_columns != nominal.flip_columns)
    findings.push_back("the columns run the other way than the instrument file says: flip_columns changed");
  if (o.flip_rows != nominal.flip_rows)
    findings.push_back("the rows run the other way than the instrument file says: flip_rows changed");
  if (turn_deg > 45)
    findings.push_back("the detector is rolled by " + number_text(std::round(turn_deg)) +
                       " degrees against the instrument file");
}

// Detector offset from the direct beam if there is one, else from the first mount; the others' shifts against it are
// turned stage and tilted mirrors.
void place(const Similarity& s, const std::vector<Ray>& rays, Start& start) {
  std::vector<double> count(s.shift.size(), 0), cosine(s.shift.size(), 0);
  for (const std::size_t i : s.near) {
    count[rays[i].group] += 1;
    cosine[rays[i].group] += rays[i].cos_incidence;
  }
  std::size_t base = s.shift.size() - 1;
  if (count[base] == 0) base = static_cast<std::size_t>(std::max_element(count.begin(), count.end()) - count.begin());
  const Complex unit = s.alpha / std::abs(s.alpha);
  const auto on_arm = [&](Complex shift) { return s.mirrored ? std::conj(shift / unit) : shift / unit; };
  const double distance = std::abs(s.alpha);
  start.values[kDistance] = distance;
  start.values[kOffsetX] = -on_arm(s.shift[base]).real();
  start.values[kOffsetY] = -on_arm(s.shift[base]).imag();
  double stage = 0, specular = 0;
  for (std::size_t g = 0; g + 1 < s.shift.size(); ++g) {
    if (count[g] == 0 || g == base) continue;
    const Complex turn = on_arm(s.shift[g] - s.shift[base]) / distance;
    start.values[ParameterTable::index_of_key(kTiltColumn, g)] -= turn.imag() / (2 * cosine[g] / count[g]);
    stage += count[g] * turn.real() / 2;
    specular += count[g];
  }
  if (base + 1 == s.shift.size() && specular > 0) start.values[kStageZeroColumn] += stage / specular;
}

Start start_of(const Similarity& s, const std::vector<Ray>& rays, const ParameterTable& nominal) {
  Start start{nominal, nominal.nominal(), {}, {}};
  const double nominal_roll = start.values[kRoll];
  const Orientation o = orientation_of(s, nominal_roll, nominal.array());
  describe(o, nominal_roll, nominal.array(), start.findings);
  start.table.set_flips(o.flip_columns, o.flip_rows);
  start.values[kRoll] = o.roll_rad;
  if (turn_between(o.roll_rad, nominal_roll) > std::numbers::pi / 4) start.table.set_nominal(kRoll, o.roll_rad);
  place(s, rays, start);
  for (const std::size_t i : s.near) start.near.push_back(rays[i].target);
  return start;
}

}  // namespace

std::vector<Start> starts(const ParameterTable& nominal, const TargetList& list) {
  std::vector<Ray> rays;
  Start as_stated{nominal, nominal.nominal(), {}, {}};
  for (std::size_t i = 0; i < list.targets.size(); ++i) {
    const auto ray = ray_of(nominal, list, i);
    if (!ray) continue;
    rays.push_back(*ray);
    as_stated.near.push_back(i);
  }
  if (rays.empty()) {
    throw Error({list.name,
                 "holds no target whose beam reaches the detector; check the signs of stage and arm angles",
                 {},
                 "arm near 2 x stage for specular targets, near 180 degrees for direct ones"});
  }
  std::vector<Start> out;
  for (const Similarity& s : Finder(nominal, rays).both()) {
    if (!s.near.empty()) out.push_back(start_of(s, rays, nominal));
  }
  out.push_back(as_stated);
  return out;
}

}  // namespace scatmap::calib
