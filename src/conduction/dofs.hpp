#pragma once
// The degrees of freedom of the heat equation, and what they say of temperatures.
#include <optional>
#include <span>

#include "base/petsc.hpp"
#include "cloud/cloud.hpp"
#include "conduction/quadrature.hpp"
#include "conduction/supports.hpp"

namespace calor {

/// Moving least squares with the supports that a scheme was built with.
struct ShapeFunctions {
  MovingLeastSquares mls;
  SupportSize size;
  std::vector<double> R;  ///< of all local points, in spacings
};

/// Degrees of freedom u, one a point: the temperatures of the points, or parameters of moving least squares, which do
/// not interpolate: T(x_i) = sum_J Phi_iJ u_J.
class Dofs {
 public:
  /// The temperatures of the points. `cloud` must outlive this.
  explicit Dofs(const Cloud& cloud);
  /// Parameters. `phi`: one row an owned point; both must outlive this. Collective.
  Dofs(const Cloud& cloud, const SparseRows& phi, ShapeFunctions shapes);
  Dofs(const Dofs&) = delete;
  Dofs& operator=(const Dofs&) = delete;

  bool are_temperatures() const { return phi_ == nullptr; }
  int owned() const { return cloud_.owned; }
  /// Rows of Phi; only of parameters.
  const SparseRows& phi() const { return *phi_; }

  /// Temperatures of the owned points from the local degrees of freedom, ghosts up to date.
  void temperatures(std::span<const double> u, std::span<double> T) const;
  /// Owned degrees of freedom with these temperatures. Throws Error(numbers) on all ranks where that fails. Collective.
  void solve(std::span<const double> T, std::span<double> u);
  /// Changes the owned degrees of freedom such that the temperatures change by dT, likewise.
  void add(std::span<const double> dT, std::span<double> u);
  /// Temperatures at other places from the local degrees of freedom, for places within a spacing of an owned point;
  /// nothing where temperatures are known at the points only. Collective; throws Error.
  std::optional<SparseRows> interpolation(std::span<const Vec3> x) const;

 private:
  void factorise();
  bool solve_linear();

  const Cloud& cloud_;
  const SparseRows* phi_ = nullptr;
  ShapeFunctions shapes_;
  petsc::Matrix matrix_;
  petsc::Vector right_, solution_, left_;
  petsc::LinearSolver solver_;
  bool is_direct_ = false;
};

}  // namespace calor
