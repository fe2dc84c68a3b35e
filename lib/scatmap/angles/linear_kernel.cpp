#include "scatmap/angles/linear_kernel.h"

#include "scatmap/base/simd.h"

namespace scatmap::kernel {

SCATMAP_CLONES void run_linear(const LinearRow& row, std::size_t n, float* theta, float* phi) {
  constexpr float kTwoPi = 6.2831855f;
  for (std::size_t i = 0; i < n; ++i) {
    const float d = row.first_d + static_cast<float>(static_cast<int>(i));
    theta[i] = row.theta + (row.theta_rest + d * row.theta_step);
    const float f = row.phi + (row.phi_rest + d * row.phi_step);
    const float up = f < 0 ? f + kTwoPi : f;  // may round to 2 pi
    phi[i] = up >= kTwoPi ? up - kTwoPi : up;
  }
}

}  // namespace scatmap::kernel
