#pragma once
// The semi-discrete heat equation dE/dt = F(t, T): residual, Jacobian, capacity, enthalpy. It knows no time stepping,
// and no method beyond its flux sites.
#include <petscmat.h>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "boundary/conditions.hpp"
#include "cloud/cloud.hpp"
#include "conduction/flux_sites.hpp"
#include "material/material_field.hpp"
#include "source/source.hpp"

namespace calor {

/// What a run carries from step to step; everything else can be computed from it.
struct State {
  double t = 0;
  std::vector<double> E;          ///< enthalpy of the owned points above the reference temperature, J
  std::vector<double> T;          ///< unknowns of the local points (ghosts may be stale), K: see HeatSystem::values
  std::vector<double> exchanged;  ///< heat that came in by each account since the start, J; this rank's share
};

/// The material where the equation wants it.
struct SystemMaterial {
  MaterialField points;                     ///< at all local points
  std::optional<MaterialField> conduction;  ///< at the sites' conduction places, if they have any
  std::optional<MaterialField> capacity;    ///< at their capacity places
};

/// The unknowns T are the temperatures of the points, or whatever the sites make of them (parameters of moving least
/// squares): `values` turns them into temperatures.
class HeatSystem {
 public:
  HeatSystem(const Cloud& cloud, std::unique_ptr<FluxSites> sites, SystemMaterial material, Conditions conditions,
             std::vector<std::unique_ptr<Source>> sources);
  ~HeatSystem();

  const Cloud& cloud() const;
  const FluxSites& sites() const;
  const MaterialField& material() const;  ///< at all local points
  /// Names of what heat comes in by: boundaries, then sources.
  const std::vector<std::string>& accounts() const;
  int boundary_accounts() const;  ///< how many of the accounts are boundaries; the rest are sources

  /// State at time t from temperatures of the owned points; walls are not yet imposed. Collective.
  State start(double t, std::span<const double> T_owned) const;
  /// Temperatures of the owned points from the unknowns, K. Valid until the next call. Collective.
  std::span<const double> values(std::span<double> T) const;
  bool is_nodal() const;  ///< are the unknowns the temperatures of the points?
  /// Does every point hold the heat of its cell at its own temperature? Explicit integrators need that.
  bool points_hold_heat() const;

  /// F_i = net heat into every owned point by conduction, wall fluxes and sources, W (prescribed points too: without
  /// their reaction; 0 at algebraic wall points); power[a] = this rank's share by account a, W, without reactions.
  /// Updates the ghosts of T. Collective; throws Error on all ranks alike.
  void rate(double t, std::span<double> T, std::span<double> F, std::span<double> power) const;

  // Enthalpies of the owned points, J, and the heat capacity of their cells, J/K. Ghosts of T up to date.
  void energy(std::span<const double> T, std::span<double> E) const;
  void capacity(std::span<const double> T, std::span<double> C) const;
  /// Inverse of energy where points hold their heat; T holds a guess, its ghosts may be stale. Collective.
  void temperature(std::span<const double> E, std::span<double> T) const;
  /// Bends a step dT of the owned unknowns from T to one in the enthalpies: dE = C d(values), and the new temperatures
  /// follow from E. Only where points hold heat. Updates the ghosts of T. Collective.
  void step_in_enthalpy(std::span<double> T, std::span<double> dT) const;

  /// Sets prescribed points to their temperature at time t, books the heat that this takes (the reaction) and solves
  /// algebraic wall rows. Call it at t = 0 and after every stage or step that advanced E by F. Collective.
  void impose(double t, std::span<double> T, std::span<double> E, std::span<double> exchanged) const;
  /// Owned points with prescribed temperature, ascending.
  std::span<const int> prescribed() const;
  /// Writes T at those points only. Not collective: formulas may throw on one rank alone.
  void prescribed_temperatures(double t, std::span<double> T) const;

  /// F as a residual for Newton: algebraic wall points give their row (W), prescribed points the violation of their
  /// temperature times the capacity of their cell (J), which is 0 in nodal systems, where they are set.
  void residual(double t, std::span<double> T, std::span<double> R) const;
  /// An AIJ matrix with the right pattern and layout; the caller owns it.
  Mat create_jacobian() const;
  /// J = capacity_factor * dE/dT - rate_factor * dF/dT, for prescribed points minus the derivative of their residual;
  /// in nodal systems identity rows (and empty columns) there. Exact. Collective.
  void jacobian(double t, std::span<double> T, double capacity_factor, double rate_factor, Mat J) const;
  bool jacobian_is_constant() const;  ///< nothing depends on T (and k not on time)
  bool jacobian_is_symmetric() const;

  /// Gershgorin bound of the largest eigenvalue of C^-1 (-dF/dT) at (t, T), 1/s: explicit Euler is stable for
  /// dt <= 2 / bound. The same bits on any number of ranks. Collective.
  double rate_bound(double t, std::span<double> T) const;
  /// The same for explicit steps where points hold heat. With parameters as unknowns these go by C^-1 (-dF/dT) Phi^-1,
  /// of which no row sums are known: the bound above, times what its largest eigenvalue is to that in a uniform body.
  double explicit_rate_bound(double t, std::span<double> T) const;
  /// The largest eigenvalue itself (from below, within a percent). Collective.
  double largest_rate(double t, std::span<double> T) const;

  /// Heat flux vector at the owned points, W/m^2. Collective.
  void heat_flux(double t, std::span<double> T, std::span<Vec3> q) const;

  /// Of every source at (t, T): the power asked for and what goes into the points, W. Collective.
  struct SourcePower {
    double asked, deposited;
  };
  std::vector<SourcePower> source_powers(double t, std::span<const double> T) const;
  /// Heat that the sources were asked for since t = 0, J; nothing where one of them is not asked for a power.
  std::optional<double> energy_asked(double t) const;
  /// Longest time step that resolves moving sources between two times, s.
  double longest_step(double begin, double end) const;

  /// Times at which data jump or have kinks, sorted.
  std::vector<double> events() const;
  /// Lets the sites change that change by themselves at time t, one of the events (cracks that open).
  void change_sites(double t);
  bool has_algebraic_walls() const;
  /// Highest less lowest temperature of body, walls and ambients at time t, K. Collective.
  double temperature_span(double t, std::span<const double> T) const;
  /// Throws Error(numbers) that names a point whose temperature is not finite. Collective.
  void require_finite(double t, std::span<const double> T) const;
  /// Anything that fixes the level of a steady temperature (prescribed temperature, convection, radiation)? Collective.
  bool level_is_fixed() const;

 private:
  struct Parts;
  /// The Jacobian; without `exact` the derivative of k is left out.
  void assemble(double t, std::span<double> T, double capacity_factor, double rate_factor, bool exact, Mat J) const;

  std::unique_ptr<Parts> parts_;
};

}  // namespace calor
