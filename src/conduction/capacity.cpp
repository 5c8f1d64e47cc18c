#include "conduction/capacity.hpp"

namespace calor {

void LumpedCapacity::evaluate(Evaluation& at, std::span<double> E, std::span<double> C) {
  at.at(Evaluation::nodes).material().enthalpy(at.T(), E, C);
  for (std::span<double> held : {E, C})
    for (std::size_t i = 0; i < held.size(); ++i) held[i] *= volume_[i];
}

void LumpedCapacity::add_jacobian(Evaluation& at, JacobianEntries& J) {
  C_.resize(volume_.size());
  evaluate(at, {}, C_);
  for (std::size_t i = 0; i < C_.size(); ++i) J.add_nodal(static_cast<int>(i), C_[i]);
}

void CellCapacity::evaluate(Evaluation& at, std::span<double> E, std::span<double> C) {
  Coefficients& inside = at.at(location_);
  const auto add_up = [&](std::span<double> held) {
    for (std::size_t i = 0; i < held.size(); ++i) {
      held[i] = 0;
      for (std::int64_t q = cells_.cell[i]; q < cells_.cell[i + 1]; ++q) held[i] += cells_.volume[q] * H_[q];
    }
  };
  if (!E.empty()) inside.material().enthalpy(inside.T(), H_, {}), add_up(E);
  if (!C.empty()) inside.material().enthalpy(inside.T(), {}, H_), add_up(C);
}

void CellCapacity::add_jacobian(Evaluation& at, JacobianEntries& J) {
  Coefficients& inside = at.at(location_);
  inside.material().enthalpy(inside.T(), {}, H_);
  std::vector<double> row;
  for (std::size_t i = 0; i + 1 < cells_.cell.size(); ++i) {
    for (std::int64_t q = cells_.cell[i]; q < cells_.cell[i + 1]; ++q) {
      const auto phi = cells_.phi.values(q);
      row.assign(phi.begin(), phi.end());
      for (double& value : row) value *= cells_.volume[q] * H_[q];
      J.add(static_cast<int>(i), cells_.phi.columns(q), row);
    }
  }
}

}  // namespace calor
