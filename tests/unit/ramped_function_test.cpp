#include "base/ramped_function.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace calor {
namespace {

RampedFunction ramped(const std::string& expression) {
  return RampedFunction(Function::formula(expression, {.value = "W/m^2", .si = "W/m^2"}));
}

struct Point {
  double value, slope;
};
Point at(const RampedFunction& f, double T) {
  const std::vector<Vec3> x(1);
  Point p{};
  f.evaluate({.x = x, .T = {&T, 1}}, {&p.value, 1});
  f.derivative({.x = x, .T = {&T, 1}}, {&p.slope, 1});
  return p;
}

TEST(RampedFunction, GoesOverAJumpInAHundredthOfAKelvin) {
  // The jump at 300.004 K lies in the interval from 300.00 K to 300.01 K.
  const RampedFunction f = ramped("T < 300.004 ? 1000 : -200");
  for (const double T : {299.0, 299.9, 299.9999}) {
    EXPECT_EQ(at(f, T).value, 1000) << T;
    EXPECT_EQ(at(f, T).slope, 0) << T;
  }
  for (const double T : {300.0101, 300.1, 301.0}) {
    EXPECT_EQ(at(f, T).value, -200) << T;
    EXPECT_EQ(at(f, T).slope, 0) << T;
  }
  for (const double part : {0.1, 0.5, 0.9}) {
    EXPECT_NEAR(at(f, 300 + 0.01 * part).value, 1000 - 1200 * part, 1e-6);
    EXPECT_NEAR(at(f, 300 + 0.01 * part).slope, -1.2e5, 1e-3);
  }
}

TEST(RampedFunction, LeavesBendsAndSmoothFunctionsAsTheyAre) {
  for (const char* expression : {"20 - 0.1*T", "exp(T/100)", "max(T - 300, 0)", "abs(T - 300.003)", "5"}) {
    const RampedFunction f = ramped(expression);
    const Function whole = Function::formula(expression, {.value = "W/m^2", .si = "W/m^2"});
    for (const double T : {250.0, 299.999, 300.001, 300.004, 300.02, 451.77}) {
      EXPECT_EQ(at(f, T).value, whole({}, 0, T)) << expression << " " << T;
    }
    const double expected = (whole({}, 0, 351) - whole({}, 0, 349)) / 2;
    EXPECT_NEAR(at(f, 350).slope, expected, 1e-4 * std::abs(expected)) << expression;
  }
}

TEST(RampedFunction, LeavesJumpsFromPlaceToPlaceAsTheyAre) {
  const RampedFunction f = ramped("x < 1 ? 10 : 20");
  const std::vector<Vec3> x{{0.5, 0, 0}, {1.5, 0, 0}};
  std::vector<double> out(2);
  f.evaluate({.x = x}, out);
  EXPECT_EQ(out, (std::vector<double>{10, 20}));
}

}  // namespace
}  // namespace calor
