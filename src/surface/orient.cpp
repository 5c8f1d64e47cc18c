#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "surface/edges.hpp"
#include "surface/surface.hpp"
#include "surface/surface_tree.hpp"

namespace calor {
namespace {

struct Shell {
  std::vector<std::int32_t> facets;
  Vec3 low, high;
};

/// Turns a facet to its other side.
void turn(Surface& surface, int facet) {
  auto& vertex = surface.facets[facet].vertex;
  std::swap(vertex[0], vertex[surface.dimension - 1]);
}

/// Facets that hang together by edges of two facets. `turned` tells of every facet whether it runs against the first
/// facet of its shell, in which case it is turned.
std::vector<Shell> shells_of(Surface& surface, std::vector<char>& turned) {
  struct Neighbour {
    std::int32_t facet = -1;
    bool alike = false;  ///< it runs with this one instead of against it
  };
  std::vector<std::array<Neighbour, 3>> neighbours(surface.facets.size());
  for_each_edge(sides_by_edge(surface), [&](std::span<const Side> sides) {
    if (sides.size() != 2) return;
    const bool alike = sides[0].forward == sides[1].forward;
    neighbours[sides[0].facet][sides[0].side] = {sides[1].facet, alike};
    neighbours[sides[1].facet][sides[1].side] = {sides[0].facet, alike};
  });
  std::vector<Shell> shells;
  std::vector<char> seen(surface.facets.size());
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (std::size_t first = 0; first < surface.facets.size(); ++first) {
    if (seen[first]) continue;
    seen[first] = 1;
    Shell shell{.facets = {static_cast<std::int32_t>(first)},
                .low = {infinity, infinity, infinity},
                .high = {-infinity, -infinity, -infinity}};
    for (std::size_t n = 0; n < shell.facets.size(); ++n) {
      const std::int32_t f = shell.facets[n];
      for (const Neighbour& next : neighbours[f]) {
        if (next.facet < 0 || seen[next.facet]) continue;
        seen[next.facet] = 1;
        turned[next.facet] = static_cast<char>(turned[f] != next.alike);
        shell.facets.push_back(next.facet);
      }
      for (int k = 0; k < surface.dimension; ++k) {
        const Vec3& x = surface.vertices[surface.facets[f].vertex[k]];
        for (int a = 0; a < 3; ++a) {
          shell.low[a] = std::min(shell.low[a], x[a]);
          shell.high[a] = std::max(shell.high[a], x[a]);
        }
      }
    }
    for (const std::int32_t f : shell.facets)
      if (turned[f]) turn(surface, f);
    shells.push_back(std::move(shell));
  }
  return shells;
}

/// A shell alone, with vertices of its own.
Surface alone(const Surface& surface, const Shell& shell) {
  Surface out;
  out.dimension = surface.dimension;
  for (const std::int32_t f : shell.facets) {
    Surface::Triangle facet;
    for (int k = 0; k < surface.dimension; ++k) {
      facet.vertex[k] = static_cast<std::int32_t>(out.vertices.size());
      out.vertices.push_back(surface.vertices[surface.facets[f].vertex[k]]);
    }
    out.facets.push_back(facet);
  }
  return out;
}

void turn_shell(Surface& surface, const Shell& shell, std::vector<char>& turned) {
  for (const std::int32_t f : shell.facets) {
    turn(surface, f);
    turned[f] = static_cast<char>(!turned[f]);
  }
}

/// Whether the shell lies inside the one of the tree. Places that both have in common tell nothing, so the first place
/// that is clearly in or out decides.
bool lies_inside(const Surface& surface, const Shell& shell, const SurfaceTree& other) {
  double clearest = 0.5;
  for (const std::int32_t f : shell.facets) {
    const double w = other.winding_number(surface.centroid(f));
    if (std::abs(w - 0.5) > std::abs(clearest - 0.5)) clearest = w;
    if (std::abs(clearest - 0.5) > 0.4) break;
  }
  return clearest > 0.5;
}

}  // namespace

int orient(Surface& surface) {
  std::vector<char> turned(surface.facets.size());
  const std::vector<Shell> shells = shells_of(surface, turned);
  std::vector<int> depth(shells.size());
  for (std::size_t s = 0; s < shells.size(); ++s) {
    if (enclosed_volume(alone(surface, shells[s])) < 0) turn_shell(surface, shells[s], turned);
    if (shells.size() == 1) break;
    const auto holds = [&](const Shell& other) {  // the box of the other; most shells hold no other
      for (int a = 0; a < 3; ++a)
        if (other.low[a] < shells[s].low[a] || other.high[a] > shells[s].high[a]) return false;
      return &other != &shells[s];
    };
    std::vector<std::size_t> held;
    for (std::size_t t = 0; t < shells.size(); ++t)
      if (holds(shells[t])) held.push_back(t);
    if (held.empty()) continue;
    const Surface shell = alone(surface, shells[s]);
    const SurfaceTree tree(shell);
    for (const std::size_t t : held) depth[t] += lies_inside(surface, shells[t], tree);
  }
  for (std::size_t s = 0; s < shells.size(); ++s)
    if (depth[s] % 2 == 1) turn_shell(surface, shells[s], turned);
  return static_cast<int>(std::ranges::count_if(shells, [&](const Shell& shell) {
    return std::ranges::any_of(shell.facets, [&](std::int32_t f) { return turned[f] != 0; });
  }));
}

}  // namespace calor
