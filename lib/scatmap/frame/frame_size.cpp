#include "scatmap/frame/frame_size.h"

#include "scatmap/base/error.h"
#include "scatmap/frame/frame.h"

namespace scatmap {
namespace {

std::string shape(long long columns, long long rows) {
  return std::to_string(columns) + " columns x " + std::to_string(rows) + " rows";
}

}  // namespace

void check_frame_size(const std::string& file, long long columns, long long rows) {
  if (columns < 1 || rows < 1) {
    throw Error({file, "holds an image without pixels", shape(columns, rows), "at least 1 x 1"});
  }
  if (columns > kMaxFramePixels / rows) {
    throw Error({file, "holds more pixels than a frame may have", shape(columns, rows),
                 "at most " + std::to_string(kMaxFramePixels) + " pixels"});
  }
}

void check_enough_data(const std::string& file, long long pixels, long long file_bytes) {
  if (pixels / kMaxPixelsPerFileByte > file_bytes) {
    throw Error({file, "is too short for the pixels it announces", std::to_string(file_bytes) + " bytes",
                 std::to_string(pixels) + " pixels"});
  }
}

}  // namespace scatmap
