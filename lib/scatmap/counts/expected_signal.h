#pragma once
#include "scatmap/base/grid.h"
#include "scatmap/base/mask.h"

namespace scatmap {

/// Scatter counts as structure from this many standard deviations of a sample variance on.
inline constexpr double kStructureSigmas = 2;
/// With fewer good neighbours the pixel's own value is all that is known.
inline constexpr int kLeastNeighbours = 3;

/// Variance of a pixel at its expected signal. Where there is no light the estimate fluctuates about zero and is taken
/// as it is: cut off at zero it would make variances too large on average. Only what no noise explains is cut off, at
/// kLeastVariance of the floor.
inline constexpr double kLeastVariance = 0.5;
template <class T>
constexpr T variance_at(T expected, T floor, T shot) {
  const T variance = floor + expected * shot, least = static_cast<T>(kLeastVariance) * floor;
  return variance > least ? variance : least;
}

/// Best local estimate of the signal that a noisy image samples, for use in variances, weights and gradients (never as
/// the result itself): expected = m + w (value − m), with m and s² mean and variance of the good neighbours in a 5 × 5
/// window without the pixel itself, and w = τ²/(τ² + v), τ² = max(0, s² − v (1 + 2 sqrt(2/(n − 1)))), v the noise
/// variance at m and n the neighbours: what chance explains is no structure. In flat noise
/// the pixel's own value hardly counts, so σ does not follow its fluctuation; on steep bright features w → 1. (J.-S.
/// Lee, IEEE Trans. PAMI 2, 165 (1980), with the pixel itself left out of the local statistics.)
///
/// @param value  rows × columns; @param floor variance at zero signal, value²; @param shot variance per unit of signal
/// @return rows × columns; NaN where the pixel is masked and has no good neighbour; masked pixels get m
Grid<double> expected_signal(const Grid<double>& value, const Grid<float>& floor, const Grid<float>& shot,
                             const Grid<Mask>& mask);

}  // namespace scatmap
