#pragma once
// Algebraic rows at wall points that hold no heat, as the paper of Rong & Kisu has them (eq. 5 with corrected signs):
//   0 = k_i sum_j w_ij (T_j - T_i) - sum over the point's faces of q(T_i),
// w_ij = sum over the faces of 2 V_j grad W_ij . n, the factor 2 ("zeta") for the half of the support that the wall
// cuts off. They are solved together after every change of the points inside.
#include <memory>
#include <span>
#include <vector>

#include "base/petsc.hpp"
#include "boundary/conditions.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/constraint.hpp"

namespace calor {

class ZetaRows final : public Constraint {
 public:
  /// Rows of all owned points that lie on a face and have no prescribed temperature. `G`: 2 V_i V_j F_ij / section with
  /// full volumes. Cloud and conditions must outlive this. Collective.
  ZetaRows(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G, const Conditions& conditions);
  ZetaRows(const ZetaRows&) = delete;
  ZetaRows& operator=(const ZetaRows&) = delete;

  std::span<const int> points() const override { return point_; }
  bool fixes_dofs() const override { return false; }
  bool is_massless() const override { return true; }
  Traits traits() const override;
  std::span<const std::int32_t> coupled(std::size_t n) const override { return weights_.columns(n); }

  /// c_i = area (q - k_i sum_j w_ij (T_j - T_i)), W; the area makes rows comparable with heat balances.
  void residual(Evaluation& at, std::span<double> c) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;
  void scale(Evaluation& at, std::span<double> scale) override;
  void set_known(double /*t*/, std::span<double> /*u*/) override {}
  void impose(Evaluation& at, double t, std::span<double> u, std::span<double> E, std::span<double> heat) override;

 private:
  /// Sums over the faces of the rows' points of the flux into the body, W/m^2, and of its derivative by T.
  void find_exchange(Evaluation& at);
  double difference(std::size_t n, std::span<const double> T) const;  ///< sum_j w_ij (T_j - T_i), K/m
  void assemble(Evaluation& at);
  /// One step of Newton's method; returns the largest change, K. Collective.
  double newton_step(Evaluation& at, std::span<double> T);

  const Cloud& cloud_;
  std::span<const SurfaceTerm> fluxes_;
  std::vector<int> point_;
  SparseRows weights_;                      ///< 1/m
  std::vector<double> area_;                ///< m^2
  std::vector<std::vector<double>> share_;  ///< of every facet of every flux in its point's face
  std::vector<PetscInt> number_;            ///< of all local points among the rows of all ranks; -1 elsewhere
  std::vector<double> exchange_, exchange_derivative_;  ///< of all owned points
  bool is_assembled_ = false;
  std::vector<double> assembled_with_;  ///< exchange derivatives
  petsc::Matrix matrix_;
  petsc::Vector right_, change_;
  petsc::LinearSolver solver_;
};

/// Null where no point of any rank has such a row. Collective.
std::unique_ptr<ZetaRows> zeta_rows(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> G,
                                    const Conditions& conditions);

}  // namespace calor
