#pragma once
#include "cli/bad_input.h"

namespace scatmap::test {

inline std::vector<BadInput> bad_usage() {
  const std::vector<std::string> pose{"--stage-deg", "20", "--arm-deg", "40"};
  return {
      {"usage: no verb", {}, nothing(), 2, {"--help"}},
      {"usage: unknown verb", {"brdff", "measurement.toml"}, nothing(), 2, {"brdff"}},
      {"usage: unknown option before the verb",
       {"--fast", "brdf", "measurement.toml", "-o", "out.fits"},
       nothing(),
       2,
       {"--fast"}},
      {"usage: unknown option", {"brdf", "measurement.toml", "-o", "out.fits", "--fast"}, nothing(), 2, {"--fast"}},
      {"usage: option with a line break",
       {"brdf", "measurement.toml", "-o", "out.fits", "--fa\nst"},
       nothing(),
       2,
       {"--fa"}},
      {"usage: no output", {"brdf", "measurement.toml"}, nothing(), 2, {"--output"}},
      {"usage: output without a name", {"brdf", "measurement.toml", "-o"}, nothing(), 2, {"--output"}},
      {"usage: no measurement", {"brdf", "-o", "out.fits"}, nothing(), 2, {"measurement"}},
      {"usage: one file too many",
       {"brdf", "measurement.toml", "second.toml", "-o", "out.fits"},
       nothing(),
       2,
       {"second.toml"}},
      {"usage: precision triple",
       {"brdf", "measurement.toml", "-o", "out.fits", "--precision", "triple"},
       nothing(),
       2,
       {"--precision", "triple"}},
      {"usage: no scene", {"simulate", "-o", "out"}, nothing(), 2, {"scene"}},
      {"usage: two folders", {"simulate", "scene.toml", "-o", "out", "out2"}, nothing(), 2, {"out2"}},
      {"usage: no stage angle",
       {"angles", "instrument.toml", "--arm-deg", "40", "-o", "out.fits"},
       nothing(),
       2,
       {"--stage-deg"}},
      {"usage: stage angle without a number",
       {"angles", "instrument.toml", "--arm-deg", "40", "-o", "out.fits", "--stage-deg"},
       nothing(),
       2,
       {"--stage-deg"}},
      {"usage: no instrument",
       {"angles", "--stage-deg", "20", "--arm-deg", "40", "-o", "out.fits"},
       nothing(),
       2,
       {"instrument"}},
      {"usage: no map to be like", {"model", "model.toml", "-o", "out.fits"}, nothing(), 2, {"--like"}},
      {"usage: unknown method of the model",
       {"model", "model.toml", "--like", "maps/angles.fits", "-o", "out.fits", "--method", "fastest"},
       nothing(),
       2,
       {"--method", "fastest"}},
      {"usage: tolerance not a number",
       {"model", "model.toml", "--like", "maps/angles.fits", "-o", "out.fits", "--tolerance-rel", "nan"},
       nothing(),
       2,
       {"--tolerance-rel", "nan"}},
      {"usage: tolerance zero",
       {"model", "model.toml", "--like", "maps/angles.fits", "-o", "out.fits", "--tolerance-rel", "0"},
       nothing(),
       2,
       {"--tolerance-rel"}},
      {"usage: tolerance finer than tiles keep",
       {"model", "model.toml", "--like", "maps/angles.fits", "-o", "out.fits", "--method", "culled", "--tolerance-rel",
        "1e-13"},
       nothing(),
       1,
       {"--tolerance-rel"}},
      {"usage: pixel averages by a method",
       {"model", "model.toml", "--like", "maps/angles.fits", "-o", "out.fits", "--pixel-average", "--method", "exact"},
       nothing(),
       2,
       {"--pixel-average"}},
      {"usage: force with a value",
       {"model", "model.toml", "--like", "maps/angles.fits", "-o", "out.fits", "--force=perhaps"},
       nothing(),
       2,
       {"--force"}},
  };
}

/// Where the result shall go; `angles` stands for all verbs that write maps.
inline std::vector<BadInput> bad_outputs() {
  const auto to = [](std::vector<std::string> targets) {
    std::vector<std::string> run{"angles", "instrument.toml", "--stage-deg", "20", "--arm-deg", "40"};
    for (const std::string& target : targets) {
      if (!target.starts_with("--")) run.emplace_back("-o");
      run.push_back(target);
    }
    return run;
  };
  const std::vector<std::string> brdf{"brdf", "measurement.toml", "-o", "out.fits"};
  const std::vector<std::string> model{"model", "model.toml", "--like", "maps/angles.fits", "-o", "out.fits"};
  const Spoil old = write("out.fits", "an older result"), old_exr = write("out.exr", "an older result");
  const Spoil link = [](Lab& lab) { fs::create_symlink("elsewhere.fits", lab.path("out.fits")); };
  return {
      {"output: exists", to({"out.fits"}), old, 1, {"out.fits", "--force"}},
      {"output: EXR exists", to({"out.exr"}), old_exr, 1, {"out.exr", "--force"}},
      {"output: exists, brdf", brdf, old, 1, {"out.fits", "--force"}},
      {"output: exists, model", model, old, 1, {"out.fits", "--force"}},
      {"output: one of two exists", to({"out.fits", "out.exr"}), old_exr, 1, {"out.exr", "--force"}},
      {"output: is the input of --like",
       {"model", "model.toml", "--like", "maps/angles.fits", "-o", "maps/angles.fits"},
       nothing(),
       1,
       {"maps/angles.fits", "--force"}},
      {"output: a link to nowhere", to({"out.fits"}), link, 1, {"out.fits", "--force"}},
      {"output: is a folder", to({"out.fits"}), make_folder("out.fits"), 1, {"out.fits", "is a folder"}},
      {"output: is a folder, forced",
       to({"out.fits", "--force"}),
       make_folder("out.fits"),
       1,
       {"out.fits", "is a folder"}},
      {"output: ends in a slash", to({"out.fits/"}), nothing(), 1, {"out.fits/"}},
      {"output: in a missing folder", to({"nowhere/out.fits"}), nothing(), 1, {"nowhere/out.fits", "folder"}},
      {"output: in a file", to({"model.toml/out.fits"}), nothing(), 1, {"model.toml/out.fits", "folder"}},
      {"output: second in a missing folder", to({"out.fits", "nowhere/out.exr"}), nothing(), 1, {"nowhere/out.exr"}},
      {"output: unknown extension", to({"out.csv"}), nothing(), 1, {"out.csv", ".fits"}},
      {"output: no extension", to({"out"}), nothing(), 1, {"out", ".fits"}},
      {"output: only an extension", to({".fits"}), nothing(), 1, {".fits"}},
      {"output: read-only folder",
       to({"locked/out.fits"}),
       all({make_folder("locked"), read_only("locked")}),
       1,
       {"locked/out.fits", "folder"},
       true},
      {"output: compressed", to({"out.fits.gz"}), nothing(), 1, {"out.fits.gz", ".fits"}},
      {"output: no name", to({""}), nothing(), 1, {"output"}},
      {"output: name too long", to({std::string(300, 'a') + ".fits"}), nothing(), 1, {"aaa.fits"}},
      {"output: one name twice", to({"out.fits", "out.fits"}), nothing(), 1, {"out.fits"}},
      {"output: one file by two names", to({"out.fits", "./out.fits"}), nothing(), 1, {"out.fits"}},
      {"output: one name twice, forced", to({"out.fits", "out.fits", "--force"}), nothing(), 1, {"out.fits"}},
  };
}

/// `compare MEASURED MODELLED -o DIR`
inline std::vector<BadInput> bad_comparisons() {
  const std::string measured = "maps/measured.fits", modelled = "maps/modelled.fits";
  const std::vector<std::string> run{"compare", measured, modelled, "-o", "out"};
  return {
      {"compare: no output", {"compare", measured, modelled}, nothing(), 2, {"--output"}},
      {"compare: no modelled map", {"compare", measured, "-o", "out"}, nothing(), 2, {"modelled"}},
      {"compare: measured map missing", run, erase(measured), 1, {measured, "exist"}},
      {"compare: modelled map missing", run, erase(modelled), 1, {modelled, "exist"}},
      {"compare: measured is text", run, copy("model.toml", measured), 1, {measured, "FITS"}},
      {"compare: measured is a raw frame", run, copy("frames/exposure1_001.fits", measured), 1, {measured, "no map"}},
      {"compare: modelled is an angle file", run, copy("maps/angles.fits", modelled), 1, {modelled, "BRDF"}},
      {"compare: modelled contradicts its instrument",
       run,
       overwrite_bytes(modelled, "columns = 64", "columns = 63"),
       1,
       {modelled, "63 x 64"}},
      {"compare: map without a mask",
       run,
       overwrite_bytes(measured, "'MASK    '", "'MUSK    '"),
       1,
       {measured, "MASK"}},
      {"compare: unknown picture format",
       {"compare", measured, modelled, "-o", "out", "--pictures", "bmp"},
       nothing(),
       2,
       {"--pictures", "bmp"}},
      {"compare: measured truncated", run, cut(measured, 20000), 1, {measured, "truncated"}},
      {"compare: other poses", run, card(modelled, "STAGERAD", "0.4"), 1, {modelled}},
      {"compare: into a used folder", run, all({make_folder("out"), write("out/notes.txt", "mine")}), 1, {"out"}},
      {"compare: into a file", run, write("out", "mine"), 1, {"out", "not a folder"}},
      {"compare: into a missing folder",
       {"compare", measured, modelled, "-o", "nowhere/out"},
       nothing(),
       1,
       {"nowhere/out"}},
  };
}

}  // namespace scatmap::test
