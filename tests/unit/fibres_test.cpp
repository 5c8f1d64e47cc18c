// Pairs of a lattice whose cells hold several parts.
#include "conduction/fibres.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "case_models.hpp"

namespace calor {
namespace {

const std::string materials = simple_material({.name = "board", .k = "0.3", .rho = "1", .c = "1"}) +
                              simple_material({.name = "copper", .k = "390", .rho = "1", .c = "1"}) +
                              "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n";

/// Heat that flows where T grows by 1 K/m along an axis, and the largest rate of a point between its ends, W.
struct Flow {
  double through = 0, between = 0;
};

Flow flow_along(const CaseModel& m, int axis, double length) {
  std::vector<double> T(m.cloud().local());
  for (int i = 0; i < m.cloud().local(); ++i) T[i] = 300 + m.cloud().x[i][axis];
  const std::vector<double> F = m.rates(0, std::move(T)).F;
  Flow flow;
  for (int i = 0; i < m.cloud().owned; ++i) {
    const double at = m.cloud().x[i][axis];
    if (at == 0)
      flow.through += F[i];
    else if (at < length)
      flow.between = std::max(flow.between, std::abs(F[i]));
  }
  return flow;
}

TEST(Fibres, FlowAlongLayersIsExactWhereverTheInterfaceLies) {
  // 1 K/m through (0.3 t_1 + 390 t_2) * 1 m; points of unequal spacing, the interface on a point, midway and anywhere.
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    for (const double copper : {0.2, 0.15, 0.1234, 0.02}) {
      SCOPED_TRACE(method + fmt::format(" {}", copper));
      const CaseModel m(fmt::format("title = \"t\"\nmethod = \"{}\"\n[cloud]\nshape = \"box\"\n", method) +
                        "x = [\"0 m\", \"0.3 m\", \"0.6 m\", \"0.9 m\", \"1.2 m\"]\n"
                        "y = [\"0 m\", \"0.25 m\", \"0.5 m\", \"0.7 m\", \"0.8 m\", \"0.9 m\", \"1 m\"]\n" +
                        materials + "[body]\nalong = \"y\"\n" +
                        fmt::format("[[body.layer]]\nmaterial = \"board\"\nthickness = \"{} m\"\n", 1 - copper) +
                        fmt::format("[[body.layer]]\nmaterial = \"copper\"\nthickness = \"{} m\"\n", copper));
      const Flow flow = flow_along(m, 0, 1.2);
      EXPECT_NEAR(flow.through / (0.3 * (1 - copper) + 390 * copper), 1, 1e-9);
      EXPECT_LE(flow.between, 1e-9);
    }
  }
}

TEST(Fibres, LayersThatLieInsideACellCount) {
  // A sheet between the points of a row and the end of their cells; points of equal spacing, too, have no pair that
  // runs past it.
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    SCOPED_TRACE(method);
    const CaseModel m(box_case({"1 m", "1 m"}, {6, 6}, method) + materials +
                      "[body]\nalong = \"y\"\n[[body.layer]]\nmaterial = \"board\"\nthickness = \"0.63 m\"\n"
                      "[[body.layer]]\nmaterial = \"copper\"\nthickness = \"0.02 m\"\n"
                      "[[body.layer]]\nmaterial = \"board\"\nthickness = \"0.35 m\"\n");
    EXPECT_NEAR(flow_along(m, 0, 1).through / (0.3 * 0.98 + 390 * 0.02), 1, 1e-9);
  }
}

TEST(Fibres, FlowAlongAWireIsExactWhereverItsEdgesLie) {
  // A square wire in a box, its edges between points on one side and on points on the other.
  const CaseModel m(box_case({"1 m", "1 m", "1 m"}, {6, 6, 4}, "mlpg") + materials +
                    "[body]\nmaterial = \"board\"\n[[body.region]]\nmaterial = \"copper\"\n"
                    "where = \"x > 0.4 && x < 0.67 && y > 0.33 && y < 0.8\"\n");
  const double area = 0.27 * 0.47;
  const Flow flow = flow_along(m, 2, 1);
  EXPECT_NEAR(flow.through / (0.3 * (1 - area) + 390 * area), 1, 1e-9);
  EXPECT_LE(flow.between, 1e-9);
}

TEST(Fibres, PairsThatJumpOverAThinRegionRunThroughIt) {
  // An insulator across a metal bar, from a fifth of the spacing to twice of it, wherever it lies: resistances in
  // series.
  int n = 0;
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    for (const char* jitter : {"0", "0.2"}) {
      for (const double thickness : {0.01, 0.025, 0.05, 0.08, 0.1}) {
        const double begin = 0.5 - (0.5 + 0.4 * scattered(++n)) * thickness, end = begin + thickness;
        SCOPED_TRACE(fmt::format("{}, jitter {}: {} to {} m", method, jitter, begin, end));
        const double flow = 100 * 0.5 / ((1 - thickness) / 400 + thickness / 0.1);
        const std::string text =
            box_case({"1 m", "0.5 m"}, {21, 11}, method) + fmt::format("jitter = {}\n", jitter) +
            simple_material({.name = "metal", .k = "400"}) + simple_material({.name = "insulator", .k = "0.1"}) +
            "[body]\nmaterial = \"metal\"\n" +
            fmt::format("region = [{{ material = \"insulator\", where = \"x > {} && x < {}\" }}]\n", begin, end) +
            "[steady]\n[boundary.hot]\non = \"xmin\"\ntemperature = \"400 K\"\n"
            "[boundary.cold]\non = \"xmax\"\ntemperature = \"300 K\"\n" +
            fmt::format("[[expect]]\nheat_flow = \"hot\"\nvalue = \"{:.15g} W\"\nwithin = \"1e-5 W\"\n", flow);
        for (const Verdict& v : run_into("", text).verdicts) EXPECT_TRUE(v.passed) << v.value << " W, exact " << flow;
      }
    }
  }
}

TEST(Fibres, WhatLiesBeyondAContactConductsByThePointsThere) {
  // Layers end at the contact, so do their cells: it changes nothing for heat that runs along. The slice of a region in
  // the cells of the points around it hangs on nothing but the contact: it is left to the region's points.
  const std::string board = box_case({"1 m", "1 m"}, {5, 6}, "mlpg") + materials;
  const std::string layers = board +
                             "[body]\nalong = \"y\"\n[[body.layer]]\nmaterial = \"board\"\nthickness = \"0.67 m\"\n"
                             "[[body.layer]]\nmaterial = \"copper\"\nthickness = \"0.33 m\"\n";
  const std::string region = board +
                             "[body]\nmaterial = \"board\"\n[[body.region]]\nmaterial = \"copper\"\nwhere = \"y > "
                             "0.67\"\n";
  const std::string contact = "contact = \"10 W/(m^2 K)\"\n";
  const double exact = 0.3 * 0.67 + 390 * 0.33;
  EXPECT_NEAR(flow_along(CaseModel(layers), 0, 1).through, exact, 1e-7);
  EXPECT_NEAR(flow_along(CaseModel(layers + contact), 0, 1).through, exact, 1e-7);
  EXPECT_NEAR(flow_along(CaseModel(region), 0, 1).through, exact, 1e-7);
  EXPECT_NEAR(flow_along(CaseModel(region + contact), 0, 1).through, 0.3 * 0.7 + 390 * 0.3, 1e-7);
}

}  // namespace
}  // namespace calor
