#include "scatmap/model/stripes_kernel.h"

#include <cmath>
#include <numbers>

#include "scatmap/base/exponential.h"
#include "scatmap/base/simd.h"
#include "scatmap/base/sine.h"

namespace scatmap {
namespace {

using Constants = StripesKernel::Constants;

struct Pattern {
  alignas(64) ChunkRow across;  // the coordinate that the phases multiply
  alignas(64) ChunkRow exponent;
};

SCATMAP_CLONES
void fill_pattern(const Constants& k, const DirectionChunk& in, Pattern& pattern) {
  const double cos_phi = k.cos_phi, sin_phi = k.sin_phi, per_c2 = k.per_c2;
  const bool paper = k.paper;
  for (int i = 0; i < kChunk; ++i) {
    const double x = in.sum_x[i], y = in.sum_y[i], z = in.sum_z[i];
    const double along = cos_phi * x + sin_phi * y, across = cos_phi * y - sin_phi * x;
    const double per_length2 = 1 / (x * x + y * y + z * z);
    pattern.exponent[i] = -per_c2 * (along * along) * per_length2;
    pattern.across[i] = across * (paper ? std::sqrt(per_length2) : 1.0);
  }
}

// Whether any exponential of the chunk is not 0 (NaN counts).
SCATMAP_CLONES
bool any_light(const Pattern& pattern) {
  long long live = 0;
  for (int i = 0; i < kChunk; ++i) live |= pattern.exponent[i] < kSmallestExponent ? 0LL : 1LL;
  return live != 0;
}

template <class T>
SCATMAP_INLINE void add_pattern(const Constants& k, const Pattern& pattern, double* values) {
  constexpr double kPi = std::numbers::pi;
  const double period = k.period_turns, width = k.width_turns, rho = k.rho_per_sr;
  for (int i = 0; i < kChunk; ++i) {
    const double y = pattern.across[i];
    // cos(pi t) = sin(pi (1/2 − |t|)): relative digits are kept beside its zeros.
    const T cosine = sin_pi_kernel(static_cast<T>(0.5 - std::abs(beside_integer(period * y))));
    const double turns = width * y;
    const T sine = sin_pi_kernel(static_cast<T>(beside_integer(turns)));
    const T sinc = turns == 0 ? T(1) : sine / static_cast<T>(kPi * turns);
    const double amplitude = static_cast<double>(cosine) * static_cast<double>(sinc);
    values[i] += rho * (amplitude * amplitude) * exp_kernel<T>(pattern.exponent[i]);
  }
}

SCATMAP_CLONES
void add_double(const Constants& k, const Pattern& pattern, double* values) { add_pattern<double>(k, pattern, values); }
SCATMAP_CLONES
void add_single(const Constants& k, const Pattern& pattern, double* values) { add_pattern<float>(k, pattern, values); }

}  // namespace

StripesKernel::StripesKernel(const StripesTerm& term, double phi_ref_rad, double wavelength_m,
                             double detector_distance_m, const Vector3<double>& wi) {
  const bool paper = term.form == StripesForm::kPaper;
  const double stretch = (paper ? 2 * wi.z() : 1) / wavelength_m, r_per_c = detector_distance_m / term.c_m;
  constants_ = {paper,
                std::cos(phi_ref_rad),
                std::sin(phi_ref_rad),
                term.rho,
                r_per_c * r_per_c,
                term.a_m * stretch,
                term.b_m * stretch};
}

void StripesKernel::add(const DirectionChunk& chunk, Amplitudes amplitudes, ChunkRow& values) const {
  Pattern pattern;
  fill_pattern(constants_, chunk, pattern);
  if (!any_light(pattern)) return;
  (amplitudes == Amplitudes::kDouble ? add_double : add_single)(constants_, pattern, values);
}

}  // namespace scatmap
