#pragma once
// One facet and one place or segment, as the leaves of a SurfaceTree ask. Facets may be thin or have no area.
#include <algorithm>
#include <array>
#include <cmath>

#include "base/vec3.hpp"

namespace calor {

/// Corners of a triangle; of a segment in the plane the second one comes twice.
using Corners = std::array<Vec3, 3>;

/// Solid angle of a triangle seen from x, positive from the side to which its normal does not point (van Oosterom &
/// Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125).
inline double solid_angle(const Corners& corners, const Vec3& x) {
  const Vec3 a = corners[0] - x, b = corners[1] - x, c = corners[2] - x;
  const double la = norm(a), lb = norm(b), lc = norm(c);
  return 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

/// Angle of a segment in the plane seen from x, positive on its left.
inline double angle(const Corners& corners, const Vec3& x) {
  const Vec3 a = corners[0] - x, b = corners[1] - x;
  return std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y);
}

inline Vec3 closest_on_segment(const Vec3& a, const Vec3& b, const Vec3& x) {
  const Vec3 ab = b - a;
  const double along = dot(x - a, ab), length2 = dot(ab, ab);
  return along <= 0 ? a : along >= length2 ? b : a + (along / length2) * ab;
}

/// The foot of x on the plane of the triangle, where it is inside; else the closest place of the edges beyond which it
/// lies. Triangles so thin that their normal is round-off have no other places than those of their edges.
inline Vec3 closest_on_triangle(const Corners& corners, const Vec3& x) {
  const auto& [a, b, c] = corners;
  const Vec3 ab = b - a, ac = c - a, normal = cross(ab, ac), inwards = cross(normal, a - x);
  const double n2 = dot(normal, normal);
  const bool is_thin = n2 < 1e-24 * dot(ab, ab) * dot(ac, ac);
  // Barycentric coordinates of the foot, times n2.
  const double w = dot(ab, inwards), v = -dot(ac, inwards), u = n2 - v - w;
  if (u > 0 && v > 0 && w > 0 && !is_thin) return a + (v / n2) * ab + (w / n2) * ac;
  Vec3 best = a;
  double least = dot(a - x, a - x);
  const auto try_edge = [&](const Vec3& from, const Vec3& to) {
    const Vec3 p = closest_on_segment(from, to, x);
    if (const double r2 = dot(p - x, p - x); r2 < least) best = p, least = r2;
  };
  if (w <= 0 || is_thin) try_edge(a, b);
  if (v <= 0 || is_thin) try_edge(c, a);
  if (u <= 0 || is_thin) try_edge(b, c);
  return best;
}

/// Do the ends of the segment lie on different sides, and does it go through between the edges? Edges belong to the
/// triangle with more than the round-off, so that nothing slips through between two triangles.
inline bool triangle_crossed(const Corners& corners, const Vec3& from, const Vec3& to) {
  const auto& [a, b, c] = corners;
  const Vec3 normal = cross(b - a, c - a);
  const double before = dot(normal, from - a), behind = dot(normal, to - a);
  if ((before < 0) == (behind < 0) || before == 0 || behind == 0) return false;
  const Vec3 along = to - from, fa = a - from, fb = b - from, fc = c - from;
  const double sign = before < 0 ? 1 : -1;
  const double u = sign * dot(along, cross(fb, fc)), v = sign * dot(along, cross(fc, fa)),
               w = sign * dot(along, cross(fa, fb));
  const double far2 = std::max({dot(fa, fa), dot(fb, fb), dot(fc, fc)});
  const double roundoff = -1e-15 * norm(along) * far2;
  return u >= roundoff && v >= roundoff && w >= roundoff;
}

/// The same in the plane: a to b is the facet.
inline bool segment_crossed(const Vec3& a, const Vec3& b, const Vec3& from, const Vec3& to) {
  const auto area = [](const Vec3& p, const Vec3& q) { return p.x * q.y - p.y * q.x; };
  const Vec3 ab = b - a, along = to - from;
  const double before = area(ab, from - a), behind = area(ab, to - a);
  if ((before < 0) == (behind < 0) || before == 0 || behind == 0) return false;
  const double roundoff = 1e-15 * norm(along) * (norm(a - from) + norm(b - from));
  const double sa = area(along, a - from), sb = area(along, b - from);
  return (sa >= -roundoff && sb <= roundoff) || (sa <= roundoff && sb >= -roundoff);
}

/// Part of the way at which a segment goes through a facet that it crosses.
inline double crossing_of(const Corners& corners, int dimension, const Vec3& from, const Vec3& to) {
  const Vec3 ab = corners[1] - corners[0];
  const Vec3 normal = dimension == 2 ? Vec3{ab.y, -ab.x, 0} : cross(ab, corners[2] - corners[0]);
  const double before = dot(normal, from - corners[0]), behind = dot(normal, to - corners[0]);
  return before / (before - behind);
}

}  // namespace calor
