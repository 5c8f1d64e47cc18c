// Of a steady state R(u, p) = 0 and readings d = w(p) . u,
//   dd/dp = d's own derivative - w . J^-1 dR/dp,   J = dR/du,
// by the adjoints J^-T w of the readings or by the tangents J^-1 dR/dp, whichever are fewer. dR/dp is a central
// difference of residuals at the state that has been found: it costs evaluations and no solution. Temperatures that are
// prescribed follow p at once: R is taken with them in their place, and they are part of the reading's own derivative.
#include "app/derivatives.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "case/numbers.hpp"
#include "case/tree.hpp"
#include "output/files.hpp"
#include "output/probes.hpp"
#include "solve/linearisation.hpp"

namespace calor {
namespace {

/// Of a number, for a difference: its square is what is neglected, where residuals bend at all, and rounding leaves
/// 1e-16 over it.
constexpr double relative_step = 1e-4;

/// One of the numbers.
struct Parameter {
  std::shared_ptr<const CaseNumbers> among;
  std::size_t entry;
  SourceLocation asked_at;
  bool is_conductivity;  ///< changes nothing else

  double value() const { return among->values()[entry]; }
  const std::string& name() const { return among->names()[entry]; }
  Case with(double value) const {
    std::vector<double> all = among->values();
    all[entry] = value;
    return among->with(all);
  }
};

/// material.NAME.conductivity and what is below it.
bool is_conductivity(const std::string& path) {
  const std::vector<std::string> keys = split_path(path.substr(0, path.find('[')));
  return keys.size() > 2 && keys[0] == "material" && keys[2] == "conductivity";
}

/// What [output] derivatives names. Throws Error.
std::vector<Parameter> read_parameters(const Case& c) {
  const Table output = c.section("output");
  std::vector<Parameter> parameters;
  if (!output.has("derivatives")) return parameters;
  if (!is_steady(c)) output.refuse("derivatives", "derivatives of a transient run", "leave them out, or take [steady]");
  if (c.section("probe").keys().empty())
    output.refuse("derivatives", "derivatives of the probes, and no [probe]", "add [probe] with their places");
  const SourceLocation at = output.location("derivatives");
  for (const std::string& path : output.texts("derivatives")) {
    const auto numbers = std::make_shared<const CaseNumbers>(c, path, at);
    for (std::size_t n = 0; n < numbers->values().size(); ++n) {
      parameters.push_back({numbers, n, at, is_conductivity(path)});
      if (parameters.back().value() == 0)
        output.refuse("derivatives", fmt::format("'{}' is 0", parameters.back().name()),
                      "give it another value: a difference is a part of it");
    }
  }
  return parameters;
}

/// At the state that was found, with another value of a parameter.
struct Changed {
  std::vector<double> R;         ///< residual of the owned points
  std::vector<double> readings;  ///< temperatures of the probes
};

/// Derivatives of the probes' temperatures by one parameter are a row.
class DerivativeLog final : public Observer {
 public:
  DerivativeLog(const RunSetup& run, const Model& model, std::vector<Parameter> parameters)
      : run_(run), model_(model), parameters_(std::move(parameters)) {}

  void at_stop(const Moment& m) override {
    if (run_.folder.empty() || !m.is_last) return;
    m.temperatures();  // for the ghosts
    run_.phases.measure("derivatives", [&] { write(derivatives(m.u())); });
  }

 private:
  using Rows = std::vector<std::vector<double>>;

  Rows derivatives(std::span<double> u) {
    const std::size_t probes = run_.probes.names().size();
    const bool by_adjoint = probes < parameters_.size();
    Linearisation linearisation(run_.system, u, by_adjoint);
    const Rows adjoint = by_adjoint ? adjoints(linearisation) : Rows();
    Rows rows;
    for (const Parameter& p : parameters_) {
      const double h = relative_step * std::abs(p.value());
      const Changed more = changed(p, p.value() + h, u), less = changed(p, p.value() - h, u);
      std::vector<double> dR_dp(more.R.size());
      for (std::size_t i = 0; i < dR_dp.size(); ++i) dR_dp[i] = (more.R[i] - less.R[i]) / (2 * h);
      std::vector<double> row = by_adjoint ? products(adjoint, dR_dp) : tangent(linearisation, dR_dp);
      for (std::size_t m = 0; m < probes; ++m) row[m] = (more.readings[m] - less.readings[m]) / (2 * h) - row[m];
      rows.push_back(std::move(row));
    }
    return rows;
  }

  /// J^-T w of the probes, owned points.
  Rows adjoints(Linearisation& linearisation) const {
    const Cloud& cloud = run_.system.cloud();
    Rows all;
    for (std::size_t m = 0; m < run_.probes.names().size(); ++m) {
      std::vector<double> w(cloud.local());
      run_.probes.add_weights(static_cast<int>(m), w);
      std::vector<double>& lambda = all.emplace_back(linearisation.sum_at_owners(w));
      linearisation.solve(lambda, lambda);
    }
    return all;
  }

  /// lambda . dR/dp. A parameter may be felt by few points: only these are summed.
  std::vector<double> products(const Rows& adjoint, std::span<const double> dR_dp) const {
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
    const Case c = p.with(value);
    std::vector<double> u(u_found.begin(), u_found.end());
    Changed out{.R = std::vector<double>(run_.system.cloud().owned), .readings = {}};
    if (p.is_conductivity) {
      std::vector<MaterialField> materials = materials_of(c, model_);
      run_.system.exchange_materials(materials);
      run_.system.residual(0, u, 1, {}, out.R);
      run_.system.exchange_materials(materials);
      out.readings.resize(run_.probes.names().size());  // they stay
      return out;
    }
    Phases phases;
    const Model model = build_model(c, run_.comm(), phases);
    if (any(run_.comm(), model.cloud->count != run_.system.cloud().count || model.cloud->local() != std::ssize(u)))
      throw Error(Fault::bad_case, p.asked_at, fmt::format("'{}' changes the points of the cloud", p.name()),
                  "take its derivative by a difference of two runs");
    start(model);  // constraints have seen a state
    model.system->set_known(0, u);
    model.cloud->halo.update(u);
    model.system->residual(0, u, 1, {}, out.R);
    out.readings = Probes(c, *model.cloud, &model.system->dofs(), &model.system->material().parts()).temperatures(u);
    return out;
  }

  void write(const Rows& rows) const {
    std::string header = "number";
    for (const std::string& probe : run_.probes.names()) header += "," + probe + " [K]";
    write_in_turns(run_.comm(), run_.folder + "/derivatives.csv", header, [&](std::FILE* file) {
      if (rank_of(run_.comm()) != 0) return;
      for (std::size_t n = 0; n < rows.size(); ++n) {
        fmt::print(file, "{}", parameters_[n].name());
        for (const double value : rows[n]) fmt::print(file, ",{}", value);
        std::fputc('\n', file);
      }
    });
  }

  const RunSetup& run_;
  const Model& model_;
  std::vector<Parameter> parameters_;
};

}  // namespace

void check_derivatives(const Case& c) { read_parameters(c); }

std::unique_ptr<Observer> make_derivative_log(const RunSetup& run, const Model& model) {
  std::vector<Parameter> parameters = read_parameters(run.description);
  if (parameters.empty()) return nullptr;
  return std::make_unique<DerivativeLog>(run, model, std::move(parameters));
}

}  // namespace calor
