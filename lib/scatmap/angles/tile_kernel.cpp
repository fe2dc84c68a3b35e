#include "scatmap/angles/tile_kernel.h"

namespace scatmap::kernel {
namespace {

SCATMAP_CLONES void row1(const RowPolynomial& p, std::size_t n, float* theta, float* phi) {
  tile_row<1>(p, n, theta, phi);
}
SCATMAP_CLONES void row2(const RowPolynomial& p, std::size_t n, float* theta, float* phi) {
  tile_row<2>(p, n, theta, phi);
}
SCATMAP_CLONES void row3(const RowPolynomial& p, std::size_t n, float* theta, float* phi) {
  tile_row<3>(p, n, theta, phi);
}
SCATMAP_CLONES void row4(const RowPolynomial& p, std::size_t n, float* theta, float* phi) {
  tile_row<4>(p, n, theta, phi);
}

}  // namespace

SCATMAP_CLONES void run_tile_series(const TileLine& line, std::size_t rows, TileCoefficients& out) {
  tile_series(line, rows, out);
}

void run_tile_row(int degree, const RowPolynomial& p, std::size_t n, float* theta, float* phi) {
  switch (degree) {
    case 1:
      return row1(p, n, theta, phi);
    case 2:
      return row2(p, n, theta, phi);
    case 3:
      return row3(p, n, theta, phi);
    default:
      return row4(p, n, theta, phi);
  }
}

}  // namespace scatmap::kernel
