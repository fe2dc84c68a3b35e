#pragma once
#include <string>
#include <vector>

#include "scatmap/angles/angle_map.h"
#include "scatmap/base/provenance.h"
#include "scatmap/brdf/scale.h"

namespace scatmap {

/// One cause that moves every pixel by its own amount: signed change of the BRDF at +1 standard deviation of the cause.
struct StructuredCause {
  std::string name;  ///< as in the map's extension: "U_NONLIN", "U_ND_OD10"
  std::string meaning;
  Grid<float> sensitivity_per_sr;
  ScaleCause cause{.half_width = 1,
                   .sensitivity = 1};  ///< what it is one standard deviation of: distribution, half width
};

/// What one input exposure contributed.
struct ExposureRecord {
  std::string role;  ///< "signature", "signature exposure N" or "exposure N"
  double exposure_s = 0;
  std::vector<std::string> filters;
  std::vector<InputRecord> frames;
  std::vector<InputRecord> darks;
};

/// BRDF per pixel with the three kinds of uncertainty kept apart: random (independent per pixel), structured (one
/// sensitivity map per cause; u_pose is the norm of the pose parameters'), scale (common to all pixels).
/// covariance(p, q) = [p = q] u_random² + sum over causes s(p) s(q) + f(p) f(q) scale².
/// A modelled map has empty uncertainties.
struct BrdfMap {
  Grid<double> brdf_per_sr;  ///< NaN where the mask is not 0 and no value exists
  Grid<float> u_random_per_sr;
  Grid<float> u_pose_per_sr;
  std::vector<StructuredCause> structured;
  Grid<Mask> mask;
  AngleMap angles;
  ScaleBudget scale;
  Instrument instrument;
  Pose pose;
  double wavelength_m = 0;
  std::vector<ExposureRecord> exposures;
  std::string method;              ///< how counts became BRDF: "fused", "exact"; empty where that has no meaning
  std::vector<std::string> notes;  ///< what the user should know: a correction that was not applied, a weak input
  Provenance provenance;
};

/// Random, pose and structured parts together, per pixel (root sum of squares), scale excluded; empty if the map has
/// none.
Grid<float> per_pixel_uncertainty(const BrdfMap& map);
/// What it is made of: images of the map's.
std::vector<const Grid<float>*> uncertainty_parts(const BrdfMap& map);
/// One row of it, zeros where there are no parts. @param out columns
void per_pixel_uncertainty_row(std::span<const Grid<float>* const> parts, int row, std::span<float> out);

}  // namespace scatmap
