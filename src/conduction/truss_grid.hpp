#pragma once
// An elastic solid on a grid of equal cells over the whole body, which stands for a truss of many pairs
// (coarse_truss.hpp). Every rank holds the whole grid.
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/simd.hpp"
#include "base/vec3.hpp"
#include "cloud/cells.hpp"

namespace calor {

class TrussGrid {
 public:
  /// Over the box of the body, linear along each axis within cells at least `width` spacings wide and so wide that
  /// there are no more than `most_nodes`.
  TrussGrid(const Bounds& body, const Vec3& spacing, int dimension, double width, std::int32_t most_nodes);
  ~TrussGrid();
  TrussGrid(const TrussGrid&) = delete;
  TrussGrid& operator=(const TrussGrid&) = delete;

  /// A cell, by its lowest node, and a place in it, from 0 to 1 along every axis.
  struct Place {
    std::int32_t cell;
    Vec3 at;
  };
  std::int32_t nodes() const { return along_[0] * along_[1] * along_[2]; }
  CALOR_ALWAYS_INLINE Place place(const Vec3& x) const {
    std::int32_t node = 0, stride = 1;
    Vec3 at;
    for (int a = 0; a < 3; ++a) {
      const double along = (x[a] - low_[a]) * over_width_[a];
      const std::int32_t cell = std::clamp(static_cast<std::int32_t>(along), 0, std::max(along_[a] - 2, 0));
      at[a] = along - cell;
      node += stride * cell;
      stride *= along_[a];
    }
    return {node, at};
  }
  Vec3 node(std::int32_t n) const;

  /// Numbers of the eight corners of a cell; corner k has the bits of its coordinates.
  using Corners = Doubles<8>;
  /// Values of the corners' functions at a place of the unit cell.
  CALOR_ALWAYS_INLINE static Corners tents(const Vec3& at) {
    const double x = at.x, y = at.y, z = at.z;
    const Corners along_x = {1 - x, x, 1 - x, x, 1 - x, x, 1 - x, x};
    const Corners along_y = {1 - y, 1 - y, y, y, 1 - y, 1 - y, y, y};
    const Corners along_z = {1 - z, 1 - z, 1 - z, 1 - z, z, z, z, z};
    return along_x * along_y * along_z;
  }
  /// The three components at the corners of a cell.
  struct CellVectors {
    double v[3][8] = {};
    CALOR_ALWAYS_INLINE UnalignedDoubles<8>& operator[](int a) { return *reinterpret_cast<UnalignedDoubles<8>*>(v[a]); }
  };
  // Between cells, by their lowest nodes, and nodes, three numbers each.
  void add_to_nodes(const CellVectors& cell, std::int32_t n, std::span<double> u) const;
  CellVectors corners(std::int32_t n, std::span<const double> u) const;

  /// Cells with the energy e [(tr E)^2 + 2 E : E] under the strain E of lambda = unit p, lengths in spacings. `held`:
  /// axes across whose ends p has no component along the axis.
  void set_energies(std::vector<double> energy, const Vec3& unit, const std::array<bool, 3>& held);
  /// y = K p.
  void multiply(std::span<const double> p, std::span<double> y) const;
  /// K^-1 r, rigid motions held by a little of the diagonal; of grids with few nodes.
  std::vector<double> solve(std::span<const double> r);
  /// A few steps of Chebyshev's iteration for K p = f, f - K p = r, that damp what a grid several times wider cannot
  /// see.
  void smooth(std::span<double> p, std::span<double> r) const;

 private:
  struct Factor;
  using Matrix = std::array<std::array<double, 24>, 24>;  // of the components a of corners k, 8 a + k

  bool is_held(std::int32_t node, int a) const;
  Matrix cell_matrix(const Vec3& unit) const;
  void find_largest_eigenvalue(const Matrix& M);
  void factorise();

  int dimension_;
  Vec3 low_, spacing_, width_, over_width_;        // of the cells; 0 along axes without cells
  std::array<std::int32_t, 3> along_ = {1, 1, 1};  // nodes
  std::array<std::int32_t, 8> corner_ = {};        // of a cell, from the one with the lowest coordinates
  std::vector<double> energy_;                     // of the cells, by their lowest corner
  std::array<bool, 3> held_ = {};
  std::vector<std::array<double, 8>> column_;  // of the matrix of a cell: 3 (8 b + l) + a holds all corners k
  std::vector<double> diagonal_;               // 0 where nothing is
  double largest_ = 0;                         // no eigenvalue of diagonal^-1 K lies beyond
  std::unique_ptr<Factor> factor_;
};

}  // namespace calor
