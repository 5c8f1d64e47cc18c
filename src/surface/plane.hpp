#pragma once
// Points, lines and polygons in the plane z = 0.
#include <algorithm>
#include <span>

#include "base/vec3.hpp"

namespace calor {

/// Twice the area of the triangle a b c: positive where it runs counter-clockwise.
inline double orientation(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Is x, on the line through a and b, between them or one of them?
inline bool is_between(const Vec3& a, const Vec3& b, const Vec3& x) {
  return std::min(a.x, b.x) <= x.x && x.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= x.y &&
         x.y <= std::max(a.y, b.y);
}

/// Do the segments a b and c d have a point in common, be it an end?
inline bool segments_meet(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double of_c = orientation(a, b, c), of_d = orientation(a, b, d), of_a = orientation(c, d, a),
               of_b = orientation(c, d, b);
  if (of_c == 0 && is_between(a, b, c)) return true;
  if (of_d == 0 && is_between(a, b, d)) return true;
  if (of_a == 0 && is_between(c, d, a)) return true;
  if (of_b == 0 && is_between(c, d, b)) return true;
  return of_c != 0 && of_d != 0 && of_a != 0 && of_b != 0 && (of_c > 0) != (of_d > 0) && (of_a > 0) != (of_b > 0);
}

/// Area of a polygon; negative where it runs clockwise.
inline double polygon_area(std::span<const Vec3> corner) {
  double twice = 0;
  for (std::size_t n = 0; n + 1 < corner.size(); ++n) twice += orientation(corner[0], corner[n], corner[n + 1]);
  return twice / 2;
}

/// Is x inside the polygon? By counting the edges that a ray from x crosses.
inline bool is_inside(std::span<const Vec3> corner, const Vec3& x) {
  bool inside = false;
  for (std::size_t n = 0; n < corner.size(); ++n) {
    const Vec3 &a = corner[n], &b = corner[(n + 1) % corner.size()];
    if ((a.y > x.y) != (b.y > x.y) && (orientation(a, b, x) > 0) == (b.y > a.y)) inside = !inside;
  }
  return inside;
}

}  // namespace calor
