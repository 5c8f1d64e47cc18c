#include "app/derivatives.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "app/readings.hpp"
#include "case/numbers.hpp"
#include "case_models.hpp"
#include "derivative_checks.hpp"
#include "output/probes.hpp"
#include "results.hpp"

namespace calor {
namespace {

/// Temperatures of the probes, and the numbers of the balance that are asked for.
std::vector<double> readings(const CaseModel& model) {
  State steady = model.steady();
  model.system().temperatures(steady.T);
  const Probes probes(model.description(), model.cloud(), &model.system().dofs(), &model.system().material().parts());
  return Readings(model.description(), probes, model.system()).at(0, steady.T);
}

// T = T_w + q (L - x) / k.
const std::string slab = R"toml(
[material.m]
conductivity = "4 W/(m K)"
[boundary.heater]
on = "xmin"
flux = "3 kW/m^2"
[boundary.wall]
on = "xmax"
temperature = "300 K"
[steady]
[probe]
a = ["0.05 m"]
[output]
derivatives = ["material.m.conductivity", "boundary.heater.flux", "boundary.wall.temperature"]
)toml";

TEST(Derivatives, OfASlabAreThoseOfItsFormulaToRoundOffByTangentAndAdjoint) {
  for (const std::string method : {"sph", "peridynamics", "mlpg"})
    // Three numbers and one probe take the adjoint, with more probes the tangents.
    for (const std::string probes : {"", "b = [\"0.2 m\"]\nc = [\"0.1 m\"]\nd = [\"0.11 m\"]\n"}) {
      const TemporaryFolder folder;
      const std::string text = replaced(slab, "[output]", probes + "[output]");
      run_into(folder.path(), box_case({"0.4 m"}, {21}, method) + text);
      const auto d = derivatives(folder.path());
      EXPECT_NEAR(d.at("material.m.conductivity")[0], -3000 * 0.35 / 16, 1e-8) << method;
      EXPECT_NEAR(d.at("boundary.heater.flux")[0], 1000 * 0.35 / 4, 1e-8) << method;  // per kW/m^2
      EXPECT_NEAR(d.at("boundary.wall.temperature")[0], 1, 1e-9) << method;
    }
}

TEST(Derivatives, OfTheBalanceOfASlabAreThoseOfItsFormulaToRoundOff) {
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    const TemporaryFolder folder;
    run_into(folder.path(), box_case({"0.4 m"}, {21}, method) + slab +
                                "derivatives_of = [\"heat_flow.wall\", \"mean.m\", \"maximum.m\", \"minimum.heater\"]");
    const auto d = derivatives(folder.path());
    const auto expect = [&](const std::string& number, double flow, double mean, double highest) {
      const std::vector<double>& row = d.at(number);
      ASSERT_EQ(row.size(), 5) << method;
      EXPECT_NEAR(row[1], flow, 1e-7) << method << number;  // of 3000 W
      EXPECT_NEAR(row[2], mean, 1e-8) << method << number;
      EXPECT_NEAR(row[3], highest, 1e-8) << method << number;
      EXPECT_NEAR(row[4], highest, 1e-8) << method << number;
    };
    expect("material.m.conductivity", 0, -3000 * 0.2 / 16, -3000 * 0.4 / 16);
    expect("boundary.heater.flux", -1000, 1000 * 0.2 / 4, 1000 * 0.4 / 4);
    expect("boundary.wall.temperature", 0, 1, 1);
  }
}

TEST(Derivatives, OfNumbersThatTheBalanceDoesNotHaveAreRefused) {
  const TemporaryFolder folder;
  expect_error(
      [&] { run_into(folder.path(), box_case({"0.4 m"}, {21}) + slab + "derivatives_of = \"heat_flow.air\""); },
      {"no derivatives are known of 'heat_flow.air'", "take some of heat_flow.heater, heat_flow.wall, mean.m"});
}

/// Two materials that meet inside of the cells, radiation, convection by temperature, a source.
std::string wall(const std::string& method, double k, double h, double emissivity, double T_wall, double power) {
  return box_case({"100 mm", "40 mm"}, {26, 11}, method) + fmt::format(R"toml(
[material.a]
conductivity = {{ table = [[300, 20], [600, {:.17g}], [1600, 30]], unit = "W/(m K)" }}
[material.b]
conductivity = {{ formula = "8 + 0.01*T", unit = "W/(m K)" }}
[body]
along = "x"
[[body.layer]]
material = "a"
thickness = "46 mm"
[[body.layer]]
material = "b"
thickness = "54 mm"
[boundary.gas]
on = "xmin"
convection = {{ h = "{:.17g} W/(m^2 K)", ambient = "1500 K" }}
radiation = {{ emissivity = {:.17g}, ambient = "700 K" }}
[boundary.held]
on = "xmax"
temperature = "{:.17g} K"
[boundary.side]
on = "ymax"
convection = {{ h = {{ table = [[300, 50], [1500, 200]], of = "temperature", unit = "W/(m^2 K)" }}, ambient = "300 K" }}
[source.heat]
power_density = "{:.17g} W/m^3"
[steady]
tolerance = 1e-13
[probe]
p = ["20 mm", "10 mm"]
q = ["70 mm", "38 mm"]
[output]
derivatives = ["material.a.conductivity.table[1][1]", "boundary.gas.convection.h", "boundary.gas.radiation.emissivity",
               "boundary.held.temperature", "source.heat.power_density"]
derivatives_of = ["heat_flow.gas", "heat_flow.held", "mean.b", "maximum.a", "mean.ymax"]
)toml",
                                                                       k, h, emissivity, T_wall, power);
}

TEST(Derivatives, OfANonlinearWallAreDifferencesOfWholeRuns) {
  const std::vector<std::string> names = {"material.a.conductivity.table[1][1]", "boundary.gas.convection.h",
                                          "boundary.gas.radiation.emissivity", "boundary.held.temperature",
                                          "source.heat.power_density"};
  const std::vector<double> at = {14, 800, 0.6, 400, 2e5};
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    const auto readings_at = [&](std::vector<double> p) {
      return readings(CaseModel(wall(method, p[0], p[1], p[2], p[3], p[4])));
    };
    const TemporaryFolder folder;
    run_into(folder.path(), wall(method, at[0], at[1], at[2], at[3], at[4]));
    SCOPED_TRACE(method);
    expect_derivatives(derivatives(folder.path()), names, at, 3e-4, 1e-7, readings_at);
  }
}

/// The same over time, in fixed steps, with capacities; the wall and the air become hotter.
std::string heating(const std::string& method, const std::vector<double>& p) {
  std::string text = replaced(wall(method, p[0], p[1], 0.6, p[2], 2e5), "[steady]\ntolerance = 1e-13", R"toml(
[initial]
temperature = "350 K"
[time]
end = "40 s"
integrator = "tr-bdf2"
step = "2 s")toml");
  text = replaced(text, "[material.b]",
                  fmt::format("density = \"4000 kg/m^3\"\nspecific_heat = {{ formula = \"{:.17g} + "
                              "0.2*T\", unit = \"J/(kg K)\" }}\n[material.b]",
                              p[3]));
  // Without a kink in k, at which differences would take the mean of both sides.
  text = replaced(text, "unit = \"W/(m K)\" }", "unit = \"W/(m K)\", interpolation = \"cubic\" }");
  text = replaced(text, "[body]", "density = \"2000 kg/m^3\"\nspecific_heat = \"300 J/(kg K)\"\n[body]");
  text =
      replaced(text, "ambient = \"1500 K\"", "ambient = { table = [[0, 800], [11, 900], [11, 1500]], unit = \"K\" }");
  return text.substr(0, text.find("[output]"));
}

TEST(Derivatives, OfARunOverTimeAreDifferencesOfWholeRuns) {
  const std::vector<std::string> names = {"material.a.conductivity.table[1][1]", "boundary.gas.convection.h",
                                          "boundary.held.temperature"};
  const std::vector<double> at = {14, 800, 400, 500};
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    const auto readings_at = [&](const std::vector<double>& p) {
      const TemporaryFolder folder;
      run_into(folder.path(), heating(method, p));
      std::vector<double> at_end;
      for (const char* name : {"probes.csv", "balance.csv"}) {
        std::istringstream lines(read_file(folder / name));
        std::string line, last, cell;
        while (std::getline(lines, line)) last = line;
        std::istringstream cells(last);
        std::getline(cells, cell, ',');  // the time
        while (std::getline(cells, cell, ',')) at_end.push_back(std::stod(cell));
      }
      at_end.resize(4);  // two probes, two heat flows
      return at_end;
    };
    const TemporaryFolder folder;
    run_into(
        folder.path(),
        heating(method, at) +
            fmt::format("[output]\nderivatives = [\"{}\"]\nderivatives_of = [\"heat_flow.gas\", \"heat_flow.held\"]\n",
                        fmt::join(names, "\", \"")));
    SCOPED_TRACE(method);
    // Stages end within 1e-10 of the span of temperatures.
    expect_derivatives(derivatives(folder.path()), names, at, 1e-3, 1e-6, readings_at);
  }
}

// A body that nothing cools: T = T_0 + P t / (rho c), whatever the steps.
TEST(DerivativesParallel, OfAnInsulatedBodyAreThoseOfItsHeat) {
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    const TemporaryFolder folder(MPI_COMM_WORLD);
    run_into(folder.path(),
             box_case({"0.1 m", "0.08 m"}, {9, 7}, method) + simple_material({.k = "20", .rho = "8000", .c = "400"}) +
                 R"toml(
[initial]
temperature = "300 K"
[source.heat]
power_density = "3e6 W/m^3"
[time]
end = "10 s"
integrator = "tr-bdf2"
[probe]
a = ["0.021 m", "0.012 m"]
[output]
derivatives = ["material.m.specific_heat", "source.heat.power_density", "initial.temperature", "material.m.conductivity"]
derivatives_of = ["mean.m", "heat_flow.heat"]
)toml",
             MPI_COMM_WORLD);
    const auto d = derivatives(folder.path());
    EXPECT_NEAR(d.at("material.m.specific_heat")[0], -3e6 * 10 / 8000 / 400 / 400, 1e-8) << method;
    EXPECT_NEAR(d.at("source.heat.power_density")[0], 10. / 8000 / 400, 1e-12) << method;
    EXPECT_NEAR(d.at("source.heat.power_density")[1], 10. / 8000 / 400, 1e-12) << method;
    EXPECT_NEAR(d.at("source.heat.power_density")[2], 0.1 * 0.08, 1e-10) << method;
    EXPECT_NEAR(d.at("initial.temperature")[0], 1, 1e-8) << method;
    EXPECT_NEAR(d.at("initial.temperature")[1], 1, 1e-8) << method;
    EXPECT_NEAR(d.at("material.m.conductivity")[0], 0, 1e-8) << method;
  }
}

std::string plate_on_grid(const std::string& method) {
  return box_case({"0.1 m", "0.08 m"}, {21, 17}, method) + R"toml(
[material.m.conductivity]
grid = [[20, 22, 19], [23, 18, 21], [20, 24, 25], [19, 20, 22]]
along = ["x", "y"]
from = ["0 m", "0 m"]
to = ["0.1 m", "0.08 m"]
unit = "W/(m K)"
[boundary.heater]
on = "xmin"
flux = "40 kW/m^2"
[boundary.wall]
on = "xmax"
temperature = "300 K"
[boundary.air]
on = "ymax"
convection = { h = "100 W/(m^2 K)", ambient = "300 K" }
[steady]
[probe]
a = ["0.021 m", "0.012 m"]
b = ["0.055 m", "0.047 m"]
c = ["0.08 m", "0.07 m"]
[output]
derivatives = "material.m.conductivity.grid"
)toml";
}

TEST(DerivativesParallel, OfAGridAreThoseOfOneRank) {
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    const TemporaryFolder alone, together(MPI_COMM_WORLD);
    run_into(alone.path(), plate_on_grid(method));
    run_into(together.path(), plate_on_grid(method), MPI_COMM_WORLD);
    const auto expected = derivatives(alone.path()), found = derivatives(together.path());
    ASSERT_EQ(expected.size(), 12);
    for (const auto& [name, row] : expected)
      for (std::size_t m = 0; m < row.size(); ++m)
        EXPECT_NEAR(found.at(name)[m], row[m], 1e-7) << method << ' ' << name;
  }
}

TEST(Derivatives, ByTheScaleOfAllConductivitiesAreTheSumOfThoseByEachOfThem) {
  // Heated by a flux and held at 300 K, without air: T - 300 goes by 1/k, so that sum_n k_n dT/dk_n = -(T - 300).
  const std::string text = replaced(plate_on_grid("sph"), "\"100 W/(m^2 K)\"", "\"0 W/(m^2 K)\"");
  const TemporaryFolder folder;
  run_into(folder.path(), text);
  const CaseModel model(text);
  const std::vector<double> T = readings(model);
  const CaseNumbers numbers(model.description(), "material.m.conductivity.grid", {});
  const auto found = derivatives(folder.path());
  for (std::size_t m = 0; m < T.size(); ++m) {
    double sum = 0;
    for (std::size_t n = 0; n < numbers.values().size(); ++n)
      sum += numbers.values()[n] * found.at(numbers.names()[n])[m];
    EXPECT_NEAR(sum, 300 - T[m], 1e-6);
  }
}

TEST(Grid, IsLinearBetweenItsNodesAndRefusedOutside) {
  const Case c = parse_case(plate_on_grid("sph"));
  const Function k = c.section("material").children().front().second.function("conductivity");
  EXPECT_DOUBLE_EQ(k({0, 0, 0}), 20);
  EXPECT_DOUBLE_EQ(k({0.1, 0.08, 0}), 22);
  EXPECT_DOUBLE_EQ(k({0, 0.02, 0}), 21);
  EXPECT_NEAR(k({0.05, 0.06, 0}), (18 + 21 + 24 + 25) / 4., 1e-12);
  expect_error(
      [&] {
        k({0.11, 0, 0});
      },
      {"test.toml:9:8", "the grid reaches from x = 0 m to 0.1 m", "let the grid cover"});
}

TEST(CaseNumbers, ChangeOneNumberAndLeaveTheRest) {
  const Case c = parse_case(wall("sph", 14, 800, 0.6, 400, 2e5));
  const CaseNumbers h(c, "boundary.gas.convection.h", {}), k(c, "material.a.conductivity.table", {});
  EXPECT_EQ(h.values(), (std::vector<double>{800}));
  EXPECT_EQ(k.values(), (std::vector<double>{300, 20, 600, 14, 1600, 30}));
  EXPECT_EQ(k.names()[3], "material.a.conductivity.table[1][1]");
  const Case changed = h.with(std::vector<double>{801.25});
  EXPECT_EQ(changed.section("boundary").sub("gas").sub("convection").function("h")(), 801.25);
  EXPECT_EQ(h.with(h.values()).json(), c.json());
  for (const char* path : {"material.a.density", "material.a", "boundary.gas.on", "material.a.conductivity.table[9]",
                           "material.a.conductivity.table[", ""})
    expect_error([&] { CaseNumbers(c, path, {.file = "test.toml", .line = 3}); }, {"test.toml:3", "name a number"});
}

}  // namespace
}  // namespace calor
