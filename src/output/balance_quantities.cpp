// Quantities of the balance: heat flows, and the temperatures of materials and faces.
#include <algorithm>

#include "output/quantities.hpp"

namespace calor {
namespace {

const Balance& require_balance(const Table& expect, const std::string& quantity, const Results& results) {
  if (!results.balance) expect.refuse(quantity, "there is no balance to look at", "run the whole case");
  return *results.balance;
}

Measure measure_heat_flow(const Table& expect, const Results& results) {
  const Balance& balance = require_balance(expect, "heat_flow", results);
  require_name(expect, "heat_flow", "boundary section or source", balance.accounts());
  const auto account = std::ranges::find(balance.accounts(), expect.text("heat_flow")) - balance.accounts().begin();
  return {.values = [&balance, account](const State& state, std::span<const double>) {
    return std::vector{balance.heat_flows(state.t, state.T)[account]};
  }};
}

/// A number of the temperatures of a material or face.
Quantity summary(const std::string& name, const std::string& plural, double Balance::Summary::*number) {
  const auto make = [name, number](const Table& expect, const Results& results) -> Measure {
    const Balance& balance = require_balance(expect, name, results);
    std::vector<std::string> names;
    for (const Balance::Zone& zone : balance.zones()) names.push_back(zone.name);
    require_name(expect, name, "material or face", names);
    const Balance::Zone& zone = *std::ranges::find(balance.zones(), expect.text(name), &Balance::Zone::name);
    return {.values = [&balance, &zone, number](const State& state, std::span<const double>) {
      return std::vector{balance.summary(zone, balance.temperatures(state.t, state.T)).*number};
    }};
  };
  return {.name = name,
          .plural = plural,
          .unit = "K",
          .column = "T",
          .is_of_body = true,
          .keys = {{name, Kind::text, "", required,
                    "Name of the material, boundary section or face of the cloud whose temperature it is; body: all "
                    "materials together, where there are several."}},
          .make = make};
}

}  // namespace

Quantity heat_flow_quantity() {
  return {.name = "heat_flow",
          .plural = "heat flows",
          .unit = "W",
          .column = "heat flow",
          .is_of_body = true,
          .keys = {{"heat_flow", Kind::text, "", required,
                    "Name of the boundary section or source; heat that flows into the body is positive."}},
          .make = measure_heat_flow};
}

Quantity mean_quantity() { return summary("mean", "mean temperatures", &Balance::Summary::mean); }

Quantity minimum_quantity() { return summary("minimum", "lowest temperatures", &Balance::Summary::minimum); }

Quantity maximum_quantity() { return summary("maximum", "highest temperatures", &Balance::Summary::maximum); }

}  // namespace calor
