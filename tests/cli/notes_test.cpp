// What verbs say beside their result: methods and their bounds, tolerances that none meets, maps that look elsewhere,
// methods that were not the one asked for. Does not prove the bounds (tests/accuracy) nor any number of a result.
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "cli/lab.h"
#include "cli/spoil.h"

namespace scatmap::test {
namespace {

const LabMaker& maker() {
  static const LabMaker lab;
  return lab;
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Notes, AnglesNamesMethodAndBound) {
  const Lab lab = maker().fresh_copy();
  const std::vector<std::string> pose{"angles", "bench.toml", "--stage-deg", "20", "--arm-deg", "40"};
  lab.write("bench.toml", "[detector]\ncolumns = 300\nrows = 200\npitch_um = [30.0, 30.0]\ndistance_mm = 325.0\n");
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), pose.begin(), pose.end());
    return run_tool(more, lab.folder());
  };
  const ToolRun plain = run({"-o", "a.fits", "--method", "exact"});
  EXPECT_EQ(plain.status, 0);
  EXPECT_TRUE(holds(plain.out, "method exact, bound ")) << plain.out;
  EXPECT_EQ(plain.err, "");
  const ToolRun fine = run({"-o", "b.fits", "--tolerance-px", "1e-12"});
  EXPECT_EQ(fine.status, 0);
  EXPECT_TRUE(holds(fine.err, "note: no method meets 1e-12 px: vector, bound ")) << fine.err;
  EXPECT_TRUE(holds(fine.out, "method vector, bound ")) << fine.out;
  const ToolRun met = run({"-o", "c.fits", "--tolerance-px", "1e-6"});
  EXPECT_EQ(met.err, "");
}

TEST(Notes, AnglesSaysThatNoPixelSeesTheSample) {
  const Lab lab = maker().fresh_copy();
  const ToolRun run =
      run_tool({"angles", "instrument.toml", "--stage-deg", "20", "--arm-deg", "220", "-o", "a.fits"}, lab.folder());
  EXPECT_EQ(run.status, 0);
  EXPECT_TRUE(holds(run.out, " 0 of 4096 pixels")) << run.out;
  EXPECT_TRUE(holds(run.err, "note: no pixel sees")) << run.err;
}

TEST(Notes, ModelNamesMethodAndBound) {
  const Lab lab = maker().fresh_copy();
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"model", "model.toml", "--like", "maps/angles.fits"});
    return run_tool(more, lab.folder());
  };
  const ToolRun plain = run({"-o", "a.fits"});
  EXPECT_TRUE(holds(plain.out, "method culled, bound 1.00e-09 relative; rounding of directions adds ")) << plain.out;
  EXPECT_EQ(plain.err, "");
  const ToolRun fine = run({"-o", "b.fits", "--tolerance-rel", "1e-15"});
  EXPECT_EQ(fine.status, 0);
  EXPECT_TRUE(holds(fine.err, "note: no method meets 1e-15 relative: exact, bound 1.00e-12")) << fine.err;
  EXPECT_EQ(run({"-o", "c.fits", "--method", "single"}).err, "");
}

TEST(Notes, MapsThatLookElsewhereAreComparedOnlyWhenAsked) {
  Lab lab = maker().fresh_copy();
  overwrite_bytes("maps/modelled.fits", "distance_mm = 325", "distance_mm = 425")(lab);
  const std::vector<std::string> command{
      "compare", "maps/measured.fits", "maps/modelled.fits", "--pictures", "none", "-o", "out"};
  const ToolRun refused = run_tool(command, lab.folder());
  EXPECT_EQ(refused.status, 1);
  EXPECT_FALSE(fs::exists(lab.path("out")));
  auto asked = command;
  asked.emplace_back("--other-directions");
  const ToolRun run = run_tool(asked, lab.folder());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(holds(run.err, "note: the maps look elsewhere: directions differ by up to ")) << run.err;
}

TEST(Notes, MapsOfOneDetectorAreComparedWithoutAWord) {
  const Lab lab = maker().fresh_copy();
  const ToolRun run = run_tool(
      {"compare", "maps/measured.fits", "maps/modelled.fits", "--pictures", "none", "-o", "out"}, lab.folder());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
}

// Numbers in other units pass every check of range; only their proportion is odd.
TEST(Notes, DetectorsOfOddSizeAreWonderedAt) {
  for (const auto& [from, to] : {std::pair{"distance_mm = 325", "distance_mm = 0.325"},
                                 {"pitch_um = [212.5, 212.5]", "pitch_um = [0.2125, 0.2125]"}}) {
    Lab lab = maker().fresh_copy();
    lab.replace("instrument.toml", from, to);
    const ToolRun run =
        run_tool({"angles", "instrument.toml", "--stage-deg", "20", "--arm-deg", "40", "-o", "a.fits"}, lab.folder());
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_TRUE(holds(run.err, "note: instrument.toml describes a detector of ")) << to << ": " << run.err;
  }
}

// A camera's own gain is a round number; the measured one goes with the frames all the same when the file says so.
TEST(Notes, AMeasuredGainGoesWithFramesThatSayTheirNominalOne) {
  Lab lab = maker().fresh_copy();
  lab.replace("instrument.toml", "gain_e_per_dn = 1.5", "gain_e_per_dn = 1.4");
  const std::vector<std::string> command{"brdf", "measurement.toml", "-o", "out.fits"};
  const ToolRun refused = run_tool(command, lab.folder());
  EXPECT_EQ(refused.status, 1);
  EXPECT_TRUE(holds(refused.err, "sensor.header_gain_e_per_dn")) << refused.err;
  lab.replace("instrument.toml", "gain_e_per_dn = 1.4", "gain_e_per_dn = 1.4\nheader_gain_e_per_dn = 1.5");
  EXPECT_EQ(run_tool(command, lab.folder()).status, 0);
}

TEST(Notes, DoublePrecisionIsNotTheFusedPass) {
  Lab lab = maker().fresh_copy();
  const auto method = [&](std::vector<std::string> more) {
    std::vector<std::string> command{"brdf", "measurement.toml", "-o", "out.fits", "--force", "--json"};
    command.insert(command.end(), more.begin(), more.end());
    const ToolRun run = run_tool(command, lab.folder());
    EXPECT_EQ(run.status, 0) << run.err;
    return nlohmann::json::parse(run.out).at("method").get<std::string>();
  };
  EXPECT_EQ(method({}), "fused");
  EXPECT_EQ(method({"--precision", "double"}), "exact");
  EXPECT_EQ(method({"--precision", "double", "--method", "fused"}), "fused");
}

TEST(Notes, BrdfSaysWhenItDoesNotFuse) {
  Lab lab = maker().fresh_copy();
  const std::vector<std::string> command{"brdf", "measurement.toml", "--method", "fused", "-o"};
  auto one = command;
  one.emplace_back("one.fits");
  EXPECT_EQ(run_tool(one, lab.folder()).err, "");
  std::string text = lab.read("measurement.toml");
  const std::size_t begin = text.find("[[exposure]]");
  ASSERT_NE(begin, std::string::npos);
  std::size_t end = text.find("\n[", begin + 1);
  const std::string exposure = text.substr(begin, end == std::string::npos ? end : end - begin);
  lab.write("measurement.toml", text + "\n" + exposure + "\n");
  const std::string both = "[\"frames/exposure1_001.fits\", \"frames/exposure1_002.fits\"]";
  lab.replace("measurement.toml", both, "[\"frames/exposure1_001.fits\"]");
  lab.replace("measurement.toml", both, "[\"frames/exposure1_002.fits\"]");
  auto two = command;
  two.emplace_back("two.fits");
  const ToolRun run = run_tool(two, lab.folder());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(holds(run.err, "note: method exact was used: fused is for a single exposure")) << run.err;
}

TEST(Notes, ExportSaysThatCameraModelsAreNotRead) {
  const Lab lab = maker().fresh_copy();
  lab.write("x.cameramodel", "{}");
  const ToolRun run = run_tool({"export", "x.cameramodel", "--stage-deg", "20", "--arm-deg", "40", "--instrument",
                                "instrument.toml", "-o", "b.toml"},
                               lab.folder());
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(holds(run.err, "reading .cameramodel is not offered")) << run.err;
}

// Every number of a frame over its dark, as a share of what it was: 16-bit FITS with BZERO 32768.
void dim(Lab& lab, const std::string& file, double share) {
  std::string bytes = lab.read(file);
  for (std::size_t i = 0; i < kSide * kSide; ++i) {
    auto* at = reinterpret_cast<unsigned char*>(bytes.data()) + kHeaderBytes + 2 * i;
    const double dn = ((at[0] << 8) | at[1]) ^ 0x8000;
    const auto dimmed = static_cast<unsigned>(std::lround(300 + share * (dn - 300))) ^ 0x8000U;
    at[0] = static_cast<unsigned char>(dimmed >> 8U);
    at[1] = static_cast<unsigned char>(dimmed & 0xffU);
  }
  lab.write(file, bytes);
}

const std::vector<std::string> kBrdf{"brdf", "measurement.toml", "-o", "out.fits"};

TEST(Notes, FramesOfOneExposureThatDifferInLight) {
  Lab lab = maker().fresh_copy();
  EXPECT_FALSE(holds(run_tool(kBrdf, lab.folder()).out, "less light"));
  dim(lab, "frames/exposure1_002.fits", 0.5);
  const ToolRun run = run_tool({"brdf", "measurement.toml", "-o", "out2.fits"}, lab.folder());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(holds(run.out, "note: exposure 1: frames/exposure1_002.fits shows ")) << run.out;
  Lab slightly = maker().fresh_copy();
  dim(slightly, "frames/exposure1_002.fits", 0.96);
  const ToolRun seen = run_tool(kBrdf, slightly.folder());
  EXPECT_TRUE(holds(seen.out, "note: exposure 1: frames/exposure1_002.fits shows ")) << seen.out;
  EXPECT_TRUE(holds(seen.out, " where there is light")) << seen.out;
}

TEST(Notes, LightBesideTheBeamIsToldOf) {
  Lab lab = maker().fresh_copy();
  EXPECT_FALSE(holds(run_tool(kBrdf, lab.folder()).out, "light beside its beam"));
  const auto block = [](std::size_t c, std::size_t r) { return c >= 56 && c < 59 && r >= 4 && r < 7; };
  for (const char* file : {"frames/signature_001.fits", "frames/signature_002.fits"}) pixels(file, 9000, block)(lab);
  fs::remove(lab.path("out.fits"));
  const ToolRun run = run_tool(kBrdf, lab.folder());
  EXPECT_TRUE(holds(run.out, "note: the signature shows light beside its beam, at column 57, row 5 with ")) << run.out;
}

TEST(Notes, MoreLightThanFellIsToldOf) {
  Lab lab = maker().fresh_copy();
  EXPECT_FALSE(holds(run_tool(kBrdf, lab.folder()).out, "times the light that fell"));
  const std::string text = lab.read("measurement.toml");
  const std::size_t signature = text.find("[signature]"), filters = text.find("filters = [", signature);
  lab.write("measurement.toml", text.substr(0, filters) + "filters = []" + text.substr(text.find('\n', filters)));
  fs::remove(lab.path("out.fits"));
  const ToolRun run = run_tool(kBrdf, lab.folder());
  EXPECT_TRUE(holds(run.out, " times the light that fell on the sample")) << run.out << run.err;
}

TEST(Notes, AFlatWithItsBiasIsToldOf) {
  Lab flat = maker().fresh_copy();
  copy("frames/exposure1_001.fits", "flat.fits")(flat);
  card("flat.fits", "IMAGETYP", "'FLAT'")(flat);
  pixels("flat.fits", 20000, [](std::size_t, std::size_t) { return true; })(flat);
  flat.replace("measurement.toml", "instrument =", "flat = \"flat.fits\"\ninstrument =");
  const ToolRun run = run_tool(kBrdf, flat.folder());
  EXPECT_TRUE(holds(run.out, "flat.fits: holds whole numbers, none below sensor.bias_dn = 300")) << run.out << run.err;
}

// Its flanks were taken for hits of single frames and left out; the sum of frames does not change when a beam moves.
TEST(Notes, ABeamThatMovesBetweenFramesKeepsItsLight) {
  const auto largest = [](const Lab& lab) {
    const ToolRun run = run_tool({"brdf", "measurement.toml", "-o", "out.fits", "--json"}, lab.folder());
    EXPECT_EQ(run.status, 0) << run.err;
    const auto json = nlohmann::json::parse(run.out);
    return std::pair(json.at("largest_per_sr").get<double>(), json.dump());
  };
  Lab lab = maker().fresh_copy();
  const auto still = largest(lab);
  EXPECT_FALSE(holds(still.second, "did the beam or the scene move?"));
  roll_columns("frames/signature_002.fits", 1)(lab);
  fs::remove(lab.path("out.fits"));
  const auto moved = largest(lab);
  EXPECT_TRUE(holds(moved.second, "did the beam or the scene move?")) << moved.second;
  EXPECT_NEAR(moved.first, still.first, 0.01 * still.first);
}

TEST(Notes, PixelsThatPileUpBelowTheSaturation) {
  Lab lab = maker().fresh_copy();
  lab.replace("instrument.toml", "saturation_dn = 65535", "saturation_dn = 70000");
  pixels("frames/exposure1_001.fits", 65535, [](std::size_t c, std::size_t r) { return c < 4 && r < 4; })(lab);
  const ToolRun run = run_tool(kBrdf, lab.folder());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(holds(run.out, "frames/exposure1_001.fits: 16 pixels hold the very same largest value, 65535 DN"))
      << run.out;
}

TEST(Notes, AnApertureThatLeavesOutSomeOfTheBeam) {
  Lab lab = maker().fresh_copy();
  lab.replace("measurement.toml", "[signature]", "[signature]\naperture_radius_px = 2");
  const ToolRun run = run_tool(kBrdf, lab.folder());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(holds(run.out, "note: signature.aperture_radius_px = 2 leaves out ")) << run.out;
}

TEST(Notes, ReadNoiseStatedTooLow) {
  Lab lab = maker().fresh_copy();
  lab.replace("instrument.toml", "read_noise_e = 8", "read_noise_e = 0.8");
  EXPECT_TRUE(holds(run_tool(kBrdf, lab.folder()).out, " times the stated read noise"));
}

TEST(Notes, AFlatThatIsTheSample) {
  Lab lab = maker().fresh_copy();
  copy("frames/exposure1_001.fits", "flat.fits")(lab);
  card("flat.fits", "IMAGETYP", "'FLAT'")(lab);
  pixels("flat.fits", 5000, [](std::size_t c, std::size_t) { return c < 8; })(lab);
  lab.replace("measurement.toml", "instrument =", "flat = \"flat.fits\"\ninstrument =");
  const ToolRun run = run_tool(kBrdf, lab.folder());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(holds(run.out, "flat.fits: ")) << run.out;
  EXPECT_TRUE(holds(run.out, "off its mean by more than a factor of 2: is it a flat field?")) << run.out;
}

TEST(Notes, DarksBelowTheBias) {
  Lab lab = maker().fresh_copy();
  lab.replace("instrument.toml", "bias_dn = 300", "bias_dn = 1000");
  const ToolRun run = run_tool(kBrdf, lab.folder());
  EXPECT_TRUE(holds(run.out, "below sensor.bias_dn = 1000")) << run.out << run.err;
}

TEST(Notes, FramesBelowTheirDarks) {
  Lab lab = maker().fresh_copy();
  const auto everywhere = [](std::size_t, std::size_t) { return true; };
  pixels("frames/exposure1_001.fits", 100, everywhere)(lab);
  pixels("frames/exposure1_002.fits", 101, everywhere)(lab);
  const ToolRun run = run_tool(kBrdf, lab.folder());
  EXPECT_TRUE(holds(run.out, "note: most pixels lie below their darks")) << run.out << run.err;
}

TEST(Notes, AModelThatIsNothing) {
  Lab lab = maker().fresh_copy();
  lab.write("none.toml", "wavelength_nm = 632.8\n\n[[term]]\nkind = \"lambertian\"\nrho = 0\n");
  const ToolRun run = run_tool({"model", "none.toml", "--like", "maps/angles.fits", "-o", "none.fits"}, lab.folder());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(holds(run.err, "note: the model is 0 at every pixel")) << run.err;
  const ToolRun compared =
      run_tool({"compare", "maps/measured.fits", "none.fits", "--pictures", "none", "-o", "out"}, lab.folder());
  EXPECT_EQ(compared.status, 1);
  EXPECT_TRUE(holds(compared.err, "none.fits: the model is 0 at every pixel")) << compared.err;
}

// --force replaces results, not data.
TEST(Notes, ForceKeepsInputsAndForeignFiles) {
  Lab lab = maker().fresh_copy();
  const std::string frame = "frames/exposure1_001.fits", before = lab.read(frame);
  const ToolRun run = run_tool({"brdf", "measurement.toml", "-o", frame, "--force"}, lab.folder());
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(holds(run.err, frame + ": is an input of this run")) << run.err;
  EXPECT_EQ(lab.read(frame), before);
  const std::vector<std::string> compare{
      "compare", "maps/measured.fits", "maps/modelled.fits", "--pictures", "none", "-o", "out", "--force"};
  EXPECT_EQ(run_tool(compare, lab.folder()).status, 0);
  EXPECT_EQ(run_tool(compare, lab.folder()).status, 0);
  lab.write("out/notes.txt", "mine");
  const ToolRun refused = run_tool(compare, lab.folder());
  EXPECT_EQ(refused.status, 1);
  EXPECT_TRUE(holds(refused.err, "notes.txt: was not written by scatmap")) << refused.err;
  EXPECT_EQ(lab.read("out/notes.txt"), "mine");
}

}  // namespace
}  // namespace scatmap::test
