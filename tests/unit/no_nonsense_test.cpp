// Runs that could give nonsense: steps too long for a state that changes, temperatures that cannot be, parts of a body
// that nothing holds.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/units.hpp"
#include "case_models.hpp"
#include "material/heat_by_point.hpp"

namespace calor {
namespace {

/// A cold plate under hot surroundings; the radiation of its surface grows twenty times on the way.
std::string oven(const std::string& time, const std::string& ambient = "460 K") {
  return box_case({"0.6 m", "1.3 m"}, {4, 14}) + simple_material({.k = "0.133", .rho = "400", .c = "660"}) +
         "[initial]\ntemperature = \"280 K\"\n[boundary.ymax]\nradiation = { emissivity = 0.7, ambient = \"" + ambient +
         "\" }\n[time]\nend = \"40000 s\"\n" + time +
         "[[expect]]\nreport = \"maximum.m\"\nat_most = " + ambient.substr(0, ambient.find(' ')) + "\n";
}

TEST(StableSteps, FollowTheRadiationOfASurfaceThatGrowsHot) {
  for (const char* integrator : {"euler", "rkl2", "tr-bdf2"})
    for (const char* ambient : {"460 K", "1500 K"}) {
      const RunResult result = run_into("", oven(fmt::format("integrator = \"{}\"\n", integrator), ambient));
      EXPECT_TRUE(result.passed()) << integrator << " " << result.numbers.at("maximum.m");
    }
}

TEST(StableSteps, KeepTemperaturesAboveAWallHalfACellAway) {
  // 1/dt of the first cell: (50 W/(m K) / 0.25 mm + 50 / 2.5 mm) / (3e6 J/(m^3 K) 0.5 mm), by hand.
  const double limit = 3e6 * 0.5e-3 / (50 / 0.25e-3 + 50 / 2.5e-3);
  const std::string text = R"toml(title = "Cells"
method = "sph"
cloud = { shape = "box", x = ["0 mm", "0.5 mm", "5 mm", "10 mm", "15 mm"], at = "cells" }
initial = { temperature = "300 K" }
boundary.cold = { on = "xmin", temperature = "280 K" }
time = { end = "0.5 s", integrator = "INTEGRATOR" }
)toml" + simple_material({.k = "50", .rho = "1000", .c = "3000"});
  for (const char* integrator : {"euler", "rkl2"}) {
    const RunResult result = run_into("", replaced(text, "INTEGRATOR", integrator));
    EXPECT_GE(result.lowest.T, 280 - 1e-9) << integrator;
    if (integrator == std::string("euler")) EXPECT_GE(result.numbers.at("steps"), 0.5 / limit);
  }
}

TEST(StableSteps, OfFixedLengthEndWithTimeAndLimitWhereTheyHaveBecomeTooLong) {
  // Stable for 10 W/(m^2 K), far too long for what the coefficient jumps to at 100 s.
  const std::string text =
      box_case({"20 mm", "10 mm"}, {11, 6}) + simple_material({.k = "40", .rho = "7850", .c = "470"}) + R"toml(
[initial]
temperature = "800 K"
[boundary.xmin]
convection = { h = { table = [[0, 10], [100, 10], [100, 400000], [200, 400000]], of = "time", unit = "W/(m^2 K)" }, ambient = "300 K" }
[time]
end = "200 s"
integrator = "euler"
step = "0.05 s"
)toml";
  expect_error([&] { run_into("", text); }, {"the step of 0.05 s is unstable at t = 100 s", "take at most"},
               Fault::numbers);
  const RunResult free = run_into("", replaced(text, "step = \"0.05 s\"\n", ""));
  EXPECT_GE(free.numbers.at("minimum.m"), 300 - 1e-9);
}

TEST(Temperatures, BelowAbsoluteZeroAreRefusedOrStopTheRun) {
  const std::string body = box_case({"1 m"}, {11}) + simple_material({.k = "1", .rho = "1", .c = "1"});
  expect_refused(body + "[initial]\ntemperature = \"-300 degC\"\n[time]\nend = \"1 s\"\n", {"below absolute zero"});
  expect_refused(
      body +
          "[initial]\ntemperature = \"300 K\"\n[boundary.xmin]\ntemperature = { table = [[0, 300], [1, -5]], "
          "unit = \"K\" }\n[time]\nend = \"1 s\"\n",
      {"-5 K, below absolute zero"});
  expect_error(
      [&] {
        run_into("", body +
                         "[initial]\ntemperature = \"300 K\"\n[boundary.xmin]\nflux = \"-3000 W/m^2\"\n[time]\nend = "
                         "\"1 s\"\n");
      },
      {"at (0, 0, 0) m", "at t = 0.0", "below absolute zero"}, Fault::numbers);
}

TEST(TablesInTime, MayJump) {
  // Up to 1 s 300 K, then 400 K: at 1 s + tau the body has warmed for tau.
  const std::string text = box_case({"1 m"}, {2}) + simple_material({.k = "1e6", .rho = "1", .c = "1"}) + R"toml(
[initial]
temperature = "300 K"
[boundary.wall]
on = ["xmin", "xmax"]
convection = { h = "0.5 W/(m^2 K)", ambient = { table = [[0, 300], [1, 300], [1, 400], [3, 400]], unit = "K" } }
[time]
end = "2 s"
tolerance = "1e-5 K"
[probe]
p = ["0.5 m"]
[[expect]]
probe = "p"
at = ["1 s", "2 s"]
value = { formula = "t <= 1 ? 300 : 400 - 100*exp(1 - t)", unit = "K" }
within = "1e-3 K"
)toml";
  for (const Verdict& v : run_into("", text).verdicts) EXPECT_TRUE(v.passed) << v.error;
}

TEST(SteadyStates, OfPartsThatNothingHoldsAreRefused) {
  const std::string text = box_case({"1 m", "1 m"}, {8, 8}) + R"toml([[crack]]
x = ["0 m", "1 m"]
y = ["0.5 m", "0.5 m"]
[material.m]
conductivity = "1 W/(m K)"
[boundary.ymin]
temperature = "300 K"
[steady]
)toml";
  expect_refused(text, {"nothing fixes the level", "cut off from the rest"});
  CaseModel both(text + "[boundary.ymax]\nradiation = { emissivity = 1.0, ambient = \"0 K\" }\n");
  EXPECT_FALSE(both.system().loose_part(both.model().T_start));
}

TEST(Units, ThatSayMoreThanAUnitAreRefused) {
  for (const char* unit : {"K @ 5", "K from 5", "K 5"})
    EXPECT_THROW(to_si(293, unit, "K"), std::invalid_argument) << unit;
  EXPECT_DOUBLE_EQ(to_si(1, "W/(m^2 K)", "W/(m2 K)"), 1);
}

TEST(HeatByPoint, IsTheIntegralOfTheHeatCapacity) {
  // c = 1 + x T + T^2: H = (T - T0) + x (T^2 - T0^2)/2 + (T^3 - T0^3)/3.
  const std::vector<Vec3> x{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}};
  const double T0 = 350;
  const HeatByPoint heat(Function::constant(2), Function::formula("1 + x*T + T^2", {}), x, {300, 900, T0});
  for (const double T : {350.0, 351.0, 899.0, 300.0, 1200.0, 20.0}) {
    const std::vector<double> all(x.size(), T);
    std::vector<double> H(x.size()), c(x.size());
    heat.evaluate(0, all, H, c);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double exact = 2 * (T - T0 + x[i].x * (T * T - T0 * T0) / 2 + (T * T * T - T0 * T0 * T0) / 3);
      EXPECT_NEAR(H[i], exact, 1e-12 * 2 * T0 * T0 * T0);
      EXPECT_NEAR(c[i], 2 * (1 + x[i].x * T + T * T), 1e-9 * T * T);
    }
  }
}

TEST(Balance, SaysWhatFlowsThroughFacesAndHowWarmPartsAre) {
  // A wall whose temperature rises by a = 10 K/s: for long q = k dT/L + rho c a L / 3 at x = 0.
  const std::string text = box_case({"1 m"}, {41}) + simple_material({.k = "1", .rho = "1", .c = "1"}) + R"toml(
[initial]
temperature = "300 K"
[boundary.xmin]
temperature = { formula = "300 + 10*t", unit = "K" }
[boundary.xmax]
temperature = "300 K"
[source.s]
power_density = "6 W/m^3"
[time]
end = "4 s"
[[expect]]
heat_flow = "xmin"
value = { formula = "40 + 10/3 - 3", unit = "W" }
within = "0.01 W"
[[expect]]
quantity = "heat_flow"
heat_flow = "s"
value = "6 W"
within = "1e-9 W"
[[expect]]
maximum = "m"
value = "340 K"
within = "1e-9 K"
[[expect]]
mean = "xmax"
value = "300 K"
within = "1e-9 K"
)toml";
  for (const char* method : {"sph", "peridynamics", "mlpg"})
    for (const Verdict& v : run_into("", replaced(text, "\"sph\"", fmt::format("\"{}\"", method))).verdicts)
      EXPECT_TRUE(v.passed) << method << ": " << v.what << " " << v.value;
  expect_error([&] { run_into("", replaced(text, "heat_flow = \"xmin\"", "heat_flow = \"xmim\"")); },
               {"there is no boundary section or source 'xmim'", "did you mean 'xmin'?"});
}

}  // namespace
}  // namespace calor
