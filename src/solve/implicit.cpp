#include "solve/implicit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/archive.hpp"
#include "base/parallel.hpp"

namespace calor {

StageSolver::StageSolver(HeatSystem& system)
    : system_(system),
      newton_(system,
              {.residual =
                   [this](std::span<double> T, std::span<double> R) {
                     T_of_rate_.clear();
                     system_.residual(t_, T, gamma_dt_, known_, R, rate_);
                     T_of_rate_.assign(T.begin(), T.end());
                   },
               .jacobian =
                   [this](std::span<double> T, JacobianOperator& J) {
                     matrix_t_ = t_, matrix_gamma_dt_ = gamma_dt_;
                     J.evaluate(t_, T, 1, gamma_dt_);
                   },
               .tolerance = [this](auto, std::span<double> tolerance,
                                   auto) { std::ranges::copy(tolerance_, tolerance.begin()); },
               .correct_step =
                   steps_in_enthalpy(system)
                       ? [this](std::span<double> T, std::span<double> dT) { system_.correct_by_enthalpy(T, dT); }
                       : std::function<void(std::span<double>, std::span<double>)>(),
               .residual_may_grow = true},
              false),
      tolerance_(system.cloud().owned) {
  newton_.always_renew(steps_in_enthalpy(system));
}

bool StageSolver::steps_in_enthalpy(const HeatSystem& system) {
  return system.capacity_is_lumped() && system.material().capacity_depends_on_T();
}

bool StageSolver::solve(double t, double gamma_dt, std::span<const double> known, double tolerance, bool careful,
                        std::span<double> T, StepCounts& counts) {
  const int most_iterations = steps_in_enthalpy(system_) ? 100 : 25;  // a front of melting goes from point to point
  constexpr double round_off = 8 * std::numeric_limits<double>::epsilon(), least = 1e-13;
  const bool is_constant = system_.jacobian_is_constant();
  if (std::abs(gamma_dt - gamma_dt_) > 1e-12 * gamma_dt) newton_.renew_jacobian();
  t_ = t, gamma_dt_ = gamma_dt, known_ = known;
  system_.set_known(t, T);
  if (rate_bound_ == 0 || !is_constant) rate_bound_ = system_.rate_bound(t, T);

  const std::size_t owned = known.size();
  double hottest = 0;
  for (std::size_t i = 0; i < owned; ++i) hottest = std::max(hottest, std::abs(T[i]));
  hottest = max(system_.cloud().comm, hottest);
  const double reachable = std::max({tolerance, round_off * hottest * (1 + gamma_dt * rate_bound_), least});
  system_.residual_scale(t, T, tolerance_);
  const double C = owned > 0 ? std::ranges::max(tolerance_) : 0;
  const double size = max(system_.cloud().comm, C) * (1 + gamma_dt * rate_bound_);
  for (double& value : tolerance_) value *= reachable;

  const auto solve = [&](int most) {
    Newton::Result result = newton_.solve(T, most, size);
    counts.newton_iterations += result.iterations;
    counts.linear_iterations += result.linear_iterations;
    return result;
  };
  const std::vector<double> guess = careful ? std::vector<double>(T.begin(), T.end()) : std::vector<double>();
  Newton::Result result = solve(most_iterations);
  if (!result.converged && careful) {
    std::ranges::copy(guess, T.begin());
    newton_.go_carefully(true), newton_.renew_jacobian();
    newton_.always_renew(true);
    result = solve(8 * most_iterations);
    newton_.go_carefully(false), newton_.always_renew(steps_in_enthalpy(system_));
  }
  reason_ = result.reason;
  return result.converged;
}

void StageSolver::rate(std::span<double> T, HeatSystem::Rate& rate) {
  const std::size_t owned = system_.cloud().owned;
  const bool is_elsewhere =
      T_of_rate_.empty() ? !T.empty() : !std::ranges::equal(std::span(T_of_rate_).first(owned), T.first(owned));
  rate = rate_;
  if (any(system_.cloud().comm, is_elsewhere)) system_.rate(t_, T, rate.F, rate.power);
}

void StageSolver::exchange(Archive& archive) {
  archive.value("rate bound", rate_bound_);
  archive.value("matrix at time", matrix_t_);
  archive.value("matrix with step", matrix_gamma_dt_);
  double gamma_dt = gamma_dt_;
  t_ = matrix_t_, gamma_dt_ = matrix_gamma_dt_;
  newton_.exchange(archive);
  archive.value("step of stage", gamma_dt);
  gamma_dt_ = gamma_dt;
}

void ImplicitStepper::make_solver(HeatSystem& system) {
  if (!solver_) solver_ = std::make_unique<StageSolver>(system);
  known_.resize(system.cloud().owned);
}

void ImplicitStepper::enter(HeatSystem& system, State& /*state*/, const SmoothInterval& /*interval*/, bool fresh) {
  make_solver(system);
  if (fresh) solver_->renew();
}

void ImplicitStepper::exchange_own(Archive& archive, HeatSystem& system) {
  make_solver(system);
  solver_->exchange(archive);
}

void ImplicitStepper::evaluate(HeatSystem& system, double t, std::span<double> T, Rate& rate) {
  rate.F.resize(system.cloud().owned);
  rate.power.resize(system.accounts().size());
  system.rate(t, T, rate.F, rate.power);
  ++counts.rate_evaluations;
}

bool ImplicitStepper::solve_stage(double t, double gamma_dt, std::span<const double> E0,
                                  const std::vector<Weighted>& rates, double tolerance, Rate& rate) {
  std::ranges::copy(E0, known_.begin());
  for (const Weighted& r : rates)
    for (std::size_t i = 0; i < known_.size(); ++i) known_[i] += r.weight * r.rate.F[i];
  if (!solver_->solve(t, gamma_dt, known_, tolerance, options_.step.has_value(), T_, counts)) return false;
  solver_->rate(T_, rate);
  ++counts.rate_evaluations;
  return true;
}

void ImplicitStepper::take(HeatSystem& system, State& state, const SmoothInterval& interval, double t_new,
                           const std::vector<Weighted>& rates) {
  for (const Weighted& r : rates) {
    for (std::size_t i = 0; i < state.E.size(); ++i) state.E[i] += r.weight * r.rate.F[i];
    for (std::size_t a = 0; a < state.cumulative_heat.size(); ++a)
      state.cumulative_heat[a] += r.weight * r.rate.power[a];
  }
  state.t = t_new;
  state.T = T_;
  system.temperature_after_stage(state.E, state.T);
  system.impose(interval.data_time(t_new), state.T, state.E, state.cumulative_heat);
}

double ImplicitStepper::tight_tolerance(HeatSystem& system, const State& state) const {
  return 1e-10 * system.temperature_span(state.t, state.T);
}

void ImplicitStepper::fail(double t, double dt) const {
  if (solver_->reason()) std::rethrow_exception(solver_->reason());
  throw Error(
      Fault::numbers, fmt::format("Newton's method did not converge in the step of {:.6g} s at t = {:.6g} s", dt, t),
      "take a smaller [time] step, or integrator = \"rkl2\" or \"tr-bdf2\" without a step; or look for a run-away");
}

}  // namespace calor
