#pragma once
// Sparse rows over the degrees of freedom, and the points between the nodes at which a method integrates.
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

/// A sparse linear map from the degrees of freedom of the local points, by rows.
struct SparseRows {
  std::vector<std::int64_t> row = {0};
  std::vector<std::int32_t> column;  ///< local points
  std::vector<double> value;

  std::size_t count() const { return row.size() - 1; }
  std::span<const std::int32_t> columns(std::size_t r) const {
    return {column.data() + row[r], static_cast<std::size_t>(row[r + 1] - row[r])};
  }
  std::span<const double> values(std::size_t r) const {
    return {value.data() + row[r], static_cast<std::size_t>(row[r + 1] - row[r])};
  }
  double times(std::size_t r, std::span<const double> u) const {
    double sum = 0;
    for (std::int64_t n = row[r]; n < row[r + 1]; ++n) sum += value[n] * u[column[n]];
    return sum;
  }
  void apply(std::span<const double> u, std::span<double> out) const {
    for (std::size_t r = 0; r < count(); ++r) out[r] = times(r, u);
  }
};

/// Points between the nodes at which a method wants properties.
struct QuadraturePoints {
  std::vector<Vec3> x;   ///< m
  std::vector<int> tag;  ///< of the node that the point belongs to
  SparseRows phi;        ///< temperature there: T(x_q) = sum_J phi_qJ u_J
};

/// Quadrature points whose enthalpies add up to those of the owned points' cells: E_i = sum_q volume_q H(T(x_q)).
struct CellQuadrature : QuadraturePoints {
  std::vector<std::int64_t> cell = {0};  ///< those of owned point i are cell[i] .. cell[i+1]
  std::vector<double> volume;            ///< m^3
};

}  // namespace calor
