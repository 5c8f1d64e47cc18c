#include "cloud/jitter.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace calor {
namespace {

std::vector<double> segment_lengths(const Lattice& lattice, const Slice& mine) {
  const auto& box = lattice.box();
  std::vector<double> length;
  for (std::int64_t i = mine.begin; i < mine.end; ++i) {
    const auto x = [&](std::int64_t j) { return lattice.position({j, 0, 0}).x; };
    const double low = i == 0 ? box.origin.x : 0.5 * (x(i - 1) + x(i));
    const double high = i == box.points[0] - 1 ? box.origin.x + box.size[0] : 0.5 * (x(i) + x(i + 1));
    length.push_back(high - low);
  }
  return length;
}

/// Places of the points of a few layers of the lattice, across its last axis.
class Layers {
 public:
  Layers(const Lattice& lattice, std::int64_t low, std::int64_t high) {
    const int last = lattice.box().dimension - 1;
    LatticeIndex first{}, end{};
    first[last] = std::max<std::int64_t>(0, low);
    end[last] = std::min(lattice.box().points[last], high + 1);
    first_ = lattice.id(first);
    for (std::int64_t id = first_; id < lattice.id(end); ++id) x_.push_back(lattice.position(lattice.index(id)));
  }
  const Vec3& at(std::int64_t id) const { return x_[id - first_]; }

 private:
  std::int64_t first_;
  std::vector<Vec3> x_;
};

constexpr int samples = 64;

/// The samples of one lattice cell and the points nearest to them.
struct Samples {
  std::array<double, samples> x, y, z, square;
  std::array<std::int64_t, samples> owner;

  void try_point(std::int64_t id, const Vec3& p) {
    for (int s = 0; s < samples; ++s) {
      const double dx = x[s] - p.x, dy = y[s] - p.y, dz = z[s] - p.z;
      const double d = dx * dx + dy * dy + dz * dz;
      owner[s] = d < square[s] ? id : owner[s];
      square[s] = d < square[s] ? d : square[s];
    }
  }
};

void place_samples(const Lattice& lattice, const LatticeIndex& cell, Samples& out) {
  const BoxLattice& box = lattice.box();
  const int per_axis = box.dimension == 2 ? 8 : 4;
  std::int64_t number = 0;
  for (int a = box.dimension - 1; a >= 0; --a) number = number * lattice.cells(a) + cell[a];
  for (int s = 0; s < samples; ++s) {
    const std::array<int, 3> sub = {s % per_axis, s / per_axis % per_axis, s / (per_axis * per_axis)};
    const Vec3 u = hashed_uniform(~box.seed, number * samples + s);
    Vec3 x;
    for (int a = 0; a < box.dimension; ++a)
      x[a] = box.origin[a] + (static_cast<double>(cell[a]) + (sub[a] + u[a]) / per_axis) * lattice.dx(a);
    out.x[s] = x.x, out.y[s] = x.y, out.z[s] = x.z;
  }
  out.square.fill(std::numeric_limits<double>::infinity());
}

}  // namespace

std::vector<double> nearest_point_volumes(const Lattice& lattice, const Slice& mine) {
  const BoxLattice& box = lattice.box();
  const int D = box.dimension;
  if (mine.begin == mine.end) return {};
  if (D == 1) return segment_lengths(lattice, mine);
  double sample_volume = 1.0 / samples;
  for (int a = 0; a < D; ++a) sample_volume *= lattice.dx(a);

  // Ids run along x first, so the slice lies between two layers of the last axis; cells up to two layers off matter.
  const int last = D - 1;
  const std::int64_t bottom = lattice.index(mine.begin)[last], top = lattice.index(mine.end - 1)[last];
  const Layers points(lattice, bottom - 5, top + 5);
  LatticeIndex low{}, high{};
  for (int a = 0; a < D; ++a) high[a] = lattice.cells(a) - 1;
  low[last] = std::max<std::int64_t>(0, bottom - 2);
  high[last] = std::min(high[last], top + 2);

  std::vector<double> volume(mine.end - mine.begin, 0.0);
  const auto for_each = [](const LatticeIndex& from, const LatticeIndex& to, const auto& work) {
    LatticeIndex i;
    for (i[2] = from[2]; i[2] <= to[2]; ++i[2])
      for (i[1] = from[1]; i[1] <= to[1]; ++i[1])
        for (i[0] = from[0]; i[0] <= to[0]; ++i[0]) work(i);
  };
  Samples s;
  for_each(low, high, [&](const LatticeIndex& cell) {
    place_samples(lattice, cell, s);
    LatticeIndex near{}, far{};
    for (int a = 0; a < D; ++a) {
      // On walls the cell's own corners are cell and cell + 1; in cells its own point is cell.
      near[a] = std::max<std::int64_t>(0, cell[a] - (box.on_walls ? 1 : 2));
      far[a] = std::min(box.points[a] - 1, cell[a] + 2);
    }
    for_each(near, far, [&](const LatticeIndex& i) { s.try_point(lattice.id(i), points.at(lattice.id(i))); });
    for (std::int64_t id : s.owner)
      if (id >= mine.begin && id < mine.end) volume[id - mine.begin] += sample_volume;
  });
  return volume;
}

}  // namespace calor
