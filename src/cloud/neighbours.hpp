#pragma once
// Neighbour lists within the support, by a cell list.
#include <cstdint>
#include <span>
#include <vector>

#include "cloud/cloud.hpp"

namespace calor {

/// Directed lists in compressed rows: neighbours of owned point i are column[row[i]] .. column[row[i+1]], local indices
/// (ghosts >= cloud.owned), without i itself, in ascending order of id, so that sums over neighbours do not depend on
/// the number of ranks.
struct Neighbours {
  std::vector<std::int64_t> row;
  std::vector<std::int32_t> column;

  std::span<const std::int32_t> of(int i) const {
    return {column.data() + row[i], static_cast<std::size_t>(row[i + 1] - row[i])};
  }
};

/// All pairs with |x_j - x_i| < reach * (d_i + d_j) / 2 * (1 - 1e-9), d the local spacing. Refuses points that coincide
/// (closer than 1e-9 of that). Collective; throws Error.
Neighbours find_neighbours(const Cloud& cloud, double reach);

/// Refuses points with fewer neighbours than the body has dimensions (ends of a line: one), which cannot carry heat in
/// every direction. Collective; throws Error.
void require_neighbours(const Cloud& cloud, const Neighbours& neighbours);

}  // namespace calor
