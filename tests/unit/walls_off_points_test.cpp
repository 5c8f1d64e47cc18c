// Walls that lie off the points: what happens there reaches the points through the layer between.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "case_models.hpp"
#include "results.hpp"

namespace calor {
namespace {

constexpr double sigma = 5.670374419e-8;  // W/(m^2 K^4)

/// Cells of a bar, 2 m long, k = 3 W/(m K); `tail`: its conditions.
std::string bar(const std::string& method, int cells, const std::string& tail) {
  return box_case({"2 m"}, {cells}, method) + "at = \"cells\"\n" + simple_material({.k = "3"}) + tail + "[steady]\n";
}

/// Largest difference between the temperatures of the owned points and f.
template <class F>
double largest_error(const CaseModel& m, const State& state, const F& f) {
  double largest = 0;
  for (int i = 0; i < m.cloud().owned; ++i) largest = std::max(largest, std::abs(state.T[i] - f(m.cloud().x[i])));
  return largest;
}

class WallsOffPoints : public testing::TestWithParam<const char*> {};

TEST_P(WallsOffPoints, ConvectionOnBothSidesOfABarIsExact) {
  // 1/h + L/k + 1/h in series: q = 100 K / (1/5 + 2/3 + 1/20) (m^2 K/W).
  const double q = 100 / (1. / 5 + 2. / 3 + 1. / 20);
  const CaseModel m(bar(GetParam(), 7, R"toml(
[boundary.xmin]
convection = { h = "5 W/(m^2 K)", ambient = "400 K" }
[boundary.xmax]
convection = { h = "20 W/(m^2 K)", ambient = "300 K" }
)toml"));
  EXPECT_LT(largest_error(m, m.steady(), [&](const Vec3& x) { return 400 - q / 5 - q / 3 * x.x; }), 1e-8);
}

TEST_P(WallsOffPoints, SeveralFluxesOnOneWallSeeItsTemperature) {
  // At xmin convection, radiation and a flux; T at xmax fixes the heat: with the wall at 680 K,
  const double T_wall = 680, q = 7 * (600 - T_wall) + 0.8 * sigma * (std::pow(700, 4) - std::pow(T_wall, 4)) + 50;
  const CaseModel m(bar(GetParam(), 6,
                        fmt::format(R"toml(
[boundary.xmin]
convection = {{ h = "7 W/(m^2 K)", ambient = "600 K" }}
radiation = {{ emissivity = 0.8, ambient = "700 K" }}
[boundary.more]
on = "xmin"
flux = "50 W/m^2"
[boundary.xmax]
temperature = "{:.17g} K"
)toml",
                                    T_wall - q / 3 * 2)));
  EXPECT_LT(largest_error(m, m.steady(), [&](const Vec3& x) { return T_wall - q / 3 * x.x; }), 1e-7);
}

TEST_P(WallsOffPoints, LinearTemperaturesStayExactOnJitteredCells) {
  // T = 300 + 10 x + 20 y with convection from ambients that suit it.
  const CaseModel m(box_case({"1 m", "1 m"}, {8, 9}, GetParam()) + "at = \"cells\"\njitter = 0.3\n" +
                    simple_material({.k = "2"}) + R"toml(
[boundary.xmin]
convection = { h = "4 W/(m^2 K)", ambient = { formula = "300 + 20*y - 2*10/4", unit = "K" } }
[boundary.xmax]
convection = { h = "4 W/(m^2 K)", ambient = { formula = "310 + 20*y + 2*10/4", unit = "K" } }
[boundary.ymin]
convection = { h = "4 W/(m^2 K)", ambient = { formula = "300 + 10*x - 2*20/4", unit = "K" } }
[boundary.ymax]
convection = { h = "4 W/(m^2 K)", ambient = { formula = "320 + 10*x + 2*20/4", unit = "K" } }
[steady]
)toml");
  EXPECT_LT(largest_error(m, m.steady(), [](const Vec3& x) { return 300 + 10 * x.x + 20 * x.y; }), 1e-7);
}

TEST_P(WallsOffPoints, TransientsAreOfSecondOrder) {
  // A half-insulated slab under convection, Bi = h L / k = 5: T = 400 - 100 sum C cos(z x/L) exp(-z^2 Fo) (VDI heat
  // atlas, E2), z tan z = Bi.
  constexpr double Bi = 5, Fo = 0.3;
  const auto exact = [](double x) {
    double T = 400;
    for (int n = 0; n < 12; ++n) {
      double low = n * M_PI, high = low + M_PI / 2 - 1e-12;
      for (int k = 0; k < 200; ++k)
        (0.5 * (low + high) * std::tan(0.5 * (low + high)) < Bi ? low : high) = 0.5 * (low + high);
      T -= 100 * 4 * std::sin(low) / (2 * low + std::sin(2 * low)) * std::cos(low * x) * std::exp(-low * low * Fo);
    }
    return T;
  };
  std::vector<double> error;
  for (const int cells : {16, 32}) {
    const TemporaryFolder folder;
    run_into(folder.path(), box_case({"1 m"}, {cells}, GetParam()) + "at = \"cells\"\n" +
                                simple_material({.k = "1", .rho = "1", .c = "1"}) +
                                fmt::format(R"toml(
[boundary.xmax]
convection = {{ h = "5 W/(m^2 K)", ambient = "400 K" }}
[initial]
temperature = "300 K"
[time]
end = "{} s"
integrator = "tr-bdf2"
tolerance = "1e-5 K"
[output]
fields = false
samples = 1
[probe]
middle = "0.5 m"
wall = "1 m"
)toml",
                                            Fo));
    const std::string log = read_file(folder / "probes.csv");
    double t = 0, middle = 0, wall = 0;
    std::sscanf(log.substr(log.rfind('\n', log.size() - 2) + 1).c_str(), "%lf,%lf,%lf", &t, &middle, &wall);
    error.push_back(std::max(std::abs(middle - exact(0.5)), std::abs(wall - exact(1))));
  }
  EXPECT_GT(std::log2(error[0] / error[1]), 1.8) << error[0] << " " << error[1];
}

TEST_P(WallsOffPoints, HaveAnExactJacobian) {
  const CaseModel m(box_case({"1 m", "1 m"}, {4, 4}, GetParam()) + "at = \"cells\"\n" +
                    simple_material({.k = "1 + 0.01*T", .rho = "1", .c = "1"}) + R"toml(
[boundary.all]
on = ["xmin", "ymax"]
convection = { h = { formula = "5 + 0.02*T", unit = "W/(m^2 K)" }, ambient = "500 K" }
radiation = { emissivity = 0.5, ambient = "700 K" }
[boundary.other]
on = "xmax"
flux = { formula = "1000 - 2*T", unit = "W/m^2" }
[initial]
temperature = "400 K"
[time]
end = "1 s"
)toml");
  HeatSystem& system = m.system();
  std::vector<double> T = scattered_temperatures(m.cloud(), 400, 20);
  const petsc::Matrix J = system.create_jacobian();
  system.jacobian(0, T, 0, 1, J);
  for (int j = 0; j < m.cloud().owned; ++j) {
    const double step = 1e-3;
    std::vector<double> more = T, less = T;
    more[j] += step, less[j] -= step;
    const Rates up = m.rates(0, more), down = m.rates(0, less);
    for (int i = 0; i < m.cloud().owned; ++i) {
      double value = 0;
      const PetscInt row = i, column = j;
      MatGetValues(J, 1, &row, 1, &column, &value);
      EXPECT_NEAR(-value, (up.F[i] - down.F[i]) / (2 * step), 1e-5);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, WallsOffPoints, testing::Values("sph", "peridynamics"));

/// A square of 1 m, n x n points with pieces of surface on all sides; volumes times `scale`.
std::string square(int n, bool on_walls, double scale = 1, double sign = 1, int missing = -1) {
  std::string rows = "x [m];y [m];volume [m^3];area_x [m^2];area_y [m^2];face;area2_x [m^2];area2_y [m^2];face2\n";
  const double d = 1.0 / (on_walls ? n - 1 : n);
  const auto width = [&](int a) { return on_walls && (a == 0 || a == n - 1) ? 0.5 * d : d; };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const double shift = on_walls ? 0 : 0.5;
      rows += fmt::format("{:.17g};{:.17g};{:.17g}", (i + shift) * d, (j + shift) * d, scale * width(i) * width(j));
      int pieces = 0;
      const auto add = [&](double x, double y, const char* face) {
        if (j * n + i == missing) return;
        rows += fmt::format(";{:.17g};{:.17g};{}", sign * x, sign * y, face);
        ++pieces;
      };
      if (i == 0) add(-width(j), 0, "left");
      if (i == n - 1) add(width(j), 0, "right");
      if (j == 0) add(0, -width(i), "low");
      if (j == n - 1) add(0, width(i), "high");
      for (; pieces < 2; ++pieces) rows += ";;;";
      rows += "\n";
    }
  }
  return rows;
}

std::string csv_case(const std::string& method, const std::string& file, const std::string& tail) {
  return fmt::format("title = \"test\"\nmethod = \"{}\"\n[cloud]\nshape = \"csv\"\nfile = \"{}\"\n", method, file) +
         simple_material({.k = "2"}) + tail + "[steady]\n";
}

const std::string linear_in_x = R"toml(
[boundary.left]
temperature = "300 K"
[boundary.right]
convection = { h = "4 W/(m^2 K)", ambient = "400 K" }
)toml";

TEST(CsvWalls, TemperaturesAndFluxesActHalfACellAway) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    const TemporaryFolder folder;
    const CaseModel m(csv_case(method, folder.write("square.csv", square(9, false)), linear_in_x));
    EXPECT_FALSE(m.cloud().points_on_walls);
    EXPECT_EQ(m.cloud().dimension, 2);
    const double q = 100 / (1. / 2 + 1. / 4);
    State state = m.steady();
    const std::vector<double> T = m.system().temperatures(state.T);
    for (int i = 0; i < m.cloud().owned; ++i) EXPECT_NEAR(T[i], 300 + q / 2 * m.cloud().x[i].x, 1e-7) << method;
  }
}

TEST(CsvWalls, PointsOnWallsAreToldFromThoseBesideThem) {
  for (const double scale : {0.97, 1.0, 1.03}) {
    for (const bool on_walls : {false, true}) {
      const TemporaryFolder folder;
      const CaseModel m(csv_case("sph", folder.write("square.csv", square(15, on_walls, scale)), linear_in_x));
      EXPECT_EQ(m.cloud().points_on_walls, on_walls) << scale;
      const double d = 1.0 / (on_walls ? 14 : 15);
      for (const double spacing : m.cloud().spacing) EXPECT_NEAR(spacing, d, 0.02 * d);  // corners too
    }
  }
}

TEST(CsvWalls, WhatDoesNotFitTheSurfaceIsSaid) {
  const auto notes = [](const std::string& cloud) {
    const TemporaryFolder folder;
    const CaseModel m(csv_case("sph", folder.write("square.csv", cloud), linear_in_x));
    return fmt::format("{}", fmt::join(m.model().notes, "\n"));
  };
  for (const bool on_walls : {false, true}) {
    EXPECT_EQ(notes(square(11, on_walls)).find("surface"), std::string::npos);
    EXPECT_NE(notes(square(11, on_walls, 1.03)).find("the volumes of the points sum up to 1.03 m^3"),
              std::string::npos);
    EXPECT_NE(notes(square(11, on_walls, 1, 1, 55)).find("the surface does not close"), std::string::npos);
    const TemporaryFolder folder;
    expect_refused(csv_case("sph", folder.write("square.csv", square(11, on_walls, 1, -1)), linear_in_x),
                   {"the boundary areas point inwards", "change their signs"});
  }
}

}  // namespace
}  // namespace calor
