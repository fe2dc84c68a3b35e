#include "scatmap/counts/frame_steadiness.h"

#include <cmath>

#include "scatmap/base/parallel.h"
#include "scatmap/counts/reduce.h"
#include "scatmap/counts/row_kernels.h"

namespace scatmap {

FrameChanges frame_changes(std::span<const Frame> frames, const MasterDark& dark, const SensorModel& sensor,
                           int row_step) {
  const int columns = dark.level_dn.columns(), rows = (dark.level_dn.rows() + row_step - 1) / row_step;
  const std::size_t count = frames.size(), width = static_cast<std::size_t>(columns);
  const double of_mean = 1 - 1 / static_cast<double>(count);  // a frame's distance from a mean that it is part of
  const ChangeLimits limits{1 / sensor.gain_e_per_dn, kBrightSigmas * kBrightSigmas,
                            of_mean * kFrameOutlierSigmas * kFrameOutlierSigmas,
                            kFrameDriftAllowance * kFrameDriftAllowance};
  std::vector<RowChange> of_row(static_cast<std::size_t>(rows) * count);
  for_row_ranges(rows, [&](int first, int last) {
    std::vector<float> mean(width), buffer(count * width);
    std::vector<const float*> values(count);
    for (int i = first; i < last; ++i) {
      const int row = i * row_step;
      for (std::size_t k = 0; k < count; ++k) values[k] = frames[k].dn.part(row, 0, columns, buffer.data() + k * width);
      mean_row(values, columns, mean.data());
      for (std::size_t k = 0; k < count; ++k)
        of_row[static_cast<std::size_t>(i) * count + k] =
            row_change(mean.data(), values[k], dark.level_dn.row(row).data(), dark.single_variance_dn2.row(row).data(),
                       dark.mask.row(row).data(), columns, limits);
    }
  });
  FrameChanges out{std::vector<FrameChange>(count), 0, 0};
  double variance = 0;
  for (std::size_t i = 0; i < of_row.size(); ++i) {
    out.of_frame[i % count].net_dn += of_row[i].net_dn;
    out.of_frame[i % count].differing += static_cast<std::size_t>(of_row[i].differing);
    if (i % count != 0) continue;
    out.pixels += static_cast<std::size_t>(of_row[i].bright);
    variance += of_row[i].noise2;
  }
  out.u_net_dn = std::sqrt(variance);
  return out;
}

}  // namespace scatmap
