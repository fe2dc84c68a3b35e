#include "scatmap/model/model_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "scatmap/base/error.h"

namespace scatmap {

ModelKernel::ModelKernel(const Model& model, const Vector3<double>& wi, double detector_distance_m) : wi_(wi) {
  if (!(detector_distance_m > 0 && std::isfinite(detector_distance_m))) {
    throw Error({"detector distance", "is out of range", std::to_string(detector_distance_m) + " m", "a number > 0"});
  }
  for (const scatmap::Term& term : model.terms) {
    if (const auto* microfacet = std::get_if<MicrofacetTerm>(&term)) {
      terms_.emplace_back(LobeKernel(*microfacet, model.phi_ref_rad, model.polarization, wi));
    } else if (const auto* stripes = std::get_if<StripesTerm>(&term)) {
      terms_.emplace_back(StripesKernel(*stripes, model.phi_ref_rad, model.wavelength_m, detector_distance_m, wi));
    } else {
      constant_per_sr_ += std::get<LambertianTerm>(term).rho / std::numbers::pi;
    }
  }
  for (std::size_t i = 0; i < terms_.size(); ++i) all_.push_back(i);
}

void ModelKernel::add(const DirectionChunk& chunk, std::span<const std::size_t> which, Amplitudes amplitudes,
                      ChunkRow& values) const {
  for (const std::size_t i : which) {
    if (const auto* lobe = std::get_if<LobeKernel>(&terms_[i])) {
      lobe->add(chunk, amplitudes, values);
    } else {
      std::get_if<StripesKernel>(&terms_[i])->add(chunk, amplitudes, values);
    }
  }
}

void ModelKernel::evaluate(const DirectionChunk& chunk, Amplitudes amplitudes, std::span<double> values) const {
  alignas(64) ChunkRow sum;
  // A source that is not above the horizon lights nothing: NaN everywhere.
  const double lit = wi_.z() > 0 ? (wi_.x() + wi_.y()) * 0 : std::numeric_limits<double>::quiet_NaN();
  std::fill(std::begin(sum), std::end(sum), constant_per_sr_ + lit);
  add(chunk, all_, amplitudes, sum);
  mask_below_horizon(chunk, sum);
  std::copy_n(sum, values.size(), values.begin());
}

void ModelKernel::row(const DirectionPlane& plane, double column, double row, Amplitudes amplitudes,
                      std::span<double> values) const {
  DirectionChunk chunk;
  for (std::size_t i = 0; i < values.size(); i += kChunk) {
    fill_chunk(plane, wi_, column + static_cast<double>(i), row, chunk);
    evaluate(chunk, amplitudes, values.subspan(i, std::min<std::size_t>(kChunk, values.size() - i)));
  }
}

void ModelKernel::directions(std::span<const Vector3<double>> ws, Amplitudes amplitudes,
                             std::span<double> values) const {
  DirectionChunk chunk;
  for (std::size_t i = 0; i < ws.size(); i += kChunk) {
    const std::size_t count = std::min<std::size_t>(kChunk, ws.size() - i);
    for (std::size_t j = 0; j < count; ++j) {
      chunk.ws_x[j] = ws[i + j].x();
      chunk.ws_y[j] = ws[i + j].y();
      chunk.ws_z[j] = ws[i + j].z();
    }
    complete_chunk(wi_, static_cast<int>(count), chunk);
    evaluate(chunk, amplitudes, values.subspan(i, count));
  }
}

}  // namespace scatmap
