#include "scatmap/angles/tile_kernel.h"

namespace scatmap::kernel {
namespace {

SCATMAP_CLONES void row1(const RowPolynomial<float>& p, std::size_t n, float* theta, float* phi) {
  tile_row<1>(p, n, theta, phi);
}
SCATMAP_CLONES void row2(const RowPolynomial<float>& p, std::size_t n, float* theta, float* phi) {
  tile_row<2>(p, n, theta, phi);
}
SCATMAP_CLONES void row3(const RowPolynomial<float>& p, std::size_t n, float* theta, float* phi) {
  tile_row<3>(p, n, theta, phi);
}
SCATMAP_CLONES void row4(const RowPolynomial<float>& p, std::size_t n, float* theta, float* phi) {
  tile_row<4>(p, n, theta, phi);
}
SCATMAP_CLONES void row5(const RowPolynomial<double>& p, std::size_t n, double* theta, double* phi) {
  tile_row<5>(p, n, theta, phi);
}
SCATMAP_CLONES void row6(const RowPolynomial<double>& p, std::size_t n, double* theta, double* phi) {
  tile_row<6>(p, n, theta, phi);
}
SCATMAP_CLONES void row7(const RowPolynomial<double>& p, std::size_t n, double* theta, double* phi) {
  tile_row<7>(p, n, theta, phi);
}
SCATMAP_CLONES void row8(const RowPolynomial<double>& p, std::size_t n, double* theta, double* phi) {
  tile_row<8>(p, n, theta, phi);
}
SCATMAP_CLONES void row9(const RowPolynomial<double>& p, std::size_t n, double* theta, double* phi) {
  tile_row<9>(p, n, theta, phi);
}
SCATMAP_CLONES void row10(const RowPolynomial<double>& p, std::size_t n, double* theta, double* phi) {
  tile_row<10>(p, n, theta, phi);
}

}  // namespace

SCATMAP_CLONES void run_tile_series(const TileLine& line, TileCoefficients<kTileDegree<float>>& out) {
  tile_series(line, out);
}
SCATMAP_CLONES void run_tile_series(const TileLine& line, TileCoefficients<kTileDegree<double>>& out) {
  tile_series(line, out);
}

void run_tile_row(int degree, const RowPolynomial<float>& p, std::size_t n, float* theta, float* phi) {
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

void run_tile_row(int degree, const RowPolynomial<double>& p, std::size_t n, double* theta, double* phi) {
  switch (degree) {
    case 5:
      return row5(p, n, theta, phi);
    case 6:
      return row6(p, n, theta, phi);
    case 7:
      return row7(p, n, theta, phi);
    case 8:
      return row8(p, n, theta, phi);
    case 9:
      return row9(p, n, theta, phi);
    default:
      return row10(p, n, theta, phi);
  }
}

}  // namespace scatmap::kernel
