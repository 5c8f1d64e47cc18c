// Shapes in space that a rectangle or a polygon makes by moving along z or around it.
#include <fmt/format.h>

#include "case/lengths.hpp"
#include "surface/outline.hpp"
#include "surface/part_keys.hpp"
#include "surface/polygon.hpp"
#include "surface/solid_shapes.hpp"

namespace calor {
namespace {

Surface box_from(const Table& part, double /*chord*/) {
  const Vec3 size = positive_lengths(part, "size", 3);
  Surface out = extruded(
      {.contours = {{.corner = {{}, {size.x, 0, 0}, {size.x, size.y, 0}, {0, size.y, 0}}, .face = {2, 1, 3, 0}}},
       .faces = {"xmin", "xmax", "ymin", "ymax"}},
      size.z);
  out.faces[4] = "zmin";
  out.faces[5] = "zmax";
  return out;
}

Surface extrusion_from(const Table& part, double /*chord*/) {
  const double height = positive_length(part, "height");
  return extruded(polygon_from(part, "xy", {"bottom", "top"}), height);
}

Surface revolution_from(const Table& part, double chord) {
  const double angle = part.number("angle"), degrees = full_turn / 360;
  if (!(angle > 0 && angle < full_turn * (1 + 1e-12)))
    part.refuse("angle", fmt::format("an angle of {:g} degrees", angle / degrees),
                "give one above 0, up to 360 degrees");
  const Outline outline = polygon_from(part, "rz", {"start", "end"});
  return located(part.location("shape"), [&] { return revolved(outline, angle, chord); });
}

}  // namespace

SolidShape solid_box() {
  return {.name = "box",
          .sentence = "A box, its lowest corner in the origin. Faces: xmin, xmax, ymin, ymax, zmin, zmax",
          .keys = {{"size", Kind::quantities, "m", required, "Lengths along x, y and z."}},
          .make = box_from};
}

SolidShape solid_extrusion() {
  std::vector<Key> keys = polygon_keys("xy");
  keys.push_back({"height", Kind::quantity, "m", required, "Height, from z = 0 (bottom) up."});
  return {.name = "extrusion",
          .sentence =
              "A polygon, with or without holes, extended along z. Faces: side1, side2 ... in the order of its "
              "corners; hole1 ...; bottom, top",
          .keys = keys,
          .make = extrusion_from};
}

SolidShape solid_revolution() {
  std::vector<Key> keys = polygon_keys("rz");
  keys.push_back({"angle", Kind::quantity, "rad", "360 deg", "How far it turns, from the x axis towards the y axis."});
  return {.name = "revolution",
          .sentence =
              "A polygon, with or without holes, turned around the z axis. Faces: side1, side2 ... in the order "
              "of its corners, but for sides on the axis; hole1 ...; of less than a turn also start, end",
          .keys = keys,
          .make = revolution_from};
}

}  // namespace calor
