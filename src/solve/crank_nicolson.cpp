// Crank-Nicolson: E_new = E + dt/2 (F(t, T) + F(t_new, T_new)). After a start or a jump the first two steps are four
// half steps of backward Euler (Rannacher, Numer. Math. 43 (1984) 309): they damp what Crank-Nicolson would let
// oscillate, with the same matrix and without loss of order.
#include "solve/implicit.hpp"
#include "solve/integrators.hpp"

namespace calor {
namespace {

class CrankNicolson final : public ImplicitStepper {
 public:
  using ImplicitStepper::ImplicitStepper;
  std::string name() const override { return "crank-nicolson"; }

 private:
  bool march(HeatSystem& system, State& state, const SmoothInterval& interval, bool fresh,
             const AfterStep& after_step) override {
    prepare(system, state);
    if (fresh) damped_steps_left_ = 2;
    const EqualSteps steps(state.t, interval.end(), *options_.step);
    const double dt = steps.step();
    for (long n = 1; n <= steps.count(); ++n) {
      const double t_new = steps.time(n);
      if (damped_steps_left_ > 0) {
        --damped_steps_left_;
        damped_step(system, state, interval, dt / 2, state.t + dt / 2);
        damped_step(system, state, interval, dt / 2, t_new);
      } else {
        T_ = state.T;
        evaluate(system, interval.data_time(state.t), state.T, rate0_);
        if (!solve_stage(system, interval.data_time(t_new), dt / 2, state.E, {{dt / 2, rate0_}},
                         tight_tolerance(system, state), rate1_))
          fail(state.t, dt);
        take(system, state, interval, t_new, {{dt / 2, rate0_}, {dt / 2, rate1_}});
      }
      if (!accept(system, state, dt, after_step)) return false;
    }
    return true;
  }

  void damped_step(HeatSystem& system, State& state, const SmoothInterval& interval, double dt, double t_new) {
    T_ = state.T;
    if (!solve_stage(system, interval.data_time(t_new), dt, state.E, {}, tight_tolerance(system, state), rate1_))
      fail(state.t, dt);
    take(system, state, interval, t_new, {{dt, rate1_}});
  }

  int damped_steps_left_ = 0;
  Rate rate0_, rate1_;
};

}  // namespace

std::unique_ptr<Integrator> make_crank_nicolson(const StepOptions& options) {
  return std::make_unique<CrankNicolson>(options);
}

}  // namespace calor
