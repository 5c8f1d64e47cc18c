// TR-BDF2: trapezoidal rule to t + gamma dt, then BDF2 to t + dt, gamma = 2 - sqrt(2); both stages have the same
// matrix. As a Runge-Kutta method (Hosea & Shampine, Appl. Numer. Math. 20 (1996) 21), w = sqrt(2)/4, d = gamma/2:
//   E1 = E0 + dt d (F0 + F1),   E2 = E0 + dt (w F0 + w F1 + d F2),
// with the embedded formula of third order (1 - w)/3, (3w + 1)/3, d/3.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/archive.hpp"
#include "solve/implicit.hpp"
#include "solve/stepper.hpp"

namespace calor {
namespace {

constexpr double gamma_ = 2 - std::numbers::sqrt2, d = gamma_ / 2, w = std::numbers::sqrt2 / 4;

class TrBdf2 final : public ImplicitStepper {
 public:
  using ImplicitStepper::ImplicitStepper;
  std::string name() const override { return "tr-bdf2"; }
  bool tell(StepFollower& follower) override {
    follower_ = &follower;
    return true;
  }

 private:
  void enter(HeatSystem& system, State& state, const SmoothInterval& interval, bool fresh) override {
    ImplicitStepper::enter(system, state, interval, fresh);
    if (options_.step) return;
    const double bound = system.rate_bound(interval.data_time(state.t), state.T);
    euler_limit_ = bound > 0 ? 2 / bound : std::numeric_limits<double>::infinity();
    longest_ = system.longest_step(interval.begin(), interval.end());
    if (fresh || !control_.has_proposal()) control_.restart(euler_limit_, interval.end() - state.t);
  }

  double step(HeatSystem& system, State& state, const SmoothInterval& interval) override {
    evaluate(system, interval.data_time(state.t), state.T, rate0_);
    return options_.step ? fixed_step(system, state, interval) : controlled_step(system, state, interval);
  }

  double fixed_step(HeatSystem& system, State& state, const SmoothInterval& interval) {
    const auto [dt, t_new] = equal_step(interval);
    if (!stages(system, state, interval, dt, t_new, tight_tolerance(system, state))) fail(state.t, dt);
    finish(system, state, interval, dt, t_new);
    return dt;
  }

  double controlled_step(HeatSystem& system, State& state, const SmoothInterval& interval) {
    constexpr double part_for_newton = 1e-3;
    while (true) {
      const double dt = control_.next(state.t, interval.end(),
                                      std::min(longest_, interval.longest_step(state.t, marks_with_control)));
      const double t_new = dt == interval.end() - state.t ? interval.end() : state.t + dt;
      require_motion(state.t, t_new);
      const double allowed = tolerance(system, state);
      if (!stages(system, state, interval, dt, t_new, part_for_newton * allowed)) {
        if (dt < 1e-6 * std::min(euler_limit_, interval.end())) fail(state.t, dt);
        control_.reduce(dt);
        ++counts.rejected;
        continue;
      }
      const double always_good = shortest_scale(interval, euler_limit_);
      if (!control_.judge(dt, error(system, dt) / allowed, always_good)) {
        ++counts.rejected;
        continue;
      }
      if (dt > always_good && leaves_range(system, state.t, t_new, T_)) {
        control_.reduce(dt);
        ++counts.rejected;
        continue;
      }
      finish(system, state, interval, dt, t_new);
      return dt;
    }
  }

  void exchange_own(Archive& archive, HeatSystem& system) override {
    ImplicitStepper::exchange_own(archive, system);
    control_.exchange(archive);
    archive.value("limit of Euler's step", euler_limit_);
    archive.value("longest step", longest_);
  }

  /// Both stages from the state and rate0_.
  bool stages(HeatSystem& system, const State& state, const SmoothInterval& interval, double dt, double t_new,
              double tolerance) {
    T_ = state.T;
    counts.most_stages = 2;
    if (!solve_stage(interval.data_time(state.t + gamma_ * dt), d * dt, state.E, {{d * dt, rate0_}}, tolerance, rate1_))
      return false;
    if (follower_) T_middle_ = T_;
    if (system.jacobian_is_constant())  // elsewhere a guess must not leave the range of the material
      for (std::size_t i = 0; i < T_.size(); ++i) T_[i] += (1 - gamma_) / gamma_ * (T_[i] - state.T[i]);
    return solve_stage(interval.data_time(t_new), d * dt, state.E, {{w * dt, rate0_}, {w * dt, rate1_}}, tolerance,
                       rate2_);
  }

  /// Takes the step whose stages have been found.
  void finish(HeatSystem& system, State& state, const SmoothInterval& interval, double dt, double t_new) {
    if (follower_) follower_->step(told(state, interval, dt, t_new));
    take(system, state, interval, t_new, weights(dt));
  }

  ImplicitStep told(State& state, const SmoothInterval& interval, double dt, double t_new) {
    const double t = interval.data_time(state.t), t_middle = interval.data_time(state.t + gamma_ * dt),
                 t_end = interval.data_time(t_new);
    ImplicitStep step{.t = t,
                      .t_new = t_end,
                      .u = state.T,
                      .stages = {{t_middle, d * dt, {d * dt}, T_middle_}, {t_end, d * dt, {w * dt, w * dt}, T_}},
                      .weights = {w * dt, w * dt, d * dt},
                      .E_new = state.E};
    for (const Weighted& r : weights(dt))
      for (std::size_t i = 0; i < step.E_new.size(); ++i) step.E_new[i] += r.weight * r.rate.F[i];
    return step;
  }

  std::vector<Weighted> weights(double dt) const { return {{w * dt, rate0_}, {w * dt, rate1_}, {d * dt, rate2_}}; }

  /// Largest difference to the embedded formula in K, smoothed by the matrix of the stages: without that, stiff
  /// components that the method damps well would keep the steps small.
  double error(HeatSystem& system, double dt) {
    const std::size_t owned = rate0_.F.size();
    error_.resize(system.cloud().local());
    for (std::size_t i = 0; i < owned; ++i)
      error_[i] = dt * ((4 * w - 1) / 3 * rate0_.F[i] - 1. / 3 * rate1_.F[i] + 2 * d / 3 * rate2_.F[i]);
    solver_->smooth(std::span(error_).first(owned), std::span(error_).first(owned));
    return system.largest_free(system.temperatures(error_));
  }

  StepControl control_{1.3};
  double euler_limit_ = 0;  ///< where the interval begins, s
  double longest_ = 0;      ///< step that resolves moving sources in the interval, s
  Rate rate0_, rate1_, rate2_;
  std::vector<double> error_;
  std::vector<double> T_middle_;  ///< of the first stage, for a follower
};

}  // namespace

IntegratorKind tr_bdf2_integrator() {
  return {.name = "tr-bdf2",
          .sentence = "implicit, of second order, controls its error",
          .make = [](const StepOptions& options) -> std::unique_ptr<Integrator> {
            return std::make_unique<TrBdf2>(options);
          },
          .is_adaptive = true,
          .is_explicit = false};
}

}  // namespace calor
