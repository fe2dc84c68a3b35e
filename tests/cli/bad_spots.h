#pragma once
#include "cli/bad_input.h"

namespace scatmap::test {

/// `spots FRAME… -o out.csv` and `sensor FLAT… --darks DARK… -o out.toml`
inline std::vector<BadInput> bad_spots() {
  const std::string frame = "frames/signature_001.fits", dark = "frames/signature_dark_001.fits";
  const std::vector<std::string> run{"spots",           frame,    "--darks", dark,          "--instrument",
                                     "instrument.toml", "--kind", "direct",  "--stage-deg", "0",
                                     "--arm-deg",       "180",    "-o",      "out.csv"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), run.begin(), run.end());
    return more;
  };
  const std::vector<std::string> listed{"spots",    frame,        "--instrument", "instrument.toml",
                                        "--angles", "angles.csv", "-o",           "out.csv"};
  const auto angles = [&](const char* name, const std::string& text, std::vector<std::string> says) {
    return BadInput{name, listed, write("angles.csv", text), 1, std::move(says)};
  };
  const auto everywhere = [](std::size_t, std::size_t) { return true; };
  return {
      {"spots: no frame", {"spots", "-o", "out.csv"}, nothing(), 2, {"frames"}},
      {"spots: frame missing", run, erase(frame), 1, {frame, "does not exist"}},
      {"spots: frame empty", run, write(frame, ""), 1, {frame, "is empty"}},
      {"spots: frame cut", run, cut(frame, 5000), 1, {frame, "truncated"}},
      {"spots: frame tile-compressed", run, tile_compress(frame), 1, {frame, "tile-compressed"}},
      {"spots: dark missing", run, erase(dark), 1, {dark, "does not exist"}},
      {"spots: dark of another size", run, card(dark, "NAXIS2", "32"), 1, {dark, "64"}},
      {"spots: dark of another time", run, card(dark, "EXPTIME", "0.5"), 1, {dark + ": EXPTIME", frame}},
      {"spots: frame of another size",
       run,
       all({card(frame, "NAXIS2", "32"), card(dark, "NAXIS2", "32")}),
       1,
       {frame, "64 x 32"}},
      {"spots: black frame", run, pixels(frame, 0, everywhere), 1, {frame}},
      {"spots: white frame", run, pixels(frame, 65535, everywhere), 1, {frame}},
      {"spots: only the dark", run, copy(dark, frame), 1, {frame, "no spot"}},
      {"spots: instrument missing", run, erase("instrument.toml"), 1, {"instrument.toml", "no such file"}},
      {"spots: gain unknown",
       {"spots", frame, "--kind", "direct", "--stage-deg", "0", "--arm-deg", "180", "-o", "out.csv"},
       card(frame, "EGAIN", "0"),
       1,
       {frame, "EGAIN"}},
      {"spots: read noise unknown",
       {"spots", frame, "--kind", "direct", "--stage-deg", "0", "--arm-deg", "180", "-o", "out.csv"},
       nothing(),
       1,
       {frame, "--read-noise-e"}},
      {"spots: gain zero", with({"--gain-e-per-dn", "0"}), nothing(), 2, {"--gain-e-per-dn", "must be a number > 0"}},
      {"spots: gain NaN", with({"--gain-e-per-dn", "nan"}), nothing(), 2, {"--gain-e-per-dn"}},
      {"spots: angle NaN", with({"--tilt-deg", "nan"}), nothing(), 2, {"--tilt-deg", "nan"}},
      {"spots: arm NaN",
       {"spots", frame, "--instrument", "instrument.toml", "--arm-deg", "nan", "-o", "out.csv"},
       nothing(),
       2,
       {"--arm-deg", "nan"}},
      {"spots: read noise negative",
       with({"--read-noise-e", "-1"}),
       nothing(),
       2,
       {"--read-noise-e", "must be a number >= 0"}},
      {"spots: saturation infinite", with({"--saturation-dn", "inf"}), nothing(), 2, {"--saturation-dn"}},
      {"spots: unknown method", with({"--method", "guess"}), nothing(), 2, {"--method", "guess"}},
      {"spots: one angle for two frames",
       {"spots", frame, "frames/signature_002.fits", "--instrument", "instrument.toml", "--arm-deg", "180", "-o",
        "out.csv"},
       nothing(),
       1,
       {"--arm-deg", "2 frames"}},
      {"spots: angles missing", listed, nothing(), 1, {"angles.csv", "no such file"}},
      angles("spots: angles empty", "", {"angles.csv"}),
      {"spots: neither angles nor header state the pose",
       listed,
       all({write("angles.csv", "file,stage_deg,arm_deg\nother.fits,1,2\n"),
            overwrite_bytes(frame, "ARMDEG  =", "ARMDEGX =")}),
       1,
       {frame, "arm angle"}},
      {"spots: a map as frame", run, copy("maps/measured.fits", frame), 1, {frame, "BRDF map"}},
      {"spots: an angle file as frame", run, copy("maps/angles.fits", frame), 1, {frame, "says a map"}},
      {"spots: a frame twice",
       {"spots", frame, "frames/../" + frame, "--instrument", "instrument.toml", "-o", "out.csv"},
       nothing(),
       1,
       {"frames/../" + frame, "twice"}},
      {"spots: a frame as its own dark",
       {"spots", frame, "--darks", frame, "--instrument", "instrument.toml", "-o", "out.csv"},
       nothing(),
       1,
       {frame, "twice"}},
      {"spots: a light frame as dark", run, copy("frames/signature_002.fits", dark), 1, {dark + ": IMAGETYP", "dark"}},
      angles("spots: angles without files", "stage_deg,arm_deg\n1,2\n", {"angles.csv:1", "file"}),
      angles("spots: angles with an unknown column", "file,phase_deg\n" + frame + ",1\n",
             {"angles.csv:1", "phase_deg"}),
      angles("spots: angle that is none", "file,stage_deg\n" + frame + ",north\n", {"angles.csv:2", "north"}),
      angles("spots: listed angle NaN", "file,stage_deg\n" + frame + ",nan\n", {"angles.csv:2", "nan"}),
      angles("spots: frame listed twice", "file,stage_deg\n" + frame + ",1\n" + frame + ",2\n", {frame, "angles.csv"}),
      {"spots: output exists", run, write("out.csv", "old"), 1, {"out.csv", "--force"}},
      {"spots: mount with a comma",
       {"spots", frame, "--instrument", "instrument.toml", "--stage-deg", "20", "--arm-deg", "40", "--mount", "a,b",
        "-o", "out.csv"},
       nothing(),
       2,
       {"--mount", "'a,b'"}},
      {"spots: one line for two frames of one name",
       {"spots", frame, "again/signature_001.fits", "--angles", "angles.csv", "--instrument", "instrument.toml", "-o",
        "out.csv"},
       all({make_folder("again"), copy("frames/signature_002.fits", "again/signature_001.fits"),
            write("angles.csv", "file,stage_deg,arm_deg\n" + frame + ",20,40\n")}),
       1,
       {"angles.csv", frame, "again/signature_001.fits"}},
      {"spots: output a map", {"spots", frame, "-o", "out.fits"}, nothing(), 1, {"out.fits", ".csv"}},
  };
}

inline std::vector<BadInput> bad_sensors() {
  const std::string flat = "frames/exposure1_001.fits", flat2 = "frames/exposure1_002.fits";
  const std::string dark = "frames/exposure1_dark_001.fits", dark2 = "frames/exposure1_dark_002.fits";
  const auto run = [&](std::vector<std::string> flats, std::vector<std::string> darks) {
    std::vector<std::string> out{"sensor"};
    out.insert(out.end(), flats.begin(), flats.end());
    out.emplace_back("--darks");
    out.insert(out.end(), darks.begin(), darks.end());
    out.insert(out.end(), {"--instrument", "instrument.toml", "-o", "out.toml"});
    return out;
  };
  const std::vector<std::string> both = run({flat, flat2}, {dark, dark2});
  return {
      {"sensor: no darks",
       {"sensor", flat, "--instrument", "instrument.toml", "-o", "out.toml"},
       nothing(),
       2,
       {"--darks"}},
      {"sensor: no instrument", {"sensor", flat, "--darks", dark, "-o", "out.toml"}, nothing(), 2, {"--instrument"}},
      {"sensor: one exposure time", both, nothing(), 1, {"flats", "exposure time"}},
      {"sensor: one flat", run({flat}, {dark, dark2}), nothing(), 1, {"flats", "fewer than two"}},
      {"sensor: one dark", run({flat, flat2}, {dark}), nothing(), 1, {"darks", "fewer than two"}},
      {"sensor: no dark of that time",
       both,
       all({card(dark, "EXPTIME", "7."), card(dark2, "EXPTIME", "7.")}),
       1,
       {flat, "no dark"}},
      {"sensor: flat missing", both, erase(flat), 1, {flat, "does not exist"}},
      {"sensor: dark missing", both, erase(dark2), 1, {dark2, "does not exist"}},
      {"sensor: flat without exposure time",
       both,
       overwrite_bytes(flat, "EXPTIME =", "EXPTIMX ="),
       1,
       {flat, "EXPTIME"}},
      {"sensor: flat cut", both, cut(flat2, 5000), 1, {flat2, "truncated"}},
      {"sensor: dark of another size",
       run({flat, flat2, "frames/signature_001.fits", "frames/signature_002.fits"},
           {dark, dark2, "frames/signature_dark_001.fits", "frames/signature_dark_002.fits"}),
       card(dark2, "NAXIS2", "32"),
       1,
       {dark2, "64"}},
      {"sensor: instrument of another size",
       both,
       all({overwrite_bytes("instrument.toml", "columns = 64", "columns = 32"),
            overwrite_bytes("instrument.toml", "rows = 64", "rows = 32")}),
       1,
       {flat, "64 x 64", "32 x 32", "instrument.toml"}},
      {"sensor: a flat twice", run({flat, flat}, {dark, dark2}), nothing(), 1, {flat, "twice"}},
      {"sensor: instrument missing", both, erase("instrument.toml"), 1, {"instrument.toml"}},
      {"sensor: saturation negative",
       {"sensor", flat, "--darks", dark, "--instrument", "instrument.toml", "-o", "out.toml", "--saturation-dn", "-5"},
       nothing(),
       2,
       {"--saturation-dn"}},
      {"sensor: output exists", both, write("out.toml", "old"), 1, {"out.toml", "--force"}},
  };
}

}  // namespace scatmap::test
