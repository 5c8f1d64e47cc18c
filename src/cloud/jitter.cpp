// Volumes of the points of a jittered lattice, in units of the spacings along the axes, in which flat points are cubes:
// integrals of linearly exact shape functions, or the part of the box that is nearer to a point than to any other.
#include "cloud/lattice.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/simd.hpp"
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

/// The points around a cell of the lattice, and what they get of it by their shape functions; eight at a time.
class CellShares {
 public:
  explicit CellShares(int dimension) : D_(dimension) {}

  /// Points of `layers` that a place in the cell may see.
  void look_around(const Lattice& lattice, const Layers& layers, const LatticeIndex& cell, const Vec3& origin) {
    constexpr std::int64_t most = 2;  // intervals, as points are moved by less than half a spacing
    LatticeIndex low{}, high{};
    Vec3 lowest = origin;
    for (int a = 0; a < D_; ++a) {
      low[a] = std::max<std::int64_t>(0, cell[a] - most);
      high[a] = std::min(lattice.box().points[a] - 1, cell[a] + 1 + most);
      lowest[a] += static_cast<double>(cell[a]);
    }
    ids_.clear(), x_.clear(), y_.clear(), z_.clear();
    LatticeIndex j;
    for (j[2] = low[2]; j[2] <= high[2]; ++j[2])
      for (j[1] = low[1]; j[1] <= high[1]; ++j[1])
        for (j[0] = low[0]; j[0] <= high[0]; ++j[0]) {
          const std::int64_t id = lattice.id(j);
          const Vec3& x = layers.at(id);
          double square = 0;  // of the distance to the cell
          for (int a = 0; a < D_; ++a) square += std::pow(std::max({0.0, lowest[a] - x[a], x[a] - lowest[a] - 1}), 2);
          if (square < LinearShares::radius * LinearShares::radius)
            ids_.push_back(id), x_.push_back(x.x), y_.push_back(x.y), z_.push_back(x.z);
        }
    const double far_away = lowest.x + 100;  // from all places of the cell: such points get nothing
    while (x_.size() % lanes != 0) x_.push_back(far_away), y_.push_back(0), z_.push_back(0);
    share_.assign(x_.size(), 0);
    value_.resize(x_.size());
  }

  /// Adds `weight` times the values of the shape functions at a place in the cell.
  void add(const Vec3& place, double weight) {
    std::array<double, LinearShares::moments> moments{};
    run_vectorised([&]<int>() CALOR_ALWAYS_INLINE { evaluate(place, moments); });
    const auto c = LinearShares::coefficients(moments, D_);
    if (!c) return;
    run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
      for (std::size_t n = 0; n < x_.size(); n += lanes) {
        const Lanes linear = (*c)[0] + (*c)[1] * (at(x_, n) - place.x) + (*c)[2] * (at(y_, n) - place.y) +
                             (*c)[3] * (at(z_, n) - place.z);
        at(share_, n) += weight * at(value_, n) * linear;
      }
    });
  }

  template <class Use>
  void for_each(const Use& use) const {
    for (std::size_t n = 0; n < ids_.size(); ++n) use(ids_[n], share_[n]);
  }

 private:
  static constexpr std::size_t lanes = 8;
  using Lanes = Doubles<lanes>;

  CALOR_ALWAYS_INLINE static inline UnalignedDoubles<lanes>& at(std::vector<double>& v, std::size_t n) {
    return *reinterpret_cast<UnalignedDoubles<lanes>*>(v.data() + n);
  }

  /// Weights of the points, and the moments of the linear basis.
  CALOR_ALWAYS_INLINE inline void evaluate(const Vec3& place, std::array<double, LinearShares::moments>& moments) {
    Lanes sum[LinearShares::moments] = {};
    for (std::size_t n = 0; n < x_.size(); n += lanes) {
      const Lanes x = at(x_, n) - place.x, y = at(y_, n) - place.y, z = at(z_, n) - place.z;
      const Lanes inside = 1 - (x * x + y * y + z * z) / (LinearShares::radius * LinearShares::radius);
      const Lanes positive = inside > 0 ? inside : Lanes{};
      const Lanes w = (positive * positive) * (positive * positive), wx = w * x, wy = w * y, wz = w * z;
      at(value_, n) = w;
      sum[0] += w, sum[1] += wx, sum[2] += wy, sum[3] += wz;
      sum[4] += wx * x, sum[5] += wx * y, sum[6] += wx * z, sum[7] += wy * y, sum[8] += wy * z, sum[9] += wz * z;
    }
    for (int m = 0; m < LinearShares::moments; ++m)
      for (std::size_t l = 0; l < lanes; ++l) moments[m] += sum[m][l];
  }

  int D_;
  std::vector<std::int64_t> ids_;
  std::vector<double> x_, y_, z_, value_, share_;
};

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
  CellShares shares(D);
  LatticeIndex cell;
  for (cell[2] = low[2]; cell[2] < high[2]; ++cell[2])
    for (cell[1] = low[1]; cell[1] < high[1]; ++cell[1])
      for (cell[0] = low[0]; cell[0] < high[0]; ++cell[0]) {
        shares.look_around(lattice, layers, cell, origin);
        for (int q = 0; q < rules; ++q) {
          const std::array<int, 3> k = {q % 3, q / 3 % 3, q / 9};
          Vec3 x = origin;
          double w = unit;
          for (int a = 0; a < D; ++a) x[a] += static_cast<double>(cell[a]) + place[k[a]], w *= weight[k[a]];
          shares.add(x, w);
        }
        shares.for_each([&](std::int64_t id, double share) {
          if (id >= mine.begin && id < mine.end) volume[id - mine.begin] += share;
        });
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
