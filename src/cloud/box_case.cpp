// The [cloud] keys of shape = "box".
#include <fmt/format.h>

#include "cloud/lattice.hpp"
#include "cloud/shapes.hpp"

namespace calor {
namespace {

std::string counted(long n, const std::string& one, const std::string& several) {
  return fmt::format("{} {}", n, n == 1 ? one : several);
}

}  // namespace

Points box_from(MPI_Comm comm, const Table& cloud) {
  BoxLattice box;
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
  box.jitter = cloud.number("jitter");
  if (!(box.jitter >= 0 && box.jitter < 0.5))
    cloud.refuse("jitter", fmt::format("a jitter of {}", box.jitter),
                 "give a fraction of the spacing from 0 to below 0.5");
  box.seed = static_cast<std::uint64_t>(cloud.integer("seed"));
  return make_box(comm, box);
}

void declare_box(Schema& schema) {
  schema.add(
      {.path = "cloud",
       .sentence = "A box filled with a lattice. Faces: xmin, xmax, ymin, ymax, zmin, zmax.",
       .keys = {{"size", Kind::quantities, "m", required, "Lengths of the box; their number is the dimension."},
                {"points", Kind::integers, "", optional, "Points along every axis."},
                {"spacing", Kind::quantity, "m", optional, "Distance of the points, instead of their number."},
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
       .when_key = "shape",
       .when_value = "box"});
}

}  // namespace calor
