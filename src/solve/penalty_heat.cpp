#include "solve/penalty_heat.hpp"

#include <cmath>

namespace calor {

PenaltyHeat::PenaltyHeat(const PenaltyWalls& walls, const SparseRows& phi,
                         const std::vector<PrescribedTerm>& temperatures, const MaterialField& material)
    : walls_(walls), phi_(phi), temperatures_(temperatures), material_(material) {}

void PenaltyHeat::evaluate_k(double t, std::span<const double> T_points, bool with_derivative) {
  k_.resize(T_points.size());
  dk_dT_.assign(with_derivative ? T_points.size() : 0, 0);
  material_.conductivity(t, T_points, k_, dk_dT_);
}

template <class Use>
void PenaltyHeat::for_each_point(double t, std::span<const double> T, std::span<const double> T_points,
                                 const Use& use) {
  for (std::size_t m = 0; m < temperatures_.size(); ++m) {
    const PrescribedTerm& term = temperatures_[m];
    const SparseRows& slope = walls_.slope[m];
    wanted_.resize(term.x.size());
    term.temperature.evaluate({.x = term.x, .t = t}, wanted_);
    for (std::size_t n = 0; n < wanted_.size(); ++n) {
      const int i = term.point[n];
      double flux = walls_.stiffness[m][n] * (wanted_[n] - T_points[i]);
      // The rows sum to zero: with differences a uniform temperature gives no flux, to the last bit.
      for (auto e = slope.row[n]; e < slope.row[n + 1]; ++e) flux += slope.value[e] * (T[slope.column[e]] - T[i]);
      use(m, n, flux);
    }
  }
}

void PenaltyHeat::add_rate(double t, std::span<const double> T, std::span<const double> T_points, std::span<double> F,
                           std::span<double> power) {
  evaluate_k(t, T_points, false);
  for_each_point(t, T, T_points, [&](std::size_t m, std::size_t n, double flux) {
    const int i = temperatures_[m].point[n];
    const double heat = k_[i] * flux;
    F[i] += heat;
    power[temperatures_[m].account] += heat;
  });
}

void PenaltyHeat::add_jacobian(double t, std::span<const double> T, std::span<const double> T_points,
                               JacobianEntries& J) {
  const bool depends_on_T = material_.conductivity_depends_on_T();
  evaluate_k(t, T_points, depends_on_T);
  const auto add = [&](int i, const SparseRows& rows, std::size_t r, double factor) {
    row_.assign(rows.value.begin() + rows.row[r], rows.value.begin() + rows.row[r + 1]);
    for (double& value : row_) value *= factor;
    J.add(i, {rows.column.data() + rows.row[r], row_.size()}, row_);
  };
  for_each_point(t, T, T_points, [&](std::size_t m, std::size_t n, double flux) {
    const int i = temperatures_[m].point[n];
    add(i, walls_.slope[m], n, k_[i]);
    add(i, phi_, i, (depends_on_T ? dk_dT_[i] * flux : 0) - k_[i] * walls_.stiffness[m][n]);
  });
}

void PenaltyHeat::add_row_bound(double t, std::span<const double> T_points, std::span<double> bound) {
  evaluate_k(t, T_points, false);
  for (std::size_t m = 0; m < temperatures_.size(); ++m) {
    const SparseRows& slope = walls_.slope[m];
    for (std::size_t n = 0; n < slope.count(); ++n) {
      const int i = temperatures_[m].point[n];
      double sum = walls_.stiffness[m][n];
      for (auto e = slope.row[n]; e < slope.row[n + 1]; ++e) sum += std::abs(slope.value[e]);
      bound[i] += k_[i] * sum;
    }
  }
}

}  // namespace calor
