// Explicit Euler: E_new = E + dt F(t, T).
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/archive.hpp"
#include "solve/stepper.hpp"

namespace calor {
namespace {

class Euler final : public Stepper {
 public:
  using Stepper::Stepper;
  std::string name() const override { return "euler"; }

 private:
  void enter(HeatSystem& system, State& state, const SmoothInterval& interval, bool /*fresh*/) override {
    find_bound(system, state, interval);
  }

  double step(HeatSystem& system, State& state, const SmoothInterval& interval) override {
    F_.resize(state.E.size());
    power_.resize(state.cumulative_heat.size());
    return options_.step ? fixed_step(system, state, interval) : stable_step(system, state, interval);
  }

  double fixed_step(HeatSystem& system, State& state, const SmoothInterval& interval) {
    if (steps_in_interval() > 0 && !system.jacobian_is_constant()) find_bound(system, state, interval);
    const auto [dt, t_new] = equal_step(interval);
    require_stable(system, state, interval, dt);
    go(system, state, interval, dt, t_new);
    return dt;
  }

  double stable_step(HeatSystem& system, State& state, const SmoothInterval& interval) {
    const bool bound_is_constant = system.jacobian_is_constant();
    const double longest = std::min(system.longest_step(interval.begin(), interval.end()),
                                    interval.longest_step(state.t, marks_without_control));
    State before;
    while (true) {
      const double stable = bound_ > 0 ? options_.safety * 2 / bound_ : std::numeric_limits<double>::infinity();
      // Equal steps over what is left: the last one is not a splinter.
      const EqualSteps steps(state.t, interval.end(), std::min(stable, longest));
      require_motion(state.t, steps.time(1));
      if (!bound_is_constant) before = state;
      go(system, state, interval, steps.step(), steps.time(1));
      if (bound_is_constant) return steps.step();
      // Where the step led it may have been too long: then radiation, for one, takes temperatures past the ambient's.
      const double used = bound_;
      find_bound(system, state, interval);
      if (steps.step() * bound_ <= 2 * (1 + 1e-9)) return steps.step();
      constexpr double most_reduction = 4;  // what a wild step leads to says little
      bound_ = std::min(bound_, most_reduction * std::max(used, 2 / steps.step()));
      state = before;
      ++counts.rejected;
    }
  }

  void find_bound(HeatSystem& system, State& state, const SmoothInterval& interval) {
    bound_ = system.explicit_rate_bound(interval.data_time(state.t), state.T, HeatSystem::monotone);
  }

  /// Refuses a fixed step above the limit of the state.
  void require_stable(HeatSystem& system, State& state, const SmoothInterval& interval, double dt) {
    if (dt * bound_ <= 2 * (1 + 1e-9) || bound_ <= stable_bound_) return;
    const double limit = system.euler_limit(interval.data_time(state.t), state.T);
    if (dt > limit * (1 + 1e-9))
      throw Error(Fault::numbers,
                  fmt::format("the step of {:.6g} s is unstable at t = {:.6g} s: the limit of explicit Euler has come "
                              "down to {:.6g} s",
                              dt, state.t, limit),
                  fmt::format("take at most {:.3g} s, leave the step out, or choose another integrator", 2 / bound_));
    constexpr double until_next_look = 1.01;  // the eigenvalue costs many steps
    stable_bound_ = until_next_look * bound_;
  }

  void go(HeatSystem& system, State& state, const SmoothInterval& interval, double dt, double t_new) {
    system.rate(interval.data_time(state.t), state.T, F_, power_);
    ++counts.rate_evaluations;
    for (std::size_t i = 0; i < F_.size(); ++i) state.E[i] += dt * F_[i];
    for (std::size_t a = 0; a < power_.size(); ++a) state.cumulative_heat[a] += dt * power_[a];
    state.t = t_new;
    system.temperature(state.E, state.T);
    system.impose(interval.data_time(t_new), state.T, state.E, state.cumulative_heat);
  }

  void exchange_own(Archive& archive, HeatSystem& /*system*/) override {
    archive.value("rate bound", bound_);
    archive.value("stable rate bound", stable_bound_);
  }

  double bound_ = 0;         ///< explicit_rate_bound of the state, 1/s
  double stable_bound_ = 0;  ///< fixed steps are known to be stable up to this one
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
