#pragma once
#include "scatmap/angles/tile_kernel_body.h"

/// The loops of tile_kernel_body.h, compiled for every instruction set (base/simd.h).
namespace scatmap::kernel {

void run_tile_series(const TileLine& line, std::size_t rows, TileCoefficients& out);
/// @param degree 1 to kTileDegree
void run_tile_row(int degree, const RowPolynomial& row, std::size_t n, float* theta, float* phi);

}  // namespace scatmap::kernel
