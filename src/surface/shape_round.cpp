// Round shapes in space: outlines that turn around the z axis.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "case/lengths.hpp"
#include "surface/outline.hpp"
#include "surface/part_keys.hpp"
#include "surface/solid_shapes.hpp"

namespace calor {
namespace {

Surface full_revolution(const Table& part, const Outline& outline, double chord) {
  return located(part.location("shape"), [&] { return revolved(outline, full_turn, chord); });
}

// Circles of one radius have the same chords in all shapes, so that a pin fits its bush.

Surface cylinder_from(const Table& part, double chord) {
  const double r = positive_length(part, "radius"), h = positive_length(part, "height");
  return located(part.location("radius"),
                 [&] { return extruded({.contours = {circle(r, chord, 0)}, .faces = {"side"}}, h); });
}

Surface tube_from(const Table& part, double chord) {
  const Radii radii = inner_and_outer(part);
  const double h = positive_length(part, "height");
  return located(part.location("outer"), [&] {
    return extruded({.contours = {circle(radii.outer, chord, 1), reversed(circle(radii.inner, chord, 0))},
                     .faces = {"inner", "outer"}},
                    h);
  });
}

Surface cone_from(const Table& part, double chord) {
  const double h = positive_length(part, "height");
  for (const char* key : {"bottom_radius", "top_radius"})
    if (part.number(key) < 0)
      part.refuse(key, fmt::format("{} = {:g} m is negative", key, part.number(key)), "give 0 (a tip) or more");
  const double bottom = part.number("bottom_radius"), top = part.number("top_radius");
  if (bottom == 0 && top == 0)
    part.refuse("bottom_radius", "both radii of the cone are 0", "give at least one that is positive");
  std::vector<std::string> faces = {"side"};
  Contour contour;
  const auto disc = [&](double radius, double z, const std::string& name) {
    if (radius == 0) return;
    contour.corner.push_back({radius, z, 0});
    contour.face.push_back(static_cast<int>(faces.size()));
    faces.push_back(name);
  };
  // From the axis outwards on the bottom, up the side, inwards on the top, down the axis.
  contour.corner.push_back({});
  disc(bottom, 0, "bottom");
  contour.face.push_back(0);
  disc(top, h, "top");
  contour.corner.push_back({0, h, 0});
  contour.face.push_back(-1);
  return full_revolution(part, {.contours = {contour}, .faces = faces}, chord);
}

/// Half a circle around the origin from the south pole to the north pole, with chords for a surface that is curved both
/// ways: the diagonals of its squares are as long as `chord`.
std::vector<Vec3> half_circle(double radius, double chord) {
  return arc({}, radius, -full_turn / 4, full_turn / 4, chords_in(radius, full_turn / 2, chord / std::sqrt(2)));
}

Outline ball(double radius, double chord) {
  Contour contour{.corner = half_circle(radius, chord), .face = {}};
  contour.face.assign(contour.corner.size(), 0);
  contour.face.back() = -1;
  return {.contours = {contour}, .faces = {"surface"}};
}

Surface ball_surface(double radius, double chord) {
  return revolved(ball(radius, chord), full_turn, chord / std::sqrt(2));
}

Surface sphere_from(const Table& part, double chord) {
  const double radius = positive_length(part, "radius");
  return located(part.location("radius"), [&] { return ball_surface(radius, chord); });
}

Surface ellipsoid_from(const Table& part, double chord) {
  const Vec3 semi_axes = positive_lengths(part, "semi_axes", 3);
  // A unit sphere, stretched; facets grow with the longest axis at most.
  const double unit = chord / std::max({semi_axes.x, semi_axes.y, semi_axes.z});
  Surface out =
      full_revolution(part, located(part.location("semi_axes"), [&] { return ball(1, unit); }), unit / std::sqrt(2));
  for (Vec3& x : out.vertices) x = product(x, semi_axes);
  return out;
}

Surface shell_from(const Table& part, double chord) {
  const Radii radii = inner_and_outer(part);
  return located(part.location("outer"), [&] {
    Surface out = ball_surface(radii.outer, chord);
    const Surface cavity = ball_surface(radii.inner, chord);
    const auto first = static_cast<std::int32_t>(out.vertices.size());
    out.vertices.insert(out.vertices.end(), cavity.vertices.begin(), cavity.vertices.end());
    for (Surface::Triangle& facet : out.facets) facet.face = 1;
    for (const auto& [vertex, face] : cavity.facets)  // they look into it
      out.facets.push_back({{first + vertex[0], first + vertex[2], first + vertex[1]}, 0});
    out.faces = {"inner", "outer"};
    return out;
  });
}

std::vector<Key> radii_keys() {
  return {{"inner", Kind::quantity, "m", required, "Inner radius."},
          {"outer", Kind::quantity, "m", required, "Outer radius."}};
}

const Key height_key{"height", Kind::quantity, "m", required, "Height, from z = 0 (bottom) up."};

}  // namespace

SolidShape solid_cylinder() {
  return {.name = "cylinder",
          .sentence = "A cylinder around the z axis. Faces: side, bottom, top",
          .keys = {{"radius", Kind::quantity, "m", required, "Radius."}, height_key},
          .make = cylinder_from};
}

SolidShape solid_tube() {
  std::vector<Key> keys = radii_keys();
  keys.push_back(height_key);
  return {.name = "tube",
          .sentence = "A tube around the z axis. Faces: inner, outer, bottom, top",
          .keys = keys,
          .make = tube_from};
}

SolidShape solid_cone() {
  return {.name = "cone",
          .sentence =
              "A cone around the z axis, with or without its tip. Faces: side, and, where the radius is not 0, "
              "bottom, top",
          .keys = {{"bottom_radius", Kind::quantity, "m", required, "Radius at z = 0; 0: a tip."},
                   {"top_radius", Kind::quantity, "m", "0 m", "Radius at the upper end; 0: a tip."},
                   height_key},
          .make = cone_from};
}

SolidShape solid_sphere() {
  return {.name = "sphere",
          .sentence = "A sphere around the origin. Faces: surface",
          .keys = {{"radius", Kind::quantity, "m", required, "Radius."}},
          .make = sphere_from};
}

SolidShape solid_shell() {
  return {.name = "shell",
          .sentence = "A sphere around the origin with a concentric cavity. Faces: inner, outer",
          .keys = radii_keys(),
          .make = shell_from};
}

SolidShape solid_ellipsoid() {
  return {.name = "ellipsoid",
          .sentence = "An ellipsoid around the origin. Faces: surface",
          .keys = {{"semi_axes", Kind::quantities, "m", required, "Half its lengths along x, y and z."}},
          .make = ellipsoid_from};
}

}  // namespace calor
