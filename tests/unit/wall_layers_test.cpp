// Walls of lattices of cells that cut through layers or have thin ones before them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "case_models.hpp"

namespace calor {
namespace {

/// A box of 1 m an edge with 6 cells along each, conductivities 1 below y = `interface` and `k` above; `contact`: a
/// line of the upper layer.
std::string layered(const std::string& method, int dimension, double interface, const std::string& boundary,
                    const std::string& k = "10", const std::string& contact = "") {
  return box_case(std::vector<std::string>(dimension, "1 m"), std::vector<int>(dimension, 6), method) +
         "at = \"cells\"\n" + simple_material({.name = "a", .k = "1"}) + simple_material({.name = "b", .k = k}) +
         fmt::format(
             "[body]\nalong = \"y\"\n[[body.layer]]\nmaterial = \"a\"\nthickness = \"{} m\"\n"
             "[[body.layer]]\nmaterial = \"b\"\nthickness = \"{} m\"\n{}",
             interface, 1 - interface, contact) +
         boundary + "[steady]\n";
}

template <class Exact>
double largest_error(const std::string& text, const Exact& exact, MPI_Comm comm = MPI_COMM_SELF) {
  const CaseModel m(text, comm);
  State state = m.steady();
  const std::vector<double> T = m.system().temperatures(state.T);
  double largest = 0;
  for (int i = 0; i < m.cloud().owned; ++i) largest = std::max(largest, std::abs(T[i] - exact(m.cloud().x[i])));
  return max(comm, largest);
}

std::string section(const std::string& name, const std::string& face, const std::string& condition) {
  return fmt::format("[boundary.{}]\non = \"{}\"\n{}\n", name, face, condition);
}

constexpr double interfaces[] = {0.5, 0.53, 0.7, 0.97};  // between cells, in one of them anywhere, in the last one

TEST(WallLayers, ConductWithTheirShareOfEveryFacetWhereHeatRunsAlongThem) {
  // 300 K + x: every layer conducts what its wall gives it, by temperature, by flux and by convection.
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    for (const double y : interfaces) {
      for (const int dimension : {2, 3}) {
        SCOPED_TRACE(fmt::format("{} {} {}", method, y, dimension));
        const std::string k = fmt::format("y < {} ? 1 : 10", y), cold = section("a", "xmin", "temperature = \"300 K\"");
        const auto linear = [](const Vec3& x) { return 300 + x.x; };
        EXPECT_LE(largest_error(layered(method, dimension, y, cold + section("b", "xmax", "temperature = \"301 K\"")),
                                linear),
                  1e-9);
        const std::string flux = fmt::format("flux = {{ formula = \"{}\", unit = \"W/m^2\" }}", k);
        EXPECT_LE(largest_error(layered(method, dimension, y, cold + section("b", "xmax", flux)), linear), 1e-9);
        const std::string convection =
            fmt::format("convection = {{ h = {{ formula = \"{}\", unit = \"W/(m^2 K)\" }}, ambient = \"302 K\" }}", k);
        EXPECT_LE(largest_error(layered(method, dimension, y, cold + section("b", "xmax", convection)), linear), 1e-9);
      }
    }
  }
}

TEST(WallLayers, ConductInSeriesWhereTheyLieAlongTheWall) {
  // y/1 + (1 - y)/10 m^2 K/W between 300 K below and 310 K on top, and 1/2 of a convection.
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    for (const double y : interfaces) {
      SCOPED_TRACE(fmt::format("{} {}", method, y));
      const std::string cold = section("a", "ymin", "temperature = \"300 K\"");
      for (const double h : {0.0, 2.0}) {
        const double q = 10 / (y + (1 - y) / 10 + (h > 0 ? 1 / h : 0));
        const auto exact = [=](const Vec3& x) { return 300 + q * (std::min(x.y, y) + std::max(x.y - y, 0.0) / 10); };
        const std::string warm =
            h > 0 ? "convection = { h = \"2 W/(m^2 K)\", ambient = \"310 K\" }" : "temperature = \"310 K\"";
        EXPECT_LE(largest_error(layered(method, 2, y, cold + section("b", "ymax", warm)), exact), 1e-8);
      }
    }
  }
}

TEST(WallLayers, RefuseAContactBetweenAWallAndItsPoints) {
  expect_refused(
      layered("sph", 2, 0.97, section("a", "ymin", "temperature = \"300 K\""), "10", "contact = \"5 W/(m^2 K)\"\n"),
      {"test.toml", "contact", "between a wall and the points", "at = \"walls\""});
}

TEST(WallLayersParallel, AreTheSameOnAnyNumberOfRanks) {
  const std::string text =
      layered("peridynamics", 2, 0.53,
              section("a", "xmin", "temperature = \"300 K\"") +
                  section("b", "ymax", "convection = { h = \"2 W/(m^2 K)\", ambient = \"310 K\" }"));
  const auto above = [](const Vec3&) { return 300; };
  EXPECT_NEAR(largest_error(text, above, MPI_COMM_WORLD), largest_error(text, above), 1e-9);
}

}  // namespace
}  // namespace calor
