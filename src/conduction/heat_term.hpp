#pragma once
// Everything that moves heat is one kind of thing: pairs, faces of cells, mirror images, penalty walls, surface fluxes
// and sources each add their part to the semi-discrete heat equation
//   dE_i/dt = F_i(t, u),
// E the enthalpies of the cells, u the degrees of freedom. One virtual call an array, none inside the loops.
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec3.hpp"
#include "conduction/evaluation.hpp"

namespace calor {

/// Receives the entries of a Jacobian: row is an owned local point, column a local point.
class JacobianEntries {
 public:
  virtual ~JacobianEntries() = default;
  /// Adds `values[n]` at (row, columns[n]).
  virtual void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) = 0;
  /// Adds the derivative by the temperature of the row's own point: at the diagonal, where the degrees of freedom are
  /// the temperatures.
  virtual void add_nodal(int row, double by_T) {
    const std::int32_t column = row;
    add(row, {&column, 1}, {&by_T, 1});
  }
};

/// What the solvers choose by.
struct Traits {
  bool is_symmetric = true;  ///< dF/du of frozen coefficients, up to a scaling of its columns by k
  bool is_constant = true;   ///< dF/du does not change where the material's properties do not
  bool fixes_level = false;  ///< of a steady temperature, on this rank
};

class HeatTerm {
 public:
  virtual ~HeatTerm() = default;
  /// What needs all ranks at time t: called before all that follows. Collective.
  virtual void prepare(double /*t*/) {}
  // Not collective: material laws and formulas may throw on one rank alone.
  /// F_i += net heat into owned point i, W; power[account] += what of it comes from outside the body, W.
  virtual void add_rate(Evaluation& at, std::span<double> F, std::span<double> power) = 0;
  /// dF_i/du_j.
  virtual void add_jacobian(Evaluation& at, JacobianEntries& J) = 0;
  /// Row sums of |dF_i/du_j| with the derivative of k left out, for bounds on the time step, W/K per owned point.
  virtual void add_row_sums(Evaluation& at, std::span<double> sums) = 0;
  virtual Traits traits() const = 0;
  /// Times at which data jump or have kinks, or the term itself changes (bonds that fail) by `apply`.
  virtual Changes changes() const { return {}; }
  /// Changes what changes by itself at time t, one of the events.
  virtual void apply(double /*t*/) {}
};

/// Heat conducted between the points, div(k grad T) of the method.
///   F_i = sum_q s_iq k_q (g_q . u)
class Conduction : public HeatTerm {
 public:
  /// `location`: where it wants the conductivity.
  explicit Conduction(Location location) : location_(location) {}
  Location location() const { return location_; }
  /// Where pairs that cross interfaces have their ends; null: there are none on any rank. It is location 1 then.
  virtual const QuadraturePoints* ends() const { return nullptr; }

  // With a given conductivity; u covers all local points, ghosts up to date.
  virtual void add_rate(const Conductivity& k, std::span<const double> u, std::span<double> F) const = 0;
  virtual void add_jacobian(const Conductivity& k, std::span<const double> u, JacobianEntries& J) const = 0;
  virtual void add_row_sums(const Conductivity& k, std::span<double> sums) const = 0;
  /// Heat flux vector at owned `points`, W/m^2; exact for linear temperatures.
  virtual void heat_flux(const Conductivity& k, std::span<const double> u, std::span<const int> points,
                         std::span<Vec3> q) const = 0;
  /// Points that couple to owned point i (without i), by conduction, capacity or value: the sparsity of the Jacobian.
  /// `buffer` is room for them where they are not kept in this form.
  virtual std::span<const std::int32_t> coupled(int i, std::vector<std::int32_t>& buffer) const = 0;
  /// Does add_product work?
  virtual bool multiplies() const { return false; }
  /// F_i += sum_j dF_i/du_j v_j at u, without the entries; u and v cover all local points, ghosts up to date.
  virtual void add_product(const Conductivity& /*k*/, std::span<const double> /*u*/, std::span<const double> /*v*/,
                           std::span<double> /*F*/) const {}

  void add_rate(Evaluation& at, std::span<double> F, std::span<double> /*power*/) final {
    with_conductivity(at, Purpose::rate, [&](const Conductivity& k) { add_rate(k, at.u(), F); });
  }
  void add_jacobian(Evaluation& at, JacobianEntries& J) final {
    with_conductivity(at, Purpose::jacobian, [&](const Conductivity& k) { add_jacobian(k, at.u(), J); });
  }
  void add_row_sums(Evaluation& at, std::span<double> sums) final {
    with_conductivity(at, Purpose::bound, [&](const Conductivity& k) { add_row_sums(k, sums); });
  }
  void add_product(Evaluation& at, std::span<const double> v, std::span<double> F) const {
    with_conductivity(at, Purpose::jacobian, [&](const Conductivity& k) { add_product(k, at.u(), v, F); });
  }
  void heat_flux(Evaluation& at, std::span<const int> points, std::span<Vec3> q) const {
    with_conductivity(at, Purpose::rate, [&](const Conductivity& k) { heat_flux(k, at.u(), points, q); });
  }

 private:
  template <class Use>
  void with_conductivity(Evaluation& at, Purpose purpose, const Use& use) const {
    Conductivity k = at.at(location_).conductivity(purpose), at_ends;
    if (ends()) {
      at_ends = at.at(Evaluation::nodes + 1).at_ends(purpose);
      k.ends = &at_ends;
      k.t = at.t();
    }
    use(k);
  }

  Location location_;
};

}  // namespace calor
