// Volumes of the points of a jittered lattice: in units of the spacings along the axes, in which flat points are cubes,
// the part of the box that is nearer to a point than to any other.
#include "cloud/lattice.hpp"

#include <algorithm>
#include <cmath>

#include "cloud/convex_cell.hpp"

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

}  // namespace

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
