#pragma once
// A case put together in one process, for Python.
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "app/model.hpp"
#include "arrays.hpp"

namespace calor::python {

/// Rows, columns and values of a square sparse matrix over the points; entries of one place add up.
using Entries = std::tuple<Numbers, Numbers, Array>;

class CaseModel {
 public:
  /// `overrides`: as on the command line. Throws Error.
  CaseModel(const std::string& path, const std::vector<std::string>& overrides, const py::dict& functions);

  const Cloud& cloud() const { return *model_.cloud; }
  const Order& order() const { return order_; }
  const std::vector<std::string>& notes() const { return model_.notes; }
  const std::vector<std::string>& accounts() const { return model_.system->accounts(); }
  std::vector<std::string> parts() const;  ///< materials of the parts
  Numbers part() const;                    ///< of every point
  py::dict facets() const;                 ///< point, face, area, normal
  Numbers prescribed() const;              ///< points with a temperature that is given, ascending
  bool dofs_are_temperatures() const { return model_.system->dofs().are_temperatures(); }
  Array start() const;  ///< degrees of freedom at t = 0, walls imposed

  Array temperatures(const Array& u) const;
  Array dofs(const Array& T) const;
  Entries shape_functions() const;  ///< T = Phi u
  /// Conduction with 1 W/(m K) everywhere.
  Entries weights() const;

  Array conductivity(const Array& T, double t) const;
  Array heat_capacity(const Array& T) const;
  Array energy(const Array& u) const;
  Array capacity(const Array& u) const;
  Array rate(const Array& u, double t) const;
  Array residual(const Array& u, double t, double rate_factor, const std::optional<Array>& known) const;
  Entries jacobian(const Array& u, double t, double capacity_factor, double rate_factor) const;
  Array heat_flux(const Array& u, double t) const;
  std::vector<double> heat_flows(const Array& u, double t) const;  ///< by account

  /// Temperatures of the steady state.
  Array solve() const;
  /// Temperatures at these times, (times, points).
  Array march(const std::vector<double>& times) const;

 private:
  std::vector<double> local(const Array& u, const std::string& name = "u") const { return order_.to_cloud(u, name); }
  HeatSystem& system() const { return *model_.system; }
  /// With the cracks that are open at time t.
  HeatSystem& system_at(double t) const {
    model_.system->apply(t);
    return *model_.system;
  }

  Phases phases_;
  Case case_;
  Model model_;
  Order order_;
  State start_;
};

/// A whole run with results in `folder`; true where all [[expect]] entries hold. Throws Error.
bool run_case(const std::string& path, const std::vector<std::string>& overrides, const py::dict& functions,
              const std::string& folder);

}  // namespace calor::python
