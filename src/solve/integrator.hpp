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

class Integrator {
 public:
  virtual ~Integrator() = default;
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
/// Newton (SNES) with the exact Jacobian from state.T; fills T and E. Throws Error(numbers) without convergence.
SteadyReport solve_steady(const Case& c, HeatSystem& system, State& state);

void declare_time(Schema& schema);

}  // namespace calor
