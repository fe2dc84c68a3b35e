#include "scatmap/report/map_fits.h"

#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "scatmap/angles/angle_uncertainty.h"
#include "scatmap/angles/tan_wcs.h"
#include "scatmap/base/units.h"
#include "scatmap/report/fits_file.h"

namespace scatmap {
namespace {

// A lens bends the plane: no TAN projection then.
std::optional<TanWcs> wcs_of(const Instrument& instrument, const SampleView& view) {
  if (instrument.lens_cameramodel) return std::nullopt;
  return tan_wcs(view);
}

void write_wcs(FitsWriter& fits, const std::optional<TanWcs>& stated) {
  if (!stated) return;
  const TanWcs& wcs = *stated;
  fits.key("CTYPE1", std::string("SCLN-TAN"), "phi_s from -x, exact for a flat detector");
  fits.key("CTYPE2", std::string("SCLT-TAN"), "90 deg - theta_s");
  fits.key("CUNIT1", std::string("deg"), "");
  fits.key("CUNIT2", std::string("deg"), "");
  fits.key("CRPIX1", wcs.crpix[0], "foot of the perpendicular from the spot");
  fits.key("CRPIX2", wcs.crpix[1], "");
  fits.key("CRVAL1", wcs.crval_deg[0], "phi_s there");
  fits.key("CRVAL2", wcs.crval_deg[1], "90 deg - theta_s there");
  fits.key("CD1_1", wcs.cd[0][0], "");
  fits.key("CD1_2", wcs.cd[0][1], "");
  fits.key("CD2_1", wcs.cd[1][0], "");
  fits.key("CD2_2", wcs.cd[1][1], "");
  fits.key("LONPOLE", TanWcs::kLonPole_deg, "");
}

void write_pose(FitsWriter& fits, const SampleView& view, const Pose& pose, double wavelength_m) {
  // Written in radians too, so that --like works on the very same doubles.
  fits.key("STAGEDEG", pose.stage_rad * kDegPerRad, "commanded stage angle");
  fits.key("ARMDEG", pose.arm_rad * kDegPerRad, "commanded arm angle");
  fits.key("STAGERAD", pose.stage_rad, "the same, every bit");
  fits.key("ARMRAD", pose.arm_rad, "the same, every bit");
  fits.key("THETAI", incidence_angle(view) * kDegPerRad, "[deg] angle of incidence");
  fits.key("PHII", 0.0, "[deg] azimuth of incidence");
  if (wavelength_m > 0) fits.key("WAVELEN", wavelength_m / kMetrePerNm, "[nm] wavelength");
  fits.key("ANGCONV", std::string("phi from -x towards -y; specular at 180"), "sample axes: z normal, x forward");
}

// So that a reader can tell whether the lens is still the one these numbers were made with.
void write_lens(FitsWriter& fits, const Instrument& instrument) {
  if (!instrument.lens_cameramodel) return;
  fits.key("LENSSHA", record_input(*instrument.lens_cameramodel).sha256, "");
}

void write_provenance(FitsWriter& fits, const Provenance& p) {
  fits.key("CREATOR", p.written_by, "program and version");
  fits.key("CMDLINE", p.command_line.empty() ? "-" : p.command_line, "");
}

// For files without a table of frames.
void write_inputs(FitsWriter& fits, const Provenance& p) {
  for (const InputRecord& i : p.inputs) fits.history("input " + i.path + " sha256 " + i.sha256);
}

void write_scale(FitsWriter& fits, const BrdfMap& map) {
  if (map.u_random_per_sr.empty()) return;
  const ScaleInterval interval = map.scale.filters_interval();
  fits.key("USCALE", map.scale.standard(), "relative standard u, common to all pixels");
  fits.key("NDWORST", map.scale.filters_worst_case(), "ND filters: ln10 sqrt(sum (tol OD)^2)");
  fits.key("NDGUM", map.scale.filters_standard(), "ND filters: standard u (worst case/sqrt 3)");
  fits.key("NDLOW", interval.low, "ND filters: exact interval, low");
  fits.key("NDHIGH", interval.high, "ND filters: exact interval, high");
}

void write_primary_header(FitsWriter& fits, const BrdfMap& map, const SampleView& view) {
  write_pose(fits, view, map.pose, map.wavelength_m);
  write_lens(fits, map.instrument);
  write_scale(fits, map);
  write_provenance(fits, map.provenance);
  if (!map.method.empty()) fits.key("METHOD", map.method, "how counts became BRDF");
  for (const std::string& note : map.notes) fits.history("NOTE: " + note);
}

void write_mask(FitsWriter& fits, const Grid<Mask>& mask, const std::optional<TanWcs>& wcs) {
  fits.image("MASK", mask);
  for (const MaskFlag& flag : kMaskFlags) {
    int bit = 0;
    while ((flag.bit >> bit) != 1) ++bit;
    fits.key("FLAG" + std::to_string(bit), std::string(flag.name),
             std::string("bit ") + std::to_string(flag.bit) + ": " + flag.meaning);
  }
  write_wcs(fits, wcs);
}

void write_uncertainties(FitsWriter& fits, const BrdfMap& map, const std::optional<TanWcs>& wcs) {
  if (map.u_random_per_sr.empty()) return;
  fits.image("UNCERT", "sr-1", per_pixel_uncertainty(map));
  fits.key("UTYPE", std::string("StdDevUncertainty"), "random and structured; scale excluded");
  write_wcs(fits, wcs);
}

void write_parts(FitsWriter& fits, const BrdfMap& map) {
  if (map.u_random_per_sr.empty()) return;
  fits.image("U_RANDOM", "sr-1", map.u_random_per_sr);
  fits.key("ERRCORR", std::string("random"), "independent from pixel to pixel");
  if (!map.u_pose_per_sr.empty()) {
    fits.image("U_POSE", "sr-1", map.u_pose_per_sr);
    fits.key("ERRCORR", std::string("structured"), "norm over the calibration's parameters");
  }
  for (const StructuredCause& s : map.structured) {
    fits.image(s.name, "sr-1", s.sensitivity_per_sr);
    fits.key("ERRCORR", std::string("structured"), "signed change at +1 sigma of one cause");
    fits.key("CAUSE", s.meaning, "");
    fits.key("DISTRIB", std::string(to_string(s.cause.distribution)), "of the cause");
    fits.key("HALFWID", s.cause.half_width, "of the cause, in its unit; normal: 1 sigma");
    fits.key("HALFWIDB", s.cause.half_width_below, "asymmetric only: downwards");
    fits.key("ISFILTER", s.cause.is_filter ? 1 : 0, "1: an ND filter, half width in OD");
  }
}

void write_angle_images(FitsWriter& fits, const AngleMap& angles, bool theta_done,
                        FitsPixels pixels = FitsPixels::kDouble) {
  if (!theta_done) fits.image("THETA_S_DEG", "deg", angles.theta_s_rad, pixels, kDegPerRad);
  fits.image("PHI_S_DEG", "deg", angles.phi_s_rad, pixels, kDegPerRad);
  fits.image("SOLID_ANGLE_SR", "sr", angles.solid_angle_sr, pixels);
}

void write_method(FitsWriter& fits, const std::optional<AngleMethodNote>& method) {
  if (!method) return;
  fits.key("ANGMETH", method->method, "method of the angles");
  fits.key("ANGBOUND", method->bound_rad, "[rad] largest error of a direction");
  fits.key("ANGBNDPX", method->bound_px, "[pixel] the same");
}

// From the calibration, where the instrument has one.
void write_angle_uncertainty(FitsWriter& fits, const Instrument& instrument, const Pose& pose, const Grid<Mask>& mask) {
  auto u = angle_uncertainty(instrument, pose, mask);
  if (!u) return;
  const auto degrees = [](Grid<float> rad) {
    for (float& v : rad) v = static_cast<float>(v * kDegPerRad);
    return rad;
  };
  fits.image("SIGMA_THETA_S_DEG", "deg", degrees(std::move(u->theta_s_rad)));
  fits.image("SIGMA_PHI_S_DEG", "deg", degrees(std::move(u->phi_s_rad)));
  fits.image("CORR_THETA_PHI", "", std::move(u->correlation));
  fits.image("SIGMA_DIRECTION_PX", "pixel", std::move(u->direction_px));
}

void write_common(FitsWriter& fits, const ScaleBudget& scale) {
  std::vector<FitsColumn> columns{
      {"CAUSE", "", {}, {}}, {"DISTRIBUTION", "", {}, {}}, {"HALF_WIDTH", "", {}, {}},      {"SENSITIVITY", "", {}, {}},
      {"U_LN", "", {}, {}},  {"IS_FILTER", "", {}, {}},    {"HALF_WIDTH_BELOW", "", {}, {}}};
  for (const ScaleCause& c : scale.causes) {
    columns[0].text.push_back(c.name);
    columns[1].text.push_back(to_string(c.distribution));
    columns[2].numbers.push_back(c.half_width);
    columns[3].numbers.push_back(c.sensitivity);
    columns[4].numbers.push_back(c.standard());
    columns[5].numbers.push_back(c.is_filter ? 1 : 0);
    columns[6].numbers.push_back(c.half_width_below);
  }
  fits.table("COMMON", columns);
}

// Pairs of rows of COMMON (first = 1) whose causes are not independent.
void write_correlation(FitsWriter& fits, const ScaleBudget& scale) {
  std::vector<FitsColumn> columns{{"CAUSE_A", "", {}, {}}, {"CAUSE_B", "", {}, {}}, {"CORRELATION", "", {}, {}}};
  for (std::size_t a = 0; a < scale.causes.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const double rho = scale.correlation_of(a, b);
      if (rho == 0) continue;
      columns[0].numbers.push_back(static_cast<double>(b + 1));
      columns[1].numbers.push_back(static_cast<double>(a + 1));
      columns[2].numbers.push_back(rho);
    }
  }
  if (!columns[0].numbers.empty()) fits.table("COMMON_CORRELATION", columns);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : "+") + n;
  return text;
}

void write_frames(FitsWriter& fits, const BrdfMap& map) {
  std::vector<FitsColumn> columns{{"ROLE", "", {}, {}},   {"KIND", "", {}, {}},    {"FILE", "", {}, {}},
                                  {"SHA256", "", {}, {}}, {"FILTERS", "", {}, {}}, {"EXPOSURE_S", "s", {}, {}}};
  const auto add = [&](const std::string& role, const char* kind, const InputRecord& r, const std::string& filters,
                       double exposure_s) {
    columns[0].text.push_back(role);
    columns[1].text.push_back(kind);
    columns[2].text.push_back(r.path);
    columns[3].text.push_back(r.sha256);
    columns[4].text.push_back(filters);
    columns[5].numbers.push_back(exposure_s);
  };
  for (const ExposureRecord& e : map.exposures) {
    for (const InputRecord& r : e.frames) add(e.role, "frame", r, joined(e.filters), e.exposure_s);
    for (const InputRecord& r : e.darks) add(e.role, "dark", r, "", e.exposure_s);
  }
  for (const InputRecord& r : map.provenance.inputs) add("input", "file", r, "", 0);
  fits.table("FRAMES", columns);
}

void write_instrument(FitsWriter& fits, const Instrument& instrument) {
  FitsColumn lines{"TOML", "", {}, {}};
  std::istringstream text(to_toml(instrument));
  for (std::string line; std::getline(text, line);) lines.text.push_back(line);
  fits.table("INSTRUMENT", {lines});
}

}  // namespace

void write_map_fits(const BrdfMap& map, const std::filesystem::path& target, Precision precision, Overwrite overwrite) {
  const FitsPixels pixels = precision == Precision::kDouble ? FitsPixels::kDouble : FitsPixels::kFloat;
  const SampleView view = sample_view(map.instrument, map.pose);
  const std::optional<TanWcs> wcs = wcs_of(map.instrument, view);
  FitsWriter fits(target, overwrite);
  fits.image("BRDF", "sr-1", map.brdf_per_sr, pixels);
  write_wcs(fits, wcs);
  write_primary_header(fits, map, view);
  write_uncertainties(fits, map, wcs);
  write_mask(fits, map.mask, wcs);
  write_parts(fits, map);
  write_angle_images(fits, map.angles, false);
  if (!map.u_random_per_sr.empty()) write_angle_uncertainty(fits, map.instrument, map.pose, map.angles.mask);
  write_common(fits, map.scale);
  write_correlation(fits, map.scale);
  write_frames(fits, map);
  write_instrument(fits, map.instrument);
  fits.commit();
}

void write_angles_fits(const AngleMap& angles, const Instrument& instrument, const Pose& pose,
                       const Provenance& provenance, const std::filesystem::path& target, Overwrite overwrite,
                       const std::optional<AngleMethodNote>& method) {
  const SampleView view = sample_view(instrument, pose);
  const std::optional<TanWcs> wcs = wcs_of(instrument, view);
  const bool single = method && method->precision == Precision::kSingle;
  const FitsPixels pixels = single ? FitsPixels::kFloat : FitsPixels::kDouble;
  FitsWriter fits(target, overwrite);
  fits.image("THETA_S_DEG", "deg", angles.theta_s_rad, pixels, kDegPerRad);
  write_wcs(fits, wcs);
  write_pose(fits, view, pose, 0);
  write_lens(fits, instrument);
  write_method(fits, method);
  write_provenance(fits, provenance);
  write_inputs(fits, provenance);
  write_angle_images(fits, angles, true, pixels);
  write_angle_uncertainty(fits, instrument, pose, angles.mask);
  write_mask(fits, angles.mask, wcs);
  write_instrument(fits, instrument);
  fits.commit();
}

void write_residual_fits(const Comparison& comparison, const BrdfMap& like, const Provenance& provenance,
                         const std::filesystem::path& target, Overwrite overwrite) {
  const SampleView view = sample_view(like.instrument, like.pose);
  const std::optional<TanWcs> wcs = wcs_of(like.instrument, view);
  FitsWriter fits(target, overwrite);
  const auto finish = [&] {
    write_wcs(fits, wcs);
    write_provenance(fits, provenance);
    write_inputs(fits, provenance);
  };
  if (comparison.residual) {
    fits.image("RESIDUAL", "1", comparison.residual->normalised);
    finish();
  }
  fits.image("LOG10_RATIO", "1", comparison.log10_ratio);
  finish();
  fits.commit();
}

}  // namespace scatmap
