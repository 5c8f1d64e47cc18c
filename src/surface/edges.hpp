#pragma once
// The edges of a surface and the facets that meet there. In the plane the edges are vertices.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "surface/surface.hpp"

namespace calor {

/// A side of a facet: in space from vertex[side] to the next one, in the plane the vertex at that end.
struct Side {
  std::int32_t facet, side;
  std::array<std::int32_t, 2> edge;  ///< its vertices by ascending number; in the plane the vertex and -1
  bool forward;                      ///< runs along the edge; in the plane: begins there
};

/// Sides of all facets, those of an edge one after the other.
std::vector<Side> sides_by_edge(const Surface& surface);

/// Calls `work` with the sides of one edge after the other.
template <class Work>
void for_each_edge(const std::vector<Side>& sides, const Work& work) {
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].edge == sides[begin].edge) ++end;
    work(std::span(sides).subspan(begin, end - begin));
  }
}

/// Middle of the edge, m.
Vec3 middle(const Surface& surface, const Side& side);
/// Length of the edge, m; 0 in the plane.
double length(const Surface& surface, const Side& side);

}  // namespace calor
