#pragma once
// Time integration: one-step methods on the enthalpy. An integrator knows the heat system and nothing of the method.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "solve/heat_system.hpp"

namespace calor {

class Archive;

struct StepCounts {
  long steps = 0, rejected = 0, rate_evaluations = 0, newton_iterations = 0, linear_iterations = 0;
  int most_stages = 0;
  double smallest_step = 0, largest_step = 0;  ///< s
};

/// Called after every accepted step, between which a run may be stored; false ends the run.
using AfterStep = std::function<bool(const State&)>;

/// A step of a diagonally implicit Runge-Kutta method, E0 the enthalpies at its begin and F_0 the rates there:
///   E(u_n) - gamma_dt F_n = E0 + sum_{m < n} before[m] F_m of every stage, then E = E0 + sum weights[n] F_n.
struct ImplicitStep {
  struct Stage {
    double t, gamma_dt;          ///< s
    std::vector<double> before;  ///< s
    std::span<double> u;         ///< what was found, local points
  };
  double t, t_new;              ///< s; at which data are asked for
  std::span<double> u;          ///< at t
  std::vector<Stage> stages;    ///< the last one ends at t_new
  std::vector<double> weights;  ///< s
  std::vector<double> E_new;    ///< before constraints are imposed, J
};

/// Goes along with the steps of a run. Collective.
class StepFollower {
 public:
  virtual ~StepFollower() = default;
  /// Constraints are about to be imposed on a state at time t, as data have jumped.
  virtual void impose(double t, const State& state) = 0;
  /// A step is about to be taken.
  virtual void step(const ImplicitStep& step) = 0;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Tells a follower, which outlives the run, of all steps; false where these are none that one can follow.
  virtual bool tell(StepFollower& /*follower*/) { return false; }
  /// Marches from state.t to exactly t_end, or until after_step returns false. The walls of `state` are imposed on
  /// entry and on return. Collective.
  virtual void advance(HeatSystem& system, State& state, double t_end, const AfterStep& after_step) = 0;
  /// What it carries from step to step besides the state: marching goes on as if it had not been interrupted, on the
  /// same number of ranks with the same bits. For reading, of a new one. Collective.
  virtual void exchange(Archive& archive, HeatSystem& system) = 0;
  virtual std::string name() const = 0;  ///< as in [time] integrator
  StepCounts counts;
  std::string why;                 ///< this integrator was taken: half a sentence
  std::vector<std::string> notes;  ///< what a user should know about its steps
};

/// The integrator that [time] names, or the one that fits best. Checks a fixed step against the stability limit:
/// above the Gershgorin bound a note, above 2/lambda_max an Error. Collective.
std::unique_ptr<Integrator> make_integrator(const Case& c, HeatSystem& system, State& start);

struct SteadyReport {
  int newton_iterations = 0;
  long linear_iterations = 0;
  /// Largest imbalance of a point over the largest heat flow through one, at most `tolerance`; where rounding of the
  /// temperatures makes more than the tolerance allows, `tolerance` times the imbalance over that.
  double residual = 0;
  double imbalance = 0, flow = 0;  ///< W
  bool at_round_off = false;       ///< the imbalance fell no further, short of the tolerance
};
/// Refuses numbers of [steady] that make no sense.
void check_steady(const Case& c);
/// Newton (SNES) with the exact Jacobian from state.T; fills T and E. Throws Error(numbers) without convergence.
SteadyReport solve_steady(const Case& c, HeatSystem& system, State& state);

void declare_time(Schema& schema);

}  // namespace calor
