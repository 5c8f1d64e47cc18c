#pragma once
// The box cells of an unjittered box lattice.
#include "cloud/cloud.hpp"

namespace calor {

/// Low and high end of something along an axis, m.
struct CellExtent {
  double low, high;
};

/// The cell of local point i along an axis: half a spacing to both sides, but not through walls.
CellExtent extent(const Cloud& cloud, int i, int axis);

}  // namespace calor
