#pragma once
#include <filesystem>
#include <string>

#include "scatmap/angles/angle_map.h"
#include "scatmap/base/direction.h"
#include "scatmap/base/grid.h"

namespace scatmap {

/// What every pixel of a camera with a lens looks at, in camera axes: x along the columns, y along the rows as stored,
/// z the boresight, away from the sample.
struct LensRays {
  std::string model;                ///< mrcal's name of the lens model
  Grid<Vector3<double>> direction;  ///< rows × columns, unit; NaN where the model has no answer
  Grid<double> solid_angle_sr;      ///< of one pixel: |∂ray/∂column × ∂ray/∂row|, from the lens's
                                    ///< Jacobian or rays at the pixel's four edges
};

/// kFastest: by what the model allows; kMrcal: by mrcal_unproject whatever the model, to compare.
enum class LensInverse { kFastest, kMrcal };

/// Reads a .cameramodel file with mrcal and unprojects every pixel: LENSMODEL_OPENCV4, 5, 8 and 12 by unproject_row
/// (opencv_lens.h), every other lens model that mrcal can unproject by mrcal's own mrcal_unproject. The file's pose is
/// ignored: the camera sits at the spot and its axes are the instrument's. mrcal costs about 3 µs a pixel for iterative
/// models, 0.1 µs for closed ones.
/// @throws Error if the module is not installed, the file is no camera model, its size is not columns × rows, or the
/// model cannot be unprojected
LensRays load_lens_rays(const std::filesystem::path& cameramodel, int columns, int rows,
                        LensInverse inverse = LensInverse::kFastest);

/// Angles of a detector behind a lens: direction = X ray.x + Y ray.y + Z ray.z, where X, Y, Z are the view's column
/// direction, row direction (both with their flips) and detector normal. Distance, offset and pitch of the view do not
/// enter. Pixels without a ray get kNoData. With LENSMODEL_PINHOLE and the focal lengths and centre of
/// calib::pinhole_at_spot this equals the bare CCD.
AngleMap angle_map(const SampleView& view, const LensRays& rays);

}  // namespace scatmap
