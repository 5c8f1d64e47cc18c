// Discs and cylinders, whole, halves and quarters, by concentric rings.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cloud/ring_lattice.hpp"
#include "cloud/shapes.hpp"

namespace calor {
namespace {

Rings rings_from(const Table& cloud) {
  Rings r;
  r.radius = cloud.number("radius");
  if (!(r.radius > 0))
    cloud.refuse("radius", fmt::format("a radius of {} m is not positive", r.radius), "give a positive one");
  if (cloud.has("rings") == cloud.has("spacing"))
    cloud.refuse(cloud.has("rings") ? "spacing" : "",
                 cloud.has("rings") ? "both rings and spacing were given" : "neither rings nor spacing was given",
                 "give one of the two");
  if (cloud.has("rings") && cloud.integer("rings") < 1)
    cloud.refuse("rings", fmt::format("{} rings", cloud.integer("rings")), "give at least 1");
  r.rings = static_cast<int>(cloud.has("rings") ? cloud.integer("rings")
                                                : intervals(cloud, r.radius, cloud.number("spacing")));
  const std::string sector = cloud.text("sector");
  r.sector = sector == "full" ? Sector::full : sector == "half" ? Sector::half : Sector::quarter;
  return r;
}

}  // namespace

Points make_rings(MPI_Comm comm, const Rings& rings) {
  refuse_too_many(comm, std::pow(rings.rings, 2.0) * std::max(1, rings.levels));  // at least that many
  const bool solid = rings.levels > 0;
  const int levels = solid ? rings.levels : 1;
  const double dz = solid ? rings.height / (levels - 1) : rings.thickness;

  Points out;
  out.dimension = solid ? 3 : 2;
  out.nearest_volumes = false;
  out.rings = std::make_shared<const RingLattice>(rings);
  const RingLattice& lattice = *out.rings;
  out.section = solid ? 1 : rings.thickness;
  out.exact.volume = lattice.angle() / 2 * rings.radius * rings.radius * (solid ? rings.height : rings.thickness);
  out.faces = {"side"};
  if (solid) out.faces.insert(out.faces.end(), {"bottom", "top"});
  const int bottom = 1, top = 2, cut1 = static_cast<int>(out.faces.size()), cut2 = cut1 + 1;
  if (rings.sector != Sector::full) out.faces.push_back("cut1");
  if (rings.sector == Sector::quarter) out.faces.push_back("cut2");

  const Slice mine = slice(comm, lattice.count() * levels);
  out.points.reserve(mine.end - mine.begin);
  for (std::int64_t id = mine.begin; id < mine.end; ++id) {
    const std::int64_t level = id / lattice.count();
    const RingPoint p = lattice.point(id % lattice.count());
    const bool lowest = solid && level == 0, highest = solid && level == levels - 1;
    const double height = lowest || highest ? dz / 2 : dz;
    const double z = !solid ? 0 : highest ? rings.height : static_cast<double>(level) * dz;
    out.points.push_back({.id = id,
                          .x = {p.x, p.y, z},
                          .volume = p.area * height,
                          .full_volume = p.full_area * dz,
                          .spacing = solid ? std::max(lattice.dr(), dz) : lattice.dr(),
                          .metric = {lattice.dr(), lattice.dr(), dz}});
    if (p.arc > 0) out.add_patch(0, p.arc * height, p.arc_normal, height * p.arc_vector);
    if (lowest) out.add_patch(bottom, p.area, {0, 0, -1});
    if (highest) out.add_patch(top, p.area, {0, 0, 1});
    if (p.cut1 > 0) out.add_patch(cut1, p.cut1 * height, {0, -1, 0});
    if (p.cut2 > 0) out.add_patch(cut2, p.cut2 * height, {-1, 0, 0});
  }
  return out;
}

namespace {

Points disc_from(MPI_Comm comm, const Table& cloud) {
  Rings r = rings_from(cloud);
  r.thickness = section_of(cloud, 2);
  return make_rings(comm, r);
}

Points cylinder_from(MPI_Comm comm, const Table& cloud) {
  Rings r = rings_from(cloud);
  section_of(cloud, 3);
  r.height = cloud.number("height");
  if (!(r.height > 0))
    cloud.refuse("height", fmt::format("a height of {} m is not positive", r.height), "give a positive one");
  if (!cloud.has("levels") && !cloud.has("spacing"))
    cloud.refuse("", "the levels of points over the height are missing",
                 "give levels, or spacing instead of rings and levels");
  r.levels = static_cast<int>(cloud.has("levels") ? cloud.integer("levels")
                                                  : intervals(cloud, r.height, cloud.number("spacing")) + 1);
  if (r.levels < 2) cloud.refuse("levels", fmt::format("{} levels", r.levels), "give at least 2: bottom and top");
  return make_rings(comm, r);
}

/// Of a disc; a cylinder has more.
std::vector<Key> disc_keys() {
  return {{"radius", Kind::quantity, "m", required, "Radius."},
          {"rings",
           Kind::integer,
           "",
           optional,
           "Rings of points around the centre, 6 m points on ring m; the last lies on the side.",
           {},
           {"spacing"}},
          {"spacing", Kind::quantity, "m", optional, "Distance of the rings, instead of their number.", {}, {"rings"}},
          {"sector",
           Kind::choice,
           "",
           "full",
           "The whole, or a part of it with points on the cuts (planes of symmetry).",
           {"full", "half", "quarter"}}};
}

std::vector<Key> cylinder_keys() {
  std::vector<Key> keys = disc_keys();
  keys.push_back({"height", Kind::quantity, "m", required, "Height, from z = 0 (bottom) up."});
  keys.push_back({"levels", Kind::integer, "", optional,
                  "Layers of points over the height, bottom and top included; from spacing if absent."});
  return keys;
}

}  // namespace

CloudShape disc_shape() {
  return {.name = "disc",
          .sentence =
              "A disc of concentric rings around the origin. Faces: side; of sectors also cut1 (y = 0) and cut2 "
              "(x = 0)",
          .keys = disc_keys(),
          .make = disc_from};
}

CloudShape cylinder_shape() {
  return {.name = "cylinder",
          .sentence =
              "A cylinder around the z axis by rings. Faces: side, bottom, top; of sectors also cut1 (y = 0) "
              "and cut2 (x = 0)",
          .keys = cylinder_keys(),
          .make = cylinder_from};
}

}  // namespace calor
