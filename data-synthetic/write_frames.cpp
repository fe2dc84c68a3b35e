#include "data-synthetic/write_frames.h"

#include <array>
#include <cstdio>
#include <utility>

#include "data-synthetic/render.h"

namespace scatmap::synth {
namespace {

std::string numbered(const std::string& name, int number) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "_%03d", number);
  return name + text.data();
}

}  // namespace

std::vector<FitsCard> history_cards(const Provenance& provenance) {
  std::vector<std::string> lines{"Written by " + provenance.written_by, "Command: " + provenance.command_line};
  for (const InputRecord& input : provenance.inputs)
    lines.push_back("Input: " + input.path + " sha256 " + input.sha256);
  std::vector<FitsCard> cards;
  for (std::string& text : lines) {
    for (char& c : text) c = c < 0x20 || c > 0x7e ? '?' : c;
    cards.push_back({"HISTORY", text, {}});
  }
  return cards;
}

FrameWriter::FrameWriter(const Scene& scene, std::filesystem::path folder, const Provenance& provenance)
    : scene_(scene),
      folder_(std::move(folder)),
      provenance_(provenance),
      no_light_e_(scene.bench.rows, scene.bench.columns, 0) {
  std::filesystem::create_directory(folder_ / "frames");
}

std::string FrameWriter::write(const std::string& name, const std::string& image_type, const Grid<double>& signal_e,
                               const FrameSetting& setting) {
  const Grid<std::uint16_t> dn =
      render_frame(signal_e, scene_.sensor, setting.true_exposure_s, {scene_.seed, number_++});
  std::vector<FitsCard> cards{{"IMAGETYP", image_type, {}},
                              {"EXPTIME", setting.exposure_s, "[s] exposure time"},
                              {"EGAIN", scene_.nominal_sensor.gain_e_per_dn, "[electron/DN] gain"},
                              {"STAGEDEG", setting.stage_deg, "[deg] stage as commanded"},
                              {"ARMDEG", setting.arm_deg, "[deg] arm as commanded"},
                              {"ROWORDER", std::string("TOP-DOWN"), "first row stored is the top one"},
                              {"BUNIT", std::string("adu"), {}},
                              {"DATE-OBS", scene_.date_obs, "UTC, from the scene file"}};
  if (setting.tilt_deg) cards.push_back({"TILTDEG", *setting.tilt_deg, "[deg] known mirror tilt"});
  if (!setting.target.empty()) cards.push_back({"TARGET", setting.target, "what the beam met"});
  for (FitsCard& card : history_cards(provenance_)) cards.push_back(std::move(card));
  const std::string path = "frames/" + name + ".fits";
  FitsWriter file(folder_ / path);
  file.image(dn, cards);
  file.close();
  return path;
}

StackFiles FrameWriter::write_stack(const std::string& name, const Grid<double>& signal_e, const FrameStack& stack,
                                    double stage_deg, double arm_deg, const std::string& image_type) {
  const FrameSetting setting{stack.exposure_s, stack.true_exposure_s, stage_deg, arm_deg};
  StackFiles files;
  for (int i = 1; i <= stack.frames; ++i) {
    files.frames.push_back(write(numbered(name, i), image_type, signal_e, setting));
  }
  for (int i = 1; i <= stack.darks; ++i) {
    files.darks.push_back(write(numbered(name + "_dark", i), "Dark Frame", no_light_e_, setting));
  }
  return files;
}

}  // namespace scatmap::synth
