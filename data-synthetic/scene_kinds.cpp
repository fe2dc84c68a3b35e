#include <algorithm>
#include <map>

#include "data-synthetic/scene_tables.h"
#include "scatmap/base/error.h"

namespace scatmap::synth {
namespace {

constexpr int kMostFrames = 10000;
constexpr NumberRange kCommandedDeg{-360, 360};

// A beam along the surface has no spot.
void require_lit_front(const TomlTable& root, const Bench& bench, const BrdfScene& scene) {
  constexpr long double kGrazing_deg = 89.999L;
  const long double incidence_deg = TruthGeometry(bench, scene.stage_deg, scene.arm_deg).incidence_rad() * 180 / kPi;
  if (incidence_deg <= kGrazing_deg) return;
  throw Error({root.where("stage_deg"),
               "leaves the front of the sample out of the beam",
               {},
               "an angle of incidence below 89.999 degrees"});
}

NdFilter read_filter(const TomlTable& t, const std::string& name) {
  NdFilter out;
  out.name = name;
  out.od = t.number("od", kNotNegative);
  out.true_od = t.number_or("true_od", out.od, kNotNegative);
  for (const char* key : {"tolerance_percent", "tolerance_od", "u_od"}) {
    const auto value = t.optional_number(key, kNotNegative);
    if (!value) continue;
    if (!out.tolerance_key.empty())
      throw Error({t.where(key), "is a second tolerance of one filter", {}, out.tolerance_key});
    out.tolerance_key = key;
    out.tolerance = *value;
  }
  if (out.tolerance_key.empty()) {
    throw Error({t.where("tolerance_percent"), "is missing", {}, "tolerance_percent, tolerance_od or u_od"});
  }
  return out;
}

FrameStack read_stack(const TomlTable& t, const std::vector<NdFilter>& filters) {
  FrameStack out;
  out.exposure_s = t.number("exposure_s", kPositive);
  out.true_exposure_s = t.number_or("true_exposure_s", out.exposure_s, kPositive);
  out.frames = t.integer("frames", 1, kMostFrames);
  out.darks = t.integer("darks", 1, kMostFrames);
  out.filters = t.strings_or_empty("filters");
  out.u_exposure_percent = t.optional_number("u_exposure_percent", kNotNegative);
  for (const std::string& name : out.filters) {
    const bool known = std::any_of(filters.begin(), filters.end(), [&](const NdFilter& f) { return f.name == name; });
    if (!known)
      throw Error({t.where("filters"), "names an unknown filter", "\"" + name + "\"", "a [filters.NAME] of this file"});
    if (std::count(out.filters.begin(), out.filters.end(), name) > 1) {
      throw Error({t.where("filters"), "names one filter twice", "\"" + name + "\"", {}});
    }
  }
  return out;
}

Term read_term(const TomlTable& t) {
  static const std::map<std::string, TermKind> kinds{
      {"microfacet", TermKind::kMicrofacet}, {"stripes", TermKind::kStripes}, {"lambertian", TermKind::kLambertian}};
  Term out;
  const std::string kind = t.string("kind");
  const auto found = kinds.find(kind);
  if (found == kinds.end())
    throw Error({t.where("kind"), "is not known", "\"" + kind + "\"", "microfacet, stripes or lambertian"});
  out.kind = found->second;
  out.rho = t.number("rho", kNotNegative);
  if (out.kind == TermKind::kMicrofacet) {
    out.m = t.number("m", kPositive);
    const auto n = t.numbers("n", 2, kNotNegative);
    out.n_re = n[0];
    out.n_im = n[1];
    out.dtheta_deg = t.number_or("dtheta_deg", 0);
    out.dphi_deg = t.number_or("dphi_deg", 0);
  } else if (out.kind == TermKind::kStripes) {
    out.a_um = t.number("a_um", kPositive);
    out.b_um = t.number("b_um", kPositive);
    out.c_um = t.number("c_um", kPositive);
    out.grating = t.choice("form", {"paper", "grating"}) == "grating";
  }
  return out;
}

ModelTruth read_model(const TomlTable& root, double wavelength_nm, double distance_mm) {
  ModelTruth out;
  out.wavelength_nm = wavelength_nm;
  out.distance_mm = distance_mm;
  out.phi_ref_deg = root.number_or("phi_ref_deg", 0);
  const std::string polarization = root.choice("polarization", {"unpolarized", "s", "p"});
  if (polarization != "unpolarized") out.polarization = polarization == "s" ? Polarization::kS : Polarization::kP;
  for (const TomlTable& t : root.tables("term")) out.terms.push_back(read_term(t));
  return out;
}

LaserTruth read_laser(const TomlTable& t) {
  LaserTruth out;
  out.electrons_per_s = t.number("electrons_per_s", kNotNegative);
  out.drift_percent = t.number_or("drift_percent", 0, {-100, 1000, false});
  out.drift_tolerance_percent = t.number_or("drift_tolerance_percent", 0, kNotNegative);
  return out;
}

std::vector<MirrorMount> read_mounts(const TomlTable& root, const Bench& bench) {
  std::vector<MirrorMount> out;
  for (const TomlTable& t : root.tables("mount")) {
    MirrorMount mount{t.string("name"), t.number_or("tilt_deg", 0), t.number_or("height_mm", 0)};
    const bool taken = std::any_of(out.begin(), out.end(), [&](const MirrorMount& m) { return m.name == mount.name; });
    if (taken || mount.name.find_first_of(",\"\n") != std::string::npos) {
      throw Error({t.where("name"), "is not a name of its own", mount.name, "a unique name without comma or quote"});
    }
    out.push_back(std::move(mount));
  }
  if (out.empty()) out.push_back({"mirror", bench.sample_tilt_deg, bench.sample_height_mm});
  return out;
}

// Every combination of the grid's lists, stage outermost.
void add_grid(const TomlTable& t, const std::vector<MirrorMount>& mounts, std::vector<MirrorTarget>& out) {
  const std::string name = t.optional_string("mount").value_or(mounts.front().name);
  const auto found = std::find_if(mounts.begin(), mounts.end(), [&](const MirrorMount& m) { return m.name == name; });
  if (found == mounts.end()) throw Error({t.where("mount"), "names no [[mount]] of this file", "\"" + name + "\"", {}});
  const auto mount = static_cast<std::size_t>(found - mounts.begin());
  const auto offsets_deg = t.numbers("arm_offset_deg", 0), tilts_deg = t.numbers("tilt_deg", 0);
  for (const double stage_deg : t.numbers("stage_deg", 0)) {
    for (const double offset_deg : offsets_deg) {
      for (const double tilt_deg : tilts_deg)
        out.push_back({false, mount, stage_deg, 2 * stage_deg + offset_deg, tilt_deg});
    }
  }
}

}  // namespace

BrdfScene read_brdf_scene(const TomlTable& root, const Bench& bench, double wavelength_nm) {
  BrdfScene out;
  out.stage_deg = root.number("stage_deg", kCommandedDeg);
  out.arm_deg = root.number("arm_deg", kCommandedDeg);
  require_lit_front(root, bench, out);
  out.laser = read_laser(root.table("laser"));
  const TomlTable filters = table_or_empty(root, "filters");
  for (const std::string& name : filters.table_names()) out.filters.push_back(read_filter(filters.table(name), name));
  const TomlTable signature = root.table("signature");
  for (const TomlTable& t : signature.tables("exposure")) out.signatures.push_back(read_stack(t, out.filters));
  if (out.signatures.empty()) out.signatures.push_back(read_stack(signature, out.filters));
  out.signature_arm_deg = signature.number_or("arm_deg", 180, kCommandedDeg);
  for (const TomlTable& t : root.tables("exposure")) out.exposures.push_back(read_stack(t, out.filters));
  if (out.exposures.empty()) throw Error({root.where("exposure"), "is missing", {}, "one or more tables [[exposure]]"});
  out.model = read_model(root, wavelength_nm, bench.distance_mm);
  return out;
}

MirrorScene read_mirror_scene(const TomlTable& root, const Bench& bench) {
  MirrorScene out;
  const TomlTable t = root.table("targets");
  out.sigma_px = t.number("sigma_px", kPositive);
  out.write_frames = t.boolean_or("write_frames", false);
  out.spot_e = t.number_or("spot_e", out.spot_e, kNotNegative);
  out.exposure_s = t.number_or("exposure_s", out.exposure_s, kPositive);
  out.mounts = read_mounts(root, bench);
  for (const TomlTable& grid : t.tables("grid")) add_grid(grid, out.mounts, out.targets);
  if (t.has("direct_arm_deg")) {
    for (const double arm_deg : t.numbers("direct_arm_deg", 0)) out.targets.push_back({true, 0, 0, arm_deg, 0});
  }
  if (out.targets.empty())
    throw Error({t.where("grid"), "is missing", {}, "tables [[targets.grid]] or direct_arm_deg"});
  return out;
}

FlatScene read_flat_scene(const TomlTable& root) {
  FlatScene out;
  const TomlTable t = root.table("flats");
  out.exposure_s = t.numbers("exposure_s", 0, kPositive);
  if (out.exposure_s.empty()) throw Error({t.where("exposure_s"), "is empty", {}, "one exposure time or more, s"});
  out.frames = t.integer("frames", 1, kMostFrames);
  out.darks = t.integer("darks", 1, kMostFrames);
  out.electrons_per_s = t.number("electrons_per_s", kNotNegative);
  out.falloff_percent = t.number_or("falloff_percent", out.falloff_percent, {0, 100, true});
  out.prnu_percent = t.number_or("prnu_percent", out.prnu_percent, {0, 10, true});
  return out;
}

}  // namespace scatmap::synth
