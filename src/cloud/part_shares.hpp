#pragma once
// How much of every cell the parts of a body have.
#include <functional>
#include <span>
#include <vector>

#include "cloud/cloud.hpp"

namespace calor {

/// The parts of a body by place.
struct Partition {
  int count = 0;
  std::function<void(std::span<const Vec3> x, std::span<int> part)> at;  ///< 0 .. count - 1, or -1: none of them
  /// Does one part alone, surely, lie within `radius` (m) of a place?
  std::function<bool(const Vec3& x, double radius)> is_one_around;
};

/// share[p][i]: what part p has of the cell of owned point i, 0 to 1. On unjittered lattices and rings by the
/// quadrature of CellIntegrals. On other clouds by samples (CellSampler), which are asked in cells alone that an
/// interface may cut, and all of them only in the cubes of a quarter spacing (an eighth in the plane) next to it.
std::vector<std::vector<double>> part_shares(const Cloud& cloud, const Partition& parts);

}  // namespace calor
