// Quantities of [stress].
#include <fmt/format.h>

#include <algorithm>

#include "base/parallel.hpp"
#include "output/quantities.hpp"
#include "output/thermal_stress.hpp"

namespace calor {
namespace {

const ThermalStress& require_stress(const Table& expect, const std::string& plural, const Results& results) {
  if (!results.stress)
    expect.refuse("quantity", fmt::format("{} need [stress]", plural), "add [stress], or take another quantity");
  return *results.stress;
}

/// A component of the stress.
Quantity component(const std::string& name, const std::string& plural, const std::string& component) {
  const auto make = [plural, component](const Table& expect, const Results& results) -> Measure {
    const ThermalStress& stress = require_stress(expect, plural, results);
    const auto found = std::ranges::find(stress.components(), component);
    if (found == stress.components().end())
      expect.refuse("quantity", fmt::format("the body of [stress] has no {}", plural),
                    component == "stress" ? "take radial_stress or hoop_stress" : "take stress");
    const auto k = static_cast<std::size_t>(found - stress.components().begin());
    return {.values =
                [&stress, &results, k](const State& state, std::span<const double> T) {
                  const Deformation d = stress.deformation(state.T);
                  std::vector<double> sigma;
                  collective_try(results.cloud.comm, [&] { sigma = stress.at_points(d, k, T); });
                  return sigma;
                },
            .at_probes =
                [&stress, &results, k](const State& state) {
                  return stress.at_probes(stress.deformation(state.T), k, results.probes.temperatures(state.T));
                }};
  };
  return {.name = name, .plural = plural, .unit = "Pa", .column = "sigma", .make = make};
}

/// A number of the deformation.
Quantity number(const std::string& name, const std::string& plural, const std::string& unit,
                double Deformation::*number) {
  const auto make = [plural, number](const Table& expect, const Results& results) -> Measure {
    const ThermalStress& stress = require_stress(expect, plural, results);
    return {.values = [&stress, number](const State& state, std::span<const double>) {
      return std::vector{stress.deformation(state.T).*number};
    }};
  };
  return {.name = name, .plural = plural, .unit = unit, .column = name, .is_of_body = true, .make = make};
}

}  // namespace

Quantity stress_quantity() { return component("stress", "stresses", "stress"); }
Quantity radial_stress_quantity() { return component("radial_stress", "radial stresses", "radial stress"); }
Quantity hoop_stress_quantity() { return component("hoop_stress", "hoop stresses", "hoop stress"); }
Quantity lowest_stress_quantity() { return number("lowest_stress", "lowest stresses", "Pa", &Deformation::lowest); }
Quantity highest_stress_quantity() { return number("highest_stress", "highest stresses", "Pa", &Deformation::highest); }
Quantity strain_quantity() { return number("strain", "strains", "", &Deformation::strain); }
Quantity curvature_quantity() { return number("curvature", "curvatures", "1/m", &Deformation::curvature); }

}  // namespace calor
