#include "cloud/mirror.hpp"

namespace calor {

std::vector<Mirror> mirrors_of(const std::vector<double>& walls) {
  std::vector<Mirror> mirrors(std::size_t{1} << walls.size());
  for (std::uint32_t set = 0; set < mirrors.size(); ++set) {
    if (has_opposite_walls(set)) continue;
    for (std::size_t f = 0; f < walls.size(); ++f) {
      if (!(set >> f & 1)) continue;
      const int axis = static_cast<int>(f / 2);
      mirrors[set].sign[axis] = -1;
      mirrors[set].shift[axis] = 2 * walls[f];
    }
  }
  return mirrors;
}

}  // namespace calor
