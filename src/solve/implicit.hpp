#pragma once
// The stage of an implicit step: E(T) - gamma dt F(t, T) = known.
#include <exception>
#include <span>
#include <vector>

#include "solve/integrator.hpp"
#include "solve/newton.hpp"
#include "solve/stepper.hpp"

namespace calor {

class StageSolver {
 public:
  explicit StageSolver(HeatSystem& system);

  /// Finds T (local points; a first guess on entry) with prescribed points at their temperature at time t. Every
  /// balance is met to `tolerance` (K, times the capacity) or to round-off. False if Newton fails; where steps cannot
  /// be shortened it is `careful` then, before it gives up. Collective.
  bool solve(double t, double gamma_dt, std::span<const double> known, double tolerance, bool careful,
             std::span<double> T, StepCounts& counts);
  /// The rate at the temperatures that the last solve found. Collective.
  void rate(std::span<double> T, HeatSystem::Rate& rate);
  /// Data have jumped: the next solve takes a new matrix.
  void renew() { newton_.forget_jacobian(); }
  /// What is kept from solve to solve, the matrix by where it was evaluated. Collective.
  void exchange(Archive& archive);
  /// Why the last solve failed, if the equations said so.
  std::exception_ptr reason() const { return reason_; }
  /// x = (dE/dT - gamma dt dF/dT)^-1 r with the matrix of the last solve: takes stiff components out of an error.
  /// The error is wanted to so many digits that steps, which follow from it, are the same on any number of ranks.
  void smooth(std::span<const double> r, std::span<double> x) { newton_.solve_linear(r, x, 1e-6); }

 private:
  /// Where the capacity depends on temperature, Newton's method goes in the enthalpies. In temperatures it would jump
  /// to and fro over a narrow range of melting (Swaminathan & Voller, Metall. Trans. B 23 (1992) 651).
  static bool steps_in_enthalpy(const HeatSystem& system);

  HeatSystem& system_;
  Newton newton_;
  double t_ = 0, gamma_dt_ = 0, rate_bound_ = 0;
  double matrix_t_ = 0, matrix_gamma_dt_ = 0;  ///< those of the last Jacobian
  std::span<const double> known_;
  std::vector<double> tolerance_;
  HeatSystem::Rate rate_;          ///< where the residual was evaluated last,
  std::vector<double> T_of_rate_;  ///< at these temperatures; empty where that failed
  std::exception_ptr reason_;
};

/// A stepper whose steps are made of such stages.
class ImplicitStepper : public Stepper {
 public:
  using Stepper::Stepper;

 protected:
  using Rate = HeatSystem::Rate;
  /// Data change where an interval begins at a break: the matrix of before has served its time.
  void enter(HeatSystem& system, State& state, const SmoothInterval& interval, bool fresh) override;
  void exchange_own(Archive& archive, HeatSystem& system) override;
  void evaluate(HeatSystem& system, double t, std::span<double> T, Rate& rate);
  /// known = E0 + sum weight F, weights in s; finds T_ from it, starting where T_ is, and its rate.
  struct Weighted {
    double weight;
    const Rate& rate;
  };
  bool solve_stage(double t, double gamma_dt, std::span<const double> E0, const std::vector<Weighted>& rates,
                   double tolerance, Rate& rate);
  /// E += sum weight F, the same for the accounts, T from E, walls imposed: heat is conserved to round-off whatever the
  /// tolerance of the stages.
  void take(HeatSystem& system, State& state, const SmoothInterval& interval, double t_new,
            const std::vector<Weighted>& rates);
  /// Tolerance of the stages of fixed steps, K.
  double tight_tolerance(HeatSystem& system, const State& state) const;
  [[noreturn]] void fail(double t, double dt) const;

  std::unique_ptr<StageSolver> solver_;
  std::vector<double> T_;

 private:
  void make_solver(HeatSystem& system);

  std::vector<double> known_;
};

}  // namespace calor
