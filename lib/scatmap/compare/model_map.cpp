#include "scatmap/compare/model_map.h"

#include <limits>

#include "scatmap/angles/pixel_plane.h"
#include "scatmap/base/parallel_rows.h"

namespace scatmap {

BrdfMap model_map(const Model& model, const Instrument& instrument, const Pose& pose) {
  const SampleView view = sample_view(instrument, pose);
  const PreparedModel prepared(model, view.to_source, instrument.geometry.distance);
  BrdfMap map;
  map.instrument = instrument;
  map.pose = pose;
  map.wavelength_m = model.wavelength_m;
  map.angles = angle_map(instrument, pose);
  map.mask = map.angles.mask;
  map.brdf_per_sr = Grid<double>(instrument.rows, instrument.columns);
  const bool lens = instrument.lens_cameramodel.has_value();
  for_each_row(instrument.rows, [&](int row) {
    for (int c = 0; c < instrument.columns; ++c) {
      if (map.mask(row, c) != 0) {
        map.brdf_per_sr(row, c) = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      const Vector3<double> direction =
          lens ? direction_from_angles(map.angles.theta_s_rad(row, c), map.angles.phi_s_rad(row, c))
               : Vector3<double>(view.pixel(c, row).normalized());
      map.brdf_per_sr(row, c) = prepared(direction);
    }
  });
  return map;
}

}  // namespace scatmap
