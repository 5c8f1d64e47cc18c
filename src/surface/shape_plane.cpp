// Shapes in the plane.
#include <fmt/format.h>

#include "case/lengths.hpp"
#include "surface/outline.hpp"
#include "surface/part_keys.hpp"
#include "surface/polygon.hpp"
#include "surface/solid_shapes.hpp"

namespace calor {
namespace {

Surface rectangle_from(const Table& part, double /*chord*/) {
  const Vec3 size = positive_lengths(part, "size", 2);
  return plane_surface({.contours = {{.corner = {{}, {size.x, 0, 0}, size, {0, size.y, 0}}, .face = {2, 1, 3, 0}}},
                        .faces = {"xmin", "xmax", "ymin", "ymax"}});
}

Surface polygon_of(const Table& part, double /*chord*/) { return plane_surface(polygon_from(part, "xy")); }

Surface disc_from(const Table& part, double chord) {
  const double radius = positive_length(part, "radius");
  return located(part.location("radius"),
                 [&] { return plane_surface({.contours = {circle(radius, chord, 0)}, .faces = {"side"}}); });
}

Surface annulus_from(const Table& part, double chord) {
  const auto [inner, outer] = inner_and_outer(part);
  return located(part.location("outer"), [&, inner = inner, outer = outer] {
    return plane_surface(
        {.contours = {circle(outer, chord, 1), reversed(circle(inner, chord, 0))}, .faces = {"inner", "outer"}});
  });
}

Surface sector(double inner, double outer, double from, double to, double chord) {
  const auto add = [](Contour& contour, const std::vector<Vec3>& corners, int face_of_arc, int face_of_next) {
    contour.corner.insert(contour.corner.end(), corners.begin(), corners.end());
    contour.face.insert(contour.face.end(), corners.size() - 1, face_of_arc);
    contour.face.push_back(face_of_next);
  };
  const bool is_wedge = inner == 0;
  std::vector<std::string> faces = {"start", "outer", "end"};
  if (!is_wedge) faces.push_back("inner");
  Contour contour;
  add(contour, arc({}, outer, from, to, chords_in(outer, to - from, chord)), 1, 2);
  add(contour, is_wedge ? std::vector<Vec3>{{}} : arc({}, inner, to, from, chords_in(inner, to - from, chord)), 3, 0);
  return plane_surface({.contours = {contour}, .faces = faces});
}

Surface sector_from(const Table& part, double chord) {
  const double outer = positive_length(part, "outer"), from = part.number("from"), to = part.number("to");
  const double inner = part.has("inner") ? inner_and_outer(part).inner : 0;
  const double degrees = full_turn / 360;
  if (!(to > from))
    part.refuse("to", fmt::format("the sector ends at {:g} degrees and begins at {:g}", to / degrees, from / degrees),
                "let it run counter-clockwise: give an end beyond the beginning");
  if (!(to - from < full_turn * (1 - 1e-12)))
    part.refuse("to", fmt::format("a sector of {:g} degrees", (to - from) / degrees),
                "stay below 360, or take shape = \"disc\" or \"annulus\"");
  return located(part.location("outer"), [&] { return sector(inner, outer, from, to, chord); });
}

}  // namespace

SolidShape solid_rectangle() {
  return {.name = "rectangle",
          .sentence = "A rectangle, its lowest corner in the origin. Faces: xmin, xmax, ymin, ymax",
          .keys = {{"size", Kind::quantities, "m", required, "Lengths along x and y."}},
          .make = rectangle_from};
}

SolidShape solid_polygon() {
  return {
      .name = "polygon",
      .sentence = "A polygon, with or without holes. Faces: side1, side2 ... in the order of its corners; hole1 ...",
      .keys = polygon_keys("xy"),
      .make = polygon_of};
}

SolidShape solid_disc() {
  return {.name = "disc",
          .sentence = "A disc around the origin. Faces: side",
          .keys = {{"radius", Kind::quantity, "m", required, "Radius."}},
          .make = disc_from};
}

SolidShape solid_annulus() {
  return {.name = "annulus",
          .sentence = "A ring around the origin. Faces: inner, outer",
          .keys = {{"inner", Kind::quantity, "m", required, "Inner radius."},
                   {"outer", Kind::quantity, "m", required, "Outer radius."}},
          .make = annulus_from};
}

SolidShape solid_sector() {
  return {.name = "sector",
          .sentence = "A sector of a disc or a ring around the origin. Faces: start, outer, end; of a ring also inner",
          .keys = {{"inner", Kind::quantity, "m", optional, "Inner radius, of a ring."},
                   {"outer", Kind::quantity, "m", required, "Outer radius."},
                   {"from", Kind::quantity, "rad", required, "Angle where it begins, from the x axis."},
                   {"to", Kind::quantity, "rad", required, "Angle where it ends, counter-clockwise from there."}},
          .make = sector_from};
}

}  // namespace calor
