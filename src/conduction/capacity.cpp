#include "conduction/capacity.hpp"

#include <algorithm>
#include <utility>

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
  const SparseRows& phi = cells_.phi;
  const std::int32_t last = phi.column.empty() ? -1 : std::ranges::max(phi.column);
  std::vector<std::int32_t> seen_by(last + 1, -1), columns;
  std::vector<double> row(last + 1), values;
  for (std::int32_t i = 0; i + 1 < static_cast<std::int32_t>(cells_.cell.size()); ++i) {
    columns.clear(), values.clear();
    for (std::int64_t q = cells_.cell[i]; q < cells_.cell[i + 1]; ++q) {
      const double C = cells_.volume[q] * H_[q];
      for (std::int64_t n = phi.row[q]; n < phi.row[q + 1]; ++n) {
        const std::int32_t j = phi.column[n];
        if (std::exchange(seen_by[j], i) != i) columns.push_back(j);
        row[j] += C * phi.value[n];
      }
    }
    for (const std::int32_t j : columns) values.push_back(std::exchange(row[j], 0.0));
    J.add(i, columns, values);
  }
}

}  // namespace calor
