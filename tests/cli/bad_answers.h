#pragma once
#include "cli/bad_input.h"

namespace scatmap::test {

/// `uncertainty MAP …`
inline std::vector<BadInput> bad_uncertainties() {
  const std::string map = "maps/measured.fits";
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"uncertainty", map});
    return more;
  };
  const std::vector<std::string> run = with({"--pixel", "20,30"});
  return {
      {"uncertainty: of nothing", with({}), nothing(), 2, {"--pixel"}},
      {"uncertainty: of two things", with({"--pixel", "20,30", "--map"}), nothing(), 2, {"--pixel"}},
      {"uncertainty: map missing", run, erase(map), 1, {map, "exist"}},
      {"uncertainty: map empty", run, write(map, ""), 1, {map, "empty"}},
      {"uncertainty: map cut", run, cut(map, 20000), 1, {map, "truncated"}},
      {"uncertainty: a text file", run, copy("model.toml", map), 1, {map, "FITS"}},
      {"uncertainty: a raw frame", run, copy("frames/exposure1_001.fits", map), 1, {map, "no map"}},
      {"uncertainty: an angle file", run, copy("maps/angles.fits", map), 1, {map}},
      {"uncertainty: a modelled map", run, copy("maps/modelled.fits", map), 1, {map, "uncertain"}},
      {"uncertainty: pixel outside", with({"--pixel", "64,30"}), nothing(), 1, {"pixel", "64,30", "0,0,63,63"}},
      {"uncertainty: pixel negative", with({"--pixel", "-1,30"}), nothing(), 1, {"-1"}},
      {"uncertainty: pixel of one number", with({"--pixel", "20"}), nothing(), 2, {"--pixel"}},
      {"uncertainty: pixel between pixels", with({"--pixel", "20.5,30"}), nothing(), 2, {"20.5"}},
      {"uncertainty: pixel of words", with({"--pixel", "a,b"}), nothing(), 2, {"--pixel"}},
      {"uncertainty: region outside", with({"--region", "10,10,20,99"}), nothing(), 1, {"99"}},
      {"uncertainty: region inside out", with({"--region", "20,20,10,10"}), nothing(), 1, {"region", "swapped"}},
      {"uncertainty: region of three numbers", with({"--region", "1,2,3"}), nothing(), 2, {"--region"}},
      {"uncertainty: second of three numbers", with({"--pixel", "20,30", "--and", "1,2,3"}), nothing(), 2, {"--and"}},
      {"uncertainty: second outside", with({"--pixel", "20,30", "--and", "64,2"}), nothing(), 1, {"64"}},
      {"uncertainty: target zero",
       with({"--pixel", "20,30", "--target-percent", "0"}),
       nothing(),
       2,
       {"--target-percent"}},
      {"uncertainty: digits", with({"--pixel", "20,30", "--digits", "3"}), nothing(), 2, {"--digits"}},
      {"uncertainty: correlation of no cause", run, overwrite_bytes(map, "'MASK    '", "'MUSK    '"), 1, {map, "MASK"}},
  };
}

/// `chart JOB -o DIR`
inline std::vector<BadInput> bad_charts() {
  const std::vector<std::string> run{"chart", "angles", "--seconds", "0.01", "-o", "out"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), run.begin(), run.end());
    return more;
  };
  return {
      {"chart: no job", {"chart", "-o", "out"}, nothing(), 2, {"job"}},
      {"chart: unknown job", {"chart", "weather", "-o", "out"}, nothing(), 2, {"weather"}},
      {"chart: no output", {"chart", "angles"}, nothing(), 2, {"--output"}},
      {"chart: no time", {"chart", "angles", "--seconds", "0", "-o", "out"}, nothing(), 2, {"--seconds"}},
      {"chart: time NaN", {"chart", "angles", "--seconds", "nan", "-o", "out"}, nothing(), 2, {"--seconds"}},
      {"chart: scene missing", with({"--scene", "nowhere.toml"}), nothing(), 1, {"nowhere.toml", "no such file"}},
      {"chart: scene is no measurement", with({"--scene", "model.toml"}), nothing(), 1, {"model.toml", "instrument"}},
      {"chart: scene of bounds",
       {"chart", "bounds", "--scene", "measurement.toml", "-o", "out"},
       nothing(),
       2,
       {"--scene", "not used"}},
      {"chart: model of stability",
       {"chart", "stability", "--model", "model.toml", "-o", "out"},
       nothing(),
       2,
       {"--model", "not used"}},
      {"chart: model missing", with({"--model", "nowhere.toml"}), nothing(), 1, {"nowhere.toml", "no such file"}},
      {"chart: model is no model", with({"--model", "instrument.toml"}), nothing(), 1, {"instrument.toml"}},
      {"chart: into a used folder", run, all({make_folder("out"), write("out/notes.txt", "mine")}), 1, {"out"}},
      {"chart: into a used folder, forced",
       with({"--force"}),
       all({make_folder("out"), write("out/notes.txt", "mine")}),
       1,
       {"out", "charts.csv"}},
      {"chart: into a file", run, write("out", "mine"), 1, {"out", "not a folder"}},
      {"chart: into a missing folder",
       {"chart", "angles", "--seconds", "0.01", "-o", "nowhere/out"},
       nothing(),
       1,
       {"nowhere/out"}},
  };
}

}  // namespace scatmap::test
