#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "scatmap/base/output_file.h"
#include "scatmap/brdf/brdf_map.h"
#include "scatmap/compare/compare.h"

namespace scatmap {

/// The BRDF in float32 (relative rounding 6e-8, far below any uncertainty) or in double. Uncertainties are always
/// float32, angles always double.
enum class Precision { kSingle, kDouble };

/// Writes a map as FITS: primary image BRDF (BUNIT sr-1) with the TAN WCS of the scatter angles, UNCERT (UTYPE
/// StdDevUncertainty: random and structured, scale excluded), MASK (bits in its header), U_RANDOM, U_POSE, one image
/// per further structured cause, THETA_S_DEG, PHI_S_DEG, SOLID_ANGLE_SR, with a calibration the SIGMA_… of the angles;
/// tables COMMON (scale causes), COMMON_CORRELATION (between its rows, only where there is any), FRAMES (inputs),
/// INSTRUMENT (the instrument file, line by line). astropy's CCDData.read(file) finds data, uncertainty and mask. A
/// modelled map (empty uncertainties) has no UNCERT, U_RANDOM and U_POSE. Whole or absent. @throws Error
void write_map_fits(const BrdfMap& map, const std::filesystem::path& target, Precision precision, Overwrite overwrite);

/// How angles were computed, for the header: keywords ANGMETH, ANGBOUND (rad) and ANGBNDPX.
struct AngleMethodNote {
  std::string method;
  double bound_rad = 0;  ///< of the numbers in the file
  double bound_px = 0;
  Precision precision = Precision::kDouble;  ///< of the file's images
};

/// Writes angle images, THETA_S_DEG as primary, then PHI_S_DEG, SOLID_ANGLE_SR, MASK, INSTRUMENT; double unless
/// `method` says otherwise.
void write_angles_fits(const AngleMap& angles, const Instrument& instrument, const Pose& pose,
                       const Provenance& provenance, const std::filesystem::path& target, Overwrite overwrite,
                       const std::optional<AngleMethodNote>& method = std::nullopt);

/// Writes a comparison's images: RESIDUAL, (measured − modelled)/u, as primary where there is one, and LOG10_RATIO.
void write_residual_fits(const Comparison& comparison, const BrdfMap& like, const Provenance& provenance,
                         const std::filesystem::path& target, Overwrite overwrite);

/// Reads a map back. Instrument and pose come from the file and the angles are computed anew from them, never from the
/// stored angles. @throws Error if the file is not a map of scatmap
BrdfMap read_map_fits(const std::filesystem::path& path);

/// What a map's header says of how it was measured: enough to compute the same pixel directions.
struct MapView {
  Instrument instrument;
  Pose pose;
  double wavelength_m = 0;
};
/// @throws Error if the file is neither a map nor an angle file of scatmap
MapView read_map_view(const std::filesystem::path& path);

}  // namespace scatmap
