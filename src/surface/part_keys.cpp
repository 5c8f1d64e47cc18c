#include "surface/part_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "case/lengths.hpp"
#include "surface/outline.hpp"
#include "surface/surface_tree.hpp"

namespace calor {
namespace {

/// A vector with a component for every axis of the surface.
Vec3 vector_from(const Table& part, const std::string& key, int dimension) {
  const std::vector<double> numbers = part.numbers(key);
  if (static_cast<int>(numbers.size()) != dimension)
    part.refuse(key,
                fmt::format("{} has {} number{} for a shape of {} dimensions", key, numbers.size(),
                            numbers.size() == 1 ? "" : "s", dimension),
                fmt::format("give {}, one for every axis", dimension));
  Vec3 out;
  for (int axis = 0; axis < dimension; ++axis) out[axis] = numbers[axis];
  return out;
}

/// Turns x around an axis; `along` is the direction that the angle of the turn has.
Vec3 turned(const Vec3& x, int axis, const Vec3& along) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  Vec3 out = x;
  out[u] = along.x * x[u] - along.y * x[v];
  out[v] = along.y * x[u] + along.x * x[v];
  return out;
}

void turn(Surface& surface, const Table& part) {
  const std::vector<double> angles = part.numbers("turn");
  const bool is_plane = surface.dimension == 2;
  if (angles.size() != (is_plane ? 1 : 3))
    part.refuse("turn", fmt::format("turn has {} angle{}", angles.size(), angles.size() == 1 ? "" : "s"),
                is_plane ? "give one: a shape in the plane turns counter-clockwise"
                         : "give three: around the x axis, then the y axis, then the z axis");
  for (std::size_t n = 0; n < angles.size(); ++n)
    for (Vec3& x : surface.vertices) x = turned(x, is_plane ? 2 : static_cast<int>(n), direction(angles[n]));
}

/// Does the surface touch or cross a copy of itself that is moved by `way`?
bool touches_copy(const Surface& surface, const SurfaceTree& tree, const Vec3& way, double tolerance) {
  for (const Vec3& move : {way, -way})
    for (const Surface::Triangle& facet : surface.facets)
      for (int n = 0; n < surface.dimension; ++n) {
        const Vec3 a = surface.vertices[facet.vertex[n]] + move;
        const Vec3 b = surface.vertices[facet.vertex[(n + 1) % surface.dimension]] + move;
        if (tree.closest(a, tolerance) || tree.is_crossed(a, b)) return true;
      }
  return false;
}

void refuse_touching_copies(const Surface& surface, const Vec3& step, long count, const Table& part) {
  Vec3 low = surface.vertices.front(), high = low;
  for (const Vec3& x : surface.vertices)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], x[axis]);
      high[axis] = std::max(high[axis], x[axis]);
    }
  const Vec3 extent = high - low;
  const double tolerance = 1e-9 * norm(extent);
  const SurfaceTree tree(surface);
  for (long copy = 1; copy < count; ++copy) {
    const Vec3 way = static_cast<double>(copy) * step;
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(way[axis]) > extent[axis] + tolerance) return;  // and so is every further one
    if (touches_copy(surface, tree, way, tolerance))
      part.refuse(
          "step", fmt::format("copy {} touches the first one", copy + 1),
          fmt::format("the shape measures {:g} x {:g} x {:g} m: take a longer step", extent.x, extent.y, extent.z));
  }
}

void repeat(Surface& surface, const Table& part) {
  const long count = part.integer("count");
  if (count < 1) part.refuse("count", fmt::format("a count of {}", count), "give at least 1");
  if (count > 1 && !part.has("step"))
    part.refuse("count", fmt::format("{} copies in one place", count), "add step: the way from one to the next");
  if (!part.has("step")) return;
  const Vec3 step = vector_from(part, "step", surface.dimension);
  if (count == 1) part.refuse("step", "a step without copies", "add count, or leave step out");
  if (step == Vec3{}) part.refuse("step", "the copies lie on each other", "give a step");
  const std::size_t vertices = surface.vertices.size(), facets = surface.facets.size();
  if (static_cast<double>(count) * static_cast<double>(vertices + facets) > std::numeric_limits<std::int32_t>::max())
    part.refuse("count", fmt::format("{} copies of {} facets are too many", count, facets), "give fewer");
  refuse_touching_copies(surface, step, count, part);
  for (int copy = 1; copy < count; ++copy) {
    for (std::size_t n = 0; n < vertices; ++n) {
      const Vec3 moved = surface.vertices[n] + static_cast<double>(copy) * step;
      surface.vertices.push_back(moved);
    }
    for (std::size_t n = 0; n < facets; ++n) {
      Surface::Triangle facet = surface.facets[n];
      for (int corner = 0; corner < surface.dimension; ++corner)
        facet.vertex[corner] += copy * static_cast<int>(vertices);
      surface.facets.push_back(facet);
    }
  }
}

}  // namespace

Vec3 positive_lengths(const Table& part, const std::string& key, int dimension) {
  const Vec3 lengths = vector_from(part, key, dimension);
  for (int axis = 0; axis < dimension; ++axis)
    if (!(lengths[axis] > 0))
      part.refuse(key, fmt::format("{} has a length of {:g} m, which is not positive", key, lengths[axis]),
                  "give positive ones");
  return lengths;
}

Radii inner_and_outer(const Table& part) {
  const Radii radii{positive_length(part, "inner"), positive_length(part, "outer")};
  if (!(radii.inner < radii.outer))
    part.refuse("inner", fmt::format("inner = {:g} m is not below outer = {:g} m", radii.inner, radii.outer),
                "give the smaller radius as inner");
  return radii;
}

std::vector<Key> placing_keys() {
  return {
      {"at", Kind::quantities, "m", optional, "Where the origin of the shape lies; the origin if absent."},
      {"turn", Kind::quantities, "rad", optional,
       "How the shape is turned around its origin before it is moved, counter-clockwise: one angle in the plane; in "
       "space three, around the x axis, then the y axis, then the z axis, which stay where they are."},
      {"count", Kind::integer, "", "1", "How many copies there are, a step from one to the next."},
      {"step", Kind::quantities, "m", optional, "The step, along the axes of the body; copies must not touch."}};
}

Surface place(Surface surface, const Table& part) {
  if (part.has("turn")) turn(surface, part);
  if (part.has("at")) {
    const Vec3 at = vector_from(part, "at", surface.dimension);
    for (Vec3& x : surface.vertices) x += at;
  }
  repeat(surface, part);
  return surface;
}

}  // namespace calor
