// A quantity of an [[expect]]: the stress of a body that is held on all sides, sigma = -E alpha (T - T0)/(1 - 2 nu).
#include "output/quantities.hpp"

#include "run_case.hpp"

namespace calor {
namespace {

Measure measure_pressure(const Table& expect, const Results& /*results*/) {
  const double stiffness = expect.number("stiffness"), T0 = expect.number("free_at");
  return {.values = [stiffness, T0](const State&, std::span<const double> T) {
    std::vector<double> sigma;
    for (const double at_point : T) sigma.push_back(-stiffness * (at_point - T0));
    return sigma;
  }};
}

Quantity pressure_quantity() {
  return {.name = "held_stress",
          .plural = "stresses of a held body",
          .unit = "Pa",
          .column = "sigma",
          .keys = {{"stiffness", Kind::quantity, "Pa/K", required, "E alpha/(1 - 2 nu)."},
                   {"free_at", Kind::quantity, "K", required, "Temperature without stress."}},
          .make = measure_pressure};
}

TEST(Plugin, IsAQuantity) {
  quantities().add(pressure_quantity());
  // T = 300 K + 40 K/m x: in the middle 20 K of 5 MPa/K.
  expect_passes(bar + R"toml(
[material.m]
conductivity = "1 W/(m K)"
[boundary.xmin]
temperature = "300 K"
[boundary.xmax]
temperature = "340 K"
[steady]
[probe]
middle = "0.5 m"
[[expect]]
quantity = "held_stress"
probe = "middle"
stiffness = "5 MPa/K"
free_at = "300 K"
value = "-100 MPa"
within = "1 Pa"
)toml");
}

}  // namespace
}  // namespace calor
