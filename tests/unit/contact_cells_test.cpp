// Lattices of layers whose cells end at the contacts between them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "case_models.hpp"
#include "cloud/lattice.hpp"

namespace calor {
namespace {

std::string square(const std::string& method, const std::string& at, int points, double plane,
                   const std::string& rest) {
  return box_case({"1 m", "1 m"}, {points, points}, method) + fmt::format("at = \"{}\"\n", at) +
         simple_material({.name = "a", .k = "1"}) + simple_material({.name = "b", .k = "1"}) +
         fmt::format(
             "[body]\nalong = \"y\"\n[[body.layer]]\nmaterial = \"a\"\nthickness = \"{} m\"\n"
             "[[body.layer]]\nmaterial = \"b\"\nthickness = \"{} m\"\ncontact = \"4 W/(m^2 K)\"\n",
             plane, 1 - plane) +
         rest + "[steady]\n";
}

template <class Exact>
double rms_error(const std::string& text, const Exact& exact, MPI_Comm comm = MPI_COMM_SELF) {
  const CaseModel m(text, comm);
  State state = m.steady();
  const std::vector<double> T = m.system().temperatures(state.T);
  std::vector<double> squares, volumes;
  for (int i = 0; i < m.cloud().owned; ++i) {
    squares.push_back(m.cloud().volume[i] * std::pow(T[i] - exact(m.cloud().x[i]), 2));
    volumes.push_back(m.cloud().volume[i]);
  }
  return std::sqrt(sum(comm, squares) / sum(comm, volumes));
}

/// Both sides conduct cos(2x) times sinh and cosh of 2(y - plane); the temperature jumps by the flux over 4 W/(m^2 K).
/// Points on the contact belong to the lower side.
double error_of_jump(const std::string& method, const std::string& at, int points, double plane,
                     MPI_Comm comm = MPI_COMM_SELF) {
  constexpr double below = 0.3, above = 1, slope = 4 * (above - below) / 2;
  const std::string formula =
      fmt::format("300 + cos(2*x)*((y < {0} + 1e-9 ? {1} : {2})*cosh(2*(y-{0})) + {3}*sinh(2*(y-{0})))", plane, below,
                  above, slope);
  const std::string edge = fmt::format(
      "[boundary.edge]\non = [\"xmin\", \"xmax\", \"ymin\", \"ymax\"]\ntemperature = {{ formula = \"{}\", unit = \"K\" "
      "}}\n",
      formula);
  return rms_error(
      square(method, at, points, plane, edge),
      [=](const Vec3& x) {
        const double y = 2 * (x.y - plane);
        return 300 + std::cos(2 * x.x) * ((y < 2e-9 ? below : above) * std::cosh(y) + slope * std::sinh(y));
      },
      comm);
}

TEST(ContactCells, MakeContactsOfSecondOrderWhereverTheyLieInTheCells) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    for (const double off : {0.0, 0.02, 0.3, 0.45}) {  // spacings from a row of points, or from an end of cells
      for (const bool cells : {false, true}) {
        double error[3];
        for (int n = 0; n < 3; ++n)
          error[n] = error_of_jump(method, cells ? "cells" : "walls", (10 << n) + !cells, 0.5 + off / (10 << n));
        EXPECT_LE(error[2], 4e-4) << method << " " << off << " " << cells;
        EXPECT_GE(std::log2(error[0] / error[2]) / 2, 1.6) << method << " " << off << " " << cells;
      }
    }
  }
}

TEST(ContactCells, LetAllHeatOfALayerPassItsContact) {
  // 3 W/m^3 in the lower layer alone, cold on top: y >= plane sees 3 * plane W/m^2, wherever the contact lies in a
  // cell.
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    for (const char* at : {"walls", "cells"}) {
      for (const double plane : {0.5, 0.52, 0.57, 0.63}) {
        const std::string rest = fmt::format(
            "[source.heater]\npower_density = {{ formula = \"y < {} ? 3 : 0\", unit = \"W/m^3\" }}\n"
            "[boundary.top]\non = \"ymax\"\ntemperature = \"300 K\"\n",
            plane);
        const auto above = [=](const Vec3& x) { return 300 + 3 * plane * (1 - x.y); };
        const CaseModel m(square(method, at, 6, plane, rest));
        State state = m.steady();
        const std::vector<double> T = m.system().temperatures(state.T);
        const double tolerance = std::string(method) == "peridynamics" ? 2e-3 : 1e-8;
        for (int i = 0; i < m.cloud().owned; ++i) {
          const Vec3& x = m.cloud().x[i];
          if (!(x.y > plane + 1e-9)) continue;
          EXPECT_NEAR(T[i], above(x), tolerance) << method << " " << at << " " << plane;
        }
      }
    }
  }
}

TEST(ContactCells, EndTheCellsOfPointsBesideThem) {
  Lattice lattice({.dimension = 1, .size = {4}, .points = {5}});
  const std::vector<double> places = {1.2, 2, 3.4, 3.6};  // the last two lie in one interval, which stays
  lattice.end_cells_at(0, places);
  const double ends[] = {0, 0.5, 1.2, 2, 3.5, 4};
  for (int i = 0; i < 5; ++i) {
    EXPECT_DOUBLE_EQ(lattice.cell(0, i).first, ends[i]);
    EXPECT_DOUBLE_EQ(lattice.cell(0, i).second, ends[i + 1]);
    EXPECT_NEAR(lattice.width(0, i), ends[i + 1] - ends[i], 1e-15);
  }
}

TEST(ContactCellsParallel, AreTheSameOnAnyNumberOfRanks) {
  for (const char* at : {"cells", "walls"})
    EXPECT_NEAR(error_of_jump("peridynamics", at, 12, 0.53, MPI_COMM_WORLD),
                error_of_jump("peridynamics", at, 12, 0.53), 1e-8);
}

}  // namespace
}  // namespace calor
