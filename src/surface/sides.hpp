#pragma once
// Parts of a body that contacts separate: cells end at the contacts, wherever they run between the points.
#include <functional>
#include <span>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

struct Sides {
  std::vector<int> part;                     ///< of the local points
  std::vector<char> is_beside;               ///< owned points next to a contact, whose cells may end there
  std::vector<std::vector<char>> separated;  ///< of two parts: does a contact lie between them?
  /// Sets the parts of places; `tag`: of the point whose cell or facet it may be. The points must stay in place.
  std::function<void(std::span<const Vec3> x, int tag, std::span<int> part)> at;

  /// Of two local points.
  bool separate(int i, int j) const { return separated[part[i]][part[j]] != 0; }
};

}  // namespace calor
