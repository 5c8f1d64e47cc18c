#include <array>
#include <cmath>
#include <utility>

#include "cloud/lattice.hpp"
#include "conduction/faces.hpp"

namespace calor {

Faces lattice_faces(const Cloud& cloud, int gauss) {
  const int D = cloud.dimension;
  const Lattice& lattice = *cloud.lattice;
  const Neighbours neighbours = find_neighbours(cloud, 1.1);
  Faces faces;
  for (int i = 0; i < cloud.owned; ++i) {
    for (const int j : neighbours.of(i)) {
      if (j < cloud.owned && cloud.id[j] < cloud.id[i]) continue;
      const auto [a, b] = cloud.id[i] < cloud.id[j] ? std::pair(i, j) : std::pair(j, i);
      const LatticeIndex at = lattice.index(cloud.id[a]), next = lattice.index(cloud.id[b]);
      int axis = 0;
      for (int c = 0; c < D; ++c)
        if (next[c] != at[c]) axis = c;
      LatticeIndex beside = at;
      ++beside[axis];
      if (next != beside) continue;
      Vec3 x, area;
      x[axis] = lattice.cell(axis, at[axis]).second;
      area[axis] = cloud.cross_section;
      std::array<int, 2> across = {};  // the axes of the face
      std::array<double, 2> off = {};  // of the Gauss points from its middle
      int axes = 0, points = 1;
      for (int c = 0; c < D; ++c) {
        if (c == axis) continue;
        const auto [low, high] = lattice.cell(c, at[c]);
        area *= (high - low) / gauss;
        x[c] = 0.5 * (low + high);
        off[axes] = gauss == 1 ? 0 : 0.5 * (high - low) / std::sqrt(3.0);
        across[axes++] = c;
        points *= gauss;
      }
      for (int q = 0; q < points; ++q) {
        Vec3 y = x;
        for (int n = 0; n < axes; ++n) y[across[n]] += (q >> n & 1 ? 1 : -1) * off[n];
        faces.x.push_back(y);
        faces.area.push_back(cloud.axisymmetric ? y.x * area : area);
        faces.a.push_back(a);
        faces.b.push_back(b);
      }
    }
  }
  return faces;
}

}  // namespace calor
