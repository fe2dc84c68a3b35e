#pragma once

namespace scatmap {

/// A straight line of pixels about its middle: distances of the middle's ray from the spot (r) and from the sample's
/// normal (rho), and lengths of the step (s) and of its part across the normal (q), all in one unit of length. Ranges
/// where one line stands for several.
struct LineSize {
  double rho_min = 0, rho_max = 0;
  double r_min = 0, r_max = 0;
  double q = 0, s = 0;
};

/// Upper bound, rad, of what the Taylor polynomials of theta and phi about the middle leave out up to `half` steps from
/// it: root of theta's squared and sin(theta)·phi's squared. Infinite where the pole is too near.
///
/// phi is the imaginary part of ln(1 + d q/rho…), whose series ends in e^(degree+1)/((degree+1)(1 − e)), e = half
/// q/rho. theta' is analytic up to the pole and to |ray|² = 0; on the circle of half·c steps, c > 1, every factor of it
/// is bounded by the lengths above, and Cauchy's estimate bounds the coefficients.
double taylor_remainder_rad(const LineSize& line, double half, int degree);

}  // namespace scatmap
