#pragma once
// A steady state, or a stage of a time step, and small changes of it. Where R(u, p) = 0 are its balances and d = w . u
// is a reading,
//   tangent  J du/dp = -dR/dp,   dd/dp = w . du/dp:      one solution for every number p,
//   adjoint  J^T lambda = w,     dd/dp = -lambda . dR/dp: one solution for every reading.
#include <span>
#include <vector>

#include "base/petsc.hpp"
#include "solve/heat_system.hpp"

namespace calor {

class Linearisation {
 public:
  /// Of the steady state u (local points). `transposed`: solves with J^T. Collective; throws Error.
  Linearisation(HeatSystem& system, std::span<double> u, bool transposed);
  /// Of u in the stage E(u) - gamma_dt F(t, u) = known.
  Linearisation(HeatSystem& system, double t, std::span<double> u, double gamma_dt);

  /// x = J^-1 b, or J^-T b, of the owned points; b and x may be one array. Throws Error(numbers). Collective.
  void solve(std::span<const double> b, std::span<double> x);
  /// Adds up what the ranks have for points of others: of weights w of the local points, those of the owned ones.
  /// Collective.
  std::vector<double> sum_at_owners(std::span<const double> w);

 private:
  void prepare(bool steady);
  void scale_rows();

  HeatSystem& system_;
  petsc::Matrix J_;
  petsc::Vector b_;
  petsc::LinearSolver solver_;
  std::vector<double> row_scale_;  ///< of the owned points
  double unit_ = 1;
  bool is_transposed_ = false;
};

}  // namespace calor
