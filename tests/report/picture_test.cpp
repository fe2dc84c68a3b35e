// Pictures are read back as pixels: size, colours, and where things are. Whether they please the eye is not proven.
#include "scatmap/report/picture.h"

#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <limits>

#include "compare/synthetic_map.h"
#include "scatmap/base/error.h"

namespace scatmap {
namespace {

namespace fs = std::filesystem;

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  std::array<int, 3> at(int x, int y) const {
    const auto i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
  }
};

Image read_png(const fs::path& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  Image out;
  if (!png_image_begin_read_from_file(&png, path.c_str())) throw std::runtime_error(png.message);
  png.format = PNG_FORMAT_RGB;
  out.width = static_cast<int>(png.width);
  out.height = static_cast<int>(png.height);
  out.rgb.resize(PNG_IMAGE_SIZE(png));
  if (!png_image_finish_read(&png, nullptr, out.rgb.data(), 0, nullptr)) throw std::runtime_error(png.message);
  return out;
}

// Mean place of the pixels of a colour within a part of the picture; nullopt if there are none.
struct Place {
  double x = 0, y = 0;
  int count = 0;
};
Place find_colour(const Image& image, std::array<int, 3> colour, int tolerance, int from_x, int to_x) {
  Place p;
  for (int y = 0; y < image.height; ++y) {
    for (int x = from_x; x < to_x; ++x) {
      const auto c = image.at(x, y);
      bool same = true;
      for (std::size_t k = 0; k < 3; ++k) same = same && std::abs(c[k] - colour[k]) <= tolerance;
      if (!same) continue;
      p.x += x;
      p.y += y;
      ++p.count;
    }
  }
  p.x /= p.count;
  p.y /= p.count;
  return p;
}

constexpr std::array<int, 3> kTop{0xfd, 0xe7, 0x25}, kFloor{0x44, 0x01, 0x54}, kMasked{0x8c, 0x8c, 0x8c};
constexpr int kSpan = 1200 - 80 - 115;  // px between the outer margins of a picture

class Picture : public testing::Test {
 protected:
  fs::path out(const std::string& name) const {
    return fs::path(testing::TempDir()) /
           ("picture_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + "_" + name);
  }
  static constexpr PictureOptions kForce{.overwrite = Overwrite::kForce, .keep_script = false};
};

double field(double c, double r) { return 1 + synthetic::Lobe{300, 250, 1e5, 12}(c, r); }

BrdfMap with_hole() {
  BrdfMap map = synthetic::noiseless(400, 400, field);
  for (int r = 40; r < 80; ++r) {
    for (int c = 60; c < 120; ++c) map.mask(r, c) = kHot;
  }
  return map;
}

TEST_F(Picture, MapShowsPeakFloorAndMaskWhereTheyAre) {
  const BrdfMap map = with_hole();
  draw_map({{&map, "a map"}}, out("map.png"), kForce);
  const Image image = read_png(out("map.png"));
  EXPECT_EQ(image.width, 1200);
  // 900 px high map of 400 cells, centred; margins as in picture.cpp.
  const double left = 80 + (kSpan - 900) / 2.0, top = 45, cell = 900 / 400.0;
  const Place peak = find_colour(image, kTop, 30, 0, 1000);
  EXPECT_GE(peak.count, 100);
  EXPECT_LE(std::abs(peak.x - (left + 300.5 * cell)), 3);
  EXPECT_LE(std::abs(peak.y - (top + 250.5 * cell)), 3) << "rows grow downwards";
  const Place hole = find_colour(image, kMasked, 0, 0, 1000);
  EXPECT_GE(hole.count, 0.95 * 60 * 40 * cell * cell);
  EXPECT_LE(std::abs(hole.x - (left + 90 * cell)), 3);
  EXPECT_LE(std::abs(hole.y - (top + 60 * cell)), 3);
  EXPECT_GE(find_colour(image, kFloor, 3, 0, 1000).count, 500000);
}

TEST_F(Picture, TwoMapsShareOneScale) {
  const BrdfMap measured = with_hole();
  const BrdfMap modelled = synthetic::noiseless(400, 400, [](double c, double r) { return 0.001 * field(c, r); });
  draw_map({{&measured, "measured"}, {&modelled, "modelled"}}, out("maps.png"), kForce);
  const Image image = read_png(out("maps.png"));
  EXPECT_EQ(image.width, 1200);
  EXPECT_GE(find_colour(image, kTop, 30, 80, 560).count, 20);
  EXPECT_EQ(find_colour(image, kTop, 30, 600, 1080).count, 0) << "100 of 1e5 is not at the top of the common scale";
}

TEST_F(Picture, ValuesAtOrBelowZeroHaveTheFloorColourAndNanIsGrey) {
  BrdfMap map = synthetic::noiseless(100, 100, [](double c, double) { return c < 50 ? 1.0 : 1000.0; });
  for (int r = 0; r < 50; ++r) {
    for (int c = 0; c < 50; ++c) map.brdf_per_sr(r, c) = r < 25 ? 0 : -5;
  }
  for (int r = 60; r < 100; ++r) {
    for (int c = 60; c < 100; ++c) map.brdf_per_sr(r, c) = std::numeric_limits<double>::quiet_NaN();
  }
  draw_map({{&map, "signs"}}, out("signs.png"), kForce);
  const Image image = read_png(out("signs.png"));
  const double left = 80 + (kSpan - 900) / 2.0;
  const auto at = [&](double column, double row) {
    return image.at(static_cast<int>(left + 9 * column), static_cast<int>(45 + 9 * row));
  };
  EXPECT_EQ(at(20, 10), kFloor);
  EXPECT_EQ(at(20, 40), kFloor);
  EXPECT_EQ(at(80, 80), kMasked);
  EXPECT_EQ(at(80, 20), kTop);
}

TEST_F(Picture, ProfilesAndOverviewAreDrawnPanelByPanel) {
  const BrdfMap measured = synthetic::noisy(400, 400, field, 0.1, 0.3, 41);
  const BrdfMap modelled = synthetic::noiseless(400, 400, field);
  const Profile a = column_profile(measured, {300, 250}), b = column_profile(modelled, {300, 250});
  draw_profiles({{&a, &b, "through the peak"}, {&a, nullptr, "alone"}}, out("profiles.png"), kForce);
  const Image image = read_png(out("profiles.png"));
  constexpr std::array<int, 3> kMeasured{0x1f, 0x3b, 0x73}, kModelled{0xfd, 0xae, 0x6b};
  EXPECT_GE(find_colour(image, kMeasured, 40, 80, 1180).count, 1000);
  const Place model = find_colour(image, kModelled, 20, 80, 1180);
  EXPECT_GE(model.count, 1000);
  EXPECT_LE(model.y, image.height / 2.0) << "only the upper panel has a model";

  draw_overview({{&measured, "measured"}, {&modelled, "modelled"}}, {{&a, &b, "peak"}}, out("overview.png"), kForce);
  EXPECT_GT(read_png(out("overview.png")).height, 800);
}

TEST_F(Picture, ResidualIsWhiteAtZeroAndColouredBySign) {
  BrdfMap measured =
      synthetic::noiseless(90, 90, [](double c, double) { return c < 30 ? 0.0 : (c < 60 ? 6.0 : 12.0); });
  measured.u_random_per_sr = Grid<float>(90, 90, 1.0F);
  const BrdfMap modelled = synthetic::noiseless(90, 90, [](double, double) { return 6.0; });
  draw_residual(residual(measured, modelled), measured, "residual", out("residual.png"), kForce);
  const Image image = read_png(out("residual.png"));
  const int left = 80 + (kSpan - 900) / 2;
  const auto low = image.at(left + 150, 500), zero = image.at(left + 450, 500), high = image.at(left + 750, 500);
  EXPECT_GT(low[2], low[0] + 50);
  EXPECT_GT(high[0], high[2] + 50);
  EXPECT_GT(std::min({zero[0], zero[1], zero[2]}), 240);
}

TEST_F(Picture, LargeMapsAreQuickAndSmall) {
  const BrdfMap map = synthetic::noiseless(3000, 2000, field);
  draw_map({{&map, "large"}}, out("large.svg"), {.overwrite = Overwrite::kForce, .keep_script = true});
  EXPECT_EQ(fs::file_size(fs::path(out("large.svg")).replace_extension(".dat")), 1000u * 667u * 4u);
  EXPECT_LE(fs::file_size(out("large.svg")), 3000000u) << "the map is one embedded image, not a rectangle per cell";
}

TEST_F(Picture, NothingToDrawIsAnError) {
  EXPECT_THROW(draw_map({}, out("x.png"), kForce), Error);
  EXPECT_THROW(draw_profiles({}, out("x.png"), kForce), Error);
  const BrdfMap dark = synthetic::noiseless(20, 20, [](double, double) { return -1.0; });
  EXPECT_THROW(draw_map({{&dark, "dark"}}, out("x.png"), kForce), Error);
  EXPECT_FALSE(fs::exists(out("x.png")));
}

}  // namespace
}  // namespace scatmap
