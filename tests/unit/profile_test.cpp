#include "base/profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/function.hpp"

namespace calor {
namespace {

double at(const Profile& profile, double coordinate) {
  double value;
  profile({&coordinate, 1}, {&value, 1});
  return value;
}

TEST(Profile, OfAPowerGoesFromTheFirstValueToTheLast) {
  const Profile p = power_profile({.from = 2, .to = 4}, 3, 10, 20);
  EXPECT_EQ(at(p, 2), 10);
  EXPECT_EQ(at(p, 4), 20);
  EXPECT_DOUBLE_EQ(at(p, 3), 10 + 10 * 0.125);
  EXPECT_EQ(at(p, 1), 10);  // outside the ends hold
  EXPECT_EQ(at(p, 5), 20);
}

TEST(Profile, MayRunAgainstItsCoordinate) {
  // 1 - (1 - eta)^M, the ceramic of a plate.
  const Profile p = power_profile({.from = 0.01, .to = 0}, 5, 1, 0);
  EXPECT_EQ(at(p, 0), 0);
  EXPECT_EQ(at(p, 0.01), 1);
  EXPECT_DOUBLE_EQ(at(p, 0.004), 1 - std::pow(0.6, 5));
}

TEST(Profile, ReachesItsEndsInSpiteOfRounding) {
  // s^0.01 is 0.69 at s = 1e-16.
  const Profile p = power_profile({.from = 0.01, .to = 0}, 0.01, 1, 0);
  EXPECT_EQ(at(p, std::nextafter(0.01, 0)), 1);
  EXPECT_EQ(at(p, std::nextafter(0.01, 1)), 1);
  EXPECT_EQ(at(p, 1e-18), 0);
}

TEST(Profile, OfAnExponentialIsAGeometricSeriesBetweenTwoValues) {
  // 2 (50/2)^s for the rate ln 25.
  const Profile p = exponential_profile({.from = 0, .to = 1}, std::log(25.0), 2, 50);
  EXPECT_DOUBLE_EQ(at(p, 0.5), 10);
  EXPECT_DOUBLE_EQ(at(p, 0), 2);
  EXPECT_DOUBLE_EQ(at(p, 1), 50);
}

TEST(Profile, OfAnExponentialTakesEveryRate) {
  const auto part = [](double rate, double s) { return at(exponential_profile({.from = 0, .to = 1}, rate, 0, 1), s); };
  EXPECT_EQ(part(0, 0.3), 0.3);
  EXPECT_NEAR(part(1e-9, 0.3), 0.3, 1e-9);
  EXPECT_DOUBLE_EQ(part(2, 0.3), (std::exp(0.6) - 1) / (std::exp(2.0) - 1));
  EXPECT_DOUBLE_EQ(part(-2, 0.3), (std::exp(-0.6) - 1) / (std::exp(-2.0) - 1));
  EXPECT_NEAR(part(1e5, 1 - 1e-5), std::exp(-1.0), 1e-11);  // e^1e5 overflows; 1 - s is rounded
  EXPECT_DOUBLE_EQ(part(-1e5, 1e-5), 1 - std::exp(-1.0));
  EXPECT_NEAR(part(3, 0.4) + part(-3, 0.6), 1, 1e-15);  // the same curve from its other end
}

TEST(Profile, OfAHumpIsHighestWhereItsPowersSay) {
  // A n^n z^z / (n + z)^(n + z) at s = n / (n + z).
  const Profile p = hump_profile({.from = 0, .to = 2}, 3, 2, 1);
  EXPECT_DOUBLE_EQ(at(p, 4.0 / 3), 3 * 4 / 27.0);
  EXPECT_LT(at(p, 1.3), 3 * 4 / 27.0);
  EXPECT_LT(at(p, 1.4), 3 * 4 / 27.0);
  EXPECT_EQ(at(p, 0), 0);
  EXPECT_EQ(at(p, 2), 0);
  EXPECT_EQ(at(p, 3), 0);
}

TEST(Profile, OfACoordinateIsAFunctionOfPlace) {
  const Function f = Function::of_coordinate('r', power_profile({.from = 0, .to = 10}, 2, 0, 1));
  EXPECT_TRUE(f.depends_on_place());
  EXPECT_FALSE(f.depends_on_time() || f.depends_on_temperature() || f.is_layered());
  EXPECT_DOUBLE_EQ(f({.x = 3, .y = 4, .z = 99}), 0.25);
  EXPECT_DOUBLE_EQ(Function::of_coordinate('z', power_profile({.from = 0, .to = 10}, 1, 0, 1))({.x = 3, .z = 4}), 0.4);
}

TEST(Profile, IsRefusedWhereItIsNotFinite) {
  const Function f = Function::of_coordinate(
      'x', power_profile({.from = 0, .to = 1}, 2, 0, std::numeric_limits<double>::infinity()), {"plate.toml", 7, 12});
  try {
    f({.x = 0.5});
    FAIL() << "an infinite value passed";
  } catch (const Error& e) {
    EXPECT_EQ(e.location().line, 7);
    EXPECT_NE(std::string(e.what()).find("the law along x is inf"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace calor
