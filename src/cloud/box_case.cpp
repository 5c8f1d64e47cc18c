// The [cloud] keys of shape = "box".
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "cloud/lattice.hpp"
#include "cloud/shapes.hpp"

namespace calor {
namespace {

std::string counted(long n, const std::string& one, const std::string& several) {
  return fmt::format("{} {}", n, n == 1 ? one : several);
}

const std::array<std::string, 3> axes = {"x", "y", "z"};

/// The box that coordinates along its axes describe.
void read_coordinates(const Table& cloud, BoxLattice& box) {
  box.dimension = 0;
  while (box.dimension < 3 && cloud.has(axes[box.dimension])) ++box.dimension;
  if (box.dimension == 0)
    cloud.refuse("", "neither the size of the box nor the coordinates of its points were given",
                 "give size = [\"1 m\", ...] and points, or x = [\"0 m\", ...] along every axis");
  for (int a = box.dimension + 1; a < 3; ++a)
    if (cloud.has(axes[a]))
      cloud.refuse(axes[a], axes[a] + " without " + axes[box.dimension], "give the axes in order");
  for (const char* key : {"points", "spacing", "origin", "grading", "jitter"})
    if (cloud.has(key))
      cloud.refuse(key, fmt::format("both {} and coordinates were given", key), "give one of the two");
  box.section = section_of(cloud, box.dimension);
  box.on_walls = cloud.text("at") == "walls";
  for (int a = 0; a < box.dimension; ++a) {
    box.coordinates[a] = cloud.numbers(axes[a]);
    const std::vector<double>& x = box.coordinates[a];
    if (x.size() < 2) cloud.refuse(axes[a], "fewer than 2 coordinates", "give both walls at least");
    for (std::size_t i = 1; i < x.size(); ++i)
      if (!(x[i] > x[i - 1]))
        cloud.refuse(axes[a], fmt::format("{} m follows {} m", x[i], x[i - 1]), "give them in ascending order");
  }
}

/// Intervals in geometric sequence along an axis: the last is `ratio` times the first.
void grade(const Table& cloud, BoxLattice& box, int axis, double ratio) {
  if (!(ratio > 0))
    cloud.refuse("grading", fmt::format("a ratio of {}", ratio), "give the last interval over the first: above 0");
  const std::int64_t n = box.points[axis] - (box.on_walls ? 1 : 0);
  if (ratio == 1 || n < 2) return;
  const double q = std::pow(ratio, 1.0 / static_cast<double>(n - 1));
  const double low = box.origin[axis], size = box.size[axis], all = std::pow(q, n) - 1;
  std::vector<double>& x = box.coordinates[axis];
  for (std::int64_t i = 0; i < n; ++i) x.push_back(low + size * (std::pow(q, i) - 1) / all);
  x.push_back(low + size);
}

Points box_from(MPI_Comm comm, const Table& cloud) {
  BoxLattice box;
  if (!cloud.has("size")) {
    read_coordinates(cloud, box);
    return lattice_points(comm, box);
  }
  for (const std::string& axis : axes)
    if (cloud.has(axis)) cloud.refuse(axis, "both size and " + axis + " were given", "give one of the two");
  const std::vector<double> size = cloud.numbers("size");
  if (size.empty() || size.size() > 3)
    cloud.refuse("size", counted(size.size(), "length", "lengths"),
                 "give one, two or three: the dimension of the body");
  box.dimension = static_cast<int>(size.size());
  box.section = section_of(cloud, box.dimension);
  box.on_walls = cloud.text("at") == "walls";
  const auto check_length = [&](const std::string& key, std::size_t n) {
    if (n != size.size())
      cloud.refuse(key, counted(n, "value for ", "values for ") + counted(size.size(), "axis", "axes"),
                   "give one per axis of size");
  };
  for (int a = 0; a < box.dimension; ++a) {
    if (!(size[a] > 0))
      cloud.refuse("size", fmt::format("a length of {} m is not positive", size[a]), "give positive lengths");
    box.size[a] = size[a];
  }
  if (cloud.has("origin")) {
    const std::vector<double> origin = cloud.numbers("origin");
    check_length("origin", origin.size());
    for (int a = 0; a < box.dimension; ++a) box.origin[a] = origin[a];
  }
  if (cloud.has("points") == cloud.has("spacing"))
    cloud.refuse(cloud.has("points") ? "spacing" : "",
                 cloud.has("points") ? "both points and spacing were given" : "neither points nor spacing was given",
                 "give one of the two");
  const int least = box.on_walls ? 2 : 1;
  if (cloud.has("points")) {
    const std::vector<long> points = cloud.integers("points");
    check_length("points", points.size());
    for (int a = 0; a < box.dimension; ++a) {
      if (points[a] < least)
        cloud.refuse("points", counted(points[a], "point", "points") + " along " + "xyz"[a],
                     fmt::format("give at least {}", least));
      box.points[a] = points[a];
    }
  } else {
    for (int a = 0; a < box.dimension; ++a)
      box.points[a] = intervals(cloud, size[a], cloud.number("spacing")) + (box.on_walls ? 1 : 0);
  }
  if (cloud.has("grading")) {
    const std::vector<double> grading = cloud.numbers("grading");
    check_length("grading", grading.size());
    for (int a = 0; a < box.dimension; ++a) grade(cloud, box, a, grading[a]);
  }
  box.jitter = cloud.number("jitter");
  if (!(box.jitter >= 0 && box.jitter < 0.5))
    cloud.refuse("jitter", fmt::format("a jitter of {}", box.jitter),
                 "give a fraction of the spacing from 0 to below 0.5");
  if (box.jitter > 0 && cloud.has("grading"))
    cloud.refuse("jitter", "jitter of a graded lattice", "leave out jitter or grading");
  box.seed = static_cast<std::uint64_t>(cloud.integer("seed"));
  return lattice_points(comm, box);
}

}  // namespace

CloudShape box_shape() {
  return {.name = "box",
          .sentence = "A box filled with a lattice. Faces: xmin, xmax, ymin, ymax, zmin, zmax",
          .keys = {{"size", Kind::quantities, "m", optional, "Lengths of the box; their number is the dimension."},
                   {"points", Kind::integers, "", optional, "Points along every axis.", {}, {"spacing"}},
                   {"spacing",
                    Kind::quantity,
                    "m",
                    optional,
                    "Distance of the points, instead of their number.",
                    {},
                    {"points"}},
                   {"grading", Kind::numbers, "", optional,
                    "Last interval over the first along every axis; those between grow by one factor. All are equal if "
                    "absent."},
                   {"x", Kind::quantities, "m", optional,
                    "Coordinates of the points along x (of the ends of the cells for at = \"cells\"); with y and z in "
                    "place of size and points."},
                   {"y", Kind::quantities, "m", optional, "The same along y."},
                   {"z", Kind::quantities, "m", optional, "The same along z."},
                   {"origin", Kind::quantities, "m", optional, "Lowest corner; zeros if absent."},
                   {"at",
                    Kind::choice,
                    "",
                    "walls",
                    "Outermost points on the walls, or all at the centres of cells.",
                    {"walls", "cells"}},
                   {"jitter", Kind::number, "", "0",
                    "Random displacement of the points as a fraction of the spacing; points on walls stay on them."},
                   {"seed", Kind::integer, "", "1", "Chooses the random displacements."}},
          .make = box_from};
}

}  // namespace calor
