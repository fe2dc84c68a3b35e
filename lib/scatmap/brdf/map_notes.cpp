#include "scatmap/brdf/map_notes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "scatmap/base/number_text.h"

namespace scatmap {
namespace {

constexpr double kVisibleSeam = 2e-3;  // a step between exposures that the user should hear of

std::string percent(double relative) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100 * relative);
  return text;
}

}  // namespace

void note_noise(double pooled_dark_noise_dn, const std::string& role, const SensorModel& sensor, BrdfMap& map) {
  if (pooled_dark_noise_dn == 0) return;
  const double ratio = pooled_dark_noise_dn / sensor.read_noise_dn();
  constexpr double kTooNoisy = 2;  // dark charge adds some of its own
  if (ratio < 0.7) {
    map.notes.push_back("darks of " + role + " scatter by " + std::to_string(ratio) +
                        " of the stated read noise: check sensor.read_noise_e and gain_e_per_dn");
  } else if (ratio > kTooNoisy) {
    map.notes.push_back("darks of " + role + " scatter by " + number_text(std::round(ratio)) +
                        " times the stated read noise, and pixels that are none may count as hot: check "
                        "sensor.read_noise_e");
  }
}

void note_overlap(const OverlapReport& o, BrdfMap& map) {
  for (std::size_t k = 0; k < o.causes.causes.size(); ++k) {
    const ScaleCause& c = o.causes.causes[k];
    const double shift = o.solution.shift[static_cast<Eigen::Index>(k)];
    // Three standard uncertainties: a filter known only together with others may seem off by their tolerance.
    const auto i = static_cast<Eigen::Index>(k);
    if (c.distribution != Distribution::kNormal &&
        std::abs(shift) > c.worst_case() + 3 * std::sqrt(o.solution.covariance(i, i))) {
      map.notes.push_back(c.name + " is " + number_text(shift) + " off its stated value, beyond its tolerance of " +
                          number_text(c.worst_case()));
    }
  }
  for (const OverlapPair& p : o.solution.pairs) {
    const std::string names = pair_name(p, static_cast<std::size_t>(o.causes.sensitivity.rows()));
    if (!p.problem.empty()) {
      map.notes.push_back(names + " are inconsistent and their overlap was not used: " + p.problem);
    } else if (p.used && std::abs(p.ln_ratio) > kVisibleSeam + 3 * p.u) {
      map.notes.push_back(names + " leave a step of " + percent(p.ln_ratio));
    }
  }
}

void note_beam(const Measurement& m, const MergedSignature& signature, BrdfMap& map) {
  if (const auto& spot = signature.other)
    map.notes.push_back("the signature shows light beside its beam, at column " + number_text(spot->column) + ", row " +
                        number_text(spot->row) + " with " + percent(spot->share) + " of its peak: it is left out");
  constexpr double kSeen = 0.01;
  if (!(signature.outside > kSeen)) return;
  map.notes.push_back("signature.aperture_radius_px = " + number_text(*m.aperture.radius_px) + " leaves out " +
                      percent(signature.outside) + " of the beam found within " +
                      number_text(std::round(10 * signature.found_radius_px) / 10) +
                      " px: the map is too bright by as much");
}

// Some rows tell.
void note_darkness(BrdfMap& map) {
  constexpr int kStep = 16;
  constexpr double kBelow = -1;
  double sum = 0, count = 0;
  for (int r = 0; r < map.mask.rows(); r += kStep) {
    for (int c = 0; c < map.mask.columns(); ++c) {
      if (map.mask(r, c) != 0 || !(map.u_random_per_sr(r, c) > 0)) continue;
      sum += std::clamp(map.brdf_per_sr(r, c) / map.u_random_per_sr(r, c), -10.0, 10.0);
      count += 1;
    }
  }
  if (count > 0 && sum < kBelow * count)
    map.notes.push_back("most pixels lie below their darks by more than their noise: are frames and darks exchanged?");
}

void note_power(BrdfMap& map) {
  constexpr int kStep = 16;
  constexpr double kSigmas = 3;
  double power = 0;
  for (int r = 0; r < map.mask.rows(); r += kStep) {
    const int rows = std::min(kStep, map.mask.rows() - r);
    for (int c = 0; c < map.mask.columns(); ++c) {
      if (map.mask(r, c) == 0)
        power +=
            rows * map.brdf_per_sr(r, c) * std::cos(map.angles.theta_s_rad(r, c)) * map.angles.solid_angle_sr(r, c);
    }
  }
  const double u = map.scale.standard();
  if (!(power > 1 + kSigmas * u)) return;
  char times[32];
  std::snprintf(times, sizeof times, "%.1g", power);
  map.notes.push_back(std::string("the map's pixels take some ") + times +
                      " times the light that fell on the sample: are filters and exposure times right?");
}

}  // namespace scatmap
