#pragma once
#include "scatmap/base/direction.h"

namespace scatmap {

/// Where the pixels of a flat detector lie, in sample axes with the spot as origin: pixel (column, row) at
/// origin + column·column_step + row·row_step, in any unit of length. Only its directions are used.
struct DirectionPlane {
  Vector3<double> origin;
  Vector3<double> column_step;
  Vector3<double> row_step;

  Vector3<double> at(double column, double row) const { return origin + column * column_step + row * row_step; }
};

}  // namespace scatmap
