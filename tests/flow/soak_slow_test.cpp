// Memory stays flat over 2000 frames: 200 measurements of 10 frames, reduced and written by one process. Does not cover
// one exposure of very many frames: the frames of one exposure are in memory together.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "data-synthetic/simulate.h"
#include "scatmap/brdf/from_frames.h"
#include "scatmap/report/map_exr.h"
#include "scatmap/report/map_fits.h"

namespace scatmap {
namespace {
namespace fs = std::filesystem;

double resident_mib() {
  std::ifstream file("/proc/self/statm");
  double whole = 0, resident = 0;
  file >> whole >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

TEST(SoakSlow, MemoryIsFlatOverTwoThousandFrames) {
  const fs::path folder = fs::path(testing::TempDir()) / "soak";
  synth::simulate(fs::path(SCATMAP_SOURCE_DIR) / "data-synthetic/scenes/small-20-0.toml", folder, Overwrite::kKeep, {});
  constexpr int kFrames = 2000, kSettled = 100;
  constexpr double kGrowth = 1.05;
  int frames = 0;
  double settled_mib = 0, largest_mib = 0;
  while (frames < kFrames) {
    const BrdfResult result = brdf_from_frames(read_measurement(folder / "measurement.toml"));
    write_map_fits(result.map, folder / "map.fits", Precision::kSingle, Overwrite::kForce);
    write_map_exr(result.map, folder / "map.exr", Overwrite::kForce);
    for (const ExposureRecord& e : result.map.exposures) frames += static_cast<int>(e.frames.size() + e.darks.size());
    if (frames <= kSettled) {
      settled_mib = std::max(settled_mib, resident_mib());
    } else {
      largest_mib = std::max(largest_mib, resident_mib());
    }
  }
  std::printf("%d frames: %.1f MiB within the first %d, at most %.1f MiB later\n", frames, settled_mib, kSettled,
              largest_mib);
  EXPECT_GT(settled_mib, 1);
  EXPECT_GT(largest_mib, 1);
  EXPECT_LE(largest_mib, kGrowth * settled_mib);
}

}  // namespace
}  // namespace scatmap
