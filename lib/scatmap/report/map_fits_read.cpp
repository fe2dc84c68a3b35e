#include <cmath>
#include <limits>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
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

// Directions are computed anew from the lens file: it must be the one the map was made with.
void require_same_lens(FitsReader& fits, const std::string& file, const std::string& primary, const Instrument& in) {
  if (!in.lens_cameramodel) return;
  const auto sha256 = fits.text_key(primary, "LENSSHA");
  if (sha256 && *sha256 == record_input(*in.lens_cameramodel).sha256) return;
  throw Error({file + "[INSTRUMENT]: detector.lens_cameramodel", "has changed since the file was written",
               in.lens_cameramodel->string(), "the file with sha256 " + sha256.value_or("(not stated)")});
}

// Numbers that follow from others in the file: whoever changed one alone expects it to count.
void require_derived(double stated, double derived, const std::string& where, const std::string& from) {
  constexpr double kSame = 1e-9;  // relative, and in degrees
  if (std::abs(stated - derived) <= kSame * (1 + std::abs(derived))) return;
  throw Error({where, "does not follow from " + from, number_text(stated), number_text(derived)});
}

void require_possible_incidence(FitsReader& fits, const std::string& file, const std::string& primary,
                                const MapView& view) {
  const auto theta_i_rad = [&] {
    try {
      return incidence_angle(sample_view(view.instrument, view.pose));
    } catch (const Error& e) {
      throw with_context(file, e);
    }
  }();
  if (const auto theta_i_deg = fits.number_key(primary, "THETAI"))
    require_derived(*theta_i_deg, theta_i_rad * kDegPerRad, file + ": THETAI", "STAGERAD and the instrument");
}

MapView read_view(FitsReader& fits, const std::string& file) {
  const std::string primary = fits.names().empty() ? "" : fits.names().front();
  if ((primary != "BRDF" && primary != "THETA_S_DEG") || !fits.has("INSTRUMENT")) {
    throw Error(
        {file, "is no map of scatmap", "a primary image named '" + primary + "'", "BRDF, and a table INSTRUMENT"});
  }
  std::string text;
  for (const std::string& line : fits.text_column("INSTRUMENT", "TOML")) text += line + "\n";
  MapView view{parse_instrument(text, file + "[INSTRUMENT]"), {}, 0};
  require_same_lens(fits, file, primary, view.instrument);
  view.pose = {required_key(fits, file, primary, "STAGERAD"), required_key(fits, file, primary, "ARMRAD")};
  view.wavelength_m = fits.number_key(primary, "WAVELEN").value_or(0) * kMetrePerNm;
  if (primary == "BRDF" && !(view.wavelength_m > 0))
    throw Error({file + ": WAVELEN", "is no wavelength", {}, "a number > 0, nm"});
  require_possible_incidence(fits, file, primary, view);
  return view;
}

constexpr std::size_t kMostCauses = 1000;  // their correlations are a square matrix

Eigen::MatrixXd read_correlation(FitsReader& fits, const std::string& file, std::size_t causes) {
  const auto size = static_cast<Eigen::Index>(causes);
  Eigen::MatrixXd out = Eigen::MatrixXd::Identity(size, size);
  const auto first = fits.number_column("COMMON_CORRELATION", "CAUSE_A"),
             second = fits.number_column("COMMON_CORRELATION", "CAUSE_B");
  const auto rho = fits.number_column("COMMON_CORRELATION", "CORRELATION");
  const auto is_row = [&](double row) { return row >= 1 && row <= static_cast<double>(causes); };
  for (std::size_t i = 0; i < rho.size(); ++i) {
    if (!is_row(first[i]) || !is_row(second[i]) || !(std::abs(rho[i]) <= 1))
      throw Error(
          {file + ": COMMON_CORRELATION, row " + std::to_string(i + 1), "is no correlation of two causes", {}, {}});
    const auto a = static_cast<Eigen::Index>(first[i]) - 1, b = static_cast<Eigen::Index>(second[i]) - 1;
    out(a, b) = out(b, a) = rho[i];
  }
  return out;
}

Distribution known_distribution(const std::string& text, const std::string& where) {
  if (const auto distribution = distribution_from(text)) return *distribution;
  throw Error({where, "has an unknown distribution", text, "one that scatmap writes"});
}

void require_possible(const ScaleCause& c, const std::string& where) {
  const auto possible = [](double half_width) { return half_width >= 0 && std::isfinite(half_width); };
  if (possible(c.half_width) && possible(c.half_width_below) && std::isfinite(c.sensitivity)) return;
  throw Error({where, "is no cause of uncertainty",
               "half widths " + number_text(c.half_width) + " and " + number_text(c.half_width_below) +
                   ", sensitivity " + number_text(c.sensitivity),
               "finite numbers, half widths >= 0"});
}

ScaleBudget read_scale(FitsReader& fits, const std::string& file) {
  ScaleBudget out;
  const auto names = fits.text_column("COMMON", "CAUSE"), distributions = fits.text_column("COMMON", "DISTRIBUTION");
  if (names.empty()) return out;
  if (names.size() > kMostCauses)
    throw Error({file + ": COMMON", "has too many rows", std::to_string(names.size()), std::to_string(kMostCauses)});
  const auto half_widths = fits.number_column("COMMON", "HALF_WIDTH"),
             sensitivities = fits.number_column("COMMON", "SENSITIVITY");
  const auto is_filter = fits.number_column("COMMON", "IS_FILTER"),
             below = fits.number_column("COMMON", "HALF_WIDTH_BELOW");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string where = file + ": COMMON, row " + std::to_string(i + 1);
    out.causes.push_back({names[i], known_distribution(distributions[i], where), half_widths[i], sensitivities[i],
                          is_filter[i] != 0, below[i]});
    require_possible(out.causes.back(), where);
  }
  if (fits.has("COMMON_CORRELATION")) out.correlation = read_correlation(fits, file, names.size());
  return out;
}

StructuredCause read_structured(FitsReader& fits, const std::string& file, const std::string& hdu) {
  StructuredCause out{hdu, fits.text_key(hdu, "CAUSE").value_or(hdu), fits.image_float(hdu)};
  out.cause.name = out.meaning;
  if (const auto distribution = fits.text_key(hdu, "DISTRIB"))
    out.cause.distribution = known_distribution(*distribution, file + ": " + hdu + ": DISTRIB");
  out.cause.half_width = fits.number_key(hdu, "HALFWID").value_or(1);
  out.cause.half_width_below = fits.number_key(hdu, "HALFWIDB").value_or(0);
  out.cause.is_filter = fits.number_key(hdu, "ISFILTER").value_or(0) != 0;
  require_possible(out.cause, file + ": " + hdu);
  return out;
}

void require_shape(const BrdfMap& map, int rows, int columns, const std::string& file, const std::string& hdu) {
  if (rows == map.instrument.rows && columns == map.instrument.columns) return;
  throw Error({file + ": " + hdu, "has another size than the instrument in the file",
               std::to_string(columns) + " x " + std::to_string(rows),
               std::to_string(map.instrument.columns) + " x " + std::to_string(map.instrument.rows)});
}

// Where the mask is 0 there is a number, and an uncertainty that can be one.
template <class T>
void require_numbers(const BrdfMap& map, const Grid<T>& image, T least, const std::string& where,
                     const char* expected) {
  for (std::size_t i = 0; i < image.size(); ++i) {
    if (map.mask[i] != 0 || (image[i] >= least && std::isfinite(image[i]))) continue;
    const auto columns = static_cast<std::size_t>(image.columns());
    throw Error({where + ", column " + std::to_string(i % columns) + ", row " + std::to_string(i / columns),
                 "has no possible value though its mask is 0", number_text(static_cast<double>(image[i])), expected});
  }
}

void require_derived_uncertainty(const BrdfMap& map, const Grid<float>& stated, const std::string& where) {
  const Grid<float> derived = per_pixel_uncertainty(map);
  constexpr float kSame = 1e-4f;  // roundings of its parts
  for (std::size_t i = 0; i < derived.size(); ++i) {
    if (map.mask[i] != 0 || std::abs(stated[i] - derived[i]) <= kSame * derived[i]) continue;
    const auto columns = static_cast<std::size_t>(derived.columns());
    throw Error({where + ", column " + std::to_string(i % columns) + ", row " + std::to_string(i / columns),
                 "is not the norm of the images U_...", number_text(static_cast<double>(stated[i])),
                 number_text(static_cast<double>(derived[i]))});
  }
}

void require_derived_numbers(FitsReader& fits, const std::string& file, const BrdfMap& map) {
  if (const auto scale = fits.number_key("BRDF", "USCALE"))
    require_derived(*scale, map.scale.standard(), file + ": USCALE", "the table COMMON");
  if (map.u_random_per_sr.empty() || !fits.has("UNCERT")) return;
  const Grid<float> stated = fits.image_float("UNCERT");
  require_shape(map, stated.rows(), stated.columns(), file, "UNCERT");
  require_derived_uncertainty(map, stated, file + ": UNCERT");
}

}  // namespace

MapView read_map_view(const std::filesystem::path& path) {
  FitsReader fits(path);
  MapView view = read_view(fits, path.string());
  fits.require_unchanged();
  return view;
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
    map.structured.push_back(read_structured(fits, file, name));
  }
  for (const Grid<float>* u : {&map.u_random_per_sr, &map.u_pose_per_sr}) {
    if (!u->empty()) require_shape(map, u->rows(), u->columns(), file, "an uncertainty");
  }
  for (const StructuredCause& s : map.structured)
    require_shape(map, s.sensitivity_per_sr.rows(), s.sensitivity_per_sr.columns(), file, s.name);
  require_numbers(map, map.brdf_per_sr, std::numeric_limits<double>::lowest(), file + ": BRDF", "a finite number");
  require_numbers(map, map.u_random_per_sr, 0.f, file + ": U_RANDOM", "a finite number >= 0");
  require_numbers(map, map.u_pose_per_sr, 0.f, file + ": U_POSE", "a finite number >= 0");
  map.scale = read_scale(fits, file);
  require_derived_numbers(fits, file, map);
  fits.require_unchanged();
  map.angles = angle_map(map.instrument, map.pose);
  return map;
}

}  // namespace scatmap
