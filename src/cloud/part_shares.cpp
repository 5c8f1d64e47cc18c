#include "cloud/part_shares.hpp"

#include <algorithm>
#include <array>

#include "cloud/cell_integrals.hpp"

namespace calor {
namespace {

/// Samples are this many times finer along every axis in cells that an interface cuts.
constexpr int finer = 4;

std::vector<std::vector<double>> by_quadrature(const Cloud& cloud, const Partition& parts) {
  std::vector<std::vector<double>> share;
  const CellIntegrals cells(cloud);
  std::vector<int> part;
  for (int p = 0; p < parts.count; ++p) {
    share.push_back(cells.over_cells({.f = [&](std::span<const Vec3> x, std::span<double> out) {
      part.resize(x.size());
      parts.at(x, part);
      for (std::size_t n = 0; n < x.size(); ++n) out[n] = part[n] == p;
    }}));
    for (int i = 0; i < cloud.owned; ++i) share[p][i] = std::min(1.0, share[p][i] / cloud.volume[i]);
  }
  return share;
}

/// Cubes of samples, and which of them lie side by side.
class CubeGrid {
 public:
  explicit CubeGrid(std::span<const std::array<int, 3>> cubes) : low_(cubes[0]), high_(cubes[0]) {
    for (const auto& c : cubes)
      for (int a = 0; a < 3; ++a) low_[a] = std::min(low_[a], c[a]), high_[a] = std::max(high_[a], c[a]);
    number_.assign(static_cast<std::size_t>(side(0)) * side(1) * side(2), -1);
    for (int n = 0; const auto& c : cubes) number_[at(c)] = n++;
  }

  /// Does `holds(number)` hold of any cube that has a corner in common with this one?
  template <class Holds>
  bool any_beside(const std::array<int, 3>& c, const Holds& holds) const {
    std::array<int, 3> from, to, n;
    for (int a = 0; a < 3; ++a) from[a] = std::max(c[a] - 1, low_[a]), to[a] = std::min(c[a] + 1, high_[a]);
    for (n[2] = from[2]; n[2] <= to[2]; ++n[2])
      for (n[1] = from[1]; n[1] <= to[1]; ++n[1])
        for (n[0] = from[0]; n[0] <= to[0]; ++n[0])
          if (const int k = number_[at(n)]; k >= 0 && holds(k)) return true;
    return false;
  }

 private:
  int side(int a) const { return high_[a] - low_[a] + 1; }
  std::size_t at(const std::array<int, 3>& c) const {
    return (c[0] - low_[0]) +
           static_cast<std::size_t>(side(0)) * ((c[1] - low_[1]) + side(1) * static_cast<std::size_t>(c[2] - low_[2]));
  }

  std::array<int, 3> low_, high_;
  std::vector<int> number_;  // -1: no such cube
};

/// Shares by samples. What a part has of a cell is the share of its samples there.
class SampledShares {
 public:
  SampledShares(const Cloud& cloud, const Partition& parts) : cloud_(cloud), parts_(parts), sampler_(cloud) {}

  std::vector<std::vector<double>> take() {
    share_.assign(parts_.count, std::vector<double>(cloud_.owned));
    std::vector<int> whole;
    std::vector<Vec3> x;
    for (int i = 0; i < cloud_.owned; ++i) {
      if (parts_.is_one_around(cloud_.x[i], sampler_.farthest_in_cell(i) * cloud_.spacing[i]))
        whole.push_back(i), x.push_back(cloud_.x[i]);
      else
        add_samples(i);
    }
    part_.resize(x.size());
    parts_.at(x, part_);
    for (std::size_t n = 0; n < whole.size(); ++n) add(part_[n], whole[n], 1);
    return std::move(share_);
  }

 private:
  void add(int part, int i, double share) {
    if (part >= 0) share_[part][i] += share;
  }

  void add_samples(int i) {
    sampler_.of(i, 1, x_, cubes_);
    part_.resize(x_.size());
    parts_.at(x_, part_);
    if (std::ranges::all_of(part_, [&](int p) { return p == part_[0]; })) return add(part_[0], i, 1);
    sampler_.of(i, finer, x_, cubes_);
    find_parts();
    const std::vector<double> weight = weights_of(cloud_, x_);
    for (std::size_t n = 0; n < x_.size(); ++n) add(part_[n], i, weight[n]);
  }

  /// Of all samples x_: in cubes between others of the same part that of one of their samples.
  void find_parts() {
    middle_.clear();
    for (std::size_t k = 0; k < cubes_.index.size(); ++k)
      middle_.push_back(x_[(cubes_.begin[k] + cubes_.begin[k + 1]) / 2]);
    of_cube_.resize(middle_.size());
    parts_.at(middle_, of_cube_);
    const CubeGrid grid(cubes_.index);
    std::vector<Vec3> asked;
    std::vector<std::int32_t> sample;
    part_.resize(x_.size());
    for (std::size_t k = 0; k < cubes_.index.size(); ++k) {
      const bool is_cut = grid.any_beside(cubes_.index[k], [&](int other) { return of_cube_[other] != of_cube_[k]; });
      for (std::int32_t n = cubes_.begin[k]; n < cubes_.begin[k + 1]; ++n) {
        part_[n] = of_cube_[k];
        if (is_cut) asked.push_back(x_[n]), sample.push_back(n);
      }
    }
    std::vector<int> found(asked.size());
    parts_.at(asked, found);
    for (std::size_t n = 0; n < found.size(); ++n) part_[sample[n]] = found[n];
  }

  const Cloud& cloud_;
  const Partition& parts_;
  CellSampler sampler_;
  std::vector<std::vector<double>> share_;
  // Of the cell at hand:
  std::vector<Vec3> x_, middle_;
  SampleCubes cubes_;
  std::vector<int> part_, of_cube_;
};

}  // namespace

std::vector<std::vector<double>> part_shares(const Cloud& cloud, const Partition& parts) {
  if (cloud.lattice || cloud.rings) return by_quadrature(cloud, parts);
  return SampledShares(cloud, parts).take();
}

}  // namespace calor
