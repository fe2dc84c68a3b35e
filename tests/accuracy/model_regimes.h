#pragma once
#include <random>
#include <string>
#include <vector>

#include "data-synthetic/truth_model.h"
#include "scatmap/model/model.h"

namespace scatmap::accuracy {

inline constexpr double kDistance_mm = 325.0;

/// One model, one direction of incidence and many scattered directions, with the truth in long double by the
/// simulator's own formulas.
struct ModelCase {
  Model model;
  synth::ModelTruth truth;
  Vector3<double> wi;
  std::vector<Vector3<double>> ws;
  std::vector<long double> truth_per_sr;
  long double peak_per_sr = 0;  ///< the largest truth
  /// Whether directions' rounding enters: a tilt turns them, a phase multiplies them.
  bool sensitive = false;
};

/// What the methods have to stand; equal numbers of directions each.
enum class Regime {
  kHemisphere,    ///< wide lobes, any directions
  kPeak,          ///< theta_h from 1e-12 to 1e-3
  kWidths,        ///< m from 1e-6 to 10, directions within four widths
  kGrazing,       ///< 85 to 89 degrees in and out
  kFaintSurface,  ///< n from 1 + 1e-6 to 1.1
  kMetals,        ///< e with negative real part
  kTotal,         ///< n < 1, on both sides of the critical angle
  kNormal,        ///< incident or scattered direction within 1e-3 of the normal, or along it
  kTilted,        ///< tilted facets, any phi_ref
  kPolarised,     ///< s and p light
  kStripes,       ///< both forms, 1 to 1e9 periods
  kPaper,         ///< the paper's scene in its frame
};
inline constexpr int kRegimeCount = 12;
const char* regime_name(Regime regime);

ModelCase model_case(Regime regime, int directions, std::mt19937_64& random);

/// The simulator's truth for a model given in its file's units.
long double truth_at(const ModelCase& c, const Vector3<long double>& ws);
void add_lobe(ModelCase& c, double rho, double m, std::complex<double> n, double dtheta_deg = 0, double dphi_deg = 0);
void add_stripes(ModelCase& c, double rho, double a_um, double b_um, double c_um, StripesForm form);
void add_lambertian(ModelCase& c, double rho);
/// A case without terms or directions.
ModelCase empty_case(const Vector3<double>& wi, double phi_ref_deg = 0,
                     Polarization polarization = Polarization::kUnpolarized);

}  // namespace scatmap::accuracy
