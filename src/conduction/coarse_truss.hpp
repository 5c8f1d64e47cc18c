#pragma once
// Long waves of the lambda solve (linear_consistency.cpp). The blocks of the points hand on what they know by one
// support an iteration; functions on a coarse grid over the whole body reach its ends at once.
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/truss_grid.hpp"

namespace calor {

/// The truss as an elastic solid, lambda linear along each axis within the cells of a grid of 40,000 nodes at most and
/// 2.5 spacings wide at least, which is solved by one cycle with a grid of 500 nodes at most. Pairs alike in all
/// directions, measured in the spacings, with the fourth moment c_i = sum_j g_ij |x_ji / s_i|^4 / (2 D (D + 2)) store
/// the energy c_i [(tr E)^2 + 2 E : E] under the strain E; a cell stores that of its points, as if they were spread
/// evenly over it. So its matrix costs little and is near to that of the truss, which is all that a preconditioner
/// needs.
class CoarseTruss {
 public:
  /// For unknowns p with lambda = unit p, axis by axis. `held`: axes across whose walls mirror images lie, where lambda
  /// has no component along the axis. Collective.
  CoarseTruss(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g, const Vec3& unit,
              const std::array<bool, 3>& held);

  /// z += about the coarse stiffness^-1 times r, three numbers a point, with the same bits on any number of ranks.
  /// Collective.
  void add_solution(std::span<const double> r, std::span<double> z);

 private:
  /// The same on the nodes of the first grid.
  std::vector<double> solution(std::vector<double> r) const;

  const Cloud& cloud_;
  std::vector<std::unique_ptr<TrussGrid>> grids_;  // one or two
  std::vector<TrussGrid::Place> node_;             // of the first, in the second
  std::vector<TrussGrid::CellVectors> cells_;      // of the first, for add_solution
};

}  // namespace calor
