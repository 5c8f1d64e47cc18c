// The implicit theta methods with fixed steps:
//   backward Euler   E_new = E + dt F(t_new, T_new)
//   Crank-Nicolson   E_new = E + dt/2 (F(t, T) + F(t_new, T_new))
#include "base/archive.hpp"
#include "solve/implicit.hpp"
#include "solve/stepper.hpp"

namespace calor {
namespace {

class ThetaMethod : public ImplicitStepper {
 public:
  using ImplicitStepper::ImplicitStepper;

 protected:
  void backward_step(HeatSystem& system, State& state, const SmoothInterval& interval, double dt, double t_new) {
    T_ = state.T;
    if (!solve_stage(interval.data_time(t_new), dt, state.E, {}, tight_tolerance(system, state), rate_))
      fail(state.t, dt);
    take(system, state, interval, t_new, {{dt, rate_}});
  }
  virtual void go(HeatSystem& system, State& state, const SmoothInterval& interval, double dt, double t_new) = 0;

  Rate rate_;

 private:
  double step(HeatSystem& system, State& state, const SmoothInterval& interval) final {
    const auto [dt, t_new] = equal_step(interval);
    go(system, state, interval, dt, t_new);
    return dt;
  }
};

class BackwardEuler final : public ThetaMethod {
 public:
  using ThetaMethod::ThetaMethod;
  std::string name() const override { return "backward-euler"; }

 private:
  void go(HeatSystem& system, State& state, const SmoothInterval& interval, double dt, double t_new) override {
    backward_step(system, state, interval, dt, t_new);
  }
};

/// After a start or a jump the first two steps are four half steps of backward Euler (Rannacher, Numer. Math. 43 (1984)
/// 309): they damp what Crank-Nicolson would let oscillate, with the same matrix and without loss of order.
class CrankNicolson final : public ThetaMethod {
 public:
  using ThetaMethod::ThetaMethod;
  std::string name() const override { return "crank-nicolson"; }

 private:
  void enter(HeatSystem& system, State& state, const SmoothInterval& interval, bool fresh) override {
    ThetaMethod::enter(system, state, interval, fresh);
    if (fresh) damped_steps_left_ = 2;
  }
  void exchange_own(Archive& archive, HeatSystem& system) override {
    ThetaMethod::exchange_own(archive, system);
    archive.value("damped steps left", damped_steps_left_);
  }
  void go(HeatSystem& system, State& state, const SmoothInterval& interval, double dt, double t_new) override {
    if (damped_steps_left_ > 0) {
      --damped_steps_left_;
      backward_step(system, state, interval, dt / 2, state.t + dt / 2);
      backward_step(system, state, interval, dt / 2, t_new);
      return;
    }
    T_ = state.T;
    evaluate(system, interval.data_time(state.t), state.T, start_rate_);
    if (!solve_stage(interval.data_time(t_new), dt / 2, state.E, {{dt / 2, start_rate_}},
                     tight_tolerance(system, state), rate_))
      fail(state.t, dt);
    take(system, state, interval, t_new, {{dt / 2, start_rate_}, {dt / 2, rate_}});
  }

  int damped_steps_left_ = 0;
  Rate start_rate_;
};

}  // namespace

IntegratorKind backward_euler_integrator() {
  return {.name = "backward-euler",
          .sentence = "implicit, of first order, fixed steps",
          .make = [](const StepOptions& options) -> std::unique_ptr<Integrator> {
            return std::make_unique<BackwardEuler>(options);
          }};
}

/// The first two steps after a start or a jump are four half steps of backward Euler (Rannacher 1984).
IntegratorKind crank_nicolson_integrator() {
  return {.name = "crank-nicolson",
          .sentence = "implicit, of second order, fixed steps",
          .make = [](const StepOptions& options) -> std::unique_ptr<Integrator> {
            return std::make_unique<CrankNicolson>(options);
          }};
}

}  // namespace calor
