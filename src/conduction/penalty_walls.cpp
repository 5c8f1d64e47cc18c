#include "conduction/penalty_walls.hpp"

#include <cmath>

namespace calor {

template <class Use>
void PenaltyWalls::for_each_point(Evaluation& at, const Use& use) {
  const std::span<const double> u = at.u(), T = at.T();
  for (std::size_t m = 0; m < temperatures_.size(); ++m) {
    const PrescribedTerm& term = temperatures_[m];
    const SparseRows& slope = rows_.slope[m];
    T_star_.resize(term.x.size());
    term.temperature.evaluate({.x = term.x, .t = at.t()}, T_star_);
    for (std::size_t n = 0; n < T_star_.size(); ++n) {
      const int i = term.point[n];
      double flux = rows_.stiffness[m][n] * (T_star_[n] - T[i]);
      // The rows sum to zero: with differences a uniform temperature gives no flux, to the last bit.
      for (auto e = slope.row[n]; e < slope.row[n + 1]; ++e) flux += slope.value[e] * (u[slope.column[e]] - u[i]);
      use(m, n, flux);
    }
  }
}

void PenaltyWalls::add_rate(Evaluation& at, std::span<double> F, std::span<double> power) {
  const std::span<const double> k = at.at(Evaluation::nodes).k();
  for_each_point(at, [&](std::size_t m, std::size_t n, double flux) {
    const int i = temperatures_[m].point[n];
    const double heat = k[i] * flux;
    F[i] += heat;
    power[temperatures_[m].account] += heat;
  });
}

void PenaltyWalls::add_jacobian(Evaluation& at, JacobianEntries& J) {
  const std::span<const double> k = at.at(Evaluation::nodes).k(), dk_dT = at.at(Evaluation::nodes).dk_dT();
  for_each_point(at, [&](std::size_t m, std::size_t n, double flux) {
    const int i = temperatures_[m].point[n];
    const auto slope = rows_.slope[m].values(n);
    row_.assign(slope.begin(), slope.end());
    for (double& value : row_) value *= k[i];
    J.add(i, rows_.slope[m].columns(n), row_);
    J.add_nodal(i, (dk_dT.empty() ? 0 : dk_dT[i] * flux) - k[i] * rows_.stiffness[m][n]);
  });
}

void PenaltyWalls::add_row_sums(Evaluation& at, std::span<double> sums) {
  const std::span<const double> k = at.at(Evaluation::nodes).k();
  for (std::size_t m = 0; m < temperatures_.size(); ++m) {
    const SparseRows& slope = rows_.slope[m];
    for (std::size_t n = 0; n < slope.count(); ++n) {
      const int i = temperatures_[m].point[n];
      double sum = rows_.stiffness[m][n];
      for (const double value : slope.values(n)) sum += std::abs(value);
      sums[i] += k[i] * sum;
    }
  }
}

}  // namespace calor
