#pragma once
// Wall points that hold no heat: their temperatures follow from algebraic rows,
//   0 = k_i sum_j w_ij (T_j - T_i) - sum over the point's faces of q(T_i),
// solved together for all of them after every change of the points inside.
#include <petscksp.h>

#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "cloud/cloud.hpp"
#include "conduction/flux_sites.hpp"

namespace calor {

class AlgebraicWalls {
 public:
  /// `active[n]`: row n is in force, its point has no prescribed temperature. Collective.
  AlgebraicWalls(const Cloud& cloud, const WallRows& rows, const std::vector<SurfaceTerm>& fluxes,
                 std::vector<char> active);
  ~AlgebraicWalls();
  AlgebraicWalls(const AlgebraicWalls&) = delete;
  AlgebraicWalls& operator=(const AlgebraicWalls&) = delete;

  const WallRows& rows() const { return rows_; }
  /// Part of facet p of flux term f in its point's face: the flux of a face with several facets is their mean.
  double share(std::size_t f, std::size_t p) const { return share_[f][p]; }

  // `exchange[i]` is the flux into owned point i, summed over its faces, W/m^2, and `exchange_derivative[i]` its d/dT.

  /// R_i = area (exchange - k_i sum_j w_ij (T_j - T_i)), W; the area makes rows comparable with heat balances.
  void residual(std::span<const double> k, std::span<const double> T, std::span<const double> exchange,
                std::span<double> R) const;
  /// dR_i/dT_j.
  void add_jacobian(const Conductivity& k, std::span<const double> T, std::span<const double> exchange_derivative,
                    JacobianEntries& J) const;
  /// One Newton step for the temperatures of the rows; returns the largest change, K. With `k_is_fixed` the matrix of
  /// the last step is kept while the derivatives are the same. Collective.
  double newton_step(const Conductivity& k, std::span<double> T, std::span<const double> exchange,
                     std::span<const double> exchange_derivative, bool k_is_fixed);

 private:
  double difference(std::size_t n, std::span<const double> T) const;  ///< sum_j w_ij (T_j - T_i), K/m

  const Cloud& cloud_;
  const WallRows& rows_;
  std::vector<char> active_;
  std::vector<double> area_;
  std::vector<std::vector<double>> share_;
  std::vector<PetscInt> number_;  ///< of all local points among the active rows of all ranks; -1 elsewhere
  bool is_assembled_ = false;
  std::vector<double> assembled_with_;  ///< exchange derivatives
  Mat matrix_ = nullptr;
  Vec right_ = nullptr, change_ = nullptr;
  KSP solver_ = nullptr;
};

}  // namespace calor
