#pragma once
// The semi-discrete heat equation dE/dt = F(t, u): a list of heat terms and constraints, a capacity and degrees of
// freedom. Residual, Jacobian, capacity, enthalpy; it knows no time stepping, and asks no term what it is.
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/petsc.hpp"
#include "base/reduce.hpp"
#include "boundary/conditions.hpp"
#include "cloud/cloud.hpp"
#include "conduction/discretisation.hpp"
#include "material/material_field.hpp"
#include "solve/wall_corners.hpp"
#include "source/source.hpp"

namespace calor {

class Archive;
class WallFluxes;

/// What a run carries from step to step; everything else can be computed from it.
struct State {
  double t = 0;
  std::vector<double> E;                ///< enthalpy of the owned points above the reference temperature, J
  std::vector<double> T;                ///< degrees of freedom of the local points (ghosts may be stale), K
  std::vector<double> cumulative_heat;  ///< heat that came in by each account since the start, J; this rank's share
};

/// Functions that evaluate terms reuse their buffers: they are not const, and one system serves one run at a time.
class HeatSystem {
 public:
  /// `materials`: at all local points, then at the locations of the discretisation. The cloud must outlive this.
  /// Collective.
  HeatSystem(const Cloud& cloud, Discretisation discretisation, std::vector<MaterialField> materials,
             Conditions conditions, std::vector<std::unique_ptr<Source>> sources);
  HeatSystem(const HeatSystem&) = delete;
  HeatSystem& operator=(const HeatSystem&) = delete;

  const Cloud& cloud() const { return cloud_; }
  const MaterialField& material() const { return materials_.front(); }  ///< at all local points
  const Discretisation& discretisation() const { return discretisation_; }
  const Dofs& dofs() const { return *discretisation_.dofs; }
  /// Does every point hold the heat of its cell at its own temperature? Explicit integrators need that.
  bool capacity_is_lumped() const { return discretisation_.capacity->is_lumped(); }
  /// Do the subdomains of the points overlap, so that their heats do not add up to that of the body?
  bool subdomains_overlap() const { return discretisation_.subdomains != nullptr; }
  /// Names of what heat comes in by: boundaries, then sources.
  const std::vector<std::string>& accounts() const { return accounts_; }
  const Conditions& conditions() const { return conditions_; }
  int boundary_accounts() const;  ///< how many of the accounts are boundaries; the rest are sources

  /// State at time t from temperatures of the owned points; walls are not yet imposed. Collective.
  State start(double t, std::span<const double> T_owned);
  /// Stores or reads a state. Collective.
  void exchange(Archive& archive, State& state) const;
  /// Temperatures of the owned points from the degrees of freedom, whose ghosts it updates, K. Collective.
  std::vector<double> temperatures(std::span<double> u) const;

  /// F_i = net heat into every owned point by conduction, wall fluxes and sources, W (prescribed points too: without
  /// their reaction; 0 at points that hold no heat); power[a] = this rank's share by account a, W, without reactions.
  /// Updates the ghosts of u. Collective; throws Error on all ranks alike.
  void rate(double t, std::span<double> u, std::span<double> F, std::span<double> power);

  /// Temperatures of Cloud::facets, K: of their points, or off the walls those of the wall, which follow from its heat.
  /// Updates the ghosts of u. Collective.
  std::vector<double> wall_temperatures(double t, std::span<double> u);

  /// Heat flow into the body by every account, W, with what prescribed temperatures take to hold. Updates the ghosts of
  /// u. Collective.
  std::vector<double> heat_flows(double t, std::span<double> u);

  /// What WallCorners::shift adds to the power by account, W, this rank's share. Updates the ghosts of u. Collective.
  std::vector<double> shifted_at_corners(double t, std::span<double> u);
  bool has_corners() const { return corners_.exist(); }

  // Enthalpies of the owned points, J, and the heat capacity of their cells, J/K. Ghosts of u up to date. Collective.
  void energy(std::span<const double> u, std::span<double> E);
  void capacity(std::span<const double> u, std::span<double> C);
  /// Inverse of energy where the capacity is lumped; u holds a guess, its ghosts may be stale. Points whose temperature
  /// does not follow from their heat keep it. Collective.
  void temperature(std::span<const double> E, std::span<double> u);
  /// Makes u agree with E to round-off after a stage that met its balances to a tolerance; nothing to do where the
  /// degrees of freedom are no temperatures. Collective.
  void temperature_after_stage(std::span<const double> E, std::span<double> u);
  /// Changes a step du of the owned degrees of freedom from u into one of the enthalpies: dE = C dT, and the new
  /// temperatures follow from E (an enthalpy-corrected Newton step). Only where the capacity is lumped. Updates the
  /// ghosts of u. Collective.
  void correct_by_enthalpy(std::span<double> u, std::span<double> du);

  /// Makes u and E meet the constraints at time t and books the heat that this takes. Call it at t = 0 and after every
  /// stage or step that advanced E by F. Collective.
  void impose(double t, std::span<double> u, std::span<double> E, std::span<double> cumulative_heat);
  /// Sets the degrees of freedom that are known at time t, as a first guess of what impose does. Collective.
  void set_known(double t, std::span<double> u);
  /// Owned points with prescribed temperature, ascending.
  std::span<const int> prescribed() const { return prescribed_; }
  /// Largest |value| over owned points that hold heat and have no prescribed temperature, on all ranks; infinity if one
  /// is not finite. Collective.
  double largest_free(std::span<const double> values) const;

  /// Heat rates of owned points, W, and of the accounts, as `rate` gives them.
  struct Rate {
    std::vector<double> F, power;
  };
  /// The residual of a stage, E(u) - rate_factor F(t, u) - known, J, or with empty `known` that of a steady state,
  /// -rate_factor F; constrained points have minus the residual of their constraint. Collective.
  void residual(double t, std::span<double> u, double rate_factor, std::span<const double> known, std::span<double> R) {
    Rate rate;
    residual(t, u, rate_factor, known, R, rate);
  }
  /// The same, and the rate at u besides.
  void residual(double t, std::span<double> u, double rate_factor, std::span<const double> known, std::span<double> R,
                Rate& rate);
  /// Puts other materials, at the same places, into the same discretisation, and gives back those that were there. They
  /// may differ in the values of their conductivities alone.
  void exchange_materials(std::vector<MaterialField>& materials);
  /// |dR_i/dT_i| of a stage of length 0: what makes a tolerance in K one of the residual. Collective.
  void residual_scale(double t, std::span<double> u, std::span<double> scale);
  /// An AIJ matrix with the right pattern and layout. Collective.
  petsc::Matrix create_jacobian() const;
  /// J = dR/du = capacity_factor dE/du - rate_factor dF/du, and minus the derivatives of the constraints. Exact.
  /// Degrees of freedom that are known by themselves have identity rows and empty columns. Collective.
  void jacobian(double t, std::span<double> u, double capacity_factor, double rate_factor, Mat J);
  /// The same entry by entry, by local points, without those of known columns: those of the conduction in free rows to
  /// `conduction`, all others to `rest`. Collective.
  void jacobian(double t, std::span<double> u, double capacity_factor, double rate_factor, JacobianEntries& conduction,
                JacobianEntries& rest) {
    give_jacobian(t, u, capacity_factor, rate_factor, false, conduction, rest);
  }
  /// Room to evaluate other states in, beside this system's own.
  Evaluation evaluation() const;
  /// Does the temperature of an owned point follow from its heat balance?
  bool is_free(int i) const { return role_[i] == Role::free; }
  /// Is the degree of freedom of a local point known by itself?
  bool is_known(int i) const { return is_known_[i] != 0; }
  bool jacobian_is_constant() const;  ///< nothing depends on T (and k not on time)
  bool jacobian_is_symmetric() const;
  /// Would it be symmetric if the conductivity were frozen?
  bool frozen_jacobian_is_symmetric() const;

  /// Gershgorin bound of the largest eigenvalue of C^-1 (-dF/du) at (t, u), 1/s: explicit Euler is stable for
  /// dt <= 2 / bound. The same bits on any number of ranks. Collective.
  double rate_bound(double t, std::span<double> u);
  /// The same for explicit steps where the capacity is lumped. With parameters as degrees of freedom steps go by
  /// C^-1 (-dF/du) Phi^-1, of which no row sums are known: its largest eigenvalue in a uniform body, times the largest
  /// diffusivity that a row sees, its row sum over that in the uniform body. Where what surfaces, sources and walls off
  /// the points exchange counts twice (`monotone`), no temperature passes those of its neighbours and surroundings in
  /// steps up to 2 / bound, if all weights are positive. Collective.
  static constexpr double monotone = 2;
  double explicit_rate_bound(double t, std::span<double> u, double exchange_factor = 1);
  /// The limit of stability of explicit Euler, s: by the largest eigenvalue where that is known, by the bound
  /// elsewhere. Collective.
  double euler_limit(double t, std::span<double> u);
  /// The largest eigenvalue itself (from below, within a percent) where the frozen Jacobian is symmetric. Collective.
  double largest_rate(double t, std::span<double> u);

  /// Heat flux vector at the owned points, W/m^2. Collective.
  void heat_flux(double t, std::span<double> u, std::span<Vec3> q);

  /// Of every source at (t, T of the owned points): the power asked for and what goes into the points, W. Collective.
  struct SourcePower {
    double asked, deposited;
  };
  std::vector<SourcePower> source_powers(double t, std::span<const double> T);
  /// Heat that the sources were asked for since t = 0, J; nothing where one of them is not asked for a power.
  std::optional<double> energy_asked(double t) const;
  /// Longest time step that resolves moving sources between two times, s.
  double longest_step(double begin, double end) const;

  /// Times at which data jump or have kinks, sorted.
  const std::vector<double>& events() const { return changes_.events; }
  const Changes& changes() const { return changes_; }
  /// Changes what changes by itself at time t, one of the events (cracks that open).
  void apply(double t);
  /// Are there points that hold no heat and follow from algebraic rows? Collective.
  bool has_massless_points() const { return has_massless_points_; }
  /// Lowest and highest temperature of walls and ambients at time t, K. Collective.
  ValueRange outer_temperatures(double t);
  /// Of the body, K; updates the ghosts of u. Collective.
  ValueRange body_temperatures(std::span<double> u);
  /// The same of body, walls and ambients; ghosts of u up to date. Collective.
  ValueRange temperature_extremes(double t, std::span<const double> u);
  double temperature_span(double t, std::span<const double> u) { return temperature_extremes(t, u).span(); }
  /// Least and most heat that a point gets from sources and surfaces which draw to no ambient temperature, W; 0 without
  /// any. Updates the ghosts of u. Collective.
  ValueRange given_heat(double t, std::span<double> u);
  /// Does no temperature leave the range of start, walls and ambients? So it is without sources and prescribed fluxes
  /// where the weights are positive.
  bool keeps_range() const { return keeps_range_; }
  /// Throws Error(numbers) that names a point whose temperature is not finite. Collective.
  void require_finite(double t, std::span<const double> u) const;
  /// Anything that fixes the level of a steady temperature (prescribed temperature, convection, radiation)? Collective.
  bool level_is_fixed() const;
  /// A point of a part of the body that neither conducts to the rest nor has anything of its own that fixes its level,
  /// near temperatures T of the owned points; nothing where there is none. Collective.
  std::optional<Vec3> loose_part(std::span<const double> T);

 private:
  /// How the temperature of an owned point follows: from its heat balance, or from one of two kinds of constraint.
  enum class Role : char { free, prescribed, massless };
  class Entries;

  /// The Jacobian; `frozen` leaves the derivative of k out.
  void assemble(double t, std::span<double> u, double capacity_factor, double rate_factor, bool frozen, Mat J);
  void give_jacobian(double t, std::span<double> u, double capacity_factor, double rate_factor, bool frozen,
                     JacobianEntries& conduction, JacobianEntries& rest);
  /// Temperatures of the owned points from the enthalpies of their cells; T holds a guess. Collective.
  void find_temperatures(std::span<const double> E, std::span<double> T);
  /// A body with k = 1 W/(m K) and a heat capacity of 1 J/(m^3 K) whose degrees of freedom are parameters.
  struct UniformBody {
    double largest = 0;          ///< eigenvalue of V^-1 K Phi^-1 over the free points, 1/s
    std::vector<double> of_row;  ///< row sums of V^-1 |K| of the owned points, 1/s
  };
  /// Collective.
  UniformBody rates_of_uniform_body();
  void find_changes();
  /// Largest row sum over heat capacity, with a factor to those of surfaces and sources, in parts of `unit`, if it is
  /// given. Collective.
  double largest_rate_of_rows(double t, std::span<double> u, double exchange_factor, std::span<const double> unit);

  const Cloud& cloud_;
  std::vector<MaterialField> materials_;
  Conditions conditions_;
  std::vector<std::unique_ptr<Source>> sources_;
  Discretisation discretisation_;
  std::vector<std::unique_ptr<HeatTerm>> exchange_;  ///< surface fluxes, sources
  std::vector<HeatTerm*> given_;                     ///< those of exchange_ that draw to no ambient temperature
  WallFluxes* wall_fluxes_ = nullptr;                ///< one of these, on clouds without points on the walls
  std::vector<HeatTerm*> terms_;                     ///< conduction, walls, exchange
  std::optional<Evaluation> at_;
  std::vector<std::string> accounts_;
  WallCorners corners_;
  std::vector<Role> role_;      ///< of owned points
  std::vector<char> is_known_;  ///< of local points: its degree of freedom
  std::vector<int> prescribed_;
  std::vector<int> not_free_;       ///< owned points whose temperature does not follow from their heat
  std::vector<double> per_volume_;  ///< 1 / V of the owned points, m^-3
  std::vector<double> H_, kept_;    ///< room
  Changes changes_;
  bool has_massless_points_ = false, keeps_range_ = false;
  std::optional<UniformBody> uniform_body_;  ///< once explicit_rate_bound has asked for it
};

}  // namespace calor
