// Explicit Euler: E_new = E + dt F(t, T).
#include <algorithm>
#include <limits>

#include "solve/stepper.hpp"

namespace calor {
namespace {

class Euler final : public Stepper {
 public:
  using Stepper::Stepper;
  std::string name() const override { return "euler"; }

 private:
  bool march(HeatSystem& system, State& state, const SmoothInterval& interval, bool /*fresh*/,
             const AfterStep& after_step) override {
    F_.resize(state.E.size());
    power_.resize(state.cumulative_heat.size());
    if (options_.step) {
      const EqualSteps steps(state.t, interval.end(), *options_.step);
      for (long n = 1; n <= steps.count(); ++n)
        if (!step(system, state, interval, steps.step(), steps.time(n), after_step)) return false;
      return true;
    }
    const bool bound_is_constant = system.jacobian_is_constant();
    double bound = 0;
    while (state.t < interval.end()) {
      if (bound == 0 || !bound_is_constant) bound = system.explicit_rate_bound(interval.data_time(state.t), state.T);
      const double stable = bound > 0 ? options_.safety * 2 / bound : std::numeric_limits<double>::infinity();
      const double longest = system.longest_step(interval.begin(), interval.end());
      // Equal steps over what is left: the last one is not a splinter.
      const EqualSteps steps(state.t, interval.end(), std::min(stable, longest));
      if (!step(system, state, interval, steps.step(), steps.time(1), after_step)) return false;
    }
    return true;
  }

  bool step(HeatSystem& system, State& state, const SmoothInterval& interval, double dt, double t_new,
            const AfterStep& after_step) {
    system.rate(interval.data_time(state.t), state.T, F_, power_);
    ++counts.rate_evaluations;
    for (std::size_t i = 0; i < F_.size(); ++i) state.E[i] += dt * F_[i];
    for (std::size_t a = 0; a < power_.size(); ++a) state.cumulative_heat[a] += dt * power_[a];
    state.t = t_new;
    system.temperature(state.E, state.T);
    system.impose(interval.data_time(t_new), state.T, state.E, state.cumulative_heat);
    return accept(system, state, dt, after_step);
  }

  std::vector<double> F_, power_;
};

}  // namespace

IntegratorKind euler_integrator() {
  return {.name = "euler",
          .sentence = "explicit Euler with the stable step",
          .make = [](const StepOptions& options) -> std::unique_ptr<Integrator> {
            return std::make_unique<Euler>(options);
          },
          .is_adaptive = true,
          .is_explicit = true};
}

}  // namespace calor
