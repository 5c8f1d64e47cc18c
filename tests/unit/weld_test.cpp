// Results of welds: histories and extents; heat of melting; losses through the faces of a plate.
#include <gtest/gtest.h>

#include <cmath>

#include "base/parallel.hpp"
#include "boundary/conditions.hpp"
#include "case_models.hpp"
#include "material/library.hpp"
#include "material/simple.hpp"
#include "method_clouds.hpp"
#include "output/weld.hpp"

namespace calor {
namespace {

TEST(Weld, PeaksAndCoolingTimesOfAParabolaAreExact) {
  // T = 1000 - 100 (t - 3.3)^2: falls through 800 at 3.3 + sqrt 2 and through 500 at 3.3 + sqrt 5.
  ThermalHistory history(1, ThermalHistory::Levels{800, 500});
  for (double t : {0.0, 0.7, 1.5, 2.9, 4.1, 5.0, 5.9}) {
    const double T = 1000 - 100 * (t - 3.3) * (t - 3.3);
    history.observe(t, std::span(&T, 1));
  }
  EXPECT_NEAR(history.peak()[0], 1000, 1e-10);
  EXPECT_NEAR(history.cooling()[0], std::sqrt(5) - std::sqrt(2), 1e-12);
}

TEST(Weld, APassThatStaysBelowTheUpperLevelLeavesTheCoolingTime) {
  ThermalHistory history(1, ThermalHistory::Levels{800, 500});
  double t = 0;
  const auto go = [&](double T) { history.observe(t, std::span(&T, 1)), t += 1; };
  go(300), go(700), go(400);
  EXPECT_EQ(history.cooling()[0], -1);
  go(900), go(700), go(450);
  const double first = history.cooling()[0];
  EXPECT_GT(first, 0.5);
  go(600), go(400);
  EXPECT_EQ(history.cooling()[0], first);
}

TEST(WeldParallel, TheExtentOfAParabolaIsExact) {
  const Cloud cloud = box_cloud({21, 11}, 1e-3, {.comm = MPI_COMM_WORLD});
  std::vector<double> T(cloud.owned);  // hotter than 500 K for |x - 8.2 mm| < 5 mm
  for (int i = 0; i < cloud.owned; ++i) T[i] = 1000 - 2e7 * std::pow(cloud.x[i].x - 8.2e-3, 2);
  const Extent extent("length", cloud, {0, 4e-3, 0}, {20e-3, 4e-3, 0}, 500, {});
  const Extent::Part part = extent.of_field(T);
  EXPECT_NEAR(part.begin, 3.2e-3, 1e-12);
  EXPECT_NEAR(part.end, 13.2e-3, 1e-12);
  const Extent none("none", cloud, {0, 4e-3, 0}, {20e-3, 4e-3, 0}, 1001, {});
  EXPECT_EQ(none.of_field(T).length(), 0);
  const Extent all("all", cloud, {0, 4e-3, 0}, {20e-3, 4e-3, 0}, -3000, {});
  EXPECT_NEAR(all.of_field(T).length(), 20e-3, 1e-15);
}

TEST(Melting, TheEnthalpyTakesUpTheLatentHeatBetweenSolidusAndLiquidus) {
  const auto steel = make_simple_material("steel", {Function::constant(30), Function::constant(7850),
                                                    Function::constant(650), LatentHeat{270e3, 1700, 1750}});
  const Vec3 x[4] = {};
  const auto properties = steel->at(x, {.low = 300, .high = 2000, .reference = 300});
  const std::vector<double> T = {1700, 1725, 1750, 1900};
  std::vector<double> H(4), rho_c(4);
  properties->enthalpy(0, T, H, rho_c);
  EXPECT_NEAR(H[0], 7850 * 650. * 1400, 1e-3);
  EXPECT_NEAR(H[1], 7850 * (650. * 1425 + 135e3), 1e-3);
  EXPECT_NEAR(H[2], 7850 * (650. * 1450 + 270e3), 1e-3);
  EXPECT_NEAR(H[3], 7850 * (650. * 1600 + 270e3), 1e-3);
  EXPECT_NEAR(rho_c[1], 7850 * (650 + 270e3 / 50), 1e-6);
  EXPECT_NEAR(rho_c[3], 7850 * 650., 1e-6);
  EXPECT_TRUE(steel->capacity_depends_on_T());
}

TEST(Melting, CarbonSteelHasTheValuesOfEN1993) {
  const SimpleProperties steel = find_in_library("carbon steel EN 1993-1-2")->properties();
  const auto at = [](const Function& f, double t) { return f({}, 0, t + 273.15); };
  EXPECT_NEAR(at(steel.conductivity, 20), 53.334, 1e-9);
  EXPECT_NEAR(at(steel.conductivity, 1000), 27.3, 1e-9);
  EXPECT_NEAR(at(*steel.specific_heat, 20), 439.80176, 1e-4);
  EXPECT_NEAR(at(*steel.specific_heat, 600), 760.217, 0.01);
  EXPECT_NEAR(at(*steel.specific_heat, 735), 5000, 1e-6);
  EXPECT_NEAR(at(*steel.specific_heat, 1600), 650, 1e-9);
}

/// An iron body with one boundary.
Case iron_with(const std::string& boundary) {
  return parse_case(box_case({"1 m"}, {2}) + "[material.m]\nlibrary = \"iron\"\n[steady]\n" + boundary);
}

TEST(PlateFaces, EveryPointHasAPieceOfThemAndTheyAreNoWalls) {
  const Cloud cloud = box_cloud({11, 6}, 1e-3, {.section = 2e-3});
  const Case c = iron_with(R"toml([boundary.faces]
on = ["top", "bottom"]
convection = { h = "10 W/(m^2 K)", ambient = "20 degC" }
)toml");
  const Conditions conditions = make_conditions(c, cloud);
  ASSERT_EQ(conditions.fluxes.size(), 1u);
  EXPECT_TRUE(conditions.fluxes[0].is_plate);
  EXPECT_NEAR(sum(cloud.comm, conditions.fluxes[0].area), 2 * 10e-3 * 5e-3, 1e-18);
  EXPECT_EQ(cloud.faces.size(), 4u);
}

TEST(PlateFaces, APrescribedTemperatureIsRefused) {
  const Cloud cloud = box_cloud({11, 6}, 1e-3);
  const Case c = iron_with("[boundary.top]\ntemperature = \"20 degC\"\n");
  EXPECT_THROW(make_conditions(c, cloud), Error);
}

}  // namespace
}  // namespace calor
