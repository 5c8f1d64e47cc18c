// Of a steady state R(u, p) = 0 and readings d(u, p),
//   du/dp = -J^-1 dR/dp,   J = dR/du:   dd/dp is a central difference of readings along (du/dp, dp): the tangent;
//   or, of readings w . u, w . du/dp = -J^-T w . dR/dp: the adjoint, where the readings are fewer than the numbers.
// dR/dp is a central difference of residuals at the state that has been found: it costs evaluations and no solution.
// Temperatures that are prescribed follow p at once: R is taken with them in their place.
#include "app/derivative_log.hpp"
#include "base/parallel.hpp"
#include "solve/linearisation.hpp"

namespace calor {
namespace {

/// The system with another value of a parameter: a conductivity is put into the discretisation that there is, all else
/// makes a model of its own.
class Changed {
 public:
  Changed(HeatSystem& system, const Readings& readings, const Model& model, const Parameter& p, double value)
      : system_(system), readings_(readings) {
    if (p.is_conductivity)
      materials_ = materials_of(p.with(value), model);
    else
      model_ = std::make_unique<ChangedModel>(model, p, value);
  }

  /// u with the temperatures that are prescribed.
  std::vector<double> with_known(std::span<const double> u) {
    std::vector<double> changed(u.begin(), u.end());
    in_place([&](HeatSystem& system, const Readings&) { system.set_known(0, changed); });
    return changed;
  }
  std::vector<double> residual(std::span<double> u) {
    std::vector<double> R(system_.cloud().owned);
    in_place([&](HeatSystem& system, const Readings&) { system.residual(0, u, 1, {}, R); });
    return R;
  }
  std::vector<double> readings(std::span<const double> u) {
    std::vector<double> values;
    in_place([&](HeatSystem&, const Readings& readings) { values = readings.at(0, u); });
    return values;
  }

 private:
  template <class Act>
  void in_place(const Act& act) {
    if (model_) return act(model_->system(), model_->readings());
    system_.exchange_materials(materials_);
    act(system_, readings_);
    system_.exchange_materials(materials_);
  }

  HeatSystem& system_;
  const Readings& readings_;
  std::vector<MaterialField> materials_;
  std::unique_ptr<ChangedModel> model_;
};

class SteadyDerivatives final : public DerivativeLog {
 public:
  using DerivativeLog::DerivativeLog;

  void at_stop(const Moment& m) override {
    if (run_.folder.empty() || !m.is_last) return;
    m.temperatures();  // for the ghosts
    run_.phases.measure("derivatives", [&] { differentiate(m.u()); });
  }

 private:
  void differentiate(std::span<double> u) {
    const bool by_adjoint = readings_.are_of_probes_alone() && readings_.count() < parameters_.size();
    Linearisation linearisation(run_.system, u, by_adjoint);
    const auto adjoint = by_adjoint ? adjoints(linearisation) : std::vector<std::vector<double>>();
    for (const Parameter& p : parameters_) {
      const double h = p.step();
      Changed more(run_.system, readings_, model_, p, p.value() + h);
      Changed less(run_.system, readings_, model_, p, p.value() - h);
      std::vector<double> u_more = more.with_known(u), u_less = less.with_known(u);
      const std::vector<double> dR_dp = p.difference(more.residual(u_more), less.residual(u_less));
      if (!by_adjoint) {
        const std::vector<double> step = solution(linearisation, dR_dp);
        u_more = sum(u_more, -h, step), u_less = sum(u_less, h, step);
      }
      std::vector<double> d = p.difference(more.readings(u_more), less.readings(u_less));
      if (by_adjoint) d = sum(d, -1, products(adjoint, dR_dp));
      add(0, p, d);
    }
  }

  /// J^-T w of the probes, owned points.
  std::vector<std::vector<double>> adjoints(Linearisation& linearisation) const {
    const Cloud& cloud = run_.system.cloud();
    std::vector<std::vector<double>> all;
    for (std::size_t m = 0; m < readings_.count(); ++m) {
      std::vector<double> w(cloud.local());
      run_.probes.add_weights(static_cast<int>(m), w);
      std::vector<double>& lambda = all.emplace_back(linearisation.sum_at_owners(w));
      linearisation.solve(lambda, lambda);
    }
    return all;
  }

  /// lambda . dR/dp. A parameter may be felt by few points: only these are summed.
  std::vector<double> products(const std::vector<std::vector<double>>& adjoint, std::span<const double> dR_dp) const {
    std::vector<double> terms;
    for (std::size_t i = 0; i < dR_dp.size(); ++i) {
      if (dR_dp[i] == 0) continue;
      for (const std::vector<double>& lambda : adjoint) terms.push_back(lambda[i] * dR_dp[i]);
    }
    return sums(run_.comm(), terms, static_cast<int>(adjoint.size()));
  }

  /// J^-1 dR/dp at the local points.
  std::vector<double> solution(Linearisation& linearisation, std::span<const double> dR_dp) const {
    const Cloud& cloud = run_.system.cloud();
    std::vector<double> s(cloud.local());
    linearisation.solve(dR_dp, std::span(s).first(cloud.owned));
    cloud.halo.update(s);
    return s;
  }
};

}  // namespace

std::unique_ptr<Observer> make_steady_derivatives(const RunSetup& run, const Model& model,
                                                  std::vector<Parameter> parameters) {
  return std::make_unique<SteadyDerivatives>(run, model, std::move(parameters));
}

}  // namespace calor
