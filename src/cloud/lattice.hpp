#pragma once
// Where the points of a box lattice lie and what they own; one answer on every rank, from the indices alone.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/vec3.hpp"
#include "cloud/shapes.hpp"

namespace calor {

using LatticeIndex = std::array<std::int64_t, 3>;  ///< along x, y, z; 0 along axes that the box does not have

class Lattice {
 public:
  explicit Lattice(const BoxLattice& box);
  /// Ends cells at places along an axis, m, in place of midway between two points: of an interval that holds one alone.
  /// A place on a point ends the cell of that point.
  void end_cells_at(int axis, std::span<const double> places);

  const BoxLattice& box() const { return box_; }
  std::int64_t count() const { return box_.points[0] * box_.points[1] * box_.points[2]; }
  std::int64_t id(const LatticeIndex& i) const { return i[0] + box_.points[0] * (i[1] + box_.points[1] * i[2]); }
  LatticeIndex index(std::int64_t id) const;

  /// Interval of an axis that is not graded, m; the mean of one that is.
  double dx(int axis) const { return dx_[axis]; }
  double largest_dx() const;
  double least_dx() const;
  bool graded(int axis) const { return !box_.coordinates[axis].empty(); }
  bool graded() const { return graded(0) || graded(1) || graded(2); }
  /// Largest distance to a neighbour along an axis of the regular lattice, m.
  double spacing(int axis, std::int64_t i) const;
  /// Intervals between walls: cells of the lattice along an axis.
  std::int64_t cells(int axis) const { return box_.points[axis] - (box_.on_walls ? 1 : 0); }
  bool lowest(const LatticeIndex& i, int axis) const { return i[axis] == 0; }
  bool highest(const LatticeIndex& i, int axis) const { return i[axis] == box_.points[axis] - 1; }

  /// Coordinate of the regular lattice, m.
  double coordinate(int axis, std::int64_t i) const;
  /// Length of the part of the regular cell of point i that lies inside the box, m.
  double width(int axis, std::int64_t i) const;
  /// Length of the whole of it; of a point on a wall, the mirrored half included.
  double full_width(int axis, std::int64_t i) const;
  /// Ends of that part, m.
  std::pair<double, double> cell(int axis, std::int64_t i) const;
  /// Position of a point, jitter included.
  Vec3 position(const LatticeIndex& i) const;
  /// Area of the wall normal to `axis` that a point on it stands for, m (2D) or m^2 (3D), jitter included. The areas
  /// integrate linear functions over the wall exactly, so that sum A = 0 and sum x cross A = 0 hold.
  double wall_area(const LatticeIndex& i, int axis) const;

 private:
  bool moves(const LatticeIndex& i, int axis) const;
  std::pair<double, double> cell_to_middles(int axis, std::int64_t i) const;

  BoxLattice box_;
  std::array<std::vector<double>, 3> ends_;  ///< of the cells on both sides of every interval; empty: its middle
  std::array<double, 3> dx_ = {1, 1, 1};
};

/// Three numbers, uniform in [0, 1), from the seed and a counter alone.
Vec3 hashed_uniform(std::uint64_t seed, std::uint64_t counter);

/// Integral over the box of the shape function of point id of `mine`, moving least squares with linear basis, in
/// m^dimension: a quadrature at the points that is exact for linear functions, for points on the walls. Cells of
/// nearest places are exact for constants only, which leaves the weights of pairs of first order on fine clouds.
/// Samples: three Gauss points a spacing along every axis.
std::vector<double> linearly_exact_volumes(const Lattice& lattice, const Slice& mine);

/// Volume of the part of the box that is nearer, in spacings, to point id of `mine` than to any other, in m^dimension;
/// over all points they add up to the box. Exact: sampled volumes would leave an error that does not fall with the
/// spacing.
std::vector<double> nearest_point_volumes(const Lattice& lattice, const Slice& mine);

}  // namespace calor
