#include <cmath>

#include "scatmap/base/error.h"
#include "scatmap/base/units.h"
#include "scatmap/report/fits_file.h"
#include "scatmap/report/map_fits.h"

namespace scatmap {
namespace {

double required_key(FitsReader& fits, const std::string& file, const std::string& hdu, const std::string& key) {
  const auto value = fits.number_key(hdu, key);
  if (!value || !std::isfinite(*value)) throw Error({file + ": " + key, "is missing", {}, "a map written by scatmap"});
  return *value;
}

MapView read_view(FitsReader& fits, const std::string& file) {
  const std::string primary = fits.names().empty() ? "" : fits.names().front();
  if ((primary != "BRDF" && primary != "THETA_S_DEG") || !fits.has("INSTRUMENT")) {
    throw Error({file, "is no map of scatmap", "a primary image named '" + primary + "'", "BRDF, and a table INSTRUMENT"});
  }
  std::string text;
  for (const std::string& line : fits.text_column("INSTRUMENT", "TOML")) text += line + "\n";
  MapView view{parse_instrument(text, file + "[INSTRUMENT]"), {}, 0};
  view.pose = {required_key(fits, file, primary, "STAGERAD"), required_key(fits, file, primary, "ARMRAD")};
  view.wavelength_m = fits.number_key(primary, "WAVELEN").value_or(0) * kMetrePerNm;
  if (primary == "BRDF" && !(view.wavelength_m > 0)) throw Error({file + ": WAVELEN", "is no wavelength", {}, "a number > 0, nm"});
  try {
    sample_view(view.instrument, view.pose);
  } catch (const Error& e) {
    throw with_context(file, e);
  }
  return view;
}

ScaleBudget read_scale(FitsReader& fits) {
  ScaleBudget out;
  const auto names = fits.text_column("COMMON", "CAUSE"), distributions = fits.text_column("COMMON", "DISTRIBUTION");
  if (names.empty()) return out;
  const auto half_widths = fits.number_column("COMMON", "HALF_WIDTH"), sensitivities = fits.number_column("COMMON", "SENSITIVITY");
  const auto is_filter = fits.number_column("COMMON", "IS_FILTER");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Distribution d = distributions[i] == to_string(Distribution::kNormal) ? Distribution::kNormal : Distribution::kRectangular;
    out.causes.push_back({names[i], d, half_widths[i], sensitivities[i], is_filter[i] != 0});
  }
  return out;
}

void require_shape(const BrdfMap& map, int rows, int columns, const std::string& file, const std::string& hdu) {
  if (rows == map.instrument.rows && columns == map.instrument.columns) return;
  throw Error({file + ": " + hdu, "has another size than the instrument in the file", std::to_string(columns) + " x " + std::to_string(rows),
               std::to_string(map.instrument.columns) + " x " + std::to_string(map.instrument.rows)});
}

}  // namespace

MapView read_map_view(const std::filesystem::path& path) {
  FitsReader fits(path);
  return read_view(fits, path.string());
}

BrdfMap read_map_fits(const std::filesystem::path& path) {
  FitsReader fits(path);
  const std::string file = path.string();
  const MapView view = read_view(fits, file);
  BrdfMap map;
  map.instrument = view.instrument;
  map.pose = view.pose;
  map.wavelength_m = view.wavelength_m;
  map.brdf_per_sr = fits.image_double("BRDF");
  require_shape(map, map.brdf_per_sr.rows(), map.brdf_per_sr.columns(), file, "BRDF");
  map.mask = fits.image_mask("MASK");
  require_shape(map, map.mask.rows(), map.mask.columns(), file, "MASK");
  if (fits.has("U_RANDOM")) map.u_random_per_sr = fits.image_float("U_RANDOM");
  if (fits.has("U_POSE")) map.u_pose_per_sr = fits.image_float("U_POSE");
  for (const std::string& name : fits.names()) {
    if (name.rfind("U_", 0) != 0 || name == "U_RANDOM" || name == "U_POSE") continue;
    map.structured.push_back({name, fits.text_key(name, "CAUSE").value_or(name), fits.image_float(name)});
  }
  for (const Grid<float>* u : {&map.u_random_per_sr, &map.u_pose_per_sr}) {
    if (!u->empty()) require_shape(map, u->rows(), u->columns(), file, "an uncertainty");
  }
  for (const StructuredCause& s : map.structured) require_shape(map, s.sensitivity_per_sr.rows(), s.sensitivity_per_sr.columns(), file, s.name);
  map.scale = read_scale(fits);
  map.angles = angle_map(map.instrument, map.pose);
  return map;
}

}  // namespace scatmap
