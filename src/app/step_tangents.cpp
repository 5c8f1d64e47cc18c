// Tangents of the steps of a diagonally implicit Runge-Kutta method. Every stage E(u) - gamma_dt F(u) = known gives
//   J du/dp = -dR/dp + d known/dp,   J = dE/du - gamma_dt dF/du,
// with the stage's own u and step. dR/dp, and what rates and constraints change by along (du/dp, dp), are central
// differences of two models, one of a larger and one of a smaller p, about the state of the run.
#include <optional>

#include "app/derivative_log.hpp"
#include "base/parallel.hpp"
#include "solve/linearisation.hpp"

namespace calor {
namespace {

using Values = std::vector<double>;

/// What the state changes by with one parameter.
class Tangent {
 public:
  Tangent(const Model& model, const Parameter& p)
      : p_(p), h_(p.step()), more_(model, p, p.value() + h_), less_(model, p, p.value() - h_) {
    State more = more_.start(), less = less_.start();
    more_.observe(more), less_.observe(less);
    differ(more, less);
  }

  /// Of a state on which constraints are imposed at time t.
  void impose(double t, std::span<const double> u, std::span<const double> E) { impose(t, u, E, false); }

  /// `at_stage(n)`: linear equations of the n-th stage.
  void step(const ImplicitStep& step, const std::function<Linearisation&(std::size_t)>& at_stage) {
    std::vector<Values> dF{rate(step.t, step.u)};
    for (std::size_t n = 0; n < step.stages.size(); ++n) {
      const ImplicitStep::Stage& stage = step.stages[n];
      Values known = dE_;
      for (std::size_t m = 0; m < stage.before.size(); ++m) known = sum(known, stage.before[m], dF[m]);
      solve(stage, known, at_stage(n));
      dF.push_back(rate(stage.t, stage.u));
    }
    for (std::size_t n = 0; n < dF.size(); ++n) dE_ = sum(dE_, step.weights[n], dF[n]);
    impose(step.t_new, step.stages.back().u, step.E_new, true);
  }

  Values of_readings(double t, std::span<const double> u) const {
    return p_.difference(more_.readings().at(t, sum(u, h_, du_)), less_.readings().at(t, sum(u, -h_, du_)));
  }

 private:
  void differ(const State& more, const State& less) {
    du_ = p_.difference(more.T, less.T), dE_ = p_.difference(more.E, less.E);
  }

  /// dF/dp along the tangent.
  Values rate(double t, std::span<const double> u) const {
    const auto of = [&](const ChangedModel& model, double h) {
      Values changed = sum(u, h, du_), F(dE_.size()), power(model.system().accounts().size());
      model.system().rate(t, changed, F, power);
      return F;
    };
    return p_.difference(of(more_, h_), of(less_, -h_));
  }

  /// du_ of a stage whose known side changes by `known`.
  void solve(const ImplicitStep::Stage& stage, std::span<const double> known, Linearisation& equations) {
    Values u_more(stage.u.begin(), stage.u.end()), u_less = u_more;
    const auto residual = [&](const ChangedModel& model, double h, Values& u) {
      model.system().set_known(stage.t, u);
      Values R(known.size());
      model.system().residual(stage.t, u, stage.gamma_dt, sum(Values(known.size()), h, known), R);
      return R;
    };
    const Values R_more = residual(more_, h_, u_more), R_less = residual(less_, -h_, u_less);
    const Values dR = p_.difference(R_less, R_more);  // with its sign turned
    Values step(dR.size());
    equations.solve(dR, step);
    du_ = sum(p_.difference(u_more, u_less), 1, step);
    more_.cloud().halo.update(du_);
  }

  /// Both models take (u, E) with the tangent, and the constraints with it; `after_stage`: u follows from E.
  void impose(double t, std::span<const double> u, std::span<const double> E, bool after_stage) {
    const auto of = [&](ChangedModel& model, double h) {
      State state{.t = t, .E = sum(E, h, dE_), .T = sum(u, h, du_), .cumulative_heat = {}};
      state.cumulative_heat.resize(model.system().accounts().size());
      if (after_stage) model.system().temperature_after_stage(state.E, state.T);
      model.system().impose(t, state.T, state.E, state.cumulative_heat);
      model.cloud().halo.update(state.T);
      model.observe(state);
      return state;
    };
    const State more = of(more_, h_), less = of(less_, -h_);
    differ(more, less);
  }

  const Parameter& p_;
  double h_;
  ChangedModel more_, less_;
  Values du_;  ///< of the local points
  Values dE_;  ///< of the owned points
};

class StepTangents final : public DerivativeLog, public StepFollower {
 public:
  StepTangents(const RunSetup& run, const Model& model, std::vector<Parameter> parameters)
      : DerivativeLog(run, model, std::move(parameters)) {
    for (const Parameter& p : parameters_) tangents_.push_back(std::make_unique<Tangent>(model, p));
  }

  void impose(double t, const State& state) override {
    for (const auto& tangent : tangents_) tangent->impose(t, state.T, state.E);
  }

  void step(const ImplicitStep& step) override {
    run_.phases.measure("derivatives", [&] {
      std::vector<Linearisation*> of_stage;
      std::vector<std::unique_ptr<Linearisation>> made;
      for (const ImplicitStep::Stage& stage : step.stages) {
        if (!run_.system.jacobian_is_constant()) {
          made.push_back(std::make_unique<Linearisation>(run_.system, stage.t, stage.u, stage.gamma_dt));
          of_stage.push_back(made.back().get());
          continue;
        }
        if (!kept_ || kept_gamma_dt_ != stage.gamma_dt)
          kept_ = std::make_unique<Linearisation>(run_.system, stage.t, stage.u, stage.gamma_dt);
        kept_gamma_dt_ = stage.gamma_dt;
        of_stage.push_back(kept_.get());
      }
      for (const auto& tangent : tangents_)
        tangent->step(step, [&](std::size_t n) -> Linearisation& { return *of_stage[n]; });
    });
  }

  void record(const Moment& m) override {
    m.temperatures();  // for the ghosts
    const double t = m.state().t;
    for (std::size_t n = 0; n < tangents_.size(); ++n) add(t, parameters_[n], tangents_[n]->of_readings(t, m.u()));
  }

 private:
  std::vector<std::unique_ptr<Tangent>> tangents_;
  std::unique_ptr<Linearisation> kept_;  ///< of equations that depend on the step alone
  double kept_gamma_dt_ = 0;             ///< s
};

}  // namespace

std::unique_ptr<Observer> make_step_tangents(const RunSetup& run, const Model& model, std::vector<Parameter> parameters,
                                             Integrator& integrator) {
  auto tangents = std::make_unique<StepTangents>(run, model, std::move(parameters));
  if (!integrator.tell(*tangents)) return nullptr;
  return tangents;
}

}  // namespace calor
