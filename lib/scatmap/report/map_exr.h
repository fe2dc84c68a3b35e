#pragma once
#include <filesystem>

#include "scatmap/base/output_file.h"
#include "scatmap/brdf/brdf_map.h"

namespace scatmap {

/// Writes a map as OpenEXR for viewing and exchange: FLOAT channels (HALF turns 4.2e5 into infinity), the BRDF as `Y`,
/// the others by their FITS names in lower case (uncert, mask, u_random, u_pose, theta_s_deg, phi_s_deg,
/// solid_angle_sr, …). theta_i, scale uncertainty, convention, units and provenance are header attributes. float32:
/// never the working precision. Whole or absent. @throws Error
void write_map_exr(const BrdfMap& map, const std::filesystem::path& target, Overwrite overwrite);

/// The angle images alone: theta_s_deg also as `Y`.
void write_angles_exr(const AngleMap& angles, const Provenance& provenance, const std::filesystem::path& target,
                      Overwrite overwrite);

}  // namespace scatmap
