#pragma once
#include <complex>

#include "scatmap/model/direction_chunk.h"
#include "scatmap/model/microfacet.h"

namespace scatmap {

/// Type of a kernel's amplitudes (polarisation factors, envelopes). Directions, exponents and phases are always double:
/// tan²(theta_h)/m² and a thousand fringe periods leave float nothing.
enum class Amplitudes { kDouble, kSingle };

/// One microfacet term for one incident direction, evaluated a chunk at a time: the formula of PreparedMicrofacet with
/// its divisions gathered into two, no branch per pixel, complex numbers written out.
class LobeKernel {
 public:
  /// `wi`: unit vector towards the source, sample axes.
  LobeKernel(const MicrofacetTerm& term, double phi_ref_rad, Polarization polarization, const Vector3<double>& wi);

  /// Adds the term's BRDF in 1/sr; 0 where PreparedMicrofacet is, and where exp(...) < 1e-307. NaN in, NaN out.
  /// A chunk all of whose exponentials are 0 costs 1 ns a pixel. Amplitudes in float are taken only where they keep
  /// kSingleModelError, as single() says.
  void add(const DirectionChunk& chunk, Amplitudes amplitudes, ChunkRow& values) const;

  /// What the kernel and the bounds of term_bound.h read.
  struct Constants {
    Matrix3<double> facet_from_sample;
    bool tilted;
    bool lit;            ///< the source stands in front of the mean facet
    bool real;           ///< e real and >= 1: no complex numbers
    Vector3<double> wi;  ///< in the facet's axes
    PolarizationFactors::Incident q;
    std::complex<double> e;
    double m2, per_m2;
    double scale_per_sr;  ///< rho / (2 pi m²)
  };
  const Constants& constants() const { return constants_; }

  /// Whether float will do: q_pp is a difference of parts up to |e| times its size, which costs 2 |e| 1.2e-7 of a Q
  /// that has q_ss beside it, and has no bound for p light alone, where it may vanish (Brewster's angle).
  bool single() const { return constants_.q.s_weight > 0 && std::abs(constants_.e) <= kLargestSingleE; }
  static constexpr double kLargestSingleE = 64;

 private:
  Constants constants_;
};

}  // namespace scatmap
