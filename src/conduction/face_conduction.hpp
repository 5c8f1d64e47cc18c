#pragma once
// Conduction through the faces between cells: heat k_q sum_J g_qJ T_J flows from cell b to cell a, one row g_q a face
// point. Where the unknowns are MLS parameters, k_q is that at the face point; where they are the temperatures of the
// points, the mean of its two points, as for pairs, and k(T) alone is taken in exactly: k grad T = grad theta, theta =
// integral k dT.
#include <optional>
#include <vector>

#include "cloud/cloud.hpp"
#include "conduction/faces.hpp"
#include "conduction/heat_term.hpp"
#include "conduction/pair_rows.hpp"

namespace calor {

/// Rows over the degrees of freedom: parameters of moving least squares, or temperatures of the points, for which only
/// `flux` is used.
struct FaceRows {
  SparseRows flux;                      ///< g_q at the face points, m
  QuadraturePoints conduction;          ///< the face points
  std::optional<CellQuadrature> cells;  ///< none: a point holds the heat of its cell at its own temperature
  SparseRows value;                     ///< Phi at the owned points
};

class FaceConduction final : public Conduction {
 public:
  /// The conductivity is wanted at the nodes, if these are temperatures of points (`nodal`), or else at
  /// rows().conduction, which then is location 1. Collective.
  FaceConduction(const Cloud& cloud, Faces faces, FaceRows rows, bool nodal);

  void add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const override;
  void add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const override;
  void add_row_sums(const Conductivity& k, std::span<double> sums) const override;
  void heat_flux(const Conductivity& k, std::span<const double> u, std::span<const int> points,
                 std::span<Vec3> q) const override;
  using Conduction::add_jacobian, Conduction::add_rate, Conduction::add_row_sums, Conduction::heat_flux;
  std::span<const std::int32_t> coupled(int i, std::vector<std::int32_t>& buffer) const override;
  Traits traits() const override { return {.is_symmetric = two_point_}; }

  bool is_nodal() const { return nodal_; }
  const Faces& faces() const { return faces_; }
  const FaceRows& rows() const { return rows_; }

 private:
  /// A face point of a cell, and whether its flux comes in (+1) or goes out (-1).
  struct Side {
    std::int32_t face, sign;
  };
  std::span<const Side> sides(int i) const {
    return {side_.data() + first_side_[i], static_cast<std::size_t>(first_side_[i + 1] - first_side_[i])};
  }
  void order_sides();
  void pack_pairs();
  void find_coupled();
  double slope(std::size_t q, std::span<const double> T) const;                        // g_q . T
  double mean(const Conductivity& k, std::size_t q) const;                             // k_q
  double flow(const Conductivity& k, std::span<const double> T, std::size_t q) const;  // W

  const Cloud& cloud_;
  Faces faces_;
  FaceRows rows_;
  bool nodal_;
  bool two_point_ = true;  // every flux row holds the two points of its face only
  PairRows pairs_;         // of temperatures of points and two-point fluxes: what flows, as that of pairs
  std::vector<std::int64_t> first_side_, first_coupled_;
  std::vector<Side> side_;
  std::vector<std::int32_t> coupled_;
};

}  // namespace calor
