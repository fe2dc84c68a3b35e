#include "scatmap/model/term_bound.h"

#include <cmath>
#include <complex>

namespace scatmap {
namespace {

template <int N>
Series<N> everything() {
  Series<N> out;
  out.c.fill(Interval::everything());
  return out;
}

// g = sqrt(e − 1 + cos²theta_s), principal root, and |g|².
template <int N>
struct Root {
  Series<N> re, im, norm;
};

template <int N>
Root<N> root(const Series<N>& g2, double g2_im) {
  if (g2_im == 0) {
    const Series<N> minus = -1.0 * g2;
    if (g2.c[0].low >= 0) return {sqrt(g2), Series<N>(0.0), g2};
    if (g2.c[0].high <= 0) return {Series<N>(0.0), sqrt(minus), minus};
    return {everything<N>(), everything<N>(), everything<N>()};
  }
  const Series<N> norm = sqrt(square(g2) + Series<N>(square(Interval(g2_im))));
  // The smaller part by division where its own difference would cancel.
  if (g2.c[0].low > 0) {
    const Series<N> re = sqrt(0.5 * (norm + g2));
    return {re, Series<N>(0.5 * g2_im) / re, norm};
  }
  const Series<N> im = sqrt(0.5 * (norm - g2));
  if (g2.c[0].high < 0) return {Series<N>(0.5 * g2_im) / im, im, norm};
  return {sqrt(0.5 * (norm + g2)), im, norm};
}

// Q by the kernel's own formula. @param x, y, c: the scattered direction in the facet's axes
template <int N>
Series<N> q_series(const LobeKernel::Constants& k, const Series<N>& wx, const Series<N>& wy, const Series<N>& c) {
  const PolarizationFactors::Incident& in = k.q;
  const Series<N> x = in.forward_x * wx + in.forward_y * wy, y = in.forward_x * wy - in.forward_y * wx;
  const Series<N> sin2 = square(wx) + square(wy);
  const Root<N> g = root(Series<N>(in.contrast.real()) + square(c), in.contrast.imag());
  const Series<N> s2 = square(c + g.re) + square(g.im);
  const Series<N> p2 = square(k.e.real() * c + g.re) + square(k.e.imag() * c + g.im);
  const Series<N> x2 = square(x), y2 = square(y);
  const Series<N> pp_re = in.e_sin_i.real() * sin2 - (in.g_i.real() * g.re - in.g_i.imag() * g.im) * x;
  const Series<N> pp_im = in.e_sin_i.imag() * sin2 - (in.g_i.real() * g.im + in.g_i.imag() * g.re) * x;
  const Series<N> s = x2 * p2 + g.norm * y2 * s2;
  const Series<N> p = std::norm(in.g_i) * (y2 * p2) + (square(pp_re) + square(pp_im)) * s2;
  return (in.s_weight * s + in.p_weight * p) / (sin2 * s2 * p2);
}

// No Q in the range is larger, along the normal included: triangle inequalities on the four factors, and
// |c + g|² >= c² + |g|², |e c + g|² >= |e|² c² + |g|² because Re g >= 0 and Re(e conj g) >= 0.
double largest_q(const LobeKernel::Constants& k, const Interval& c, const Interval& sin2) {
  const PolarizationFactors::Incident& in = k.q;
  const Interval g2_re = Interval(in.contrast.real()) + square(c);
  const Interval norm = sqrt(square(g2_re) + square(Interval(in.contrast.imag())));
  const Interval s2 = square(c) + norm, p2 = Interval(std::norm(k.e)) * square(c) + norm;
  const Interval per_s2 = Interval(1) / s2, per_p2 = Interval(1) / p2;
  const Interval pp = Interval(std::abs(in.e_sin_i)) * sqrt(sin2) + Interval(std::abs(in.g_i)) * sqrt(norm);
  const Interval s = per_s2 + norm * per_p2;
  const Interval p = Interval(std::norm(in.g_i)) * per_s2 + square(pp) * per_p2;
  return (Interval(in.s_weight) * s + Interval(in.p_weight) * p).high * (1 + 1e-12);  // std::abs and norm round
}

template <int N>
Series<N> lobe_series(const LobeKernel::Constants& k, const RangeDirections<N>& d) {
  if (!k.lit) return Series<N>(0.0);
  const auto facet = [&](const std::array<Series<N>, 3>& v, int i) {
    if (!k.tilted) return v[static_cast<std::size_t>(i)];
    return k.facet_from_sample(i, 0) * v[0] + k.facet_from_sample(i, 1) * v[1] + k.facet_from_sample(i, 2) * v[2];
  };
  Series<N> c = facet(d.ws, 2);
  if (c.c[0].high <= 0) return Series<N>(0.0);
  const bool horizon = c.c[0].low <= 0;
  if (N > 0 && horizon) return everything<N>();
  Series<N> z = facet(d.sum, 2);
  // Behind the horizon the term is 0; in front of it these hold.
  c.c[0] = intersection(c.c[0], Interval(0, 1));
  z.c[0] = intersection(z.c[0], outward(k.wi.z(), 2));
  const Series<N> per_z2 = Series<N>(1.0) / square(z);
  const Series<N> tan2 = (square(facet(d.sum, 0)) + square(facet(d.sum, 1))) * per_z2;
  const Series<N> gauss = exp(-k.per_m2 * tan2);
  const Series<N> wx = facet(d.ws, 0), wy = facet(d.ws, 1);
  Series<N> q = q_series(k, wx, wy, c);
  const Interval sin2 = intersection(square(wx.c[0]) + square(wy.c[0]), Interval(0, 1));
  q.c[0] = intersection(q.c[0], Interval(0, largest_q(k, c.c[0], sin2)));
  Series<N> out = k.scale_per_sr * (q * per_z2 * square(Series<N>(1.0) + tan2) * gauss);
  if (horizon) out.c[0].low = 0;
  return out;
}

template <int N>
Series<N> stripes_series(const StripesKernel::Constants& k, const RangeDirections<N>& d) {
  const Series<N> along = k.cos_phi * d.sum[0] + k.sin_phi * d.sum[1];
  Series<N> across = k.cos_phi * d.sum[1] - k.sin_phi * d.sum[0];
  const Series<N> length2 = square(d.sum[0]) + square(d.sum[1]) + square(d.sum[2]);
  const Series<N> gauss = exp(-k.per_c2 * (square(along) / length2));
  if (k.paper) across = across / sqrt(length2);
  return k.rho_per_sr * (square(cos_pi(k.period_turns * across)) * square(sinc_pi(k.width_turns * across)) * gauss);
}

}  // namespace

template <int N>
RangeDirections<N> range_directions(const DirectionPlane& plane, const Vector3<double>& wi, const PixelRange& range,
                                    Along along) {
  std::array<Series<N>, 3> ray;
  for (int i = 0; i < 3; ++i) {
    Series<N>& r = ray[static_cast<std::size_t>(i)];
    r.c[0] = Interval(plane.origin[i]) + range.columns * Interval(plane.column_step[i]) +
             range.rows * Interval(plane.row_step[i]);
    if constexpr (N > 0) r.c[1] = along == Along::kColumns ? plane.column_step[i] : plane.row_step[i];
  }
  const Series<N> per_length = Series<N>(1.0) / sqrt(square(ray[0]) + square(ray[1]) + square(ray[2]));
  RangeDirections<N> out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.ws[i] = ray[i] * per_length;
    out.ws[i].c[0] = intersection(out.ws[i].c[0], outward(-1, 1));
    out.sum[i] = Series<N>(wi[static_cast<Eigen::Index>(i)]) + out.ws[i];
  }
  return out;
}

template <int N>
Series<N> term_series(const ModelKernel::Term& term, const RangeDirections<N>& directions) {
  Series<N> out;
  if (const auto* lobe = std::get_if<LobeKernel>(&term)) {
    out = lobe_series(lobe->constants(), directions);
  } else {
    out = stripes_series(std::get_if<StripesKernel>(&term)->constants(), directions);
  }
  // No term is negative.
  out.c[0] = {std::max(out.c[0].low, 0.0), out.c[0].high};
  return out;
}

template RangeDirections<0> range_directions(const DirectionPlane&, const Vector3<double>&, const PixelRange&, Along);
template RangeDirections<4> range_directions(const DirectionPlane&, const Vector3<double>&, const PixelRange&, Along);
template RangeDirections<8> range_directions(const DirectionPlane&, const Vector3<double>&, const PixelRange&, Along);
template Series<0> term_series(const ModelKernel::Term&, const RangeDirections<0>&);
template Series<4> term_series(const ModelKernel::Term&, const RangeDirections<4>&);
template Series<8> term_series(const ModelKernel::Term&, const RangeDirections<8>&);

}  // namespace scatmap
