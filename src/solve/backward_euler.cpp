// Backward Euler: E_new = E + dt F(t_new, T_new).
#include "solve/implicit.hpp"
#include "solve/integrators.hpp"

namespace calor {
namespace {

class BackwardEuler final : public ImplicitStepper {
 public:
  using ImplicitStepper::ImplicitStepper;
  std::string name() const override { return "backward-euler"; }

 private:
  bool march(HeatSystem& system, State& state, const SmoothInterval& interval, bool /*fresh*/,
             const AfterStep& after_step) override {
    prepare(system, state);
    const EqualSteps steps(state.t, interval.end(), *options_.step);
    const double dt = steps.step();
    for (long n = 1; n <= steps.count(); ++n) {
      const double t_new = steps.time(n);
      T_ = state.T;
      if (!solve_stage(system, interval.data_time(t_new), dt, state.E, {}, tight_tolerance(system, state), rate_))
        fail(state.t, dt);
      take(system, state, interval, t_new, {{dt, rate_}});
      if (!accept(system, state, dt, after_step)) return false;
    }
    return true;
  }

  Rate rate_;
};

}  // namespace

std::unique_ptr<Integrator> make_backward_euler(const StepOptions& options) {
  return std::make_unique<BackwardEuler>(options);
}

}  // namespace calor
