#pragma once
#include <cstddef>
#include <span>
#include <variant>
#include <vector>

#include "scatmap/model/lobe_kernel.h"
#include "scatmap/model/model.h"
#include "scatmap/model/stripes_kernel.h"

namespace scatmap {

/// A model for one incident direction, evaluated in rows of pixels: the `vector` and `single` methods, and the ground
/// of `culled` and of pixel averages. Lambertian terms are one constant, the others are kept in the model's order.
class ModelKernel {
 public:
  /// `wi`: unit vector towards the source, sample axes. @throws Error if the distance is not a number > 0
  ModelKernel(const Model& model, const Vector3<double>& wi, double detector_distance_m);

  using Term = std::variant<LobeKernel, StripesKernel>;
  const std::vector<Term>& terms() const { return terms_; }
  double constant_per_sr() const { return constant_per_sr_; }
  const Vector3<double>& wi() const { return wi_; }

  /// Adds the terms of `which` (indices into terms()) to `values`; no horizon.
  void add(const DirectionChunk& chunk, std::span<const std::size_t> which, Amplitudes amplitudes,
           ChunkRow& values) const;

  /// The whole model on `values.size()` pixels of a row from `column` on: what PreparedModel gives, NaN below the
  /// horizon included.
  void row(const DirectionPlane& plane, double column, double row, Amplitudes amplitudes,
           std::span<double> values) const;
  /// The same on any directions (unit, NaN where there is none), as a detector with a lens has them.
  void directions(std::span<const Vector3<double>> ws, Amplitudes amplitudes, std::span<double> values) const;

 private:
  void evaluate(const DirectionChunk& chunk, Amplitudes amplitudes, std::span<double> values) const;

  Vector3<double> wi_;
  double constant_per_sr_ = 0;
  std::vector<Term> terms_;
  std::vector<std::size_t> all_;  // 0, 1, …
};

}  // namespace scatmap
