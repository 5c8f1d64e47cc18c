#pragma once
// Neighbours on lattices by their numbers along the axes.
#include "cloud/cloud.hpp"
#include "cloud/lattice.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

/// Numbers of entry n's point along the axes; of an image beyond a wall, as the lattice goes on there: below 0 or
/// beyond the last.
inline LatticeIndex index_of_neighbour(const Lattice& lattice, const Cloud& cloud, const Neighbours& neighbours,
                                       std::int64_t n) {
  LatticeIndex at = lattice.index(cloud.id[neighbours.column[n]]);
  if (!neighbours.is_image(n)) return at;
  const std::uint8_t walls = neighbours.image[n];
  for (int a = 0; a < cloud.dimension; ++a) {
    if (walls >> 2 * a & 1) at[a] = -1 - at[a];
    if (walls >> 2 * a & 2) at[a] = 2 * lattice.box().points[a] - 1 - at[a];
  }
  return at;
}

}  // namespace calor
