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

TEST(TwinParallel, IsTheSameOnAnyNumberOfRanks) {
  // Adaptive steps follow the digits of the linear solver: results differ by a small part of their tolerance of 1e-3 K.
  const std::string text = plate(wavy, "sph", {11, 7});
  EXPECT_NEAR(error(text, MPI_COMM_WORLD), error(text), 1e-6);
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
}

}  // namespace
}  // namespace calor
