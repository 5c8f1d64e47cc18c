#pragma once
// dR/du of the heat system as Newton's method takes it: by its products, and as a matrix for the preconditioner.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/petsc.hpp"
#include "solve/heat_system.hpp"
#include "solve/nearest_pairs.hpp"

namespace calor {

/// One matrix for both; or, of many neighbours, products without a matrix, which are faster and take no memory on
/// lattices, and the thin matrix of the nearest pairs.
class JacobianOperator {
 public:
  /// `by_products`: without the matrix of all pairs; the conduction must multiply. Collective.
  JacobianOperator(HeatSystem& system, bool by_products);
  JacobianOperator(const JacobianOperator&) = delete;
  JacobianOperator& operator=(const JacobianOperator&) = delete;

  /// dR/du as HeatSystem::jacobian gives it. Where it is constant, stages (capacity_factor = 1) are sums of the two
  /// matrices that the first of them has left. Collective; throws Error.
  void evaluate(double t, std::span<double> u, double capacity_factor, double rate_factor);
  /// What is constant between two events has changed: nothing is kept.
  void forget() { capacity_ = {}, rate_ = {}; }
  /// Of what was evaluated last, before it was scaled: sum_j |J_ij| of the owned rows; by products, what several terms
  /// give to one entry may count one by one.
  std::vector<double> row_sums() const;

  // Until it is evaluated again. Collective.
  void scale(double factor);
  /// Rows and columns; `columns` may be null.
  void scale(Vec rows, Vec columns);
  void add_to_diagonal(std::span<const double> values);

  Mat products() const { return by_products_ ? products_ : matrix(); }
  Mat matrix() const { return by_products_ ? near_.matrix() : static_cast<Mat>(matrix_); }

 private:
  class Sums;
  class Rest;

  static PetscErrorCode multiply(Mat self, Vec x, Vec y);
  void multiply(std::span<const double> x, std::span<double> y);
  /// J of a stage by what is kept.
  void add_up(double t, std::span<double> u, double rate_factor);
  template <class Change>
  void change(const Change& change);

  HeatSystem& system_;
  bool by_products_;
  petsc::Matrix matrix_;
  petsc::Matrix capacity_, rate_;  ///< dE/du with the rows of constraints, and -dF/du without
  // Or:
  petsc::Matrix products_;
  NearestPairs near_;
  std::optional<Evaluation> at_;
  double rate_factor_ = 1;
  std::vector<double> u_, row_sums_;
  std::vector<std::int32_t> known_;  ///< local points
  SparseRows rest_;                  ///< all but the conduction in free rows, and
  std::vector<std::int32_t> row_;    ///< where these rows belong
  std::vector<double> x_, F_;        ///< room
};

}  // namespace calor
