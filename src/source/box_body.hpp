#pragma once
// Bodies that are boxes: their walls, for mirror images, and the cells of lattices in them, for exact integrals.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "cloud/cloud.hpp"

namespace calor {

struct BoxBody {
  Vec3 low, high;  ///< corners, m
  int dimension;

  double length(int axis) const { return high[axis] - low[axis]; }
  /// Inside or on the walls, to rounding, along the axes for which `along[axis]` is true.
  bool holds(const Vec3& x, const std::array<bool, 3>& along) const;
};
/// Nothing where the faces are not the walls of a box that the cloud fills. Collective.
std::optional<BoxBody> box_body(const Cloud& cloud);

/// The cells of a lattice: those of axis a lie between planes[a][i] and planes[a][i+1].
struct LatticeCells {
  std::array<std::vector<double>, 3> planes;       ///< m; none along axes that the box does not have
  std::vector<std::array<std::int32_t, 3>> index;  ///< of the owned points
};
/// Nothing where the points are not those of an unjittered lattice.
std::optional<LatticeCells> lattice_cells(const Cloud& cloud, const BoxBody& box);

}  // namespace calor
