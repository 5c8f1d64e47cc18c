// The averaged flux of MLPG on lattices.
#include "conduction/brick_weights.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "case_models.hpp"
#include "cloud/points.hpp"

namespace calor {
namespace {

/// Largest difference to T = exp(1.25 x) sin(y) sin(0.75 z), a harmonic function, in a box between walls at it.
double error_of_harmonic(int intervals, const std::string& options) {
  const std::string T = "300 + exp(1.25*x)*sin(y)*sin(0.75*z)";
  const CaseModel m(box_case({"1 m", "1 m", "1 m"}, {intervals + 1, intervals + 1, intervals + 1}, "mlpg") + options +
                    simple_material({.k = "2"}) +
                    "[boundary.walls]\non = [\"xmin\", \"xmax\", \"ymin\", \"ymax\", \"zmin\", \"zmax\"]\n" +
                    fmt::format("temperature = {{ formula = \"{}\", unit = \"K\" }}\n[steady]\n", T));
  double error = 0;
  const State state = m.steady();
  for (int i = 0; i < m.cloud().owned; ++i) {
    const Vec3& x = m.cloud().x[i];
    error = std::max(error, std::abs(state.T[i] - 300 - std::exp(1.25 * x.x) * std::sin(x.y) * std::sin(0.75 * x.z)));
  }
  return error;
}

TEST(BrickWeights, SteadyTemperaturesWithoutSourcesAreOfFourthOrder) {
  const double coarse = error_of_harmonic(4, ""), fine = error_of_harmonic(8, "");
  EXPECT_GE(std::log2(coarse / fine), 3.8);
  EXPECT_LE(fine, 0.01 * error_of_harmonic(8, "[mlpg]\nflux = \"edge-stabilised\"\n"));
}

TEST(BrickWeights, ArePositiveAndExactForLinearTemperaturesOnFlatAndGradedPoints) {
  for (const std::string z : {R"(["0 m", "0.1 m", "0.2 m", "0.3 m"])", R"(["0 m", "0.01 m", "0.02 m", "0.03 m"])",
                              R"(["0 m", "0.5 m", "0.7 m", "0.71 m", "2 m"])"}) {
    SCOPED_TRACE(z);
    const CaseModel m(
        "title = \"t\"\nmethod = \"mlpg\"\n[steady]\n[cloud]\nshape = \"box\"\nx = [\"0 m\", \"0.1 m\", \"0.3 m\"]\n"
        "y = [\"0 m\", \"0.1 m\", \"0.2 m\"]\nz = " +
        z + "\n" + simple_material({.k = "1"}) + "[boundary.zmin]\ntemperature = \"300 K\"\n");
    const Cloud& cloud = m.cloud();
    const BrickWeights weights = brick_weights(cloud);
    EXPECT_GT(*std::ranges::min_element(weights.G), 0);
    for (int i = 0; i < cloud.owned; ++i) {
      Vec3 residual = cloud.area[i];
      for (auto n = weights.neighbours.row[i]; n < weights.neighbours.row[i + 1]; ++n)
        residual += weights.G[n] * weights.neighbours.x_ji(cloud.x, i, n);
      EXPECT_LE(norm(residual), 1e-14);
    }
  }
}

TEST(BrickWeights, AreTakenWhereHeatComesThroughTheSurface) {
  const auto is_averaged = [](const std::string& rest) {
    return CaseModel(box_case({"1 m", "1 m", "1 m"}, {4, 4, 4}, "mlpg") +
                     simple_material({.k = "1", .rho = "1", .c = "1"}) + "[boundary.zmin]\ntemperature = \"300 K\"\n" +
                     rest)
        .model()
        .weights.contains("negative_weights");
  };
  const std::string transient = "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n";
  EXPECT_TRUE(is_averaged("[steady]\n"));
  EXPECT_FALSE(is_averaged("[steady]\n[source.inside]\npower_density = \"1 W/m^3\"\n"));
  EXPECT_FALSE(is_averaged(transient));
  EXPECT_TRUE(is_averaged(transient + "[boundary.zmax]\nflux = \"1 W/m^2\"\n"));
  EXPECT_FALSE(is_averaged("[steady]\n[mlpg]\nsupport = 1.5\n"));
}

TEST(BrickWeights, AreRefusedWhereTheyWouldReachAcrossWhatTheyDoNotKnow) {
  const std::string rest = simple_material({.k = "1"}) + "[steady]\n[mlpg]\nflux = \"averaged\"\n";
  expect_refused(box_case({"1 m", "1 m"}, {5, 5}, "mlpg") + "jitter = 0.2\n" + rest, {"averaged", "lattice"});
  expect_refused(box_case({"1 m", "1 m"}, {5, 5}, "mlpg") + rest + "support = 2\n",
                 {"differences between points", "leave it out"});
}

}  // namespace
}  // namespace calor
