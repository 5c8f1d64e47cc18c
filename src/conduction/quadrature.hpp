#pragma once
// Sparse rows over the degrees of freedom, and the points between the nodes at which a method integrates.
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec3.hpp"
#include "cloud/cloud.hpp"

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
  /// The rows [first, first + count) alone.
  SparseRows part(std::size_t first, std::size_t count) const {
    const std::int64_t begin = row[first], end = row[first + count];
    SparseRows rows;
    for (std::size_t r = first; r < first + count; ++r) rows.row.push_back(row[r + 1] - begin);
    rows.column.assign(column.begin() + begin, column.begin() + end);
    rows.value.assign(value.begin() + begin, value.begin() + end);
    return rows;
  }
  /// Ends the row of what was added to `column` and `value`.
  void close_row() { row.push_back(static_cast<std::int64_t>(column.size())); }
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
  std::vector<Vec3> x;         ///< m
  std::vector<int> tag;        ///< of the node that the point belongs to
  SparseRows phi;              ///< temperature there: T(x_q) = sum_J phi_qJ u_J
  std::vector<int> part = {};  ///< whose properties are meant; empty: of the part that the point lies in
};

/// Quadrature points whose enthalpies add up to those of the owned points' cells: E_i = sum_q volume_q H(T(x_q)).
struct CellQuadrature : QuadraturePoints {
  std::vector<std::int64_t> cell = {0};  ///< those of owned point i are cell[i] .. cell[i+1]
  std::vector<double> volume;            ///< m^3
};

/// Every cell's own point. The rows phi are left empty.
CellQuadrature one_point(const Cloud& cloud);

/// 2^D points a cell that integrate quadratic functions: c + S^(1/2) (+-1, +-1, +-1), c the centroid and S the
/// covariance of the cell; for a box they are its 2^D Gauss points. The cell is the box of an unjittered lattice,
/// otherwise the part of the body that is nearer to its point (in spacings, where these are the same everywhere) than
/// to any other, behind the planes of the walls of its point. The rows phi are left empty. Does not depend on the
/// number of ranks. Collective.
CellQuadrature gauss_points(const Cloud& cloud);

}  // namespace calor
