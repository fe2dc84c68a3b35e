#include "scatmap/compare/model_map.h"

#include <cstdio>
#include <limits>

#include "scatmap/base/number_text.h"
#include "scatmap/base/parallel.h"

namespace scatmap {
namespace {

std::string two_digits(double value) {
  char text[16];
  std::snprintf(text, sizeof text, "%.1e", value);
  return text;
}

std::string method_note(const FrameModelOptions& options, double rounding) {
  const std::string what = options.pixel_average ? "means over the pixels" : "values at pixel centres";
  const std::string method = options.pixel_average ? "adaptive Gauss points" : model_method_name(options.method);
  return "model: " + what + ", method " + method + ", error at most " + number_text(model_error_bound(options)) +
         " of the larger of the value and " + number_text(kPeakShare) +
         " of the largest; rounding of directions adds " + two_digits(rounding) + " at most";
}

// A lens bends the plane of pixels that the other methods rest on.
void fill_behind_lens(const PreparedModel& prepared, BrdfMap& map) {
  for_each_row(map.mask.rows(), [&](int row) {
    for (int c = 0; c < map.mask.columns(); ++c) {
      map.brdf_per_sr(row, c) =
          map.mask(row, c) != 0
              ? std::numeric_limits<double>::quiet_NaN()
              : prepared(direction_from_angles(map.angles.theta_s_rad(row, c), map.angles.phi_s_rad(row, c)));
    }
  });
}

}  // namespace

double model_error_bound(const FrameModelOptions& options) {
  if (options.pixel_average || options.method == ModelMethod::kCulled) return options.tolerance_rel;
  if (options.method == ModelMethod::kSingle) return kSingleModelError;
  return options.method == ModelMethod::kVector ? kVectorModelError : kExactModelError;
}

BrdfMap model_map(const Model& model, const Instrument& instrument, const Pose& pose,
                  const FrameModelOptions& options) {
  const SampleView view = sample_view(instrument, pose);
  const double distance_m = instrument.geometry.distance;
  BrdfMap map;
  map.instrument = instrument;
  map.pose = pose;
  map.wavelength_m = model.wavelength_m;
  map.angles = angle_map(instrument, pose);
  map.mask = map.angles.mask;
  map.brdf_per_sr = Grid<double>(instrument.rows, instrument.columns);
  if (instrument.lens_cameramodel) {
    fill_behind_lens(PreparedModel(model, view.to_source, distance_m), map);
    map.notes.push_back("model: values at pixel centres, method exact, on the directions of the lens");
    return map;
  }
  const DirectionPlane plane{view.origin, view.column_step, view.row_step};
  FrameModel(model, view.to_source, distance_m, plane, instrument.rows, instrument.columns, options)
      .fill({map.brdf_per_sr.data(), map.brdf_per_sr.size()});
  for_each_row(instrument.rows, [&](int row) {
    for (int c = 0; c < instrument.columns; ++c) {
      if (map.mask(row, c) != 0) map.brdf_per_sr(row, c) = std::numeric_limits<double>::quiet_NaN();
    }
  });
  map.notes.push_back(method_note(options, model_rounding_error(model, view.to_source, distance_m)));
  return map;
}

}  // namespace scatmap
