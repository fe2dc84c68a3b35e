#pragma once
#include <cstddef>

namespace scatmap::kernel {

/// One row of the linear map: angle = (angle + rest) + d step, d = first_d, first_d + 1, …
struct LinearRow {
  float first_d;
  float theta, theta_rest, theta_step;
  float phi, phi_rest, phi_step;
};

/// phi is brought back to [0, 2 pi).
void run_linear(const LinearRow& row, std::size_t n, float* theta, float* phi);

}  // namespace scatmap::kernel
