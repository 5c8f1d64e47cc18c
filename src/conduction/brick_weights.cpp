#include "conduction/brick_weights.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "cloud/lattice.hpp"

namespace calor {
namespace {

/// mu of the differences along an axis of length `along`, averaged across one of length `across`.
double mu(double along, double across) { return std::min(1.0, 2 * (along / across) * (along / across)) / 12; }

/// Of a pair of corners that differ by `step` (0 or 1 along every axis), in a brick of the given lengths.
double weight_in_brick(int dimension, const Vec3& length, const std::array<bool, 3>& step) {
  double G = 0;
  for (int a = 0; a < dimension; ++a) {
    double entry = (step[a] ? 1 : -1) / length[a];  // of -S
    for (int b = 0; b < dimension; ++b) {
      if (b == a) continue;
      const double beside = mu(length[a], length[b]);
      entry *= length[b] * (step[b] ? beside : 0.5 - beside);
    }
    G += entry;
  }
  return G;
}

/// Of two points at most one interval apart along every axis: that of all bricks that both are corners of.
double weight(const Lattice& lattice, int dimension, const LatticeIndex& i, const LatticeIndex& j) {
  std::array<bool, 3> step = {};
  std::array<LatticeIndex, 2> low;  // the lower ends of the intervals along every axis
  std::array<int, 3> count = {1, 1, 1};
  for (int a = 0; a < dimension; ++a) {
    step[a] = i[a] != j[a];
    low[0][a] = low[1][a] = std::min(i[a], j[a]);
    if (step[a]) continue;
    count[a] = 0;
    if (!lattice.lowest(i, a)) low[count[a]++][a] = i[a] - 1;
    if (!lattice.highest(i, a)) low[count[a]++][a] = i[a];
  }
  double G = 0;
  for (int x = 0; x < count[0]; ++x)
    for (int y = 0; y < count[1]; ++y)
      for (int z = 0; z < count[2]; ++z) {
        const std::array<int, 3> which = {x, y, z};
        Vec3 length;
        for (int a = 0; a < dimension; ++a) {
          const std::int64_t at = low[which[a]][a];
          length[a] = lattice.coordinate(a, at + 1) - lattice.coordinate(a, at);
        }
        G += weight_in_brick(dimension, length, step);
      }
  return G;
}

}  // namespace

BrickWeights brick_weights(const Cloud& cloud) {
  const Lattice& lattice = *cloud.lattice;
  const Neighbours near = find_neighbours(cloud, 1.1 * std::sqrt(cloud.dimension));
  BrickWeights out{.neighbours = {.row = {0}, .column = {}}, .G = {}};
  for (int i = 0; i < cloud.owned; ++i) {
    const LatticeIndex at = lattice.index(cloud.id[i]);
    for (const std::int32_t j : near.of(i)) {
      const LatticeIndex to = lattice.index(cloud.id[j]);
      bool is_corner = true;
      for (int a = 0; a < cloud.dimension; ++a) is_corner = is_corner && std::abs(to[a] - at[a]) <= 1;
      if (!is_corner) continue;
      out.neighbours.column.push_back(j);
      out.G.push_back(cloud.cross_section * weight(lattice, cloud.dimension, at, to));
    }
    out.neighbours.row.push_back(static_cast<std::int64_t>(out.G.size()));
  }
  return out;
}

}  // namespace calor
