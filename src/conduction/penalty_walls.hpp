#pragma once
// Walls that a penalty holds at their temperature (as in the papers on MLPG): into point i of the wall flows the heat
//   F_i += k_i [slope . u + stiffness (T* - T(x_i))],
// that of the temperature's gradient and that of the penalty, booked to the boundary that holds the wall.
#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "conduction/heat_term.hpp"

namespace calor {

/// For every one of Conditions::temperatures, its points.
struct PenaltyRows {
  std::vector<SparseRows> slope;               ///< area . grad T, m
  std::vector<std::vector<double>> stiffness;  ///< m
};

class PenaltyWalls final : public HeatTerm {
 public:
  /// `temperatures` must outlive this.
  PenaltyWalls(PenaltyRows rows, std::span<const PrescribedTerm> temperatures)
      : rows_(std::move(rows)), temperatures_(temperatures) {}

  void add_rate(Evaluation& at, std::span<double> F, std::span<double> power) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;
  void add_row_sums(Evaluation& at, std::span<double> sums) override;
  Traits traits() const override { return {.is_symmetric = false, .fixes_level = true}; }

 private:
  /// Calls use(m, n, flux over k) for point n of term m.
  template <class Use>
  void for_each_point(Evaluation& at, const Use& use);

  PenaltyRows rows_;
  std::span<const PrescribedTerm> temperatures_;
  std::vector<double> T_star_, row_;
};

}  // namespace calor
