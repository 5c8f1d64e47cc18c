// Conditions, sources and temperatures at the start whose edges run through cells and facets.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "plate.hpp"
#include "results.hpp"

namespace calor {
namespace {

TEST(Conditions, HoldOnPartsOfFacets) {
  // Ends anywhere, one of them on a point; the edge belongs to the part or not.
  for (const char* upper : {"<", "<="}) {
    const Bound b(plate(fmt::format(R"toml(
[boundary.band]
on = "ymax"
where = "x > 0.7 && x {} 3"
flux = "1 W/m^2"
convection = {{ h = {{ formula = "x < 2.2 ? 10 : 20", unit = "W/(m^2 K)" }}, ambient = "300 K" }}
[boundary.top]
where = "x {} 1.3"
flux = {{ formula = "x", unit = "W/m^2" }}
[boundary.formula]
on = "ymin"
flux = {{ formula = "x {} 1.9 ? 7 + x : 0", unit = "W/m^2" }}
)toml",
                                    upper, upper, upper)));
    EXPECT_NEAR(total_area(b.conditions.fluxes[0]), 2.3 * 0.1, 1e-14);
    EXPECT_NEAR(total_area(b.conditions.fluxes[1]), 2.3 * 0.1, 1e-14);
    EXPECT_NEAR(total_area(b.conditions.fluxes[2]), 1.3 * 2, 1e-13);
    EXPECT_NEAR(b.conditions.areas[0], 2.3 * 0.1, 1e-14);
    EXPECT_NEAR(b.conditions.areas[1], 1.3 * 2, 1e-13);
    EXPECT_NEAR(b.conditions.areas[2], 1.9 * 0.1, 1e-13);  // where a flux is not 0
    const auto heat = [](const SurfaceTerm& term) {
      const std::vector<double> T(term.x.size(), 299);
      std::vector<double> q(T.size());
      term.flux->evaluate({.x = term.x, .T = T}, q, {});
      return std::inner_product(q.begin(), q.end(), term.area.begin(), 0.0);
    };
    EXPECT_NEAR(heat(b.conditions.fluxes[1]), 0.1 * (1.5 * 10 + 0.8 * 20), 1e-12);
    EXPECT_NEAR(heat(b.conditions.fluxes[2]), 0.5 * 1.3 * 1.3 * 2, 1e-12);
  }
}

TEST(Conditions, TakeTheSurroundingsOfEveryPlace) {
  const Bound b(plate(R"toml(
[boundary.air]
on = "ymax"
convection = { h = "10 W/(m^2 K)", ambient = { formula = "x < 1.3 ? 500 : 250", unit = "K" } }
[boundary.sky]
on = "ymin"
radiation = { emissivity = 0.5, ambient = { formula = "x < 0.7 ? 500 : 250", unit = "K" } }
)toml"));
  const auto heat = [](const SurfaceTerm& term) {
    const std::vector<double> T(term.x.size(), 300);
    std::vector<double> q(T.size());
    term.flux->evaluate({.x = term.x, .T = T}, q, {});
    return std::inner_product(q.begin(), q.end(), term.area.begin(), 0.0);
  };
  const double length = total_area(b.conditions.fluxes[0]) / 0.1;
  EXPECT_NEAR(heat(b.conditions.fluxes[0]), 0.1 * 10 * (1.3 * 200 - (length - 1.3) * 50), 1e-10);
  const auto black = [](double T) { return 0.5 * 5.670374419e-8 * (std::pow(T, 4) - std::pow(300, 4)); };
  EXPECT_NEAR(heat(b.conditions.fluxes[1]), 0.1 * (0.7 * black(500) + (length - 0.7) * black(250)), 1e-9);
}

TEST(Conditions, HoldOnCurvedFacesWhosePointsAloneAreExact) {
  // 40 points on a circle of radius 1 m: the way between them runs 3e-3 m inside.
  std::string rows = "x [m],y [m],volume [m^3],area_x [m^2],area_y [m^2]\n0,0,1,0,0\n";
  const double length = 2 * std::numbers::pi / 40;
  for (int n = 0; n < 40; ++n)
    rows += fmt::format("{0:.17g},{1:.17g},{2:.17g},{3:.17g},{4:.17g}\n", std::cos(n * length), std::sin(n * length),
                        0.5 * length, length * std::cos(n * length), length * std::sin(n * length));
  const TemporaryFolder folder;
  const std::string file = folder.write("circle.csv", rows);
  const Bound b(fmt::format(R"toml(title = "test"
method = "sph"
[cloud]
shape = "csv"
file = "{}"
[material.m]
library = "iron"
[steady]
[boundary.rim]
where = "r > 0.9999"
flux = "1 W/m^2"
[boundary.right]
where = "x > 0.3"
flux = {{ formula = "1 + x", unit = "W/m^2" }}
)toml",
                            file));
  EXPECT_NEAR(b.conditions.areas[0], 40 * length, 1e-13);
  EXPECT_NEAR(b.conditions.areas[1], 2 * std::acos(0.3), 0.01);
}

TEST(Sources, PutAPowerIntoARegionOrAFace) {
  const CaseModel m(plate(R"toml(
[source.region]
power = "100 W"
where = "x < 1234 && y > 500"
length = "mm"
[source.face]
power = { table = [[0, 0], [10, 50]], unit = "W" }
efficiency = 0.5
on = ["ymin"]
where = "x <= 1.7"
relative_density = { formula = "x^2", unit = "" }
[source.body]
power = "8 W"
)toml"));
  const auto [F, power] = m.rates(5, m.uniform(400));
  EXPECT_NEAR(power[0], 100, 1e-12);
  EXPECT_NEAR(power[1], 12.5, 1e-13);
  EXPECT_NEAR(power[2], 8, 1e-13);
  double moment = 0;
  for (int i = 0; i < m.cloud().owned; ++i) {
    const Vec3& x = m.cloud().x[i];
    if (x.y == 2) continue;
    moment += F[i];
  }
  // Rows at y = 0, 1, 2 hold 1/4, 1/2 and 1/4 of the body, and of the region from y = 0.5 on: nothing, 2/3 and 1/3.
  EXPECT_NEAR(moment, 100 * 2 / 3. + 12.5 + 8 * 0.75, 1e-10);
}

TEST(Sources, OfAFormulaGoWithItsJumps) {
  // A band of 1 m that moves by 0.3 m/s, one that depends on temperature, and one whose strength changes in time.
  const CaseModel m(plate(R"toml(
[source.moving]
power_density = { formula = "abs(x - 1 - 0.3*t) < 0.5 ? 10 : 0", unit = "W/m^3" }
[source.warm]
power_density = { formula = "x < 0.7 ? T : 0", unit = "W/m^3" }
[source.smooth]
power_density = { formula = "x^2*(1 + t)", unit = "W/m^3" }
)toml"));
  for (const double t : {0., 1., 2.7}) {
    const auto [F, power] = m.rates(t, m.uniform(400));
    EXPECT_NEAR(power[0], 10 * 2 * 0.1, 1e-12) << t;
    EXPECT_NEAR(power[1], 400 * 0.7 * 2 * 0.1, 1e-11);
    EXPECT_NEAR(power[2], 64. / 3 * (1 + t) * 2 * 0.1, 1e-12);
  }
}

TEST(Sources, AndHeatedAreasAreInTheReport) {
  const TemporaryFolder folder;
  run_into(folder.path(), plate(R"toml(
[source.chip]
power = { table = [[0, 3], [2, 5]], unit = "W" }
where = "x < 0.7"
[boundary.band]
on = "ymax"
where = "x > 0.7 && x < 3"
flux = "1 W/m^2"
)toml"));
  const Json numbers = Json::parse(read_file(folder / "report.json"))["numbers"];
  EXPECT_NEAR(numbers["area.band"].number, 2.3 * 0.1, 1e-14);
  EXPECT_NEAR(numbers["power_asked.chip"].number, 4, 1e-14);  // at the end, 1 s
  EXPECT_NEAR(numbers["power_deposited.chip"].number, 4, 1e-14);
}

TEST(InitialTemperature, OfACellThatAJumpCrossesIsItsMean) {
  const CaseModel m(replaced(plate(""), "temperature = \"400 K\"",
                             "temperature = { formula = \"x < 1.3 ? 300 : 400 + x\", unit = \"K\" }"));
  for (int i = 0; i < m.cloud().owned; ++i) {
    const double x = m.cloud().x[i].x;
    EXPECT_NEAR(m.model().T_start[i], x == 0 ? 300 : x == 1 ? 0.8 * 300 + 0.2 * 401.4 : 400 + x, 1e-11);
  }
}

}  // namespace
}  // namespace calor
