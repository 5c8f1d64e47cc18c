// Cracks as cases have them, on points in the middle of cells and on points on the walls.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.hpp"
#include "case_models.hpp"

namespace calor {
namespace {

struct Square {
  std::string method, at;
  int points;
  std::string crack, boundary;
  int dimension = 2;
};

std::string text_of(const Square& s) {
  const std::vector<std::string> size(s.dimension, "1 m");
  return box_case(size, std::vector<int>(s.dimension, s.points), s.method) + fmt::format("at = \"{}\"\n", s.at) +
         "[[crack]]\n" + s.crack + simple_material({.k = "1"}) + s.boundary + "[steady]\n";
}

/// Largest and root mean square error of the steady temperatures.
template <class Exact>
std::array<double, 2> errors(const Square& s, const Exact& exact, MPI_Comm comm = MPI_COMM_SELF) {
  const CaseModel m(text_of(s), comm);
  State state = m.steady();
  const std::vector<double> T = m.system().temperatures(state.T);
  double largest = 0;
  std::vector<double> squares, volumes;
  for (int i = 0; i < m.cloud().owned; ++i) {
    const double error = T[i] - exact(m.cloud().x[i]);
    largest = std::max(largest, std::abs(error));
    squares.push_back(m.cloud().volume[i] * error * error), volumes.push_back(m.cloud().volume[i]);
  }
  return {max(comm, largest), std::sqrt(sum(comm, squares) / sum(comm, volumes))};
}

constexpr const char* robin_below = R"toml([boundary.a]
on = "ymin"
convection = { h = "2 W/(m^2 K)", ambient = "0 K" }
[boundary.b]
on = "ymax"
temperature = "1 K"
)toml";

TEST(CracksOfCases, LeaveHeatThatRunsAlongThemAlone) {
  // 1 K on top, 1/2 m^2 K/W and 0 K below: a cut along the way of the heat changes nothing. It ends facets and cells.
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    for (const char* at : {"cells", "walls"}) {
      Square s{method, at, 10, "x = [\"0.43 m\", \"0.43 m\"]\ny = [\"0 m\", \"1.1 m\"]\n", robin_below};
      const auto exact = [](const Vec3& x) { return (1 + 2 * x.y) / 3; };
      EXPECT_LE(errors(s, exact)[0], 1e-12) << method << " " << at;
      s.crack = R"toml(x = ["0.43 m", "0.43 m", "0.43 m", "0.43 m"]
y = ["0 m", "1.1 m", "1.1 m", "0 m"]
z = ["-0.1 m", "-0.1 m", "1 m", "1 m"]
)toml";
      s.dimension = 3, s.points = 6;
      EXPECT_LE(errors(s, exact)[0], 1e-12) << method << " " << at;
    }
  }
}

TEST(CracksOfCases, InContactLetTheTemperatureJumpOnCellsToo) {
  // Resistances in series, m^2 K/W: 1/2 of the convection, 1 of the body, 1/5 of the contact.
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    for (const char* at : {"cells", "walls"}) {
      const Square s{method, at, 10,
                     "x = [\"0 m\", \"1 m\"]\ny = [\"0.47 m\", \"0.47 m\"]\ncontact = \"5 W/(m^2 K)\"\n", robin_below};
      const auto exact = [](const Vec3& x) { return (0.5 + x.y + (x.y > 0.47 ? 0.2 : 0)) / 1.7; };
      EXPECT_LE(errors(s, exact)[0], 1e-12) << method << " " << at;
    }
  }
}

/// Cut in two, T = cos(2x) cosh(2(y - cut)) above and -1/2 of that below.
std::array<double, 2> errors_of_halves(const std::string& method, const std::string& at, int points, double cut,
                                       MPI_Comm comm = MPI_COMM_SELF) {
  const Square s{method, at, points, fmt::format("x = [\"-1 m\", \"2 m\"]\ny = [\"{0} m\", \"{0} m\"]\n", cut),
                 fmt::format("[boundary.edge]\non = [\"xmin\", \"xmax\", \"ymin\", \"ymax\"]\ntemperature = {{ formula "
                             "= \"cos(2*x)*cosh(2*(y-{0}))*(y > {0} - 1e-9 ? 1 : -0.5)\", unit = \"K\" }}\n",
                             cut)};
  return errors(
      s, [=](const Vec3& x) { return std::cos(2 * x.x) * std::cosh(2 * (x.y - cut)) * (x.y > cut - 1e-9 ? 1 : -0.5); },
      comm);
}

TEST(CracksOfCases, CutCellsIntoHalvesOfSecondOrder) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    for (const double off : {0.0, 0.02, 0.3, 0.5}) {  // spacings from where two rows of cells meet
      double rms[3];
      for (int n = 0; n < 3; ++n) rms[n] = errors_of_halves(method, "cells", 10 << n, 0.5 + off / (10 << n))[1];
      std::printf("%s, %.2f: %.2e %.2e %.2e\n", method, off, rms[0], rms[1], rms[2]);
      EXPECT_LE(rms[2], 3e-4) << method << " " << off;
      EXPECT_GE(std::log2(rms[0] / rms[2]) / 2, 1.6) << method << " " << off;
    }
  }
}

TEST(CracksOfCasesParallel, CutCellsAlikeOnAnyNumberOfRanks) {
  for (const char* at : {"cells", "walls"}) {
    const auto alone = errors_of_halves("sph", at, 12, 0.51),
               together = errors_of_halves("sph", at, 12, 0.51, MPI_COMM_WORLD);
    EXPECT_NEAR(together[0], alone[0], 1e-9);
    EXPECT_NEAR(together[1], alone[1], 1e-9);
  }
}

}  // namespace
}  // namespace calor
