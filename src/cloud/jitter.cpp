// Volumes of the points of a jittered lattice, in units of the spacings along the axes, in which flat points are cubes:
// integrals of linearly exact shape functions, or the part of the box that is nearer to a point than to any other.
#include "cloud/lattice.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "cloud/convex_cell.hpp"
#include "cloud/linear_shares.hpp"

namespace calor {
namespace {

double distance(const LatticeIndex& offset) {
  Vec3 r;
  for (int a = 0; a < 3; ++a) r[a] = static_cast<double>(offset[a]);
  return norm(r);
}

Vec3 in_spacings(const Lattice& lattice, const Vec3& x) {
  return quotient(x, {lattice.dx(0), lattice.dx(1), lattice.dx(2)});
}

/// Positions, in spacings, of the points of a few layers of the lattice, across its last axis.
class Layers {
 public:
  Layers(const Lattice& lattice, std::int64_t low, std::int64_t high) {
    const int last = lattice.box().dimension - 1;
    LatticeIndex first{}, end{};
    first[last] = std::max<std::int64_t>(0, low);
    end[last] = std::min(lattice.box().points[last], high + 1);
    first_ = lattice.id(first);
    for (std::int64_t id = first_; id < lattice.id(end); ++id)
      x_.push_back(in_spacings(lattice, lattice.position(lattice.index(id))));
  }
  const Vec3& at(std::int64_t id) const { return x_[id - first_]; }

 private:
  std::int64_t first_;
  std::vector<Vec3> x_;
};

/// The other points of the lattice by their distance in indices, nearest first.
std::vector<LatticeIndex> offsets_by_distance(const Lattice& lattice, std::int64_t most) {
  std::vector<LatticeIndex> offsets;
  const int D = lattice.box().dimension;
  const auto range = [&](int a) { return a < D ? most : 0; };
  for (std::int64_t z = -range(2); z <= range(2); ++z)
    for (std::int64_t y = -range(1); y <= range(1); ++y)
      for (std::int64_t x = -range(0); x <= range(0); ++x)
        if (x != 0 || y != 0 || z != 0) offsets.push_back({x, y, z});
  std::ranges::stable_sort(offsets, {}, [&](const LatticeIndex& o) { return distance(o); });
  return offsets;
}

/// The shape functions of the points of `layers` around a place in the given cell of the lattice, all in spacings.
void evaluate(const Lattice& lattice, const Layers& layers, const LatticeIndex& cell, const Vec3& place,
              LinearShares& shapes) {
  constexpr std::int64_t most = 2;  // intervals, as points are moved by less than half a spacing
  const int D = lattice.box().dimension;
  LatticeIndex low{}, high{};
  for (int a = 0; a < D; ++a) {
    low[a] = std::max<std::int64_t>(0, cell[a] - most);
    high[a] = std::min(lattice.box().points[a] - 1, cell[a] + 1 + most);
  }
  shapes.clear();
  LatticeIndex j;
  for (j[2] = low[2]; j[2] <= high[2]; ++j[2])
    for (j[1] = low[1]; j[1] <= high[1]; ++j[1])
      for (j[0] = low[0]; j[0] <= high[0]; ++j[0]) {
        const std::int64_t id = lattice.id(j);
        const Vec3 way = layers.at(id) - place;
        shapes.add(id, way, dot(way, way));
      }
  shapes.solve(D);
}

}  // namespace

std::vector<double> linearly_exact_volumes(const Lattice& lattice, const Slice& mine) {
  const BoxLattice& box = lattice.box();
  const int D = box.dimension, last = D - 1;
  if (mine.begin == mine.end) return {};
  // Gauss points of the cells between the points of the lattice: half the distances to the middle, and weights.
  constexpr std::array<double, 3> place = {0.1127016653792583, 0.5, 0.8872983346207417};
  constexpr std::array<double, 3> weight = {5. / 18, 4. / 9, 5. / 18};
  constexpr std::int64_t reach = 3;  // intervals from a point to the cells where its shape function is not 0
  const std::int64_t first = lattice.index(mine.begin)[last], end = lattice.index(mine.end - 1)[last] + 1;
  const Layers layers(lattice, first - 2 * reach, end + 2 * reach);
  const Vec3 origin = in_spacings(lattice, box.origin);
  double unit = 1;
  for (int a = 0; a < D; ++a) unit *= lattice.dx(a);

  std::vector<double> volume(mine.end - mine.begin);
  LatticeIndex low{}, high{};  // of the cells, upper ends excluded
  for (int a = 0; a < 3; ++a) high[a] = a < D ? lattice.cells(a) : 1;
  low[last] = std::max<std::int64_t>(0, first - reach), high[last] = std::min(high[last], end + reach);
  const int rules = D == 1 ? 3 : D == 2 ? 9 : 27;
  LinearShares shapes;
  LatticeIndex cell;
  for (cell[2] = low[2]; cell[2] < high[2]; ++cell[2])
    for (cell[1] = low[1]; cell[1] < high[1]; ++cell[1])
      for (cell[0] = low[0]; cell[0] < high[0]; ++cell[0])
        for (int q = 0; q < rules; ++q) {
          const std::array<int, 3> k = {q % 3, q / 3 % 3, q / 9};
          Vec3 x = origin;
          double w = unit;
          for (int a = 0; a < D; ++a) x[a] += static_cast<double>(cell[a]) + place[k[a]], w *= weight[k[a]];
          evaluate(lattice, layers, cell, x, shapes);
          for (std::size_t n = 0; n < shapes.ids.size(); ++n)
            if (const std::int64_t id = shapes.ids[n]; id >= mine.begin && id < mine.end)
              volume[id - mine.begin] += w * shapes.value[n];
        }
  return volume;
}

std::vector<double> nearest_point_volumes(const Lattice& lattice, const Slice& mine) {
  const BoxLattice& box = lattice.box();
  const int D = box.dimension;
  if (mine.begin == mine.end) return {};
  // No cell reaches as far as half of that many intervals, however the points are moved.
  constexpr std::int64_t most = 4;
  const auto offsets = offsets_by_distance(lattice, most);
  // Ids run along x first, so the slice lies between two layers of the last axis.
  const int last = D - 1;
  const Layers points(lattice, lattice.index(mine.begin)[last] - most, lattice.index(mine.end - 1)[last] + most);
  const double moved = 2 * box.jitter * distance({1, D > 1, D > 2});  // nearer than on the lattice, at most

  const Vec3 walls_low = in_spacings(lattice, box.origin);
  const Vec3 walls_high = in_spacings(lattice, box.origin + Vec3{box.size[0], box.size[1], box.size[2]});
  double unit = 1;
  for (int a = 0; a < D; ++a) unit *= lattice.dx(a);

  std::vector<double> volume;
  volume.reserve(mine.end - mine.begin);
  ConvexCell cell;
  for (std::int64_t id = mine.begin; id < mine.end; ++id) {
    const LatticeIndex i = lattice.index(id);
    const Vec3& x = points.at(id);
    Vec3 low, high;
    for (int a = 0; a < D; ++a) {
      low[a] = std::max(walls_low[a] - x[a], -static_cast<double>(most));
      high[a] = std::min(walls_high[a] - x[a], static_cast<double>(most));
    }
    cell.set(low, high, D);
    double reach = cell.reach();
    for (const LatticeIndex& o : offsets) {
      if (distance(o) - moved > 2 * reach) break;
      LatticeIndex j = i;
      bool exists = true;
      for (int a = 0; a < D; ++a) j[a] += o[a], exists = exists && j[a] >= 0 && j[a] < box.points[a];
      if (exists && cell.keep_nearer_than(points.at(lattice.id(j)) - x)) reach = cell.reach();
    }
    volume.push_back(unit * cell.volume());
  }
  return volume;
}

}  // namespace calor
