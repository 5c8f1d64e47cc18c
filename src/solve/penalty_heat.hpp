#pragma once
// Heat through walls that a penalty holds at their temperature:
//   F_i += k_i [slope . T + stiffness (T* - T(x_i))],
// booked to the boundary that holds the wall.
#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "conduction/flux_sites.hpp"
#include "material/material_field.hpp"

namespace calor {

class PenaltyHeat {
 public:
  /// `phi`: T(x_i) from the unknowns. All of them must outlive this.
  PenaltyHeat(const PenaltyWalls& walls, const SparseRows& phi, const std::vector<PrescribedTerm>& temperatures,
              const MaterialField& material);

  // Not collective: formulas may throw on one rank alone. T are the unknowns of all local points, ghosts up to date,
  // T_points the temperatures of the owned ones.
  void add_rate(double t, std::span<const double> T, std::span<const double> T_points, std::span<double> F,
                std::span<double> power);
  void add_jacobian(double t, std::span<const double> T, std::span<const double> T_points, JacobianEntries& J);
  /// Adds to the row sums of |dF_i/dT_j| with the derivative of k left out.
  void add_row_bound(double t, std::span<const double> T_points, std::span<double> bound);

 private:
  /// Conductivity of the owned points.
  void evaluate_k(double t, std::span<const double> T_points, bool with_derivative);
  /// Calls use(m, n, flux over k) for point n of term m.
  template <class Use>
  void for_each_point(double t, std::span<const double> T, std::span<const double> T_points, const Use& use);

  const PenaltyWalls& walls_;
  const SparseRows& phi_;
  const std::vector<PrescribedTerm>& temperatures_;
  const MaterialField& material_;
  std::vector<double> k_, dk_dT_, wanted_, row_;
};

}  // namespace calor
