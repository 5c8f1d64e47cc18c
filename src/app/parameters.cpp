#include "app/parameters.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/parallel.hpp"
#include "case/tree.hpp"
#include "cloud/cracks.hpp"

namespace calor {
namespace {

/// material.NAME.conductivity and what is below it.
bool is_conductivity(const std::string& path) {
  const std::vector<std::string> keys = split_path(path);
  return keys.size() > 2 && keys[0] == "material" && keys[2] == "conductivity";
}

}  // namespace

std::vector<double> sum(std::span<const double> a, double factor, std::span<const double> b) {
  std::vector<double> out(a.begin(), a.end());
  for (std::size_t i = 0; i < b.size(); ++i) out[i] += factor * b[i];
  return out;
}

double Parameter::step() const { return 1e-4 * std::abs(value()); }

std::vector<double> Parameter::difference(std::span<const double> more, std::span<const double> less) const {
  std::vector<double> d = sum(more, -1, less);
  for (double& value : d) value /= 2 * step();
  return d;
}

Case Parameter::with(double value) const {
  std::vector<double> all = among->values();
  all[entry] = value;
  return among->with(all);
}

std::vector<Parameter> read_parameters(const Case& c) {
  const Table output = c.section("output");
  std::vector<Parameter> parameters;
  if (!output.has("derivatives")) return parameters;
  const auto refuse = [&](const std::string& problem, const std::string& cure) {
    output.refuse("derivatives", problem, cure);
  };
  if (c.section("probe").keys().empty() && !output.has("derivatives_of"))
    refuse("derivatives of nothing", "add [probe] with places, or 'derivatives_of' with numbers of the report");
  if (!is_steady(c) && has_cracks(c)) refuse("derivatives of a run with cracks", "leave them out, or take [steady]");
  const SourceLocation at = output.location("derivatives");
  for (const std::string& path : output.texts("derivatives")) {
    const auto numbers = std::make_shared<const CaseNumbers>(c, path, at);
    for (std::size_t n = 0; n < numbers->values().size(); ++n) {
      parameters.push_back({numbers, n, at, is_conductivity(path)});
      if (parameters.back().value() == 0)
        refuse(fmt::format("'{}' is 0", parameters.back().name()),
               "give it another value: a difference is a part of it");
    }
  }
  constexpr std::size_t most = 100;
  if (!is_steady(c) && parameters.size() > most)
    refuse(fmt::format("derivatives of a transient run by {} numbers", parameters.size()),
           fmt::format("ask for at most {}: each takes two models", most));
  return parameters;
}

ChangedModel::ChangedModel(const Model& model, const Parameter& p, double value)
    : case_(p.with(value)),
      model_(build_model(case_, model.cloud->comm, phases_)),
      start_(calor::start(model_)),
      probes_(case_, *model_.cloud, &system().dofs(), &system().material().parts()),
      readings_(case_, probes_, system(),
                WeldResults::make(case_, system(), probes_, start_.state, start_.E_before_walls),
                ThermalStress::make(case_, system(), probes_)) {
  const Cloud &now = *model_.cloud, &was = *model.cloud;
  if (any(was.comm, now.count != was.count || now.owned != was.owned || now.local() != was.local()))
    throw Error(Fault::bad_case, p.asked_at, fmt::format("'{}' changes the points of the cloud", p.name()),
                "take its derivative by a difference of two runs");
}

}  // namespace calor
