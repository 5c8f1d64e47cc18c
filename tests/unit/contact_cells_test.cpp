// Cells that end at contacts between parts: boxes in lattices of layers, elsewhere what is nearest on the same side.
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

std::string square(const std::string& method, const std::string& at, int points, double plane, const std::string& rest,
                   const std::string& jitter = "") {
  return box_case({"1 m", "1 m"}, {points, points}, method) + fmt::format("at = \"{}\"\n{}", at, jitter) +
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
                     MPI_Comm comm = MPI_COMM_SELF, const std::string& jitter = "") {
  constexpr double below = 0.3, above = 1, slope = 4 * (above - below) / 2;
  const std::string formula =
      fmt::format("300 + cos(2*x)*((y < {0} + 1e-9 ? {1} : {2})*cosh(2*(y-{0})) + {3}*sinh(2*(y-{0})))", plane, below,
                  above, slope);
  const std::string edge = fmt::format(
      "[boundary.edge]\non = [\"xmin\", \"xmax\", \"ymin\", \"ymax\"]\ntemperature = {{ formula = \"{}\", unit = \"K\" "
      "}}\n",
      formula);
  return rms_error(
      square(method, at, points, plane, edge, jitter),
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

/// Rings in each other (along x = r) or on each other (along y) of 1 W/(m K), with a contact between: T = r^2 - 2 y^2,
/// which jumps by the flux over 4 W/(m^2 K).
double error_of_rings(const std::string& method, const std::string& along, int points, double plane,
                      MPI_Comm comm = MPI_COMM_SELF) {
  const double flux = along == "x" ? 2 * plane : -4 * plane, jump = flux / 4;
  const std::string formula = fmt::format("300 + x^2 - 2*y^2 + ({} < {} + 1e-9 ? 0 : {})", along, plane, jump);
  const double start = along == "x" ? 0.5 : 0.3;
  const std::string text =
      box_case({"1 m", "1 m"}, {points, points}, method) + "axisymmetric = true\norigin = [\"0.5 m\", \"0.3 m\"]\n" +
      simple_material({.name = "a", .k = "1"}) + simple_material({.name = "b", .k = "1"}) +
      fmt::format(
          "[body]\nalong = \"{}\"\n[[body.layer]]\nmaterial = \"a\"\nthickness = \"{} m\"\n"
          "[[body.layer]]\nmaterial = \"b\"\nthickness = \"{} m\"\ncontact = \"4 W/(m^2 K)\"\n"
          "[boundary.edge]\non = [\"xmin\", \"xmax\", \"ymin\", \"ymax\"]\ntemperature = {{ formula = \"{}\", "
          "unit = \"K\" }}\n[steady]\n",
          along, plane - start, 1 - (plane - start), formula);
  return rms_error(
      text,
      [=](const Vec3& x) {
        const double s = along == "x" ? x.x : x.y;
        return 300 + x.x * x.x - 2 * x.y * x.y + (s < plane + 1e-9 ? 0 : jump);
      },
      comm);
}

TEST(ContactCells, MakeContactsInAxisymmetricBodiesOfSecondOrder) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    for (const char* along : {"x", "y"}) {
      for (const double off : {0.0, 0.02, 0.3, 0.45}) {
        const double start = along[0] == 'x' ? 0.5 : 0.3;
        double error[3];
        for (int n = 0; n < 3; ++n)
          error[n] = error_of_rings(method, along, (10 << n) + 1, start + 0.5 + off / (10 << n));
        EXPECT_LE(error[2], 4e-4) << method << " " << along << " " << off;
        EXPECT_GE(std::log2(error[0] / error[2]) / 2, 1.6) << method << " " << along << " " << off;
      }
    }
  }
}

TEST(ContactCells, MakeContactsOfSecondOrderOnJitteredClouds) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    double coarse = 0, fine = 0;
    for (const char* jitter : {"jitter = 0.2\nseed = 1\n", "jitter = 0.2\nseed = 2\n", "jitter = 0.2\nseed = 3\n"}) {
      coarse += error_of_jump(method, "walls", 10, 0.5, MPI_COMM_SELF, jitter) / 3;
      fine += error_of_jump(method, "walls", 28, 0.5, MPI_COMM_SELF, jitter) / 3;
    }
    EXPECT_GE(std::log(coarse / fine) / std::log(3), 1.7) << method;
    EXPECT_LE(fine, 1e-3) << method;
  }
}

/// The same by a contact in a crack, with the conductance h; far from 4 W/(m^2 K) the temperatures are those of a body
/// that conducts all the better or worse there.
double error_of_contact_in_crack(const std::string& method, int points, double h, const std::string& jitter) {
  constexpr double below = 0.3;
  const double plane = 0.5 + 0.25 / (points - 1), slope = h < 1 ? 1e-9 : 1, above = below + 2 * slope / h;
  const std::string formula = fmt::format(
      "300 + cos(2*x)*((y < {0} ? {1} : {2})*cosh(2*(y-{0})) + {3}*sinh(2*(y-{0})))", plane, below, above, slope);
  const std::string text =
      box_case({"1 m", "1 m"}, {points, points}, method) + jitter + simple_material({.name = "a", .k = "1"}) +
      fmt::format("[[crack]]\nx = [\"-0.2 m\", \"1.2 m\"]\ny = [\"{0} m\", \"{0} m\"]\ncontact = \"{1} W/(m^2 K)\"\n",
                  plane, h) +
      fmt::format(
          "[boundary.edge]\non = [\"xmin\", \"xmax\", \"ymin\", \"ymax\"]\ntemperature = {{ formula = \"{}\", "
          "unit = \"K\" }}\n[steady]\n",
          formula);
  return rms_error(text, [=](const Vec3& x) {
    const double y = 2 * (x.y - plane);
    return 300 + std::cos(2 * x.x) * ((y < 0 ? below : above) * std::cosh(y) + slope * std::sinh(y));
  });
}

TEST(ContactCells, MakeContactsInCracksOfSecondOrderHoweverWellTheyConduct) {
  for (const char* method : {"sph", "peridynamics"}) {
    for (const double h : {0.1, 4.0, 1e5}) {
      const double coarse = error_of_contact_in_crack(method, 11, h, ""),
                   fine = error_of_contact_in_crack(method, 31, h, "");
      EXPECT_GE(std::log(coarse / fine) / std::log(3), 1.6) << method << " " << h;
      EXPECT_LE(fine, h < 1 ? 5e-3 : 1e-3) << method << " " << h;
    }
  }
}

/// A round region of 5 W/(m K) with 4 W/m^3 in it or everywhere, in a square of 1 W/(m K) with the exact temperatures
/// on its walls: T = -r^2 or -2 R^2 log r outside, a jump of 2 R / h, and from there (R^2 - r^2)/5 inside.
double error_of_round_region(const std::string& method, int points, bool heated_alone, MPI_Comm comm = MPI_COMM_SELF) {
  constexpr double R = 0.52, h = 2;
  const auto outside = [=](double square) { return heated_alone ? -R * R * std::log(square) : -square; };
  const std::string formula = heated_alone ? fmt::format("300 - {}*log(x^2 + y^2)", R * R) : "300 - x^2 - y^2";
  const std::string region = fmt::format("x^2 + y^2 < {}", R * R);
  const std::string text =
      box_case({"2 m", "2 m"}, {points, points}, method) + "origin = [\"-1 m\", \"-1 m\"]\n" +
      simple_material({.name = "square", .k = "1"}) + simple_material({.name = "core", .k = "5"}) +
      fmt::format(
          "[body]\nmaterial = \"square\"\n[[body.region]]\nmaterial = \"core\"\nwhere = \"{}\"\n"
          "contact = \"{} W/(m^2 K)\"\n",
          region, h) +
      fmt::format("[source.heater]\npower_density = {{ formula = \"{}\", unit = \"W/m^3\" }}\n",
                  heated_alone ? region + " ? 4 : 0" : "4") +
      fmt::format(
          "[boundary.edge]\non = [\"xmin\", \"xmax\", \"ymin\", \"ymax\"]\ntemperature = {{ formula = "
          "\"{}\", unit = \"K\" }}\n[steady]\n",
          formula);
  return rms_error(
      text,
      [=](const Vec3& x) {
        const double square = dot(x, x);
        return 300 + (square < R * R ? outside(R * R) + 2 * R / h + (R * R - square) / 5 : outside(square));
      },
      comm);
}

TEST(ContactCells, MakeContactsAroundRoundRegionsOfSecondOrder) {
  for (const bool heated_alone : {false, true}) {  // mlpg takes the weights of sph here
    const std::string method = heated_alone ? "sph" : "peridynamics";
    const double coarse = error_of_round_region(method, 21, heated_alone);
    const double fine = error_of_round_region(method, 41, heated_alone);
    EXPECT_GE(std::log2(coarse / fine), 1.7) << method;
    EXPECT_LE(fine, 2e-3) << method;
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
  EXPECT_NEAR(error_of_round_region("sph", 13, true, MPI_COMM_WORLD), error_of_round_region("sph", 13, true), 1e-8);
  EXPECT_NEAR(error_of_jump("sph", "walls", 12, 0.5, MPI_COMM_WORLD, "jitter = 0.2\n"),
              error_of_jump("sph", "walls", 12, 0.5, MPI_COMM_SELF, "jitter = 0.2\n"), 1e-8);
  for (const char* at : {"cells", "walls"})
    EXPECT_NEAR(error_of_jump("peridynamics", at, 12, 0.53, MPI_COMM_WORLD),
                error_of_jump("peridynamics", at, 12, 0.53), 1e-8);
  EXPECT_NEAR(error_of_rings("mlpg", "x", 12, 1.03, MPI_COMM_WORLD), error_of_rings("mlpg", "x", 12, 1.03), 1e-8);
}

}  // namespace
}  // namespace calor
