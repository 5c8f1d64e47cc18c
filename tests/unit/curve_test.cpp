#include "base/curve.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "base/error.hpp"

namespace calor {
namespace {

std::vector<double> even(double lo, double hi, int n) {
  std::vector<double> x(n);
  for (int i = 0; i < n; ++i) x[i] = lo + (hi - lo) * i / (n - 1);
  return x;
}

double largest_difference(const Curve& curve, double (*f)(double), double lo, double hi) {
  double worst = 0;
  for (const double x : even(lo, hi, 40'001)) worst = std::max(worst, std::abs(curve.value(x) - f(x)));
  return worst;
}

TEST(Curve, OfAConstantHasSlopeZeroAndALinearIntegral) {
  const Curve c = Curve::constant(3);
  EXPECT_TRUE(c.is_constant());
  EXPECT_EQ(c.value(-7), 3);
  EXPECT_EQ(c.derivative(1), 0);
  EXPECT_EQ(c.integral(2), 6);
  EXPECT_TRUE(Curve().is_constant());
  EXPECT_EQ(Curve().value(1), 0);
}

TEST(Curve, ThroughPointsIsLinearBetweenThemAndConstantOutside) {
  const Curve c = Curve::through({1, 2, 4}, {10, 20, 0}, Interpolation::linear);
  EXPECT_FALSE(c.is_constant());
  EXPECT_EQ(c.value(0), 10);
  EXPECT_EQ(c.value(1.5), 15);
  EXPECT_EQ(c.value(2), 20);
  EXPECT_EQ(c.value(3), 10);
  EXPECT_EQ(c.value(4), 0);
  EXPECT_EQ(c.value(9), 0);
  EXPECT_EQ(c.derivative(0.5), 0);
  EXPECT_EQ(c.derivative(1.5), 10);
  EXPECT_EQ(c.derivative(3), -10);
  EXPECT_EQ(c.derivative(5), 0);
  // Areas by hand: 10 to x = 1, then trapezia of 15 and 20.
  EXPECT_EQ(c.integral(-1), -10);
  EXPECT_EQ(c.integral(0), 0);
  EXPECT_EQ(c.integral(1), 10);
  EXPECT_EQ(c.integral(2), 25);
  EXPECT_EQ(c.integral(4), 45);
  EXPECT_EQ(c.integral(9), 45);
}

TEST(Curve, StartsItsIntegralAtZeroWhereverItsPointsLie) {
  for (const auto& x : {std::vector{-3., -2., -1.}, {-1., 0.5, 1.}, {2., 3., 5.}}) {
    for (const Interpolation how : {Interpolation::linear, Interpolation::cubic}) {
      const Curve c = Curve::through(x, {4, 1, 2}, how);
      EXPECT_NEAR(c.integral(0), 0, 1e-15);
      EXPECT_NEAR(c.integral(1e-6), 1e-6 * c.value(0.5e-6), 1e-14);
    }
  }
}

TEST(Curve, HasKinksWhereItsSlopeJumps) {
  EXPECT_EQ(Curve::through({0, 1, 2, 3}, {0, 0, 5, 10}, Interpolation::linear).kinks(), (std::vector{1., 3.}));
  EXPECT_EQ(Curve::through({0, 1, 2}, {1, 2, 3}, Interpolation::linear).kinks(), (std::vector{0., 2.}));
  EXPECT_TRUE(Curve::through({0, 1, 2, 3}, {1, 1, 2, 2}, Interpolation::cubic).kinks().empty());
  EXPECT_TRUE(Curve::sampled([](double x) { return x * x; }, 0, 1).kinks().empty());
}

constexpr double infinite = std::numeric_limits<double>::infinity();

TEST(Curve, IsKnownAsFarAsItsRowsGoAndOnWhereItEndsLevel) {
  const auto reach = [](const Curve& c) { return std::pair(c.reach().low, c.reach().high); };
  EXPECT_EQ(reach(Curve::through({1, 2, 3}, {0, 1, 4}, Interpolation::linear)), std::pair(1., 3.));
  EXPECT_EQ(reach(Curve::through({1, 2, 3}, {0, 0, 5}, Interpolation::linear)), std::pair(-infinite, 3.));
  EXPECT_EQ(reach(Curve::through({1, 2, 3}, {0, 5, 5}, Interpolation::linear)), std::pair(1., infinite));
  EXPECT_EQ(reach(Curve::constant(2)), std::pair(-infinite, infinite));
  EXPECT_EQ(reach(Curve::sampled([](double x) { return x; }, 0, 1)), std::pair(-infinite, infinite));
}

TEST(Curve, RefusesTablesThatAreNone) {
  EXPECT_THROW(Curve::through({1}, {1}, Interpolation::linear), std::invalid_argument);
  EXPECT_THROW(Curve::through({1, 1}, {1, 2}, Interpolation::linear), std::invalid_argument);
  EXPECT_THROW(Curve::through({2, 1}, {1, 2}, Interpolation::linear), std::invalid_argument);
  EXPECT_THROW(Curve::through({1, 2}, {1}, Interpolation::linear), std::invalid_argument);
  EXPECT_THROW(Curve::through({1, 2}, {1, NAN}, Interpolation::linear), std::invalid_argument);
}

/// A table with uneven steps, as rapidcheck makes them.
std::pair<std::vector<double>, std::vector<double>> table(bool monotone) {
  const int n = *rc::gen::inRange(2, 40);
  std::vector<double> x, y;
  double at = *rc::gen::inRange(-1000, 1000), value = *rc::gen::inRange(-50, 50);
  for (int i = 0; i < n; ++i) {
    x.push_back(at);
    y.push_back(value);
    at += std::pow(10, *rc::gen::inRange(-2, 3));
    value += *rc::gen::inRange(monotone ? 0 : -50, 50);
  }
  return {x, y};
}

RC_GTEST_PROP(Curve, PassesThroughItsPoints, ()) {
  const auto [x, y] = table(false);
  for (const Interpolation how : {Interpolation::linear, Interpolation::cubic}) {
    const Curve c = Curve::through(x, y, how);
    for (std::size_t i = 0; i < x.size(); ++i) RC_ASSERT(c.value(x[i]) == y[i]);
  }
}

RC_GTEST_PROP(Curve, StaysMonotoneBetweenMonotonePoints, ()) {
  const auto [x, y] = table(true);
  const Curve c = Curve::through(x, y, Interpolation::cubic);
  const double rounding = 1e-12 * (1 + std::abs(y.front()) + std::abs(y.back()));
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    double before = y[i];
    for (const double at : even(x[i], x[i + 1], 33)) {
      const double value = c.value(at);
      RC_ASSERT(value >= before - rounding);
      RC_ASSERT(value <= y[i + 1] + rounding);
      before = value;
    }
  }
}

RC_GTEST_PROP(Curve, HasAnIntegralWithItsValueAsSlope, ()) {
  const auto [x, y] = table(false);
  for (const Interpolation how : {Interpolation::linear, Interpolation::cubic}) {
    const Curve c = Curve::through(x, y, how);
    const double lo = x.front() - 1, hi = x.back() + 1;
    // Simpson's rule is exact for cubics between the knots.
    std::vector<double> knots = x;
    knots.insert(knots.begin(), lo);
    knots.push_back(hi);
    double area = 0;
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
      const double a = knots[i], b = knots[i + 1];
      area += (b - a) / 6 * (c.value(a) + 4 * c.value((a + b) / 2) + c.value(b));
    }
    const double scale = 1000 * (hi - lo + std::abs(lo)) + 1;
    RC_ASSERT(std::abs(c.integral(hi) - c.integral(lo) - area) < 1e-12 * scale);
  }
}

TEST(Curve, OfMonotonePointsConvergesWithThirdOrderOrBetter) {
  const auto error = [](int n) {
    const std::vector<double> x = even(0, 1, n);
    std::vector<double> y;
    for (const double xi : x) y.push_back(std::exp(2 * xi));
    return largest_difference(
        Curve::through(x, y, Interpolation::cubic), [](double s) { return std::exp(2 * s); }, 0, 1);
  };
  EXPECT_GT(error(11) / error(21), 6);  // 8 for third order: slopes of parabolas
  EXPECT_GT(error(21) / error(41), 6);
}

TEST(SampledCurve, IsWithinItsAccuracyOfTheFunction) {
  const auto exponential = [](double x) { return std::exp(4 * x); };
  const auto arrhenius = [](double T) { return 20 + 1e4 / T + 1e-5 * T * T; };
  EXPECT_LT(largest_difference(Curve::sampled(exponential, 0, 1), exponential, 0, 1), 1e-11 * std::exp(4));
  EXPECT_LT(largest_difference(Curve::sampled(arrhenius, 300, 1500), arrhenius, 300, 1500), 1e-11 * arrhenius(300));
}

TEST(SampledCurve, HasTheDerivativeAndTheIntegralOfTheFunction) {
  const Curve c = Curve::sampled([](double x) { return std::exp(4 * x); }, 0, 1);
  for (const double x : even(0, 1, 1001)) {
    EXPECT_NEAR(c.derivative(x), 4 * std::exp(4 * x), 1e-6);
    EXPECT_NEAR(c.integral(x) - c.integral(0.25), (std::exp(4 * x) - std::exp(1)) / 4, 1e-11 * std::exp(4));
  }
}

TEST(SampledCurve, IsExactForCubics) {
  const Curve c = Curve::sampled([](double x) { return 1 + x * (2 - x * (3 - x)); }, -2, 2);
  for (const double x : even(-3, 3, 101)) EXPECT_NEAR(c.value(x), 1 + x * (2 - x * (3 - x)), 1e-13);
}

TEST(SampledCurve, GivesTheSameBitsInWhateverOrderItIsAsked) {
  const auto make = [] { return Curve::sampled([](double x) { return std::exp(x / 3) * std::sin(x); }, 1, 2); };
  std::vector<double> x = even(-5, 9, 2001);
  const Curve forward = make(), shuffled = make();
  std::vector<double> values(x.size()), integrals(x.size());
  forward.values(x, values);
  forward.integrals(x, integrals);
  std::vector<std::size_t> order(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937_64(1));
  for (const std::size_t i : order) {
    EXPECT_EQ(shuffled.value(x[i]), values[i]);
    EXPECT_EQ(shuffled.integral(x[i]), integrals[i]);
  }
}

TEST(SampledCurve, AsksTheFunctionOnlyWhereItIsNeeded) {
  const Curve c = Curve::sampled([](double x) { return x * std::sqrt(x); }, 0, 1);  // not defined below zero
  EXPECT_NEAR(c.value(0), 0, 1e-12);
  EXPECT_NEAR(c.value(0.25), 0.125, 1e-9);
  EXPECT_THROW(c.value(-1), Error);
}

TEST(SampledCurve, IsExactOnBothSidesOfAJumpAndInItsIntegral) {
  const Curve c = Curve::sampled([](double x) { return x < 0.3 ? 1. : 2.; }, 0, 1);
  EXPECT_EQ(c.value(0.2999), 1);
  EXPECT_EQ(c.value(0.3001), 2);
  EXPECT_NEAR(c.integral(1) - c.integral(0), 1.7, 1e-11);
  // On a knot, beside one, anywhere; upwards, downwards; in the range that is sampled first and out of it.
  for (const double place : {310., 310.001, 309.996, 311.3, 299.99999, 1000. / 3, 700., 250.1}) {
    for (const double high : {400., 0.04}) {
      const Curve k = Curve::sampled([=](double T) { return T < place ? 4 : high; }, 300, 350);
      for (const double d : {0.0051, 0.02, 0.3, 40.}) {
        EXPECT_NEAR(k.value(place - d), 4, 1e-12) << place;
        EXPECT_NEAR(k.value(place + d), high, 1e-12) << place;
        EXPECT_NEAR(k.integral(place + d) - k.integral(place - d), d * (4 + high), 1e-9) << place << ' ' << d;
      }
      for (const double x : even(place - 1, place + 1, 20'001)) {
        EXPECT_GE(k.value(x), std::min(4., high) * (1 - 1e-12));
        EXPECT_LE(k.value(x), std::max(4., high) * (1 + 1e-12));
      }
    }
  }
}

TEST(SampledCurve, HoldsTheHeatOfABoxHoweverNarrowDownToASixteenthOfAKelvin) {
  for (const double width : {0.0626, 0.1, 0.5, 1., 10.}) {
    for (const double middle : {350., 800., 801.37, 1999.999, 250.}) {
      const auto law = [=](double T) { return 500 + (std::abs(T - middle) < width / 2 ? 2e5 / width : 0.01 * T); };
      const Curve c = Curve::sampled(law, 300, 2000);
      const double low = 200, high = 2100;
      const double box = 2e5 - 0.01 * middle * width;  // above the line
      EXPECT_NEAR(c.integral(high) - c.integral(low), 500 * 1900 + 0.005 * (high * high - low * low) + box, 1e-4)
          << width << " K about " << middle;
    }
  }
}

TEST(SampledCurve, FollowsKinksClosely) {
  const auto law = [](double T) { return 40 + std::abs(T - 777.7) / 10; };
  const Curve c = Curve::sampled(law, 300, 1500);
  EXPECT_LT(largest_difference(
                c, +[](double T) { return 40 + std::abs(T - 777.7) / 10; }, 300, 1500),
            1e-4);
  // Two triangles.
  EXPECT_NEAR(c.integral(1500) - c.integral(300), 40 * 1200 + (477.7 * 477.7 + 722.3 * 722.3) / 20, 1e-6);
}

TEST(SampledCurve, MayStartFromASingleTemperature) {
  const Curve c = Curve::sampled([](double T) { return 1e4 / T; }, 300, 300);
  EXPECT_NEAR(c.value(400), 25, 1e-8);
  EXPECT_NEAR(Curve::sampled([](double T) { return T; }, 0, 0).value(1), 1, 1e-14);
}

TEST(SampledCurve, RefusesTemperaturesThatRunAway) {
  const Curve c = Curve::sampled([](double x) { return std::exp(-x); }, 0, 1);
  EXPECT_THROW(c.value(1e12), Error);
  EXPECT_THROW(c.value(-std::numeric_limits<double>::infinity()), Error);
  EXPECT_TRUE(std::isnan(c.value(NAN)));
  EXPECT_NEAR(c.value(0.5), std::exp(-0.5), 1e-11);
  EXPECT_TRUE(std::isnan(Curve::through({0, 1}, {1, 2}, Interpolation::linear).value(NAN)));
}

}  // namespace
}  // namespace calor
