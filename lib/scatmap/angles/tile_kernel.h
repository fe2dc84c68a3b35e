#pragma once
#include "scatmap/angles/tile_kernel_body.h"

/// The loops of tile_kernel_body.h, compiled for every instruction set (base/simd.h).
namespace scatmap::kernel {

void run_tile_series(const TileLine& line, TileCoefficients<kTileDegree<float>>& out);
void run_tile_series(const TileLine& line, TileCoefficients<kTileDegree<double>>& out);

/// @param degree kLeastTileDegree to kTileDegree
void run_tile_row(int degree, const RowPolynomial<float>& row, std::size_t n, float* theta, float* phi);
void run_tile_row(int degree, const RowPolynomial<double>& row, std::size_t n, double* theta, double* phi);

}  // namespace scatmap::kernel
