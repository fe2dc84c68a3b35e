#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scatmap/brdf/brdf_map.h"
#include "scatmap/compare/compare.h"
#include "scatmap/report/gnuplot.h"

namespace scatmap {

/// A map to draw. `map` must outlive the call.
struct MapPanel {
  const BrdfMap* map = nullptr;
  std::string title;
};

/// One or two curves along the same line. The profiles must outlive the call; `modelled` may be null.
struct ProfilePanel {
  const Profile* measured = nullptr;
  const Profile* modelled = nullptr;
  std::string title;
};

/// Maps side by side, false colour on one logarithmic scale (paper, Figs. 2 and 8). Axes: scatter angle from the
/// frame's centre along the detector's axes in degrees, in-plane to the right, out-of-plane (+y) downwards, whatever
/// the order in which the pixels are stored. Masked and non-finite pixels are grey; values below the scale, zero and
/// negative ones too, have its lowest colour. Large maps are drawn as means of square blocks (picture_raster.h).
/// @throws Error without a map, for maps without good positive pixels, and from write_picture
void draw_map(const std::vector<MapPanel>& panels, const std::filesystem::path& target,
              const PictureOptions& options = {});

/// BRDF against the angle from the peak, logarithmic, one panel below the other. Measured dark, modelled coloured.
void draw_profiles(const std::vector<ProfilePanel>& panels, const std::filesystem::path& target,
                   const PictureOptions& options = {});

/// (measured − modelled)/u from −5 to +5, diverging colours, on the axes of draw_map. `map` gives the axes.
void draw_residual(const Residual& residual, const BrdfMap& map, const std::string& title,
                   const std::filesystem::path& target, const PictureOptions& options = {});

/// Maps side by side above profiles, as in the paper's figures.
void draw_overview(const std::vector<MapPanel>& maps, const std::vector<ProfilePanel>& profiles,
                   const std::filesystem::path& target, const PictureOptions& options = {});

}  // namespace scatmap
