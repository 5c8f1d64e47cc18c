#pragma once
// div(k grad T) as a sum over flux sites: pairs for SPH and peridynamics, quadrature points on cell faces for MLPG.
//   dE_i/dt = sum_q s_iq k_q (g_q . T)
// The sites know where properties are needed, not what the material is; they know no time and no boundary condition.
#include <memory>
#include <span>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

/// How two points share a conductivity. integral: k depends on T alone, the pair flux is G (theta_j - theta_i) with
/// theta = integral of k dT (exact); arithmetic: k(x) or k(x,T); harmonic: layered or piecewise bodies, the interface
/// midway between the points.
enum class Mean { integral, arithmetic, harmonic };

/// The conductivity at the property points of the sites (for pairs: all local points, ghosts included).
struct Conductivity {
  Mean mean = Mean::arithmetic;
  std::span<const double> k;      ///< W/(m K)
  std::span<const double> dk_dT;  ///< only for Jacobians
  std::span<const double> theta;  ///< W/m, only for Mean::integral
};

/// Receives the entries of a Jacobian: row is an owned local point, column a local point.
class JacobianEntries {
 public:
  virtual ~JacobianEntries() = default;
  /// Adds `values[n]` at (row, columns[n]).
  virtual void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) = 0;
};

/// Algebraic rows at wall points that hold no heat (the papers' own treatment of walls):
///   0 = sum_j weight (T_j - T_i) k_i - sum over the point's faces of the heat flux into the body.
struct WallRows {
  std::vector<int> point;            ///< owned points, ascending
  std::vector<std::int64_t> row;     ///< compressed rows
  std::vector<std::int32_t> column;  ///< local points
  std::vector<double> weight;        ///< 1/m; for every face the sum of 2 V_j grad W . n
};

class FluxSites {
 public:
  virtual ~FluxSites() = default;

  /// F_i += net heat conducted into owned point i, W. T covers all local points, ghosts up to date.
  virtual void add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const = 0;
  /// dF_i/dT_j, by rows.
  virtual void add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const = 0;
  /// Is dF/dT symmetric for this kind of conductivity (up to scaling of the columns by k for Mean::integral)?
  virtual bool symmetric(Mean mean, bool k_depends_on_T) const = 0;
  /// Row sums of |dF_i/dT_j| with the derivative of k left out: for the bound on the time step. W/K per owned point.
  virtual void add_row_bound(const Conductivity& k, std::span<double> bound) const = 0;
  /// Heat flux vector at the owned points, W/m^2; exact for linear temperatures.
  virtual void heat_flux(const Conductivity& k, std::span<const double> T, std::span<Vec3> q) const = 0;
  /// Points that couple to owned point i (without i): the sparsity of the Jacobian.
  virtual std::span<const std::int32_t> coupled(int i) const = 0;
  /// Null unless the method treats its wall points algebraically.
  virtual const WallRows* wall_rows() const { return nullptr; }
};

}  // namespace calor
