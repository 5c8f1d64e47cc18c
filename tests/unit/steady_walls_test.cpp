// Steady states that Newton's method does not find from the start it is given by default.
#include <gtest/gtest.h>

#include <string>

#include "case_models.hpp"

namespace calor {
namespace {

TEST(SteadyWalls, OfTwoMaterialsBetweenConvectionAndRadiationAreFound) {
  // From 50 (494 - T_1) = q = (Theta(T_1) - Theta(T_i)) / 8.3 mm = 19.9 (T_i - T_2) / 11.7 mm = eps sigma (T_2^4 -
  // 300^4) with Theta = integral of k dT, by bisection: q = 1637.732 W/m^2.
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    SCOPED_TRACE(method);
    const CaseModel m(
        "title = \"wall\"\nmethod = \"" + method +
        "\"\n[cloud]\nshape = \"box\"\nsize = [\"20 mm\"]\npoints = [21]\n[material.a]\nconductivity = { table = "
        "[[300, "
        "6.59], [908, 10.92], [1200, 10.09]], of = \"temperature\", unit = \"W/(m K)\" }\n" +
        simple_material({.name = "b", .k = "19.9"}) +
        "[body]\nmaterial = \"a\"\n[[body.region]]\nmaterial = \"b\"\nwhere = \"x > 0.0083\"\n[boundary.left]\non = "
        "\"xmin\"\nconvection = { h = \"50 W/(m^2 K)\", ambient = \"494 K\" }\n[boundary.right]\non = \"xmax\"\n"
        "radiation = { emissivity = 0.8, ambient = \"300 K\" }\n[steady]\n");
    const State state = m.steady();
    EXPECT_NEAR(state.T[0], 461.24536, 2e-3);
    EXPECT_NEAR(state.T[20], 458.52445, 2e-3);
  }
}

TEST(SteadyWalls, ThatLeaveTheBodyAtOneTemperatureAreFoundByAllMethods) {
  // Nothing flows, so that what counts as nothing follows from rounding alone.
  for (const std::string method : {"sph", "peridynamics", "mlpg", "mlpg by parameters"}) {
    SCOPED_TRACE(method);
    const bool by_parameters = method == "mlpg by parameters";
    const CaseModel m(box_case({"1 m", "1 m"}, {8, 8}, by_parameters ? "mlpg" : method) + "jitter = 0.2\n" +
                      (by_parameters ? "[mlpg]\nflux = \"parameters\"\n" : "") + simple_material({.k = "15 + 0.01*T"}) +
                      "[boundary.all]\non = [\"xmin\", \"xmax\", \"ymin\", \"ymax\"]\nconvection = { h = \"80 W/(m^2 "
                      "K)\", ambient = \"1200 K\" }\n[steady]\n");
    const State state = m.steady();
    for (int i = 0; i < m.cloud().owned; ++i) EXPECT_NEAR(state.T[i], 1200, 1e-8);
  }
}

}  // namespace
}  // namespace calor
