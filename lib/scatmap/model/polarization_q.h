#pragma once
#include <complex>

#include "scatmap/base/direction.h"

namespace scatmap {

/// Polarisation of the laser: s is normal to the plane of incidence, p lies in it.
enum class Polarization { kUnpolarized, kS, kP };

/// Rayleigh-Rice polarisation factors (amplitudes). The first letter is the incident polarisation, the second the
/// scattered one: q_sp is s in, p out. (NIST SCATMECH names them in the same order, Germer in the opposite one.)
/// Signs: the azimuth difference grows from forward (0) towards +y when the light travels along +x.
struct PolarizationQ {
  std::complex<double> q_ss, q_sp, q_ps, q_pp;
};

/// The factors of one surface for one incident direction; what depends on that direction only is computed once.
/// Directions are unit vectors away from the surface in axes with z along its normal. z <= 0 is the caller's to mask.
///
/// Azimuths are undefined along the normal. There the limits used are: an incident direction along z counts as tilted
/// towards −x (its p axis is x, its s axis y), a scattered one along z as tilted forward. q() of an unpolarised laser,
/// and of any laser for a scattered direction along z, is the same whatever the azimuth: continuous.
class PolarizationFactors {
 public:
  /// `n` = nr + i k of the surface, nr > 0, k >= 0 (time dependence exp(−i w t)).
  PolarizationFactors(std::complex<double> n, const Vector3<double>& wi, Polarization polarization);

  /// Amplitudes of all four pairs; they do not depend on the laser's polarisation. Small et al. 2021, Eq. 5 (Q);
  /// Germer, Appl. Opt. 36, 8798 (1997). NaN in, NaN out.
  PolarizationQ amplitudes(const Vector3<double>& ws) const;

  /// The number that stands as Q in Eq. 5, where it is divided by 2: |q_ss|² + |q_sp|² + |q_ps|² + |q_pp|² for an
  /// unpolarised laser, 2 (|q_ss|² + |q_sp|²) for s and 2 (|q_pp|² + |q_ps|²) for p. Rs + Rp at specular when
  /// unpolarised. NaN in, NaN out.
  double q(const Vector3<double>& ws) const;

  /// What depends on the incident direction only, for the kernels that evaluate many scattered directions at once.
  struct Incident {
    std::complex<double> contrast;  ///< e − 1
    std::complex<double> e_sin_i;   ///< e sin(theta_i)
    std::complex<double> g_i;       ///< sqrt(e − sin²(theta_i))
    double forward_x, forward_y;    ///< unit, away from the source
    double s_weight, p_weight;      ///< of the two incident polarisations, |e − 1|² and their denominators included
  };
  Incident incident() const { return {contrast_, e_sin_i_, g_i_, forward_x_, forward_y_, s_weight_, p_weight_}; }

 private:
  struct Parts;
  Parts parts(const Vector3<double>& ws) const;

  std::complex<double> contrast_;  // e − 1
  std::complex<double> e_sin_i_, g_i_, s_in_, p_in_;
  double forward_x_, forward_y_;
  double s_weight_, p_weight_;
};

/// The two of them for a single pair of directions.
PolarizationQ polarization_amplitudes(std::complex<double> n, const Vector3<double>& wi, const Vector3<double>& ws);
double polarization_q(std::complex<double> n, const Vector3<double>& wi, const Vector3<double>& ws,
                      Polarization polarization);

}  // namespace scatmap
