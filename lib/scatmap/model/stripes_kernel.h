#pragma once
#include "scatmap/model/direction_chunk.h"
#include "scatmap/model/lobe_kernel.h"
#include "scatmap/model/stripes.h"

namespace scatmap {

/// One stripes term for one incident direction, evaluated a chunk at a time: the formula of PreparedStripes with its
/// phases in half turns, whose reduction is exact, and no branch per pixel.
class StripesKernel {
 public:
  /// `wi`: unit vector towards the source, sample axes.
  StripesKernel(const StripesTerm& term, double phi_ref_rad, double wavelength_m, double detector_distance_m,
                const Vector3<double>& wi);

  /// Adds the term's BRDF in 1/sr; 0 where exp(...) < 1e-307. NaN in, NaN out.
  void add(const DirectionChunk& chunk, Amplitudes amplitudes, ChunkRow& values) const;

  /// What the kernel and the bounds of term_bound.h read.
  struct Constants {
    bool paper;  ///< the form of Eq. 9: the half vector is normalised
    double cos_phi, sin_phi;
    double rho_per_sr;
    double per_c2;                     ///< (R / c)²
    double period_turns, width_turns;  ///< half turns per unit of the coordinate across the stripes
  };
  const Constants& constants() const { return constants_; }

 private:
  Constants constants_;
};

}  // namespace scatmap
