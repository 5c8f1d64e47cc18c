#pragma once
// Flux sites on the faces between cells: heat k_q sum_J g_qJ T_J flows from cell b to cell a, one row g_q a face point.
// Where the unknowns are MLS parameters, k_q is that at the face point; where they are the temperatures of the points,
// the mean of its two points, as for pairs, and k(T) alone is taken in exactly: k grad T = grad theta, theta = integral
// k dT.
#include <optional>
#include <utility>
#include <vector>

#include "cloud/cloud.hpp"
#include "conduction/faces.hpp"
#include "conduction/flux_sites.hpp"
#include "conduction/supports.hpp"

namespace calor {

/// Moving least squares with the supports that the sites were built with.
struct ShapeFunctions {
  MovingLeastSquares mls;
  SupportSize size;
  std::vector<double> R;  ///< of all local points, m
};

/// Rows over the unknowns: MLS parameters, or values at the points.
struct MlpgRows {
  SparseRows flux;                             ///< g_q at the face points, m
  QuadraturePoints conduction;                 ///< the face points
  std::optional<CellQuadrature> cells;         ///< none: a point holds the heat of its cell at its own temperature
  SparseRows value;                            ///< Phi at the owned points
  std::optional<CellSamples> subdomains = {};  ///< where they are not the points' cells
  ShapeFunctions shapes = {};                  ///< for values at other places
  std::optional<PenaltyWalls> walls = {};      ///< none: prescribed temperatures are collocated
};

class MlpgSites final : public FluxSites {
 public:
  /// `nodal`: the unknowns are the temperatures of the points; only rows.flux is then used. Collective.
  MlpgSites(const Cloud& cloud, Faces faces, MlpgRows rows, bool nodal);

  void add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const override;
  void add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const override;
  bool symmetric(Mean mean, bool k_depends_on_T) const override;
  void add_row_bound(const Conductivity& k, std::span<double> bound) const override;
  void heat_flux(const Conductivity& k, std::span<const double> T, std::span<Vec3> q) const override;
  std::span<const std::int32_t> coupled(int i) const override;
  const QuadraturePoints* conduction_quadrature() const override { return nodal_ ? nullptr : &rows_.conduction; }
  const CellQuadrature* capacity_quadrature() const override { return rows_.cells ? &*rows_.cells : nullptr; }
  const CellSamples* subdomains() const override { return rows_.subdomains ? &*rows_.subdomains : nullptr; }
  const PenaltyWalls* penalty_walls() const override { return rows_.walls ? &*rows_.walls : nullptr; }
  const SparseRows* point_values() const override { return nodal_ ? nullptr : &rows_.value; }
  std::optional<SparseRows> value_rows(std::span<const Vec3> places) const override;

  const Faces& faces() const { return faces_; }
  const SparseRows& flux_rows() const { return rows_.flux; }

 private:
  /// A face point of a cell, and whether its flux comes in (+1) or goes out (-1).
  struct Side {
    std::int32_t face, sign;
  };
  std::span<const Side> sides(int i) const {
    return {side_.data() + first_side_[i], static_cast<std::size_t>(first_side_[i + 1] - first_side_[i])};
  }
  void order_sides();
  void find_coupled();
  double slope(std::size_t q, std::span<const double> T) const;                        // g_q . T
  double mean(const Conductivity& k, std::size_t q) const;                             // k_q
  double flow(const Conductivity& k, std::span<const double> T, std::size_t q) const;  // W

  const Cloud& cloud_;
  Faces faces_;
  MlpgRows rows_;
  bool nodal_;             // the unknowns are the temperatures of the points
  bool two_point_ = true;  // every flux row holds the two points of its face only
  std::vector<std::int64_t> first_side_, first_coupled_;
  std::vector<Side> side_;
  std::vector<std::int32_t> coupled_;
};

}  // namespace calor
