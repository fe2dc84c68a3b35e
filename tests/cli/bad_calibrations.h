#pragma once
#include "cli/bad_input.h"

namespace scatmap::test {

/// Targets that determine a calibration.
inline constexpr const char* kTargets = R"(kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px
direct,0,180,0,31.5,31.5,0.02
direct,0,179.5,0,18.15,31.5,0.02
specular,10,20,0,31.5,31.5,0.02
specular,20,40,0,31.5,31.5,0.02
specular,30,60,0,31.5,31.5,0.02
specular,30,60.5,0,44.9,31.5,0.02
)";

/// `calibrate targets.csv --instrument instrument.toml -o out.toml`
inline std::vector<BadInput> bad_calibrations() {
  const std::string file = "targets.csv";
  const std::vector<std::string> run{"calibrate", file, "--instrument", "instrument.toml", "-o", "out.toml"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), run.begin(), run.end());
    return more;
  };
  const Spoil good = write(file, kTargets);
  const auto edited = [&](const char* name, const std::string& from, const std::string& to,
                          std::vector<std::string> says) {
    return BadInput{name, run, all({good, replace(file, from, to)}), 1, std::move(says)};
  };
  const std::string header = "kind,stage_deg,arm_deg,tilt_deg,column_px,row_px,sigma_px\n", here = file + ":%: ";
  return {
      {"calibrate: no targets", run, nothing(), 1, {file, "no such file"}},
      {"calibrate: empty file", run, write(file, ""), 1, {file, "is empty"}},
      {"calibrate: only a header", run, write(file, header), 1, {file, "lists no target"}},
      {"calibrate: a folder", run, make_folder(file), 1, {file, "not a regular file"}},
      {"calibrate: a frame", run, copy("frames/signature_001.fits", file), 1, {file + ":1"}},
      edited("calibrate: unknown column", "sigma_px\n", "sigma\n", {file + ":1", "'sigma'"}),
      edited("calibrate: column twice", "row_px,sigma_px\n", "row_px,row_px\n", {file + ":1", "twice", "row_px"}),
      edited("calibrate: column missing", ",sigma_px\n", "\n", {file + ":1", "sigma_px"}),
      edited("calibrate: unknown kind", "direct,0,180,", "diffuse,0,180,", {here + "kind", "diffuse"}),
      edited("calibrate: field missing", "direct,0,180,0,", "direct,0,180,", {file + ":%", "fields", "6"}),
      edited("calibrate: field too many", "direct,0,180,0,", "direct,0,180,0,0,", {file + ":%", "fields", "8"}),
      edited("calibrate: no number", "specular,10,", "specular,ten,", {here + "stage_deg", "'ten'"}),
      edited("calibrate: empty number", "specular,10,", "specular,,", {here + "stage_deg", "''"}),
      edited("calibrate: number with unit", "specular,10,", "specular,10deg,", {here + "stage_deg", "10deg"}),
      edited("calibrate: NaN", "specular,10,", "specular,nan,", {here + "stage_deg", "nan"}),
      edited("calibrate: infinity", "specular,10,", "specular,inf,", {here + "stage_deg", "inf"}),
      edited("calibrate: angle beyond a turn", "specular,10,", "specular,361,", {here + "stage_deg", "361"}),
      edited("calibrate: spot far away", "31.5,31.5", "1e9,31.5", {here + "column_px", "1e9"}),
      edited("calibrate: sigma zero", "31.5,0.02", "31.5,0", {here + "sigma_px"}),
      edited("calibrate: sigma negative", "31.5,0.02", "31.5,-1", {here + "sigma_px"}),
      edited("calibrate: tilted direct beam", "direct,0,180,0,", "direct,0,180,2,", {here + "tilt_deg", "direct"}),
      edited("calibrate: quotation mark", "direct,0", "\"direct\",0", {file + ":%", "quotation"}),
      {"calibrate: free parameter that one target cannot tell",
       with({"--free", "detector.distance_mm", "--free", "detector.offset_mm.0", "--free", "detector.offset_mm.1"}),
       write(file, header + "direct,0,180,0,31.5,31.5,0.02\n"),
       1,
       {"detector.distance_mm"}},
      {"calibrate: tolerance NaN", with({"--tolerance-px", "nan"}), good, 2, {"--tolerance-px"}},
      {"calibrate: instrument missing", run, all({good, erase("instrument.toml")}), 1, {"instrument.toml", "no such"}},
      {"calibrate: instrument wrong",
       run,
       all({good, replace("instrument.toml", "distance_mm = 325", "distance_mm = -325")}),
       1,
       {"instrument.toml:%: detector.distance_mm"}},
      {"calibrate: no instrument", {"calibrate", file, "-o", "out.toml"}, good, 2, {"--instrument"}},
      {"calibrate: free parameter unknown",
       with({"--free", "detector.mass_kg"}),
       good,
       1,
       {"--free", "detector.mass_kg"}},
      {"calibrate: fixed parameter unknown", with({"--fix", "nothing"}), good, 1, {"--fix", "nothing"}},
      {"calibrate: free and fixed",
       with({"--free", "detector.distance_mm", "--fix", "detector.distance_mm"}),
       good,
       2,
       {"detector.distance_mm", "second"}},
      {"calibrate: fixed and known",
       with({"--fix", "arm.zero_deg", "--prior", "arm.zero_deg=1"}),
       good,
       2,
       {"--prior", "arm.zero_deg", "second"}},
      {"calibrate: prior without a number", with({"--prior", "arm.zero_deg"}), good, 2, {"--prior", "arm.zero_deg"}},
      {"calibrate: prior of no width", with({"--prior", "arm.zero_deg=0"}), good, 1, {"--prior", "arm.zero_deg"}},
      {"calibrate: prior NaN", with({"--prior", "arm.zero_deg=nan"}), good, 1, {"--prior", "arm.zero_deg"}},
      {"calibrate: tolerance negative", with({"--tolerance-px", "-1"}), good, 2, {"--tolerance-px"}},
      {"calibrate: rejects everything", with({"--reject-sigma", "0"}), good, 2, {"--reject-sigma"}},
      {"calibrate: output exists", run, all({good, write("out.toml", "old")}), 1, {"out.toml", "--force"}},
      {"calibrate: output is the nominal",
       {"calibrate", file, "--instrument", "instrument.toml", "-o", "instrument.toml"},
       good,
       1,
       {"instrument.toml", "--force"}},
      {"calibrate: output a map",
       {"calibrate", file, "--instrument", "instrument.toml", "-o", "out.fits"},
       good,
       1,
       {"out.fits", ".toml"}},
  };
}

}  // namespace scatmap::test
