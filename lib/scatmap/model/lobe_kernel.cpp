#include "scatmap/model/lobe_kernel.h"

#include <cmath>
#include <numbers>

#include "scatmap/base/exponential.h"
#include "scatmap/base/simd.h"

namespace scatmap {
namespace {

using Constants = LobeKernel::Constants;

// What the first pass leaves for the second.
struct Lobe {
  alignas(64) ChunkRow x, y, z;  // scattered direction in the facet's axes
  alignas(64) ChunkRow tan2_h;
  alignas(64) ChunkRow per_z2;  // 1 / (cos theta_i + cos theta_s)²
};

SCATMAP_CLONES
void fill_flat(const DirectionChunk& in, Lobe& lobe) {
  for (int i = 0; i < kChunk; ++i) {
    const double x = in.sum_x[i], y = in.sum_y[i], z = in.sum_z[i];
    const double per_z2 = 1 / (z * z), tan2 = (x * x + y * y) * per_z2;
    lobe.tan2_h[i] = tan2;
    lobe.per_z2[i] = per_z2;
  }
}

SCATMAP_CLONES
void fill_tilted(const Constants& k, const DirectionChunk& in, Lobe& lobe) {
  const double xx = k.facet_from_sample(0, 0), xy = k.facet_from_sample(0, 1), xz = k.facet_from_sample(0, 2);
  const double yx = k.facet_from_sample(1, 0), yy = k.facet_from_sample(1, 1), yz = k.facet_from_sample(1, 2);
  const double zx = k.facet_from_sample(2, 0), zy = k.facet_from_sample(2, 1), zz = k.facet_from_sample(2, 2);
  for (int i = 0; i < kChunk; ++i) {
    const double sx = in.sum_x[i], sy = in.sum_y[i], sz = in.sum_z[i];
    const double x = xx * sx + xy * sy + xz * sz, y = yx * sx + yy * sy + yz * sz, z = zx * sx + zy * sy + zz * sz;
    const double per_z2 = 1 / (z * z), tan2 = (x * x + y * y) * per_z2;
    lobe.tan2_h[i] = tan2;
    lobe.per_z2[i] = per_z2;
    const double wx = in.ws_x[i], wy = in.ws_y[i], wz = in.ws_z[i];
    lobe.x[i] = xx * wx + xy * wy + xz * wz;
    lobe.y[i] = yx * wx + yy * wy + yz * wz;
    lobe.z[i] = zx * wx + zy * wy + zz * wz;
  }
}

// Whether any exponential of the chunk is not 0 (NaN counts).
SCATMAP_CLONES
bool any_light(const Lobe& lobe, double per_m2) {
  long long live = 0;
  for (int i = 0; i < kChunk; ++i) live |= -lobe.tan2_h[i] * per_m2 < kSmallestExponent ? 0LL : 1LL;
  return live != 0;
}

// Below this sin²(theta_s) the azimuth is noise, or its products underflow.
template <class T>
constexpr T kSmallestSin2 = T(1e-290);
template <>
constexpr float kSmallestSin2<float> = 1e-20f;

// The scattered azimuth times sin(theta_s), with the limits of PolarizationFactors along the normal.
template <class T>
struct Azimuth {
  T x, y;       // sin theta_s · (cos, sin) of the azimuth difference
  T sin2;       // their norm
  T sin2_of_e;  // the same where e sin(theta_i) multiplies it
};

template <class T>
SCATMAP_INLINE Azimuth<T> azimuth(T forward_x, T forward_y, T wx, T wy) {
  const T sin2 = wx * wx + wy * wy;
  const bool near = sin2 < kSmallestSin2<T>;
  return {near ? T(1) : forward_x * wx + forward_y * wy, near ? T(0) : forward_x * wy - forward_y * wx,
          near ? T(1) : sin2, near ? T(0) : sin2};
}

// Q of a real e >= 1: s² times every squared factor, over one common denominator.
template <class T>
struct RealQ {
  T e, e_sin_i, g_i, forward_x, forward_y, s_weight, p_weight;

  SCATMAP_INLINE explicit RealQ(const Constants& k)
      : e(static_cast<T>(k.e.real())),
        e_sin_i(static_cast<T>(k.q.e_sin_i.real())),
        g_i(static_cast<T>(k.q.g_i.real())),
        forward_x(static_cast<T>(k.q.forward_x)),
        forward_y(static_cast<T>(k.q.forward_y)),
        s_weight(static_cast<T>(k.q.s_weight)),
        p_weight(static_cast<T>(k.q.p_weight)) {}

  SCATMAP_INLINE T operator()(T wx, T wy, T c, T g2) const {
    const Azimuth<T> a = azimuth(forward_x, forward_y, wx, wy);
    const T g = std::sqrt(g2), s_out = c + g, p_out = e * c + g;
    const T s2 = s_out * s_out, p2 = p_out * p_out, x2 = a.x * a.x, y2 = a.y * a.y;
    const T pp = e_sin_i * a.sin2_of_e - g_i * g * a.x;
    const T s = x2 * p2 + g2 * y2 * s2, p = g_i * g_i * y2 * p2 + pp * pp * s2;
    return (s_weight * s + p_weight * p) / (a.sin2 * s2 * p2);
  }
};

// The same for any e with imaginary part >= 0.
template <class T>
struct ComplexQ {
  T g2_im, e_re, e_im, e_sin_re, e_sin_im, gi_re, gi_im, gi2, forward_x, forward_y, s_weight, p_weight;

  SCATMAP_INLINE explicit ComplexQ(const Constants& k)
      : g2_im(static_cast<T>(k.q.contrast.imag())),
        e_re(static_cast<T>(k.e.real())),
        e_im(static_cast<T>(k.e.imag())),
        e_sin_re(static_cast<T>(k.q.e_sin_i.real())),
        e_sin_im(static_cast<T>(k.q.e_sin_i.imag())),
        gi_re(static_cast<T>(k.q.g_i.real())),
        gi_im(static_cast<T>(k.q.g_i.imag())),
        gi2(static_cast<T>(std::norm(k.q.g_i))),
        forward_x(static_cast<T>(k.q.forward_x)),
        forward_y(static_cast<T>(k.q.forward_y)),
        s_weight(static_cast<T>(k.q.s_weight)),
        p_weight(static_cast<T>(k.q.p_weight)) {}

  SCATMAP_INLINE T operator()(T wx, T wy, T c, T g2_re) const {
    const Azimuth<T> a = azimuth(forward_x, forward_y, wx, wy);
    // Principal root: the larger part from a sum, the smaller from it by division, so that neither cancels.
    const T modulus = std::sqrt(g2_re * g2_re + g2_im * g2_im);
    const T magnitude = g2_re < 0 ? -g2_re : g2_re;
    const T larger = std::sqrt((modulus + magnitude) * T(0.5));
    const T smaller = larger > 0 ? g2_im / (2 * larger) : T(0);
    const T g_re = g2_re < 0 ? smaller : larger, g_im = g2_re < 0 ? larger : smaller;
    const T so_re = c + g_re, po_re = e_re * c + g_re, po_im = e_im * c + g_im;
    const T s2 = so_re * so_re + g_im * g_im, p2 = po_re * po_re + po_im * po_im;
    const T x2 = a.x * a.x, y2 = a.y * a.y;
    const T pp_re = e_sin_re * a.sin2_of_e - (gi_re * g_re - gi_im * g_im) * a.x;
    const T pp_im = e_sin_im * a.sin2_of_e - (gi_re * g_im + gi_im * g_re) * a.x;
    const T s = x2 * p2 + modulus * y2 * s2, p = gi2 * y2 * p2 + (pp_re * pp_re + pp_im * pp_im) * s2;
    return (s_weight * s + p_weight * p) / (a.sin2 * s2 * p2);
  }
};

template <class T, class Q>
SCATMAP_INLINE void add_lobe(const Constants& k, const double* wx, const double* wy, const double* wz, const Lobe& lobe,
                             double* values) {
  const Q q(k);
  const double contrast = k.q.contrast.real(), per_m2 = k.per_m2, scale = k.scale_per_sr;
  for (int i = 0; i < kChunk; ++i) {
    const double c = wz[i], tan2 = lobe.tan2_h[i], exponent = -tan2 * per_m2;
    // g² in double: beside the critical angle of total reflection it is a small difference.
    const T factor =
        q(static_cast<T>(wx[i]), static_cast<T>(wy[i]), static_cast<T>(c), static_cast<T>(contrast + c * c));
    const double per_cos2_h = 1 + tan2;
    const double value =
        scale * static_cast<double>(factor) * lobe.per_z2[i] * per_cos2_h * per_cos2_h * exp_kernel<T>(exponent);
    const bool dark = exponent < kSmallestExponent || c <= 0;
    values[i] += dark ? 0.0 : value;
  }
}

SCATMAP_CLONES
void add_real(const Constants& k, const double* wx, const double* wy, const double* wz, const Lobe& lobe, double* out) {
  add_lobe<double, RealQ<double>>(k, wx, wy, wz, lobe, out);
}
SCATMAP_CLONES
void add_complex(const Constants& k, const double* wx, const double* wy, const double* wz, const Lobe& lobe,
                 double* out) {
  add_lobe<double, ComplexQ<double>>(k, wx, wy, wz, lobe, out);
}
SCATMAP_CLONES
void add_real_single(const Constants& k, const double* wx, const double* wy, const double* wz, const Lobe& lobe,
                     double* out) {
  add_lobe<float, RealQ<float>>(k, wx, wy, wz, lobe, out);
}
SCATMAP_CLONES
void add_complex_single(const Constants& k, const double* wx, const double* wy, const double* wz, const Lobe& lobe,
                        double* out) {
  add_lobe<float, ComplexQ<float>>(k, wx, wy, wz, lobe, out);
}

}  // namespace

LobeKernel::LobeKernel(const MicrofacetTerm& term, double phi_ref_rad, Polarization polarization,
                       const Vector3<double>& wi) {
  Constants& k = constants_;
  k.facet_from_sample = facet_from_sample(term.dtheta_rad, term.dphi_rad + phi_ref_rad);
  k.tilted = term.dtheta_rad != 0;
  k.wi = k.tilted ? Vector3<double>(k.facet_from_sample * wi) : wi;
  k.lit = k.wi.z() > 0;
  k.q = PolarizationFactors(term.n, k.wi, polarization).incident();
  k.e = k.q.contrast + 1.0;
  k.real = k.e.imag() == 0 && k.q.contrast.real() >= 0;
  k.m2 = term.m * term.m;
  k.per_m2 = 1 / k.m2;
  k.scale_per_sr = term.rho / (2 * std::numbers::pi * k.m2);
}

void LobeKernel::add(const DirectionChunk& chunk, Amplitudes amplitudes, ChunkRow& values) const {
  if (!constants_.lit) return;
  Lobe lobe;
  if (constants_.tilted) {
    fill_tilted(constants_, chunk, lobe);
  } else {
    fill_flat(chunk, lobe);
  }
  if (!any_light(lobe, constants_.per_m2)) return;
  const double* const x = constants_.tilted ? lobe.x : chunk.ws_x;
  const double* const y = constants_.tilted ? lobe.y : chunk.ws_y;
  const double* const z = constants_.tilted ? lobe.z : chunk.ws_z;
  if (amplitudes == Amplitudes::kDouble || !single()) {
    (constants_.real ? add_real : add_complex)(constants_, x, y, z, lobe, values);
  } else {
    (constants_.real ? add_real_single : add_complex_single)(constants_, x, y, z, lobe, values);
  }
}

}  // namespace scatmap
