// Derivatives of what a weld and thermal stress come to over a run.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "case_models.hpp"
#include "derivative_checks.hpp"
#include "results.hpp"

namespace calor {
namespace {

/// Numbers of the report of a run.
std::vector<double> reported(const std::string& text, const std::vector<std::string>& names) {
  const TemporaryFolder folder;
  const RunResult result = run_into(folder.path(), text);
  std::vector<double> values;
  for (const std::string& name : names) values.push_back(result.numbers.at(name));
  return values;
}

std::string asked(const std::vector<std::string>& by, const std::vector<std::string>& of) {
  return fmt::format("[output]\nderivatives = [\"{}\"]\nderivatives_of = [\"{}\"]\n", fmt::join(by, "\", \""),
                     fmt::join(of, "\", \""));
}

/// An arc crosses a plate in fixed steps: the probe is at its hottest between two of them, and the melt goes on to grow
/// beside the arc when it has gone.
std::string weld(const std::vector<double>& p) {
  return box_case({"80 mm", "30 mm"}, {33, 13}, "sph") + "thickness = \"2 mm\"\n" +
         simple_material({.k = fmt::format("{:.17g} + 0.01*T", p[0]), .rho = "7850", .c = "600"}) +
         fmt::format(R"toml(
[source.arc]
power = "3000 W"
efficiency = {:.17g}
half = true
column = {{ sigma = "{:.17g} mm" }}
[[source.arc.pass]]
from = ["10 mm", "0 mm"]
to = ["70 mm", "0 mm"]
speed = "10 mm/s"
[initial]
temperature = "300 K"
[time]
end = "8 s"
integrator = "tr-bdf2"
step = "0.1 s"
[probe]
near = ["40 mm", "12 mm"]
[weld]
isotherm = "1100 K"
[weld.extent.width]
from = ["40 mm", "0 mm"]
to = ["40 mm", "30 mm"]
)toml",
                     p[1], p[2]);
}

TEST(Derivatives, OfAWeldAreDifferencesOfWholeRuns) {
  const std::vector<std::string> by = {"source.arc.efficiency", "source.arc.column.sigma"},
                                 of = {"largest_width", "peak_width", "peak.near"};
  const std::vector<double> at = {0.7, 6};
  const auto text = [](const std::vector<double>& p) { return weld({30, p[0], p[1]}); };
  const TemporaryFolder folder;
  run_into(folder.path(), text(at) + asked(by, of));
  auto found = derivatives(folder.path());
  for (auto& [name, row] : found) row.erase(row.begin());  // of the probe
  EXPECT_GT(reported(text(at), of)[0], 3e-3);
  // Steps so short that no other samples of the line become those beside the crossing.
  expect_derivatives(found, by, at, 2e-4, 1e-5, [&](const std::vector<double>& p) { return reported(text(p), of); });
}

/// A graded plate that is free to bend, heated on one side.
std::string stressed(const std::vector<double>& p, const std::string& solved) {
  return box_case({"10 mm"}, {41}, "sph") +
         fmt::format(R"toml(
[material.m]
conductivity = "{:.17g} W/(m K)"
density = "4000 kg/m^3"
specific_heat = "500 J/(kg K)"
youngs_modulus = {{ formula = "200 - 5e5*x^2", unit = "GPa" }}
poisson_ratio = 0.3
expansion = {{ formula = "1e-5 + 1e-8*(T - 300)", unit = "1/K" }}
[boundary.gas]
on = "xmin"
convection = {{ h = "{:.17g} W/(m^2 K)", ambient = "1200 K" }}
[boundary.cold]
on = "xmax"
convection = {{ h = "900 W/(m^2 K)", ambient = "300 K" }}
[stress]
body = "plate"
from = ["0 mm"]
to = ["10 mm"]
free_at = "300 K"
)toml",
                     p[0], p[1]) +
         solved;
}

TEST(Derivatives, OfThermalStressAreDifferencesOfWholeRuns) {
  const std::vector<std::string> by = {"material.m.conductivity", "boundary.gas.convection.h"},
                                 of = {"lowest_stress", "highest_stress", "largest_stress"};
  const std::vector<double> at = {3, 1500};
  const std::string shock =
      "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"8 s\"\nintegrator = \"tr-bdf2\"\nstep = \"0.1 s\"\n";
  for (const std::string& solved : {std::string("[steady]\ntolerance = 1e-13\n"), shock}) {
    const TemporaryFolder folder;
    run_into(folder.path(), stressed(at, solved) + asked(by, of));
    expect_derivatives(derivatives(folder.path()), by, at, 1e-3, 1e-5,
                       [&](const std::vector<double>& p) { return reported(stressed(p, solved), of); });
  }
}

TEST(DerivativesParallel, OfAWeldAreThoseOfOneRank) {
  const std::string text =
      weld({30, 0.7, 6}) + asked({"source.arc.efficiency", "source.arc.column.sigma"}, {"peak_width", "peak.near"});
  const TemporaryFolder alone, together(MPI_COMM_WORLD);
  run_into(alone.path(), text);
  run_into(together.path(), text, MPI_COMM_WORLD);
  const auto expected = derivatives(alone.path()), found = derivatives(together.path());
  for (const auto& [name, row] : expected)
    for (std::size_t m = 0; m < row.size(); ++m)
      EXPECT_NEAR(found.at(name)[m], row[m], 1e-6 * std::abs(row[m])) << name;
}

}  // namespace
}  // namespace calor
