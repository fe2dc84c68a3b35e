// Memory stays flat over 2000 frames: 200 measurements of 10 frames, reduced and written by one process. Does not cover
// one exposure of very many frames: the frames of one exposure are in memory together.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "data-synthetic/simulate.h"
#include "scatmap/brdf/from_frames.h"
#include "scatmap/report/map_exr.h"
#include "scatmap/report/map_fits.h"

namespace scatmap {
namespace {
namespace fs = std::filesystem;

// The largest resident size so far (proc(5), VmHWM): the size at one moment depends on what the allocator keeps.
double peak_mib() {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    if (word != "VmHWM:") continue;
    double kib = 0;
    file >> kib;
    return kib / 1024;
  }
  return std::nan("");
}

// What the program holds: grows by whatever is not freed.
double held_mib() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / (1 << 20);
}

TEST(SoakSlow, MemoryIsFlatOverTwoThousandFrames) {
  const fs::path folder = fs::path(testing::TempDir()) / "soak";
  synth::simulate(fs::path(SCATMAP_SOURCE_DIR) / "data-synthetic/scenes/small-20-0.toml", folder, Overwrite::kKeep, {});
  constexpr int kFrames = 2000, kSettled = 100;
  constexpr double kGrowth = 1.05;
  int frames = 0;
  double settled_peak_mib = 0, settled_held_mib = 0, largest_held_mib = 0;
  while (frames < kFrames) {
    const BrdfResult result = brdf_from_frames(read_measurement(folder / "measurement.toml"));
    write_map_fits(result.map, folder / "map.fits", Precision::kSingle, Overwrite::kForce);
    write_map_exr(result.map, folder / "map.exr", Overwrite::kForce);
    for (const ExposureRecord& e : result.map.exposures) frames += static_cast<int>(e.frames.size() + e.darks.size());
    if (frames <= kSettled) {
      settled_peak_mib = peak_mib();
      settled_held_mib = held_mib();
    } else {
      largest_held_mib = std::max(largest_held_mib, held_mib());
    }
  }
  std::printf(
      "%d frames: peak %.1f MiB after the first %d, %.1f MiB in the end; held between measurements %.3f and at most "
      "%.3f MiB\n",
      frames, settled_peak_mib, kSettled, peak_mib(), settled_held_mib, largest_held_mib);
  EXPECT_GT(settled_held_mib, 0.001);
  EXPECT_LE(largest_held_mib, kGrowth * settled_held_mib);
  EXPECT_LE(peak_mib(), kGrowth * settled_peak_mib);
}

}  // namespace
}  // namespace scatmap
