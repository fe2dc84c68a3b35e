#include "scatmap/compare/compare.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/units.h"
#include "scatmap/compare/pixel_directions.h"

namespace scatmap {
namespace {

constexpr double kSameWavelength = 1e-6;  // relative
constexpr double kSamePose_rad = 1e-9;    // far below an encoder's step, far above the rounding of degrees in a file
constexpr double kLobeReach = 3;          // radii: e^−9 of a lobe reaches further

std::string shape(const BrdfMap& map) {
  return std::to_string(map.mask.columns()) + " × " + std::to_string(map.mask.rows()) + " pixels";
}

void require(bool same, const std::string& what, const std::string& got, const std::string& expected) {
  if (!same) throw Error({"compare", "the maps differ in " + what, got, expected + " as in the measured map"});
}

void require_same_scene(const BrdfMap& measured, const BrdfMap& modelled) {
  require(modelled.brdf_per_sr.same_shape(measured.brdf_per_sr) && modelled.mask.same_shape(measured.mask), "shape",
          shape(modelled), shape(measured));
  require(std::abs(modelled.wavelength_m - measured.wavelength_m) <= kSameWavelength * measured.wavelength_m,
          "wavelength", number_text(modelled.wavelength_m / kMetrePerNm) + " nm",
          number_text(measured.wavelength_m / kMetrePerNm) + " nm");
  const auto pose = [&](double Pose::*angle, const char* name) {
    require(std::abs(modelled.pose.*angle - measured.pose.*angle) <= kSamePose_rad, name,
            number_text(modelled.pose.*angle * kDegPerRad) + " deg",
            number_text(measured.pose.*angle * kDegPerRad) + " deg");
  };
  pose(&Pose::stage_rad, "stage angle");
  pose(&Pose::arm_rad, "arm angle");
}

}  // namespace

MapFeatures find_features(const BrdfMap& map) {
  MapFeatures f;
  f.peaks = find_peaks(map);
  f.band = find_band(map, f.peaks);
  if (!f.band) return f;
  const Peak& centre = f.peaks[f.band->peak];
  f.along_ridge = find_fringes(ridge_profile(map, *f.band), kLobeReach * centre.radius_px);
  f.along_column = find_fringes(column_profile(map, centre.position()), kLobeReach * centre.radius_px);
  return f;
}

Comparison compare(const BrdfMap& measured, const BrdfMap& modelled) {
  require_same_scene(measured, modelled);
  Comparison c;
  c.measured = find_features(measured);
  c.modelled = find_features(modelled);
  c.peaks = pair_peaks(c.measured.peaks, c.modelled.peaks);
  for (const Peak& p : c.measured.peaks) {
    c.columns.push_back({column_profile(measured, p.position()), column_profile(modelled, p.position())});
    c.rows.push_back({row_profile(measured, p.position()), row_profile(modelled, p.position())});
  }
  if (const std::optional<Band>& band = c.measured.band ? c.measured.band : c.modelled.band) {
    c.ridge = ProfilePair{ridge_profile(measured, *band), ridge_profile(modelled, *band)};
  }
  const auto states_uncertainty = [](const BrdfMap& m) {
    return !m.u_random_per_sr.empty() || !m.u_pose_per_sr.empty() || !m.structured.empty();
  };
  if (states_uncertainty(measured) || states_uncertainty(modelled)) c.residual = residual(measured, modelled);
  c.log10_ratio = log10_ratio(measured, modelled);
  c.direction_difference_px = direction_difference_px(measured, modelled);
  return c;
}

}  // namespace scatmap
