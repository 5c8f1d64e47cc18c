// Of a steady state R(u, p) = 0 and readings d = w(p) . u,
//   dd/dp = d's own derivative - w . J^-1 dR/dp,   J = dR/du,
// by the adjoints J^-T w of the readings or by the tangents J^-1 dR/dp, whichever are fewer. dR/dp is a central
// difference of residuals at the state that has been found: it costs evaluations and no solution. Temperatures that are
// prescribed follow p at once: R is taken with them in their place, and they are part of the reading's own derivative.
#include "app/derivative_log.hpp"
#include "base/parallel.hpp"
#include "solve/linearisation.hpp"

namespace calor {
namespace {

/// At the state that was found, with another value of a parameter.
struct Changed {
  std::vector<double> R;         ///< residual of the owned points
  std::vector<double> readings;  ///< temperatures of the probes
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
    const bool by_adjoint = probes() < parameters_.size();
    Linearisation linearisation(run_.system, u, by_adjoint);
    const auto adjoint = by_adjoint ? adjoints(linearisation) : std::vector<std::vector<double>>();
    for (const Parameter& p : parameters_) {
      const double h = p.step();
      const Changed more = changed(p, p.value() + h, u), less = changed(p, p.value() - h, u);
      std::vector<double> dR_dp(more.R.size());
      for (std::size_t i = 0; i < dR_dp.size(); ++i) dR_dp[i] = (more.R[i] - less.R[i]) / (2 * h);
      std::vector<double> d = by_adjoint ? products(adjoint, dR_dp) : tangent(linearisation, dR_dp);
      for (std::size_t m = 0; m < d.size(); ++m) d[m] = (more.readings[m] - less.readings[m]) / (2 * h) - d[m];
      add(0, p, d);
    }
  }

  /// J^-T w of the probes, owned points.
  std::vector<std::vector<double>> adjoints(Linearisation& linearisation) const {
    const Cloud& cloud = run_.system.cloud();
    std::vector<std::vector<double>> all;
    for (std::size_t m = 0; m < probes(); ++m) {
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

  /// w . J^-1 dR/dp.
  std::vector<double> tangent(Linearisation& linearisation, std::span<const double> dR_dp) const {
    const Cloud& cloud = run_.system.cloud();
    std::vector<double> s(cloud.local());
    linearisation.solve(dR_dp, std::span(s).first(cloud.owned));
    cloud.halo.update(s);
    return run_.probes.temperatures(s);
  }

  /// A conductivity is put into the discretisation that there is; all else makes a model of its own.
  Changed changed(const Parameter& p, double value, std::span<const double> u_found) const {
    std::vector<double> u(u_found.begin(), u_found.end());
    Changed out{.R = std::vector<double>(run_.system.cloud().owned), .readings = {}};
    if (p.is_conductivity) {
      std::vector<MaterialField> materials = materials_of(p.with(value), model_);
      run_.system.exchange_materials(materials);
      run_.system.residual(0, u, 1, {}, out.R);
      run_.system.exchange_materials(materials);
      out.readings.resize(probes());  // they stay
      return out;
    }
    const ChangedModel model(model_, p, value);
    model.system().set_known(0, u);
    model.system().residual(0, u, 1, {}, out.R);
    out.readings = model.probes().temperatures(u);
    return out;
  }
};

}  // namespace

std::unique_ptr<Observer> make_steady_derivatives(const RunSetup& run, const Model& model,
                                                  std::vector<Parameter> parameters) {
  return std::make_unique<SteadyDerivatives>(run, model, std::move(parameters));
}

}  // namespace calor
