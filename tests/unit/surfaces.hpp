#pragma once
// Closed surfaces whose volumes and normals are known.
#include <cmath>
#include <numbers>

#include "surface/surface.hpp"

namespace calor {

/// From 0 to 1; two facets a wall, of faces xmin, xmax, ymin, ...
inline Surface unit_cube() {
  Surface s;
  s.faces = {"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"};
  for (int n = 0; n < 8; ++n) s.vertices.push_back({double(n & 1), double(n >> 1 & 1), double(n >> 2)});
  const std::int32_t wall[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (std::int32_t f = 0; f < 6; ++f) {
    s.facets.push_back({{wall[f][0], wall[f][1], wall[f][2]}, f});
    s.facets.push_back({{wall[f][0], wall[f][2], wall[f][3]}, f});
  }
  return s;
}

/// The corner of the unit cube at 0, of volume 1/6.
inline Surface tetrahedron() {
  Surface s;
  s.faces = {"surface"};
  s.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  s.facets = {{{0, 2, 1}, 0}, {{0, 1, 3}, 0}, {{0, 3, 2}, 0}, {{1, 2, 3}, 0}};
  return s;
}

/// The unit circle by n segments.
inline Surface polygon(int n) {
  Surface s;
  s.dimension = 2;
  s.faces = {"side"};
  for (std::int32_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    s.vertices.push_back({std::cos(angle), std::sin(angle), 0});
    s.facets.push_back({{i, (i + 1) % n, -1}, 0});
  }
  return s;
}

/// The unit sphere: an octahedron whose facets are cut into n^2 and put on the sphere.
inline Surface sphere(int n) {
  Surface s;
  s.faces = {"surface"};
  for (int octant = 0; octant < 8; ++octant) {
    const Vec3 a{octant & 1 ? -1. : 1., 0, 0}, b{0, octant & 2 ? -1. : 1., 0}, c{0, 0, octant & 4 ? -1. : 1.};
    const bool is_mirrored = (octant & 1) ^ (octant >> 1 & 1) ^ (octant >> 2);
    const auto vertex = [&](int i, int j) {
      Vec3 x = double(n - i - j) * a + double(i) * b + double(j) * c;
      x *= 1 / norm(x);
      s.vertices.push_back(x);
      return static_cast<std::int32_t>(s.vertices.size()) - 1;
    };
    const auto facet = [&](std::int32_t p, std::int32_t q, std::int32_t r) {
      if (is_mirrored)
        s.facets.push_back({{p, r, q}, 0});
      else
        s.facets.push_back({{p, q, r}, 0});
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        facet(vertex(i, j), vertex(i + 1, j), vertex(i, j + 1));
        if (i + j + 1 < n) facet(vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
      }
  }
  weld(s, 1e-9);
  return s;
}

}  // namespace calor
