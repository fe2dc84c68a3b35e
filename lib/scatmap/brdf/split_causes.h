#pragma once
#include "scatmap/base/grid.h"
#include "scatmap/brdf/brdf_map.h"
#include "scatmap/brdf/exposure_causes.h"
#include "scatmap/brdf/merge.h"
#include "scatmap/brdf/overlap.h"

namespace scatmap {

/// What the causes act on.
struct CauseImages {
  const Merged& merged;  ///< for the exposures' shares
  const Grid<double>& expected_per_sr;
  const Grid<float>& nonlinearity;  ///< relative change of each pixel at one sigma of non-linearity; empty: none
};

/// Parts the causes of several exposures into scale and structured causes, written to map.scale and map.structured.
/// As stated: a cause that acts alike on every exposure is scale, any other moves each pixel by its exposures' shares.
/// After a measured overlap the exposures' factors g_e have a joint covariance Γ (with the non-linearity): the scale is
/// the best linear unbiased estimate's variance 1/(1'Γ^-1 1), the largest part that all pixels have in common and that
/// is independent of the rest; the rest is one structured cause per eigenvector of what remains.
void split_causes(const ExposureCauses& causes, const OverlapSolution* overlap, const CauseImages& images,
                  BrdfMap& map);

}  // namespace scatmap
