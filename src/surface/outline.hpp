#pragma once
// Bounded pieces of the plane, and the surfaces of the bodies that they make: the plane one, and those swept along a
// line or around an axis.
#include <numbers>
#include <string>
#include <vector>

#include "base/vec3.hpp"
#include "surface/surface.hpp"

namespace calor {

/// A closed polygon. Edge n runs from corner n to the next one.
struct Contour {
  std::vector<Vec3> corner;  ///< m, z = 0
  std::vector<int> face;     ///< of every edge: index into Outline::faces; -1: on the axis of revolution, no face
};

/// What contours that do not meet enclose: the first one, counter-clockwise, without the others, which are holes inside
/// it and run clockwise. So every edge has the inside on its left.
struct Outline {
  std::vector<Contour> contours;
  std::vector<std::string> faces;
};

/// The unit vector at an angle (rad) from the x axis; exact at right angles, so that what is drawn with it begins and
/// ends on the axes.
Vec3 direction(double angle);

/// The least number of equal chords, none longer than `chord` (m), in an arc; at least eight in a circle. Throws
/// Error(bad_case) for more than a million.
int chords_in(double radius, double angle, double chord);

/// Corners of an arc around `centre` from angle `from` to `to` (rad), both included; clockwise where to < from.
std::vector<Vec3> arc(const Vec3& centre, double radius, double from, double to, int chords);

/// A circle around the origin, counter-clockwise, all of it on one face.
Contour circle(double radius, double chord, int face);

/// Turns a contour the other way round; edges keep their faces.
Contour reversed(Contour contour);

/// The body in the plane.
Surface plane_surface(const Outline& outline);

/// The outline moved along z from 0 to `height`. Faces: those of the outline, bottom, top.
Surface extruded(const Outline& outline, double height);

inline constexpr double full_turn = 2 * std::numbers::pi;

/// The outline, with r as x and z as y, turned around the z axis by `angle` (rad) from the half plane y = 0, x > 0. No
/// corner has r < 0. Faces: those of the outline; less than a turn: also start and end. Circles have facets no longer
/// than `chord` (m). Throws Error(bad_case) for more than 2e7 facets.
Surface revolved(const Outline& outline, double angle, double chord);

}  // namespace calor
