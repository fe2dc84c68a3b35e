#pragma once
#include <optional>
#include <vector>

#include "scatmap/compare/band.h"
#include "scatmap/compare/features.h"
#include "scatmap/compare/fringes.h"
#include "scatmap/compare/profile.h"
#include "scatmap/compare/residual.h"

namespace scatmap {

/// What is seen in one map. Parts are absent where the map shows no such feature.
struct MapFeatures {
  std::vector<Peak> peaks;  ///< highest first
  std::optional<Band> band;
  std::optional<FringeComb> along_ridge;   ///< fringes along the band's ridge
  std::optional<FringeComb> along_column;  ///< fringes along the pixel column through the band's peak (paper)
};

MapFeatures find_features(const BrdfMap& map);

/// Measured and modelled BRDF along the same line of pixels.
struct ProfilePair {
  Profile measured;
  Profile modelled;
};

/// A measured map beside a modelled one on the same pixels.
struct Comparison {
  MapFeatures measured;
  MapFeatures modelled;
  std::vector<PeakPair> peaks;
  std::vector<ProfilePair> columns;  ///< through each measured peak, in the order of measured.peaks
  std::vector<ProfilePair> rows;
  std::optional<ProfilePair> ridge;  ///< along the measured band, or the modelled one if only that has one
  std::optional<Residual> residual;  ///< absent if neither map has uncertainties
  Grid<float> log10_ratio;
  double direction_difference_px = 0;  ///< largest at centre and corners between the maps' pixel directions
};

/// @throws Error if shapes, wavelength (relative 1e-6) or pose (1e-9 rad) differ; from residual
Comparison compare(const BrdfMap& measured, const BrdfMap& modelled);

}  // namespace scatmap
