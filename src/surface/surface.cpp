#include "surface/surface.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "surface/edges.hpp"
#include "surface/hash_grid.hpp"

namespace calor {

double enclosed_volume(const Surface& surface) {
  if (surface.facets.empty()) return 0;
  // Seen from a vertex of the body, so that the place of the body costs no digits.
  const Vec3 o = surface.vertices[surface.facets[0].vertex[0]];
  double sum = 0;
  for (const auto& facet : surface.facets) {
    const Vec3 a = surface.vertices[facet.vertex[0]] - o, b = surface.vertices[facet.vertex[1]] - o;
    if (surface.dimension == 2)
      sum += a.x * b.y - a.y * b.x;
    else
      sum += dot(a, cross(b, surface.vertices[facet.vertex[2]] - o));
  }
  return sum / (surface.dimension == 2 ? 2 : 6);
}

// Welding ------------------------------------------------------------------------------------------------------------

int weld(Surface& surface, double tolerance) {
  const std::size_t before = surface.vertices.size();
  double size = 0;
  for (const Vec3& x : surface.vertices) size = std::max({size, std::abs(x.x), std::abs(x.y), std::abs(x.z)});
  HashGrid grid(tolerance, size);
  std::vector<Surface::Triangle> facets;
  std::vector<std::int32_t> place(before, -1);
  for (Surface::Triangle facet : surface.facets) {
    for (int n = 0; n < surface.dimension; ++n) {
      std::int32_t& welded = place[facet.vertex[n]];
      if (welded < 0) welded = grid.find_or_add(surface.vertices[facet.vertex[n]]);
      facet.vertex[n] = welded;
    }
    const auto& [a, b, c] = facet.vertex;
    if (a != b && b != c && c != a) facets.push_back(facet);
  }
  surface.facets = std::move(facets);
  surface.vertices = std::move(grid).places();
  return static_cast<int>(before - surface.vertices.size());
}

// Closed or not ------------------------------------------------------------------------------------------------------

namespace {

/// Edges of one kind of fault: how many, and where the first ones are.
struct Faults {
  int count = 0;
  std::vector<std::string> places;

  void add(const Vec3& x, int dimension) {
    constexpr int told = 3;
    if (++count > told) return;
    places.push_back(dimension == 2 ? fmt::format("({:.6g}, {:.6g}) m", x.x, x.y)
                                    : fmt::format("({:.6g}, {:.6g}, {:.6g}) m", x.x, x.y, x.z));
  }
  /// "3 edges WHAT at (..) m, (..) m, ...", nothing where there are none.
  void tell(std::vector<std::string>& out, int dimension, const std::string& what) const {
    if (count == 0) return;
    out.push_back(fmt::format("{} {} {}, at {}{}", count,
                              dimension == 2 ? (count > 1 ? "corners" : "corner") : (count > 1 ? "edges" : "edge"),
                              what, fmt::join(places, ", "), count > static_cast<int>(places.size()) ? ", ..." : ""));
  }
};

/// Facets that have the same vertices as one before.
int doubled_facets(const Surface& surface) {
  std::vector<std::array<std::int32_t, 3>> corners;
  corners.reserve(surface.facets.size());
  for (const auto& facet : surface.facets) {
    corners.push_back(facet.vertex);
    std::ranges::sort(corners.back());
  }
  std::ranges::sort(corners);
  return static_cast<int>(corners.end() - std::unique(corners.begin(), corners.end()));
}

}  // namespace

void require_closed(const Surface& surface, const SourceLocation& where) {
  if (surface.facets.empty())
    throw Error(Fault::bad_case, where, "the surface has no facets", "give the closed surface of a body");
  Faults open, shared, alike;
  for_each_edge(sides_by_edge(surface), [&](std::span<const Side> sides) {
    const bool is_sound = sides.size() == 2 && sides[0].forward != sides[1].forward;
    if (is_sound) return;
    (sides.size() == 1 ? open : sides.size() > 2 ? shared : alike).add(middle(surface, sides[0]), surface.dimension);
  });
  std::vector<std::string> told;
  open.tell(told, surface.dimension, "with one facet only");
  shared.tell(told, surface.dimension, "with more than two facets");
  alike.tell(told, surface.dimension, "between facets that face to different sides");
  if (told.empty()) return;
  std::string cure = "close it in the program it comes from, or make vertices one over a larger distance (weld = 1e-4)";
  if (const int doubled = doubled_facets(surface); doubled > 0) {
    told.push_back(fmt::format("the reason: {} facet{} twice", doubled, doubled > 1 ? "s come" : " comes"));
    cure =
        "remove the facets that come twice: a wall has one layer of facets, and bodies that touch are parts of their "
        "own";
  } else if (open.count == 0) {
    cure = "move shells that touch apart, or make them parts of their own";
  }
  throw Error(Fault::bad_case, where, fmt::format("the surface is not closed: {}", fmt::join(told, "; ")), cure);
}

}  // namespace calor
