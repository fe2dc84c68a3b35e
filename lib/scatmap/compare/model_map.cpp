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
  map.angles = angle_map(view, instrument.rows, instrument.columns);
  map.mask = map.angles.mask;
  map.brdf_per_sr = Grid<double>(instrument.rows, instrument.columns);
  for_each_row(instrument.rows, [&](int row) {
    for (int c = 0; c < instrument.columns; ++c) {
      map.brdf_per_sr(row, c) =
          map.mask(row, c) == 0 ? prepared(view.pixel(c, row).normalized()) : std::numeric_limits<double>::quiet_NaN();
    }
  });
  return map;
}

}  // namespace scatmap
