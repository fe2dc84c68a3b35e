#include "scatmap/brdf/exposure_agreement.h"

#include <algorithm>
#include <vector>

#include "scatmap/base/parallel.h"

namespace scatmap {
namespace {

struct Light {
  double first = 0, second = 0, pixels = 0;
};

Light row_light_of(const ScaledCounts& a, const ScaledCounts& b, int row) {
  constexpr double kSigmas = 10;
  Light out;
  const auto variance = [row](const ScaledCounts& e, int c) {
    return e.counts->variance(row, c, e.counts->rate_dn_per_s(row, c)) * e.factor * e.factor;
  };
  for (int c = 0; c < a.counts->mask.columns(); ++c) {
    if (a.counts->mask(row, c) != 0 || b.counts->mask(row, c) != 0) continue;
    const double va = a.counts->rate_dn_per_s(row, c) * a.factor, vb = b.counts->rate_dn_per_s(row, c) * b.factor;
    const double most = std::max(va, vb);
    if (!(most > 0 && most * most > kSigmas * kSigmas * (variance(a, c) + variance(b, c)))) continue;
    out.first += va;
    out.second += vb;
    out.pixels += 1;
  }
  return out;
}

// By rows, so that threads do not change the sums.
Light light_of(const ScaledCounts& a, const ScaledCounts& b) {
  std::vector<Light> rows(static_cast<std::size_t>(a.counts->mask.rows()));
  for_each_row(a.counts->mask.rows(), [&](int r) { rows[static_cast<std::size_t>(r)] = row_light_of(a, b, r); });
  Light sum;
  for (const Light& row : rows) {
    sum.first += row.first;
    sum.second += row.second;
    sum.pixels += row.pixels;
  }
  return sum;
}

}  // namespace

std::optional<Contradiction> contradiction(std::span<const ScaledCounts> exposures) {
  constexpr double kFewest = 10;
  std::optional<Contradiction> worst;
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    for (std::size_t j = i + 1; j < exposures.size(); ++j) {
      const Light light = light_of(exposures[i], exposures[j]);
      if (!(light.pixels >= kFewest)) continue;
      const bool first = light.first > light.second;
      const double ratio = first ? light.second / light.first : light.first / light.second;
      if (ratio * kContradiction >= 1 || (worst && worst->ratio <= ratio)) continue;
      worst = Contradiction{first ? i : j, first ? j : i, ratio};
    }
  }
  return worst;
}

}  // namespace scatmap
