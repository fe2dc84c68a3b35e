#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "scatmap/base/output_file.h"

namespace scatmap {

/// A picture to be made by gnuplot.
struct Plot {
  std::string script;  ///< commands; terminal and output are set before, the data file's name stands in `data`
  std::string data;    ///< bytes of the data file
  int width_px = 1200;
  int height_px = 800;
};

struct PictureOptions {
  Overwrite overwrite = Overwrite::kKeep;
  /// Leaves NAME.gp and NAME.dat beside the picture; `gnuplot NAME.gp` in that folder makes it again.
  bool keep_script = false;
};

/// Runs gnuplot, without a shell, in a private temporary folder and puts the picture, PNG or SVG after the target's
/// extension, in place whole.
/// @throws Error if the extension is another, a name holds control characters, gnuplot is not installed (naming its
/// package) or fails (with its first message), or a file cannot be written
void write_picture(const Plot& plot, const std::filesystem::path& target, const PictureOptions& options = {});

/// A gnuplot string constant for any text. Whatever gnuplot could take for a quote, a command, a macro or an escape
/// becomes an octal code: its own quoting has holes (5.4 misreads doubled quotes and expands @name after some).
/// Control characters become spaces.
std::string gnuplot_text(std::string_view text);

}  // namespace scatmap
