#pragma once
// div(k grad T) as a sum over flux sites: pairs for SPH and peridynamics, quadrature points on cell faces for MLPG.
//   dE_i/dt = sum_q s_iq k_q (g_q . T)
// The sites know where properties are needed, not what the material is; they know no time and no boundary condition.
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/vec3.hpp"
#include "cloud/cell_samples.hpp"

namespace calor {

/// How two points share a conductivity. integral: k depends on T alone, the pair flux is G (theta_j - theta_i) with
/// theta = integral of k dT (exact); arithmetic: k(x) or k(x,T); harmonic: layered or piecewise bodies, the interface
/// midway between the points.
enum class Mean { integral, arithmetic, harmonic };

/// A sparse linear map from the unknowns of the local points, by rows.
struct SparseRows {
  std::vector<std::int64_t> row = {0};
  std::vector<std::int32_t> column;  ///< local points
  std::vector<double> value;

  std::size_t count() const { return row.size() - 1; }
  double times(std::size_t r, std::span<const double> T) const {
    double sum = 0;
    for (std::int64_t n = row[r]; n < row[r + 1]; ++n) sum += value[n] * T[column[n]];
    return sum;
  }
  void apply(std::span<const double> T, std::span<double> out) const {
    for (std::size_t r = 0; r < count(); ++r) out[r] = times(r, T);
  }
};

/// Points between the nodes at which a method wants properties.
struct QuadraturePoints {
  std::vector<Vec3> x;   ///< m
  std::vector<int> tag;  ///< of the point that the place belongs to
  SparseRows phi;        ///< temperature there: T(x_q) = sum_J phi_qJ T_J
};

/// Quadrature points whose enthalpies add up to those of the owned points' cells: E_i = sum_q volume_q H(T(x_q)).
struct CellQuadrature : QuadraturePoints {
  std::vector<std::int64_t> cell = {0};  ///< those of owned point i are cell[i] .. cell[i+1]
  std::vector<double> volume;            ///< m^3
};

/// The conductivity where the sites want it: at their conduction places, or else at all local points, ghosts included.
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

/// Bonds from points to mirror images beyond walls of prescribed temperature. An image stands for a local point m: it
/// has its conductivity and the temperature
///   T = sign T_m + sum_n factor_n T*_n(x_n, t)
/// (odd reflection: sign = -1 and 2 T*; beyond an edge of two such walls +1; a constant layer: 0 and T*). Where fluxes
/// are differences of theta = integral of k dT, theta takes the place of T.
struct WallBonds {
  /// A wall temperature that enters an image's: Conditions::temperatures[term] at a place on its wall.
  struct Value {
    std::int32_t image, term;
    double factor;
    Vec3 x;
  };
  struct Image {
    std::int32_t point;  ///< m
    double sign;
    std::array<int, 3> term;  ///< of the walls across every axis that give it heat, in equal parts; -1: none
  };
  std::vector<Image> images;
  std::vector<Value> values;
  // One entry a bond, by ascending owned point.
  std::vector<std::int32_t> point, image;
  std::vector<double> G;  ///< m; the bond of j to the image of i has that of i to the image of j
};

/// Walls that a penalty holds at their temperature: into point i of the wall flows the heat
///   k_i [slope . T + stiffness (T* - T(x_i))],
/// that of the temperature's gradient and that of the penalty. For every one of Conditions::temperatures, its points.
struct PenaltyWalls {
  std::vector<SparseRows> slope;               ///< area . grad T, m
  std::vector<std::vector<double>> stiffness;  ///< m
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
  /// Points that couple to owned point i (without i), by conduction, capacity or value: the sparsity of the Jacobian.
  virtual std::span<const std::int32_t> coupled(int i) const = 0;
  // What the unknowns mean. All null for a method whose unknowns are the temperatures of the points and whose points
  // hold the heat of their cells at their own temperature.
  virtual const QuadraturePoints* conduction_quadrature() const { return nullptr; }
  virtual const CellQuadrature* capacity_quadrature() const { return nullptr; }
  /// The subdomains of the owned points, over which sources are integrated; null where they are the points' cells.
  virtual const CellSamples* subdomains() const { return nullptr; }
  /// Temperatures of the owned points from the unknowns.
  virtual const SparseRows* point_values() const { return nullptr; }
  /// Temperatures at other places from the unknowns of the local points, for places within a spacing of an owned point;
  /// nothing where the method knows temperatures at its points only. Collective; throws Error.
  virtual std::optional<SparseRows> value_rows(std::span<const Vec3>) const { return std::nullopt; }

  /// Times at which the sites themselves change (bonds that fail), and the change: to be called at these times.
  virtual std::vector<double> events() const { return {}; }
  virtual void change(double) {}

  /// Null unless the method treats its wall points algebraically.
  virtual const WallRows* wall_rows() const { return nullptr; }
  /// Null unless mirror images lie beyond walls of prescribed temperature.
  virtual const WallBonds* wall_bonds() const { return nullptr; }
  /// Null unless a penalty holds the walls of prescribed temperature.
  virtual const PenaltyWalls* penalty_walls() const { return nullptr; }
};

}  // namespace calor
