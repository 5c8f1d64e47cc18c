// The steady state: F(T) = 0 by Newton's method with the exact Jacobian.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>

#include "base/parallel.hpp"
#include "solve/integrator.hpp"
#include "solve/newton.hpp"
#include "solve/range_watch.hpp"

namespace calor {
namespace {

/// Largest heat flow through a point, W: by conduction through its cross-section, and what boundaries and sources give
/// to a point on average (in a body of one temperature nothing else flows).
double largest_flow(HeatSystem& system, std::span<double> T) {
  const Cloud& cloud = system.cloud();
  std::vector<Vec3> q(cloud.owned);
  system.heat_flux(0, T, q);
  double largest = 0;
  for (int i = 0; i < cloud.owned; ++i)
    largest = std::max(largest, norm(q[i]) * std::pow(cloud.spacing[i], cloud.dimension - 1) * cloud.cross_section);
  largest = max(cloud.comm, largest);
  std::vector<double> F(cloud.owned), power(system.accounts().size());
  system.rate(0, T, F, power);
  for (const double P : sums(cloud.comm, power, static_cast<int>(power.size())))
    largest = std::max(largest, std::abs(P) / static_cast<double>(cloud.count));
  return largest;
}

/// The balances of the steady state and what they are judged by. Where the conductivity depends on temperature, the
/// unknown of Newton's steps is theta = integral of k dT (Kirchhoff's transform), over the largest k: between pairs of
/// one material the flow is linear in it, so that a Jacobian serves more than one step.
class SteadyState {
 public:
  /// The rows of prescribed temperatures hold J; times the fastest rate at T they are W, as the others.
  SteadyState(HeatSystem& system, double relative, std::span<double> T)
      : system_(system),
        relative_(relative),
        rate_(system.rate_bound(0, T)),
        by_theta_(system.material().conductivity_depends_on_T() && system.dofs().are_temperatures()) {
    if (!(rate_ > 0) || !std::isfinite(rate_)) rate_ = 1;
    if (!by_theta_) return;
    const std::vector<double> k = conductivity(T);
    largest_k_ = max(system.cloud().comm, k.empty() ? 0 : std::ranges::max(k));
  }

  Newton::Equations equations() {
    return {.residual =
                [this](std::span<double> T, std::span<double> R) {
                  system_.residual(0, T, 1, {}, R);
                  for (int i : system_.prescribed()) R[i] *= rate_;
                  for (std::size_t i = 0; i < inertia_.size(); ++i) R[i] += inertia_[i] * (T[i] - T_before_[i]);
                },
            .jacobian =
                [this](std::span<double> T, JacobianOperator& J) {
                  J.evaluate(0, T, 0, 1);
                  row_sums_ = J.row_sums();
                  for (int i : system_.prescribed()) row_sums_[i] *= rate_;
                  if (first_row_sums_.empty()) first_row_sums_ = row_sums_;
                  if (holds_back_) J.add_to_diagonal(inertia_);
                  scale(T, J);
                  hold_insulated(J);
                },
            .tolerance = [this](auto T, auto tolerance, auto round_off) { judge(T, tolerance, round_off); },
            .correct_step = by_theta_
                                ? [this](std::span<double> T, std::span<double> step) { step_to_temperature(T, step); }
                                : std::function<void(std::span<double>, std::span<double>)>()};
  }

  /// From now on the unknown of the steps is the temperature itself. Between materials that are scaled differently a
  /// part of a step of theta may lead astray.
  void step_in_temperature() { by_theta_ = false; }

  /// Are the Jacobians? Differences of theta are linear in the unknown of the steps, and nothing else is.
  bool are_symmetric() const {
    if (!by_theta_) return system_.jacobian_is_symmetric();
    return system_.frozen_jacobian_is_symmetric() && system_.material().mean() == Mean::integral &&
           conducts_everywhere_ && !system_.discretisation().conduction->ends();
  }

  /// Lets every point hold heat as in an implicit step of time from T: by `part` of what it exchanged at the first
  /// guess. 0: none.
  void hold_back(double part, std::span<const double> T) {
    inertia_.clear();
    holds_back_ = part != 0;
    if (!holds_back_) return;
    for (const double exchanged : first_row_sums_) inertia_.push_back(part * exchanged);
    for (int i : system_.prescribed()) inertia_[i] = 0;
    T_before_.assign(T.begin(), T.end());
  }

  double flow() const { return flow_; }
  /// About the largest entry of the Jacobian, W/K. Collective.
  double size(std::span<double> T) {
    std::vector<double> C(system_.cloud().owned);
    system_.capacity(T, C);
    return rate_ * max(system_.cloud().comm, C.empty() ? 0 : std::ranges::max(C));
  }
  /// Largest imbalance of a point, W.
  double imbalance(std::span<double> T) {
    const Cloud& cloud = system_.cloud();
    std::vector<double> R(cloud.owned);
    system_.residual(0, T, 1, {}, R);
    for (int i : system_.prescribed()) R[i] = 0;
    double largest = 0;
    for (double value : R) largest = std::max(largest, std::abs(value));
    return max(cloud.comm, largest);
  }

 private:
  std::vector<double> conductivity(std::span<double> T) const {
    std::vector<double> k(system_.cloud().owned);
    collective_try(system_.cloud().comm, [&] { system_.material().conductivity(0, T.first(k.size()), k, {}); });
    return k;
  }
  /// Of the unknown of the steps, which at prescribed points and in insulators is the temperature itself.
  std::vector<double> dtheta_dT(std::span<double> T) const {
    std::vector<double> k = conductivity(T);
    for (double& value : k) value = value > 0 ? value / largest_k_ : 1;
    for (int i : system_.prescribed()) k[i] = 1;
    return k;
  }

  /// Turns a step of the unknown into one of T: step = integral of dtheta/dT over dT, by the value at mid-step. Where
  /// that has none, the step is the last that was found, for the line search to shorten.
  void step_to_temperature(std::span<double> T, std::span<double> step) const {
    if (!by_theta_) return;
    const std::vector<double> dtheta(step.begin(), step.end());
    std::vector<double> middle(T.begin(), T.begin() + static_cast<std::ptrdiff_t>(step.size()));
    for (int n = 0; n < 3; ++n) {
      const std::vector<double> slope = dtheta_dT(middle);
      for (std::size_t i = 0; i < step.size(); ++i) {
        step[i] = dtheta[i] / slope[i];
        middle[i] = T[i] + step[i] / 2;
      }
    }
  }

  /// Rows of prescribed temperatures to W, columns to derivatives by the unknown of the steps.
  void scale(std::span<double> T, JacobianOperator& J) {
    const petsc::Vector rows = petsc::create_vector(J.matrix()), columns = petsc::create_vector(J.matrix());
    {
      const petsc::View<double> row(rows);
      std::ranges::fill(row.values(), 1.0);
      for (int i : system_.prescribed()) row.values()[i] = rate_;
    }
    if (by_theta_) {
      std::vector<double> k = dtheta_dT(T);
      for (double& value : k) value = 1 / value;
      petsc::copy(k, columns);
    }
    J.scale(rows, by_theta_ ? static_cast<Vec>(columns) : nullptr);
  }

  /// Nothing flows to or from points within an insulator: their temperatures stay as they are.
  void hold_insulated(JacobianOperator& J) const {
    MPI_Comm comm = system_.cloud().comm;
    if (!any(comm, std::ranges::find(row_sums_, 0.0) != row_sums_.end())) return;
    const double largest = max(comm, row_sums_.empty() ? 0 : std::ranges::max(row_sums_));
    std::vector<double> held;
    held.reserve(row_sums_.size());
    for (const double sum : row_sums_) held.push_back(sum == 0 ? largest : 0);
    J.add_to_diagonal(held);
  }

  /// Are the temperatures others than those of flow_? The last steps do not change it, and it takes longer than a
  /// residual. Collective.
  bool has_moved(std::span<double> T, double span) const {
    constexpr double little = 1e-4;  // of a hundred spacings, a hundredth from one to the next
    if (flow_ == 0) return true;
    double most = 0;
    for (std::size_t i = 0; i < T_of_flow_.size(); ++i) most = std::max(most, std::abs(T[i] - T_of_flow_[i]));
    return !(max(system_.cloud().comm, most) <= little * span);
  }

  /// What is a small imbalance follows from what flows at these temperatures: the first guess, with its steps at the
  /// walls, has much larger flows than the solution, or none at all. Rounding of the temperatures alone leaves a row
  /// with eps |T| sum |J_ij|.
  void judge(std::span<double> T, std::span<double> tolerance, std::span<double> round_off) {
    const Cloud& cloud = system_.cloud();
    const double span = system_.temperature_span(0, T);
    if (has_moved(T, span)) {
      flow_ = largest_flow(system_, T);
      T_of_flow_.assign(T.begin(), T.begin() + cloud.owned);
    }
    constexpr double on_the_way = 1e-4;
    std::ranges::fill(tolerance, (holds_back_ ? on_the_way : relative_) * flow_);
    // Prescribed temperatures may be rows of their own, in units of their own.
    std::vector<double> scale(cloud.owned);
    system_.residual_scale(0, T, scale);
    for (int i : system_.prescribed()) tolerance[i] = relative_ * span * scale[i] * rate_;
    double hottest = 0;
    for (int i = 0; i < cloud.owned; ++i) hottest = std::max(hottest, std::abs(T[i]));
    hottest = max(cloud.comm, hottest);
    for (std::size_t i = 0; i < row_sums_.size(); ++i) {
      round_off[i] = std::numeric_limits<double>::epsilon() * hottest * row_sums_[i];
      tolerance[i] = std::max(tolerance[i], round_off[i]);
    }
  }

  HeatSystem& system_;
  double relative_, flow_ = 0;
  double rate_;  ///< 1/s
  bool by_theta_, conducts_everywhere_ = true, holds_back_ = false;
  double largest_k_ = 1;  ///< at the first guess, W/(m K)
  std::vector<double> T_of_flow_;
  std::vector<double> row_sums_, first_row_sums_;  ///< of the last Jacobian and the first; empty before that
  std::vector<double> inertia_, T_before_;         ///< see hold_back; W/K and K
};

/// From a first guess that Newton's method finds nothing from: implicit steps of time that grow while they succeed
/// (pseudo-transient continuation: Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998) 508). Collective.
Newton::Result march(SteadyState& equations, Newton& newton, std::span<double> T, int most_iterations) {
  constexpr double least = 1e-10, most = 1e4;
  constexpr int most_steps = 60;
  Newton::Result result;
  int iterations = 0;
  double part = 1;
  equations.step_in_temperature();
  newton.take_as_symmetric(equations.are_symmetric());
  for (int step = 0; step < most_steps && part < most; ++step) {
    std::vector<double> next(T.begin(), T.end());
    equations.hold_back(part, T);
    newton.renew_jacobian();
    const long linear_iterations = result.linear_iterations;
    result = newton.solve(next, most_iterations, equations.size(T));
    iterations += result.iterations;
    result.iterations = iterations, result.linear_iterations += linear_iterations;
    if (result.converged) std::ranges::copy(next, T.begin());
    if (result.converged && part == 0) break;
    part = result.converged ? (part > least ? part / 5 : 0) : std::max(10 * part, 100 * least);
  }
  result.converged = result.converged && part == 0;
  equations.hold_back(0, T);
  return result;
}

}  // namespace

void check_steady(const Case& c) {
  const Table steady = c.section("steady");
  if (const double relative = steady.number("tolerance"); !(relative > 0))
    steady.refuse("tolerance", fmt::format("a tolerance of {} is not positive", relative), "take 1e-11");
  if (const auto most = steady.integer("iterations"); most < 1)
    steady.refuse("iterations", fmt::format("{} iterations", most), "give at least 1");
}

SteadyReport solve_steady(const Case& c, HeatSystem& system, State& state) {
  const Table steady = c.section("steady");
  const double relative = steady.number("tolerance");
  const int most_iterations = static_cast<int>(steady.integer("iterations"));

  RangeWatch watch;
  watch.begin(system, state);
  SteadyState equations(system, relative, state.T);
  Newton newton(system, equations.equations(), true);
  newton.always_renew(false);
  newton.take_as_symmetric(equations.are_symmetric());
  const auto failure = [&](const Newton::Result& result) -> std::exception_ptr {
    constexpr double part_of_span = 1e-2;  // where points are few
    try {
      if (!result.converged && result.reason) std::rethrow_exception(result.reason);
      const double imbalance = equations.imbalance(state.T);
      if (!result.converged)
        throw Error(Fault::numbers,
                    fmt::format("Newton's method did not reach the steady state in {} iterations: an imbalance of "
                                "{:.3g} W remains, {:.3g} W are allowed",
                                result.iterations, imbalance, imbalance / result.residual),
                    "start nearer to the solution ([initial]), or march towards it ([time] with steady_below); there "
                    "may be none, if sources grow with the temperature");
      watch.require(system, std::nullopt, state.T, part_of_span * watch.range().span());
    } catch (const Error&) {
      return std::current_exception();
    }
    return nullptr;
  };
  const std::vector<double> first_guess = state.T;
  Newton::Result result = newton.solve(state.T, most_iterations, equations.size(state.T));
  if (const std::exception_ptr why = failure(result)) {
    state.T = first_guess;
    result = march(equations, newton, state.T, most_iterations);
    if (failure(result)) std::rethrow_exception(why);
  }
  const SteadyReport report{.newton_iterations = result.iterations,
                            .linear_iterations = result.linear_iterations,
                            .residual = relative * result.residual,
                            .imbalance = equations.imbalance(state.T),
                            .flow = equations.flow(),
                            .at_round_off = result.at_round_off};
  system.energy(state.T, state.E);
  return report;
}

}  // namespace calor
