#include <array>
#include <cmath>
#include <utility>

#include "conduction/faces.hpp"

namespace calor {

CellExtent extent(const Cloud& cloud, int i, int axis) {
  const double x = cloud.x[i][axis], half = 0.5 * cloud.spacing[i];
  CellExtent e{x - half, x + half};
  for (std::size_t f = 0; f < cloud.faces.size(); ++f) {
    if (!(cloud.on_faces[i] >> f & 1) || cloud.faces[f][0] - 'x' != axis) continue;
    (cloud.faces[f].ends_with("min") ? e.low : e.high) = x;
  }
  return e;
}

Faces lattice_faces(const Cloud& cloud, int gauss) {
  const int D = cloud.dimension;
  const Neighbours neighbours = find_neighbours(cloud, 1.1);
  Faces faces;
  for (int i = 0; i < cloud.owned; ++i) {
    for (const int j : neighbours.of(i)) {
      if (j < cloud.owned && cloud.id[j] < cloud.id[i]) continue;
      const auto [a, b] = cloud.id[i] < cloud.id[j] ? std::pair(i, j) : std::pair(j, i);
      const Vec3 r = cloud.x[b] - cloud.x[a];
      int axis = 0;
      for (int c = 1; c < D; ++c)
        if (std::abs(r[c]) > std::abs(r[axis])) axis = c;
      Vec3 x = 0.5 * (cloud.x[a] + cloud.x[b]), area;
      area[axis] = std::copysign(cloud.cross_section, r[axis]);
      std::array<int, 2> across = {};  // the axes of the face
      std::array<double, 2> off = {};  // of the Gauss points from its middle
      int axes = 0, points = 1;
      for (int c = 0; c < D; ++c) {
        if (c == axis) continue;
        const CellExtent e = extent(cloud, a, c);
        area *= (e.high - e.low) / gauss;
        x[c] = 0.5 * (e.low + e.high);
        off[axes] = gauss == 1 ? 0 : 0.5 * (e.high - e.low) / std::sqrt(3.0);
        across[axes++] = c;
        points *= gauss;
      }
      for (int q = 0; q < points; ++q) {
        Vec3 y = x;
        for (int n = 0; n < axes; ++n) y[across[n]] += (q >> n & 1 ? 1 : -1) * off[n];
        faces.x.push_back(y);
        faces.area.push_back(area);
        faces.a.push_back(a);
        faces.b.push_back(b);
      }
    }
  }
  return faces;
}

}  // namespace calor
