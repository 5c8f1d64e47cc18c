// A material law: the conductivity of a metal from its electrical resistivity, k = L T / rho (Wiedemann & Franz 1853;
// L = 2.44e-8 V^2/K^2, Sommerfeld 1927).
#include "material/materials.hpp"
#include "material/simple.hpp"
#include "run_case.hpp"

namespace calor {
namespace {

void declare_metal(Schema& schema) {
  schema.add({.path = "material.*",
              .sentence = "A metal, by the law of Wiedemann and Franz.",
              .keys = {{"resistivity", Kind::quantity, "ohm m", optional, "Electrical resistivity."}}});
}

std::shared_ptr<const Material> make_metal(const std::string& name, const Table& table, Materials& /*others*/) {
  const double rho = table.number("resistivity");
  if (!(rho > 0)) table.refuse("resistivity", "the resistivity is not positive", "give that of the metal");
  return make_simple_material(
      name, {.conductivity = Function::formula("2.44e-8*T/rho", {.value = "W/(m K)", .si = "W/(m K)"}, {{"rho", rho}}),
             .density = table.function("density"),
             .specific_heat = table.function("specific_heat")});
}

TEST(Plugin, IsAMaterialLaw) {
  material_laws().add({.name = "resistivity",
                       .sentence = "the law of Wiedemann and Franz",
                       .declare = declare_metal,
                       .make = make_metal});
  // 2.44e-8 * 300 / 1.7e-8
  expect_passes(bar + R"toml(
[material.copper]
resistivity = "17 nohm m"
density = "8933 kg/m^3"
specific_heat = "385 J/(kg K)"
[initial]
temperature = "300 K"
[time]
end = "1 s"
[[expect]]
quantity = "conductivity"
field = true
value = "430.58823529 W/(m K)"
within = "1e-6 W/(m K)"
)toml");
}

}  // namespace
}  // namespace calor
