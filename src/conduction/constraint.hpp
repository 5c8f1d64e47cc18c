#pragma once
// Points whose degree of freedom does not follow from a heat balance: prescribed temperatures, held by the points or
// collocated, and the algebraic wall rows of a paper. Each puts rows c(t, u) = 0 in the place of their balances.
#include <memory>
#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "cloud/cloud.hpp"
#include "conduction/capacity.hpp"
#include "conduction/heat_term.hpp"

namespace calor {

class Constraint {
 public:
  virtual ~Constraint() = default;
  /// Owned points whose balances the rows replace, ascending.
  virtual std::span<const int> points() const = 0;
  /// Are the degrees of freedom of these points known by themselves? No other row then needs a column for them.
  virtual bool fixes_dofs() const = 0;
  /// Do these points hold no heat? Their rows follow the others without delay.
  virtual bool is_massless() const = 0;
  virtual Traits traits() const = 0;
  /// Points that the row of the n-th point couples to.
  virtual std::span<const std::int32_t> coupled(std::size_t n) const = 0;

  // Not collective: may throw on one rank alone.
  /// c[i] of the rows' points.
  virtual void residual(Evaluation& at, std::span<double> c) = 0;
  virtual void add_jacobian(Evaluation& at, JacobianEntries& J) = 0;
  /// scale[i] = |dc_i/dT_i| of the rows' points, for tolerances; on entry the heat capacities of the cells, J/K.
  virtual void scale(Evaluation& at, std::span<double> scale) = 0;

  /// Sets the degrees of freedom that are known, before all others are solved for. Not collective.
  virtual void set_known(double t, std::span<double> u) = 0;
  /// Makes u meet the rows, updating its ghosts as needed, and books the heat that this takes: into E and into
  /// `heat`, by account, J. Collective.
  virtual void impose(Evaluation& at, double t, std::span<double> u, std::span<double> E, std::span<double> heat) = 0;
};

/// The constraint of [boundary.*] temperatures on points, as the degrees of freedom take it; null where no point of any
/// rank has one. All arguments must outlive it. Collective.
std::unique_ptr<Constraint> prescribed_points(const Cloud& cloud, std::span<const PrescribedTerm> temperatures,
                                              Dofs& dofs, Capacity& capacity);

/// Owned points that the terms prescribe, ascending.
std::vector<int> points_of(std::span<const PrescribedTerm> temperatures);

}  // namespace calor
