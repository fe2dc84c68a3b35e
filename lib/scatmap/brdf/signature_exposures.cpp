#include "scatmap/brdf/signature_exposures.h"

#include <algorithm>
#include <cmath>

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

// The merged image with its whole variance as a floor: measure_signature only adds variances up.
Counts as_counts(Merged merged) {
  const int rows = merged.mask.rows(), columns = merged.mask.columns();
  Counts out{
      std::move(merged.value), std::move(merged.variance), {rows, columns, 0.0f}, {rows, columns, 0.0f}, {}, 1.0, 0, 0};
  out.mask = std::move(merged.mask);
  return out;
}

// Shares and level over the aperture, weighted by the light that a pixel carries.
void weigh_exposures(std::span<const ScaledCounts> exposures, const std::vector<Grid<float>>& share,
                     const Counts& image, MergedSignature& out) {
  const Signature& beam = out.beam;
  std::vector<double> square(exposures.size(), 0);
  double sum = 0;
  for (int r = 0; r < image.mask.rows(); ++r) {
    for (int c = 0; c < image.mask.columns(); ++c) {
      if (image.mask(r, c) != 0 || std::hypot(r - beam.row, c - beam.column) > beam.radius_px) continue;
      const double net = image.rate_dn_per_s(r, c) - beam.background_dn_per_s;
      sum += net;
      for (std::size_t e = 0; e < exposures.size(); ++e) {
        const double part = static_cast<double>(share[e](r, c)) * net;
        out.share[e] += part;
        square[e] += part * net;
      }
    }
  }
  double total = 0;
  for (double& s : out.share) total += s = std::max(0.0, s / sum);
  for (std::size_t e = 0; e < exposures.size(); ++e) {
    out.share[e] /= total;
    out.level_dn += square[e] / sum / exposures[e].factor * exposures[e].counts->exposure_s;
  }
}

// A stated aperture against the one that would be found. None is, where the beam is wider than its frame: then the
// stated one is all there is.
void compare_apertures(const Counts& image, std::optional<double> radius_px, MergedSignature& out) {
  if (!radius_px) return;
  try {
    const Signature found = measure_signature(image, std::nullopt);
    out.outside = std::max(0.0, 1 - out.beam.rate_dn_per_s / found.rate_dn_per_s);
    out.found_radius_px = found.radius_px;
  } catch (const Error&) {
    return;
  }
}

}  // namespace

MergedSignature merge_signature(std::span<const ScaledCounts> exposures, std::optional<double> radius_px) {
  if (exposures.size() == 1) {
    const Counts& counts = *exposures.front().counts;
    const Signature beam = measure_signature(counts, radius_px);
    MergedSignature out{beam, {1.0}, beam.effective_rate * counts.exposure_s};
    out.other = other_spot(counts, beam);
    compare_apertures(counts, radius_px, out);
    return out;
  }
  Merged merged = merge(exposures);
  const std::vector<Grid<float>> share = std::move(merged.share);
  const Counts image = as_counts(std::move(merged));
  MergedSignature out{measure_signature(image, radius_px), std::vector<double>(exposures.size(), 0), 0};
  weigh_exposures(exposures, share, image, out);
  out.other = other_spot(image, out.beam);
  compare_apertures(image, radius_px, out);
  return out;
}

}  // namespace scatmap
