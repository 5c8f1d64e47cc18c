// Runge-Kutta-Legendre super-time-stepping of second order: Meyer, Balsara & Aslam, J. Comput. Phys. 257 (2014) 594.
// One step of s stages is stable for dt <= (s^2 + s - 2)/4 * 2/lambda and costs s evaluations of F.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/archive.hpp"
#include "base/simd.hpp"
#include "solve/stepper.hpp"

namespace calor {
namespace {

constexpr int most_stages = 199;

/// b_j of the Legendre recursion, Meyer et al. eq (15).
double b(int j) { return j < 2 ? 1. / 3 : (j * j + j - 2.) / (2. * j * (j + 1)); }

/// Smallest odd number of stages that is stable for dt; 2/lambda is Euler's limit.
int stages_for(double dt, double euler_limit) {
  const double s = 0.5 * (std::sqrt(9 + 16 * dt / euler_limit) - 1);
  const int whole = std::max(3, static_cast<int>(std::ceil(s * (1 - 1e-12))));
  return whole + 1 - whole % 2;
}

double longest_step(int stages, double euler_limit) { return euler_limit * (stages * stages + stages - 2.) / 4; }

class Rkl2 final : public Stepper {
 public:
  using Stepper::Stepper;
  std::string name() const override { return "rkl2"; }

 private:
  /// What the recursion runs on: the enthalpies and, by the same coefficients, the cumulative heat. As every stage
  /// is the same linear combination for both, sum E - sum heat stays what it was to round-off.
  struct Stage {
    std::vector<double> E, cumulative_heat;
  };

  void enter(HeatSystem& system, State& state, const SmoothInterval& interval, bool fresh) override {
    make_room(system);
    evaluate(system, interval.data_time(state.t), state.T, F0_, power0_);
    euler_limit_ = euler_limit(system, interval.data_time(state.t), state.T);
    longest_ = system.longest_step(interval.begin(), interval.end());
    if (fresh || !control_.has_proposal()) control_.restart(euler_limit_, interval.end() - state.t);
  }

  double step(HeatSystem& system, State& state, const SmoothInterval& interval) override {
    return options_.step ? fixed_step(system, state, interval) : controlled_step(system, state, interval);
  }

  double fixed_step(HeatSystem& system, State& state, const SmoothInterval& interval) {
    const auto [dt, t_new] = equal_step(interval);
    int stages = require_stages(dt, state.t);
    advance_stages(system, state, interval, dt, stages);
    // The step may have taken the state to where it needs more stages.
    while (!is_stable(system, interval.data_time(t_new), dt, stages)) {
      stages = std::min(require_stages(dt, state.t), 2 * stages + 1);
      advance_stages(system, state, interval, dt, stages);
      ++counts.rejected;
    }
    evaluate(system, interval.data_time(t_new), T_, F_, power_);
    take(state, t_new);
    return dt;
  }

  double controlled_step(HeatSystem& system, State& state, const SmoothInterval& interval) {
    while (true) {
      const double limit = euler_limit_;
      const double dt = control_.next(
          state.t, interval.end(),
          std::min({longest_, longest_step(most_stages, limit), interval.longest_step(state.t, marks_with_control)}));
      const double t_new = dt == interval.end() - state.t ? interval.end() : state.t + dt;
      require_motion(state.t, t_new);
      const int stages = stages_for(dt, limit);
      const double always_good = shortest_scale(interval, limit);
      try {
        advance_stages(system, state, interval, dt, stages);
        evaluate(system, interval.data_time(t_new), T_, F_, power_);
      } catch (const Error&) {  // on all ranks: temperatures of a step that is much too long
        if (dt <= always_good) throw;
        control_.reduce(dt);
        ++counts.rejected;
        continue;
      }
      if (!control_.judge(dt, error(system, state, dt, stages) / tolerance(system, state), always_good)) {
        ++counts.rejected;
        continue;
      }
      if (dt > always_good &&
          (!is_stable(system, interval.data_time(t_new), dt, stages) || leaves_range(system, state.t, t_new, T_))) {
        euler_limit_ = limit;
        control_.reduce(dt);
        ++counts.rejected;
        continue;
      }
      take(state, t_new);
      return dt;
    }
  }

  void make_room(const HeatSystem& system) {
    const std::size_t points = system.cloud().owned, accounts = system.accounts().size();
    for (Stage* stage : {&last_, &before_last_}) stage->E.resize(points), stage->cumulative_heat.resize(accounts);
    F0_.resize(points), F_.resize(points);
    power0_.resize(accounts), power_.resize(accounts);
  }

  void exchange_own(Archive& archive, HeatSystem& system) override {
    make_room(system);
    control_.exchange(archive);
    archive.value("limit of Euler's step", euler_limit_);
    archive.value("longest step", longest_);
    archive.points("rate", F0_);
    archive.shares("power", power0_);
  }

  /// Euler's limit, s: where it may have changed.
  double euler_limit(HeatSystem& system, double t, std::vector<double>& T) {
    const double bound = system.explicit_rate_bound(t, T, HeatSystem::monotone);
    return bound > 0 ? 2 / bound : std::numeric_limits<double>::infinity();
  }

  /// Is a step with so many stages stable for the state that it led to, T_? Leaves Euler's limit there.
  bool is_stable(HeatSystem& system, double t, double dt, int stages) {
    if (system.jacobian_is_constant()) return true;
    euler_limit_ = euler_limit(system, t, T_);
    return dt <= longest_step(stages, euler_limit_) * (1 + 1e-9);
  }

  int require_stages(double dt, double t) const {
    constexpr int most = 9999;
    if (dt <= longest_step(most, euler_limit_)) return stages_for(dt, euler_limit_);
    throw Error(Fault::numbers,
                fmt::format("a step of {:.6g} s at t = {:.6g} s would take more than {} stages: the limit of explicit "
                            "Euler is {:.6g} s",
                            dt, t, most, euler_limit_),
                "take a smaller [time] step, or leave it out");
  }

  void evaluate(HeatSystem& system, double t, std::vector<double>& T, std::vector<double>& F,
                std::vector<double>& power) {
    system.rate(t, T, F, power);
    ++counts.rate_evaluations;
  }

  /// From the state and its rate F0_ to last_ and T_, Meyer et al. eq (14)-(17).
  void advance_stages(HeatSystem& system, const State& state, const SmoothInterval& interval, double dt, int s) {
    const double w1 = 4 / (s * s + s - 2.);
    T_ = state.T;
    before_last_.E = state.E, before_last_.cumulative_heat = state.cumulative_heat;
    const double first = b(1) * w1 * dt;
    for (std::size_t i = 0; i < F0_.size(); ++i) last_.E[i] = state.E[i] + first * F0_[i];
    for (std::size_t a = 0; a < power0_.size(); ++a)
      last_.cumulative_heat[a] = state.cumulative_heat[a] + first * power0_[a];
    double c_last = b(1) * w1, c_before_last = 0;  // stage times by the same recursion
    settle(system, interval.data_time(state.t + c_last * dt), last_);
    for (int j = 2; j <= s; ++j) {
      const double mu = (2. * j - 1) / j * b(j) / b(j - 1), nu = -(j - 1.) / j * b(j) / b(j - 2);
      const double mu_rate = mu * w1, gamma_rate = -(1 - b(j - 1)) * mu_rate;
      evaluate(system, interval.data_time(state.t + c_last * dt), T_, F_, power_);
      // The new stage takes the place of the last but one.
      const auto combine = [&](std::vector<double>& stages, const std::vector<double>& last_stage,
                               const std::vector<double>& at_start, const std::vector<double>& rates,
                               const std::vector<double>& start_rates) {
        double* __restrict stage = stages.data();
        const double* __restrict last = last_stage.data(), * __restrict start = at_start.data();
        const double* __restrict rate = rates.data(), * __restrict start_rate = start_rates.data();
        for (std::size_t i = 0; i < stages.size(); ++i)
          stage[i] = start[i] + mu * (last[i] - start[i]) + nu * (stage[i] - start[i]) +
                     dt * (mu_rate * rate[i] + gamma_rate * start_rate[i]);
      };
      combine(before_last_.E, last_.E, state.E, F_, F0_);
      combine(before_last_.cumulative_heat, last_.cumulative_heat, state.cumulative_heat, power_, power0_);
      std::swap(before_last_, last_);
      c_before_last = std::exchange(c_last, j == s ? 1 : mu * c_last + nu * c_before_last + mu_rate + gamma_rate);
      settle(system, interval.data_time(state.t + c_last * dt), last_);
    }
    counts.most_stages = std::max(counts.most_stages, s);
  }

  void settle(HeatSystem& system, double t, Stage& stage) {
    system.temperature(stage.E, T_);
    system.impose(t, T_, stage.E, stage.cumulative_heat);
  }

  /// Largest error of the step in K. The step's error is (1/6 - c3) dt^3 T''' with c3 from the stability polynomial
  /// 1 + z + z^2/2 + c3 z^3 + ...; T''' comes from E0 - E1 + dt/2 (F0 + F1) = (1/4 - c3) dt^3 E''' (as in Sommeijer,
  /// Shampine & Verwer 1997).
  double error(HeatSystem& system, const State& state, double dt, int s) {
    const double c3 = (s * s + s - 6.) / (s * s + s - 2.) / 9;
    const double factor = (1. / 6 - c3) / (1. / 4 - c3);
    std::vector<double>& error = before_last_.E;  // is free now
    if (!std::exchange(knows_capacity_, !system.material().capacity_depends_on_T())) {
      C_.resize(F_.size());
      system.capacity(T_, C_);
    }
    run_vectorised([&, E0 = state.E.data(), E1 = last_.E.data(), F0 = F0_.data(), F1 = F_.data(), C = C_.data(),
                    result = error.data()]<int>() CALOR_ALWAYS_INLINE {
      for (std::size_t i = 0; i < error.size(); ++i)
        result[i] = factor * (E0[i] - E1[i] + 0.5 * dt * (F0[i] + F1[i])) / C[i];
    });
    return system.largest_free(error);
  }

  void take(State& state, double t_new) {
    std::swap(state.E, last_.E);
    std::swap(state.cumulative_heat, last_.cumulative_heat);
    std::swap(state.T, T_);
    std::swap(F0_, F_);
    std::swap(power0_, power_);
    state.t = t_new;
  }

  StepControl control_;
  double euler_limit_ = 0;  ///< at the state from which the next step starts, s
  double longest_ = 0;      ///< step that resolves moving sources in the interval, s
  Stage last_, before_last_;
  std::vector<double> T_, F0_, F_, power0_, power_;
  bool knows_capacity_ = false;  ///< C_ serves all steps
  std::vector<double> C_;
};

}  // namespace

IntegratorKind rkl2_integrator() {
  return {
      .name = "rkl2",
      .sentence = "explicit super-time-stepping of second order, controls its error",
      .make = [](const StepOptions& options) -> std::unique_ptr<Integrator> { return std::make_unique<Rkl2>(options); },
      .is_adaptive = true,
      .is_explicit = true};
}

}  // namespace calor
