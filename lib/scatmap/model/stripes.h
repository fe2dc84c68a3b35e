#pragma once
#include "scatmap/base/direction.h"

namespace scatmap {

/// Where the diffraction phase comes from. kPaper: the half vector, with the fitted factor 2 cos(theta_i) of Eq. 9.
/// kGrating: the grating equation, no fitted factor. In a 13.5 mm frame 325 mm away the two agree at phi_ref = 0 to
/// 0.003 order down the middle column (0.006 along the pattern's crest at theta_i = 60 deg), and part by up to a
/// quarter order at the edge at phi_ref = 90 deg, theta_i = 60 deg.
enum class StripesForm { kPaper, kGrating };

/// Diffraction by a periodic set of narrow stripes (paper, Eqs. 9 and 10). The stripes run along +x at phi_ref = 0.
struct StripesTerm {
  double rho = 0;  ///< largest value, 1/sr, >= 0
  double a_m = 0;  ///< period, > 0
  double b_m = 0;  ///< width of one stripe, > 0
  double c_m = 0;  ///< width of the pattern along the stripes at the detector, in half-vector measure, > 0
  StripesForm form = StripesForm::kPaper;
};

/// One stripes term for one incident direction.
class PreparedStripes {
 public:
  /// `wi`: unit vector towards the source, sample axes.
  PreparedStripes(const StripesTerm& term, double phi_ref_rad, double wavelength_m, double detector_distance_m,
                  const Vector3<double>& wi);

  /// BRDF in 1/sr; `sum` = wi + ws of unit vectors in sample axes. Exactly 0 where the exponential underflows; NaN in,
  /// NaN out. Beside a zero of cos² the error is relative to the envelope, not to the value.
  double operator()(const Vector3<double>& sum) const;

 private:
  StripesForm form_;
  double cos_phi_, sin_phi_;
  double rho_per_sr_;
  double per_c2_;                      // (R / c)²
  double period_phase_, width_phase_;  // rad per unit of the coordinate across the stripes
};

}  // namespace scatmap
