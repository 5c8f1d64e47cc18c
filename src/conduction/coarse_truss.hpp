#pragma once
// Long waves of the lambda solve (linear_consistency.cpp). The blocks of the points hand on what they know by one
// support an iteration; functions on a coarse grid over the whole body reach its ends at once.
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

/// The truss as an elastic solid, lambda linear along each axis within the cells of a grid of 1000 nodes at most and
/// three spacings wide at least. Pairs alike in all directions, measured in the spacings, with the fourth moment c_i =
/// sum_j g_ij |x_ji / s_i|^4 / (2 D (D + 2)) store the energy c_i [(tr E)^2 + 2 E : E] under the strain E; a cell
/// stores that of its points, as if they were spread evenly over it. So its matrix costs little and is near to that of
/// the truss, which is all that a preconditioner needs.
class CoarseTruss {
 public:
  /// For unknowns p with lambda = unit p, axis by axis. `held`: axes across whose walls mirror images lie, where lambda
  /// has no component along the axis. Collective.
  CoarseTruss(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g, const Vec3& unit,
              const std::array<bool, 3>& held);
  ~CoarseTruss();
  CoarseTruss(const CoarseTruss&) = delete;
  CoarseTruss& operator=(const CoarseTruss&) = delete;

  /// z += coarse stiffness^-1 r, three numbers a point, with the same bits on any number of ranks. Collective.
  void add_solution(std::span<const double> r, std::span<double> z) const;

 private:
  struct Factor;
  /// A cell, by its lowest node, and a place in it, from 0 to 1 along every axis.
  struct Place {
    std::int32_t cell;
    Vec3 at;
  };

  void lay_grid(const Vec3& metric);
  Place place(const Vec3& x) const;
  std::int32_t nodes() const { return along_[0] * along_[1] * along_[2]; }

  const Cloud& cloud_;
  Vec3 low_, over_width_;                          // of the cells; 0 along axes without cells
  std::array<std::int32_t, 3> along_ = {1, 1, 1};  // nodes
  std::array<std::int32_t, 8> corner_ = {};        // of a cell, from the one with the lowest coordinates
  std::vector<Place> places_;                      // of the owned points
  std::unique_ptr<Factor> factor_;
};

}  // namespace calor
