#pragma once
#include <cmath>
#include <cstddef>

#include "scatmap/base/arctangent.h"

/// The loops of the angle methods, written once for double and float and inlined into the clones of angle_kernel.cpp
/// (and into the tests, which hold the baseline against them). Lengths are in units of the reference ray's.
namespace scatmap::kernel {

/// A part of a row about the reference pixel at its middle; d is the distance from it in columns.
template <class T>
struct NearSegment {
  T first_d;                   ///< of the first column
  T phi, phi_rest;             ///< of the reference, in two parts
  T theta, theta_rest;         ///< of the reference
  T turn, stretch;             ///< tan(phi − phi_ref) = d turn/(1 + d stretch)
  T rho, z;                    ///< sin and cos of the reference's theta
  T rho2_linear, rho2_square;  ///< rho² = rho_ref² + d (linear + d square)
  T z_step;
};

/// Angles near a reference: both are the reference's plus a small arctangent, with nothing lost to cancellation.
/// @pre both differences at most kSmallArctangentRange, phi off the seam
template <class T>
SCATMAP_INLINE void near_angles(const NearSegment<T>& s, std::size_t n, T* theta, T* phi) {
  for (std::size_t i = 0; i < n; ++i) {
    const T d = s.first_d + static_cast<T>(static_cast<int>(i));
    const T rise = d * (s.rho2_linear + d * s.rho2_square);  // rho² − rho_ref²
    const T rho = std::sqrt(s.rho * s.rho + rise);
    const T rho_sum = rho + s.rho, dz = d * s.z_step;
    // tan(theta − theta_ref) = (rho z_ref − z rho_ref)/(rho rho_ref + z z_ref), with rho − rho_ref = rise/rho_sum.
    const T theta_numerator = rise * s.z - dz * s.rho * rho_sum;
    const T theta_denominator = rho_sum * (rho * s.rho + (s.z + dz) * s.z);
    const T phi_denominator = T(1) + d * s.stretch;
    const T inverse = T(1) / (theta_denominator * phi_denominator);  // one division for both
    theta[i] = s.theta + (s.theta_rest + small_arctangent<T>(theta_numerator * phi_denominator * inverse));
    phi[i] = s.phi + (s.phi_rest + small_arctangent<T>(d * s.turn * theta_denominator * inverse));
  }
}

/// A part of a row anywhere on the sphere: ray = start + rest + d step.
template <class T>
struct FarSegment {
  T first_d;
  T x, y, z;
  T x_rest, y_rest, z_rest;
  T x_step, y_step, z_step;
};

template <class T>
SCATMAP_INLINE void far_angles(const FarSegment<T>& s, std::size_t n, T* theta, T* phi) {
  for (std::size_t i = 0; i < n; ++i) {
    const T d = s.first_d + static_cast<T>(static_cast<int>(i));
    const T x = s.x + (s.x_rest + d * s.x_step), y = s.y + (s.y_rest + d * s.y_step),
            z = s.z + (s.z_rest + d * s.z_step);
    theta[i] = quadrant_arctangent<T>(std::sqrt(x * x + y * y), z).radians();
    phi[i] = azimuth_from_minus_x<T>(x, y);
  }
}

/// solid angle = scale/|ray|³, cos(theta) = z/|ray|, projected solid angle = scale z/|ray|⁴.
template <class T>
SCATMAP_INLINE void solid_angles(const FarSegment<T>& s, T scale, std::size_t n, T* out) {
  for (std::size_t i = 0; i < n; ++i) {
    const T d = s.first_d + static_cast<T>(static_cast<int>(i));
    const T x = s.x + (s.x_rest + d * s.x_step), y = s.y + (s.y_rest + d * s.y_step),
            z = s.z + (s.z_rest + d * s.z_step);
    const T r2 = x * x + y * y + z * z;
    out[i] = scale / (r2 * std::sqrt(r2));
  }
}

template <class T>
SCATMAP_INLINE void cosines(const FarSegment<T>& s, std::size_t n, T* out) {
  for (std::size_t i = 0; i < n; ++i) {
    const T d = s.first_d + static_cast<T>(static_cast<int>(i));
    const T x = s.x + (s.x_rest + d * s.x_step), y = s.y + (s.y_rest + d * s.y_step),
            z = s.z + (s.z_rest + d * s.z_step);
    out[i] = z / std::sqrt(x * x + y * y + z * z);
  }
}

template <class T>
SCATMAP_INLINE void projected_solid_angles(const FarSegment<T>& s, T scale, std::size_t n, T* out) {
  for (std::size_t i = 0; i < n; ++i) {
    const T d = s.first_d + static_cast<T>(static_cast<int>(i));
    const T x = s.x + (s.x_rest + d * s.x_step), y = s.y + (s.y_rest + d * s.y_step),
            z = s.z + (s.z_rest + d * s.z_step);
    const T r2 = x * x + y * y + z * z;
    out[i] = scale * z / (r2 * r2);
  }
}

}  // namespace scatmap::kernel
