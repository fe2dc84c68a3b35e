#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace scatmap {

/// What a .cameramodel file of mrcal says of a lens. Its extrinsics are not used: the pose is the instrument's.
struct LensFile {
  std::string model;               ///< "LENSMODEL_OPENCV8", "LENSMODEL_CAHVORE_linearity=0.34" and the like
  std::vector<double> intrinsics;  ///< as many as the model has
  int columns = 0;
  int rows = 0;
};

/// Reads a .cameramodel file strictly, before mrcal sees it: mrcal 2.2's own reader runs past the end of damaged
/// strings, and takes numbers of parameters as it finds them. Keys that are not needed (optimization_inputs) are
/// skipped. @throws Error with file and line: not a Python dictionary, unknown lens model, wrong number of intrinsics,
/// numbers that are not finite, a doubled or missing key
LensFile read_lens_file(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages.
LensFile parse_lens_file(const std::string& text, const std::string& name);
/// The text of a .cameramodel file with the same lens, numbers exact, extrinsics zero.
std::string to_cameramodel(const LensFile& lens);

}  // namespace scatmap
