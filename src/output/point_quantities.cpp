// Quantities of the points: temperatures and properties of the material.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/parallel.hpp"
#include "output/quantities.hpp"

namespace calor {
namespace {

/// A property of the material at the owned points.
using Property = std::function<void(const State&, std::span<const double> T, std::span<double> out)>;

Measure measure_of(const Results& results, Property property) {
  return {.values = [&results, property = std::move(property)](const State& state, std::span<const double> T) {
    std::vector<double> out(T.size());
    collective_try(results.cloud.comm, [&] { property(state, T, out); });
    return out;
  }};
}

Measure measure_temperature(const Table& /*expect*/, const Results& results) {
  return {.values = [](const State&, std::span<const double> T) { return std::vector(T.begin(), T.end()); },
          .at_probes = [&results](const State& state) { return results.probes.temperatures(state.T); }};
}

Measure measure_conductivity(const Table& /*expect*/, const Results& results) {
  return measure_of(results, [&results](const State& state, std::span<const double> T, std::span<double> k) {
    results.material.conductivity(state.t, T, k, {});
  });
}

Measure measure_heat_capacity(const Table& expect, const Results& results) {
  if (!results.material.has_capacity())
    expect.refuse("quantity", "density or specific heat of the body are not known", "give its materials both");
  return measure_of(results, [&results](const State&, std::span<const double> T, std::span<double> rho_c) {
    results.material.enthalpy(T, {}, rho_c);
  });
}

Measure measure_volume_fraction(const Table& expect, const Results& results) {
  const std::string name = expect.text("material");
  const std::vector<std::string> known = results.material.ingredients();
  if (!std::ranges::count(known, name))
    expect.refuse("material", fmt::format("'{}' is not mixed into the body", name),
                  fmt::format("it is made of {}", fmt::join(known, ", ")));
  return measure_of(results, [&results, name](const State&, std::span<const double>, std::span<double> v) {
    results.material.volume_fraction(name, v);
  });
}

}  // namespace

Quantity temperature_quantity() {
  return {.name = "temperature", .plural = "temperatures", .unit = "K", .column = "T", .make = measure_temperature};
}

Quantity conductivity_quantity() {
  return {.name = "conductivity",
          .plural = "conductivities",
          .unit = "W/(m K)",
          .column = "k",
          .make = measure_conductivity};
}

Quantity heat_capacity_quantity() {
  return {.name = "volumetric_heat_capacity",
          .plural = "volumetric heat capacities",
          .unit = "J/(m^3 K)",
          .column = "rho c",
          .make = measure_heat_capacity};
}

Quantity volume_fraction_quantity() {
  return {
      .name = "volume_fraction",
      .plural = "volume fractions",
      .unit = "",
      .column = "v",
      .keys = {{"material", Kind::text, "", required, "Whose fraction; that of what fills the pores is the porosity."}},
      .make = measure_volume_fraction};
}

}  // namespace calor
