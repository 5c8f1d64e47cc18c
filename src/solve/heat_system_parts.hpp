#pragma once
// What a HeatSystem is made of; shared by the files that implement it, not part of the library's interface.
#include <memory>
#include <span>
#include <vector>

#include "solve/heat_system.hpp"
#include "solve/nodal_values.hpp"
#include "solve/penalty_heat.hpp"
#include "solve/wall_bonds.hpp"
#include "solve/wall_rows.hpp"

namespace calor {

/// How the temperature of a point follows.
enum class Role : char {
  free,        ///< from its heat balance
  prescribed,  ///< given
  wall         ///< from an algebraic wall row; the point holds no heat
};

struct HeatSystem::Parts {
  Parts(const Cloud& cloud, std::unique_ptr<FluxSites> sites, SystemMaterial material, Conditions conditions,
        std::vector<std::unique_ptr<Source>> sources);

  const Cloud& cloud;
  std::unique_ptr<FluxSites> sites;
  SystemMaterial fields;
  const MaterialField& material;  ///< fields.points
  Conditions conditions;
  std::vector<std::unique_ptr<Source>> sources;

  std::vector<std::string> accounts;
  std::vector<Role> role;       ///< of all local points
  std::vector<int> prescribed;  ///< owned points, ascending
  std::unique_ptr<AlgebraicWalls> walls;
  std::unique_ptr<ImageHeat> images;     ///< beyond walls of prescribed temperature; null: none
  std::unique_ptr<PenaltyHeat> penalty;  ///< holds prescribed temperatures; no point is then prescribed. null: none
  std::unique_ptr<NodalValues> point_values;  ///< null: the unknowns are temperatures
  bool is_nodal = true, points_hold_heat = true;

  /// Temperatures of the owned points; T with valid ghosts.
  std::span<const double> values(std::span<const double> T);
  /// Temperatures of the owned points from the enthalpies of their cells; T holds a guess. Collective.
  void temperatures(std::span<const double> E, std::span<double> T);
  /// Enthalpies or capacities of the owned points' cells; either may be empty. Not collective.
  void hold(std::span<const double> T, std::span<double> E, std::span<double> C);

  /// Conductivity where the sites want it at (t, T), T with valid ghosts: theta or k for the rate and the flux vector,
  /// k for bounds, k and dk/dT for Jacobians. Not collective: may throw on one rank alone.
  enum class For { rate, bound, jacobian };
  Conductivity conductivity(double t, std::span<const double> T, For purpose);

  /// Conduction, surface fluxes and sources, without halo update. Not collective.
  void add_rate(double t, std::span<const double> T, std::span<double> F, std::span<double> power);
  /// diagonal[i] += d/dT(x_i) of surface fluxes and sources into point i, W/K. Not collective.
  void add_exchange_derivative(double t, std::span<const double> T, std::span<double> diagonal);

  /// The residuals of prescribed points: 0, or in systems that are not nodal (T* - T(x_i)) C_i. Not collective.
  void constrain(double t, std::span<const double> T, std::span<double> R);
  /// Sets the unknowns so that prescribed points have their temperature. Collective.
  void meet_constraints(double t, std::span<double> T);

  /// Largest eigenvalue of V^-1 K Phi^-1 of free points over the largest row sum of V^-1 |K|, with k = 1. Collective.
  double rate_of_values_over_bound();

  /// Fills held_E with the enthalpies of the prescribed points at T. Not collective.
  void hold_prescribed(std::span<const double> T);

  // Algebraic wall rows.
  void add_wall_residual(double t, std::span<const double> T, std::span<double> R);  ///< Not collective.
  void solve_walls(double t, std::span<double> T);                                   ///< Collective.
  /// Heat fluxes into the wall rows' points, summed over faces, W/m^2, or their derivatives; all owned points.
  std::span<const double> wall_exchange(double t, std::span<const double> T, bool derivative);

  std::vector<double> held_T, held_E;  ///< of `prescribed`, K, J
  bool prescribed_is_held = false;     ///< for good: the walls do not change in time
  bool prescribed_is_constant = true;
  std::vector<std::vector<int>> place;  ///< for every prescribed term: where its points are in `prescribed`

  std::vector<double> scratch, kept_T, T_points;
  double explicit_over_bound = 0;        ///< see explicit_rate_bound; 0: not yet known
  std::vector<double> constraint_scale;  ///< J/K, of `prescribed`; empty in nodal systems
  bool constraints_are_scaled = false;   ///< the same on all ranks, also on those without prescribed points

  /// Rows of free points get the derivative of capacity and exchange, those of prescribed points their constraint: for
  /// unknowns that are not nodal. Not collective.
  void add_rows(std::span<const double> T, double capacity_factor, std::span<const double> exchange, double rate_factor,
                Mat J);

 private:
  /// Calls use(f, term, q) with the fluxes of surface term f, W/m^2, or dq/dT; one value a facet.
  template <class Use>
  void for_each_surface_term(double t, std::span<const double> T, bool derivative, const Use& use);

  std::vector<double> k_, dk_dT_, theta_, T_conduction_, T_capacity_, H_capacity_, T_values_;
  bool k_is_known_ = false;  ///< and does not change
  std::vector<double> surface_T_, surface_q_, surface_dq_, source_power_, wall_exchange_[2];
  std::vector<double> base_T_, base_E_, base_C_;  ///< of `prescribed`, where the capacity is constant
};

template <class Use>
void HeatSystem::Parts::for_each_surface_term(double t, std::span<const double> T, bool derivative, const Use& use) {
  if (!conditions.fluxes.empty()) T = values(T);
  for (std::size_t f = 0; f < conditions.fluxes.size(); ++f) {
    const SurfaceTerm& term = conditions.fluxes[f];
    const std::size_t n = term.point.size();
    if (n == 0) continue;
    surface_T_.resize(n), surface_q_.resize(n), surface_dq_.resize(n);
    for (std::size_t p = 0; p < n; ++p) surface_T_[p] = T[term.point[p]];
    const std::span<double> dq_dT = derivative ? std::span<double>(surface_dq_) : std::span<double>();
    term.flux->evaluate({.x = term.x, .t = t, .T = surface_T_}, surface_q_, dq_dT);
    use(f, term, std::span<const double>(derivative ? surface_dq_ : surface_q_));
  }
}

}  // namespace calor
