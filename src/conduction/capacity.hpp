#pragma once
// The heat that the cells of the points hold.
#include <span>
#include <vector>

#include "conduction/heat_term.hpp"
#include "conduction/quadrature.hpp"

namespace calor {

class Capacity {
 public:
  virtual ~Capacity() = default;
  /// Does every point hold the heat of its cell at its own temperature? Only then temperatures follow from enthalpies.
  virtual bool is_lumped() const = 0;
  /// Enthalpies E, J, and heat capacities C = dE/dT, J/K, of the owned points' cells; either may be empty. May throw on
  /// one rank alone.
  virtual void evaluate(Evaluation& at, std::span<double> E, std::span<double> C) = 0;
  /// dE_i/du_j.
  virtual void add_jacobian(Evaluation& at, JacobianEntries& J) = 0;
};

/// E_i = V_i H(T_i).
class LumpedCapacity final : public Capacity {
 public:
  /// One volume an owned point, m^3; 0 for points that hold no heat.
  explicit LumpedCapacity(std::vector<double> volume) : volume_(std::move(volume)) {}
  bool is_lumped() const override { return true; }
  void evaluate(Evaluation& at, std::span<double> E, std::span<double> C) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;

 private:
  std::vector<double> volume_, C_;
};

/// E_i = sum_q V_q H(T(x_q)) over the quadrature points of the cell.
class CellCapacity final : public Capacity {
 public:
  /// `location` is that of the cells, which must outlive this.
  CellCapacity(const CellQuadrature& cells, Location location)
      : cells_(cells), location_(location), H_(cells.x.size()) {}
  bool is_lumped() const override { return false; }
  void evaluate(Evaluation& at, std::span<double> E, std::span<double> C) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;

 private:
  const CellQuadrature& cells_;
  Location location_;
  std::vector<double> H_;
};

}  // namespace calor
