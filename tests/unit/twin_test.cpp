// The manufactured twin of a case.
#include "solve/twin.hpp"

#include <gtest/gtest.h>

#include "case_models.hpp"

namespace calor {
namespace {

/// A plate whose conductivity depends on place and temperature, with every kind of condition; `T` in K.
std::string plate(const std::string& T, const std::string& method, const std::vector<int>& points,
                  const std::string& time = "[time]\nend = \"5 s\"\ntolerance = \"1e-3 K\"\n") {
  const std::string formula = "{ formula = \"" + T + "\", unit = \"K\" }";
  return box_case({"1 m", "0.6 m"}, points, method) +
         simple_material({.k = "20 + 0.1*(T - 300) + 5*x", .rho = "10", .c = "10 + 0.02*T"}) + R"toml(
[initial]
temperature = "300 K"
[boundary.hot]
on = "xmin"
temperature = "400 K"
[boundary.air]
on = ["xmax", "ymax"]
convection = { h = "10 W/(m^2 K)", ambient = "300 K" }
[boundary.sky]
on = "ymax"
radiation = { emissivity = 0.8, ambient = "350 K" }
[source.lost]
power = "1 kW"
)toml" + time +
         "[twin]\ntemperature = " + formula +
         "\n[[expect]]\nfield = true\nnorm = \"rms\"\nwithin = \"1 K\"\nvalue = " + formula + "\n";
}

const std::string wavy = "350 + 40*cos(2*x + 0.3)*cos(2.5*y + 0.4)*(1 + 0.5*sin(0.03*t))";

double error(const std::string& text, MPI_Comm comm = MPI_COMM_SELF) {
  return run_into("", text, comm).verdicts.at(0).error;
}

TEST(Twin, ErrorsFallWithTheSquareOfTheSpacingByAllMethods) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    const double coarse = error(plate(wavy, method, {11, 7})), fine = error(plate(wavy, method, {21, 13}));
    EXPECT_GT(std::log2(coarse / fine), 1.7) << method << ": " << coarse << ", " << fine;
    EXPECT_LT(fine, 0.05) << method;
  }
}

TEST(Twin, AUniformTemperatureIsExact) {
  // Differences of the formula vanish, and conditions and prescribed temperatures are met: what is left is round-off.
  for (const char* method : {"sph", "peridynamics", "mlpg"})
    EXPECT_LT(error(plate("350", method, {11, 7}, "[steady]\n")), 1e-9) << method;
}

/// Two layers whose plane lies inside of cells, k = 2 and 20 W/(m K): the solution is smooth over the sum of x/k, so
/// that fluxes agree at the plane.
std::string layers(const std::string& method, const std::vector<int>& points) {
  const std::string along_y = "*cos(25*y + 0.4)";
  const std::string left = "350 + 40*cos(40*x + 0.3)" + along_y;
  const std::string right = "350 + 40*cos(40*0.037 + 4*(x - 0.037) + 0.3)" + along_y;
  const auto temperature = [](const std::string& T) { return "{ formula = \"" + T + "\", unit = \"K\" }"; };
  const std::string both = temperature("x < 0.037 ? " + left + " : (" + right + ")");
  return box_case({"0.1 m", "0.06 m"}, points, method) + R"toml(
[material.a]
conductivity = "2 W/(m K)"
[material.b]
conductivity = "20 W/(m K)"
[body]
along = "x"
[[body.layer]]
material = "a"
thickness = "37 mm"
[[body.layer]]
material = "b"
thickness = "63 mm"
[boundary.hot]
on = "xmin"
temperature = "400 K"
[boundary.air]
on = ["xmax", "ymax"]
convection = { h = "50 W/(m^2 K)", ambient = "300 K" }
[steady]
[twin]
temperature = )toml" +
         both + "\n[[twin.part]]\ntemperature = " + temperature(left) +
         "\n[[twin.part]]\ntemperature = " + temperature(right) +
         "\n[[expect]]\nfield = true\nnorm = \"rms\"\nwithin = \"1 K\"\nvalue = " + both + "\n";
}

TEST(Twin, OfLayersConvergesWithTheSquareOfTheSpacing) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    const double coarse = error(layers(method, {21, 13})), fine = error(layers(method, {81, 49}));
    EXPECT_GT(0.5 * std::log2(coarse / fine), 1.8) << method << ": " << coarse << ", " << fine;
  }
}

TEST(TwinParallel, OfLayersIsTheSameOnAnyNumberOfRanks) {
  const std::string text = layers("sph", {11, 7});
  EXPECT_NEAR(error(text, MPI_COMM_WORLD), error(text), 1e-8);
}

TEST(TwinParallel, IsTheSameOnAnyNumberOfRanks) {
  // Adaptive steps follow the digits of the linear solver: results differ by a small part of their tolerance of 1e-3 K.
  const std::string text = plate(wavy, "sph", {11, 7});
  EXPECT_NEAR(error(text, MPI_COMM_WORLD), error(text), 1e-6);
}

/// A crack between the rows of points, with a solution that is level across its line.
std::string cracked(const std::vector<int>& points, const std::string& method,
                    const std::string& T = "350 + 100*(y - 0.31)^2*cos(2*x + 0.3)") {
  return plate(T, method, points, "[steady]\n[[crack]]\nx = [\"0.33 m\", \"0.68 m\"]\ny = [\"0.31 m\", \"0.31 m\"]\n");
}

TEST(Twin, OfACrackedBodyConverges) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    const double coarse = error(cracked({21, 13}, method)), fine = error(cracked({81, 49}, method));
    EXPECT_GT(0.5 * std::log2(coarse / fine), 1.5) << method << ": " << coarse << ", " << fine;
  }
}

TEST(TwinParallel, OfACrackedBodyIsTheSameOnAnyNumberOfRanks) {
  EXPECT_NEAR(error(cracked({11, 7}, "sph"), MPI_COMM_WORLD), error(cracked({11, 7}, "sph")), 1e-8);
}

/// Across and along the fibres 2 and 20 W/(m K).
std::string fibres(const std::string& method, const std::vector<int>& points, const std::string& anisotropy) {
  const std::string T = "{ formula = \"350 + 40*cos(2*x + 0.3)*cos(2.5*y + 0.4)\", unit = \"K\" }";
  return box_case({"1 m", "0.6 m"}, points, method) +
         "[material.fibres]\nconductivity = \"2 W/(m K)\"\nanisotropy = " + anisotropy + R"toml(
[boundary.hot]
on = "xmin"
temperature = "400 K"
[boundary.air]
on = ["xmax", "ymax"]
convection = { h = "10 W/(m^2 K)", ambient = "300 K" }
[steady]
[twin]
temperature = )toml" +
         T + "\n[[expect]]\nfield = true\nnorm = \"rms\"\nwithin = \"1 K\"\nvalue = " + T + "\n";
}

TEST(Twin, OfAnAnisotropicBodyConverges) {
  for (const char* method : {"sph", "peridynamics", "mlpg"})
    for (const char* anisotropy : {"{ x = 10 }", "{ x = 10, turn = \"30 deg\" }"}) {
      const double coarse = error(fibres(method, {11, 7}, anisotropy)),
                   fine = error(fibres(method, {31, 19}, anisotropy));
      EXPECT_GT(std::log(coarse / fine) / std::log(3), 1.6)
          << method << " " << anisotropy << ": " << coarse << ", " << fine;
    }
}

TEST(TwinParallel, OfAnAnisotropicBodyIsTheSameOnAnyNumberOfRanks) {
  const std::string text = fibres("sph", {11, 7}, "{ x = 10, turn = \"30 deg\" }");
  EXPECT_NEAR(error(text, MPI_COMM_WORLD), error(text), 1e-8);
}

TEST(Twin, WhatHasNoneIsRefused) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& words) {
    expect_refused(text, words);
  };
  refused(plate("300 + abs(x)", "sph", {11, 7}), {"may jump or bend"});
  refused(plate("300 + T", "sph", {11, 7}), {"depends on T"});
  refused(plate(wavy, "sph", {11, 7}, "[steady]\n"), {"depends on t"});
  refused(replaced(plate("300 + x", "sph", {11, 7}), "points = [11, 7]", "points = [11, 7]\nat = \"cells\""),
          {"off its walls"});
  refused(cracked({11, 7}, "sph", "300 + 10*y"), {"its heat would cross the crack", "0.31, 0) m"});
  const std::string two = layers("sph", {11, 7});
  const auto first = two.find("[[twin.part]]"), second = two.find("[[twin.part]]", first + 1);
  refused(two.substr(0, first) + two.substr(second), {"1 solutions for 2 parts", "[[twin.part]]"});
  const std::string graded = box_case({"1 m"}, {11}, "sph") + R"toml(
[material.m]
conductivity = { layers = [1, 2], along = "x", thickness = "0.5 m", start = "0 m", unit = "W/(m K)" }
[body]
material = "m"
conductivity_mean = "arithmetic"
[boundary.cold]
on = "xmin"
temperature = "300 K"
[steady]
[twin]
temperature = { formula = "300 + x", unit = "K" }
)toml";
  refused(graded, {"jumps between layers of one material", "[[body.layer]]"});
}

}  // namespace
}  // namespace calor
