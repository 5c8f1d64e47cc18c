#include "base/function.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace calor {
namespace {

const SourceLocation here{"plate.toml", 7, 12};

Function formula(const std::string& expression, const std::map<std::string, double>& parameters = {}) {
  return Function::formula(expression, {.value = "", .si = ""}, parameters, here);
}

/// The error of `work`.
template <class Work>
Error refusal(const Work& work) {
  try {
    work();
  } catch (const Error& e) {
    return e;
  }
  return Error(Fault::command, "nothing was thrown", "");
}

void expect_refused(const std::string& expression, const std::string& part) {
  const Error e = refusal([&] { formula(expression, {{"Bi", 2}}); });
  EXPECT_EQ(e.fault(), Fault::bad_case) << expression;
  EXPECT_EQ(e.location().text(), "plate.toml:7:12") << expression;
  EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
  EXPECT_FALSE(e.cure().empty()) << expression;
}

TEST(Function, AFormulaKnowsLengthsThatGetTheirValuesLater) {
  const LengthsOfPlace lengths{{"depth", std::make_shared<LengthOfPlace>()}, {"other", nullptr}};
  const Function f =
      Function::formula("2*depth + x", {.value = "mm", .si = "m", .length = "mm"}, {}, here, {}, lengths);
  EXPECT_TRUE(f.depends_on_place());
  EXPECT_TRUE(f.may_jump());
  const Error e = refusal([&] { f({1, 0, 0}); });
  EXPECT_EQ(e.fault(), Fault::bad_case);
  EXPECT_NE(e.problem().find("'depth' is not known before"), std::string::npos) << e.what();
  lengths.at("depth")->at = [](const Vec3& x) { return 3 * x.x; };
  EXPECT_DOUBLE_EQ(f({0.5, 0, 0}), 3.5);
}

TEST(Function, IsZeroWhereNothingIsGiven) {
  EXPECT_EQ(Function()({1, 2, 3}, 4, 5), 0);
  EXPECT_TRUE(Function().is_constant());
  EXPECT_EQ(Function::constant(3, here)(), 3);
  EXPECT_EQ(Function::constant(3, here).location().line, 7);
}

TEST(Formula, KnowsPlaceTimeTemperatureAndParameters) {
  EXPECT_EQ(formula("x + 10*y + 100*z + 1000*t + 10000*T + A", {{"A", 0.5}})({1, 2, 3}, 4, 5), 54321.5);
  EXPECT_EQ(formula("r")({3, 4, 100}), 5);  // distance from the z axis
  EXPECT_EQ(formula("pi")(), std::numbers::pi);
  EXPECT_EQ(formula("e")(), std::numbers::e);
  EXPECT_EQ(formula("1e3 + 1.5E-1")(), 1000.15);
}

TEST(Formula, KnowsTheUsualFunctions) {
  const auto expect = [](const std::string& expression, double value) {
    EXPECT_DOUBLE_EQ(formula(expression)({0.3, 0, 0}, 0, 0), value) << expression;
  };
  expect("floor(-1.5)", -2);
  expect("ceil(-1.5)", -1);
  expect("erf(x)", std::erf(0.3));
  expect("erfc(x)", std::erfc(0.3));
  expect("pow(x, 3)", 0.027);
  expect("x^3", 0.027);
  expect("-x^2", -0.09);
  expect("mod(-1, 3)", 2);
  expect("log(x)", std::log(0.3));
  expect("ln(x)", std::log(0.3));
  expect("log10(x)", std::log10(0.3));
  expect("atan2(x, -1)", std::atan2(0.3, -1));
  expect("abs(-x) + min(1, x) + max(1, 2, x)", 2.6);
  expect("sqrt(x) * sinh(x)", std::sqrt(0.3) * std::sinh(0.3));
  expect("x > 0.2 && x < 0.4 ? 1 : 2", 1);
  expect("x == 0.3 || x != x", 1);
  expect("x <= 0.2", 0);
  expect("x >= 0.2", 1);
}

TEST(Formula, IsConvertedFromAndToItsUnits) {
  const Function mm = Function::formula("x + r + 1", {.value = "mm", .si = "m", .length = "mm"});
  EXPECT_DOUBLE_EQ(mm({0.003, 0.004, 0}), 0.009);  // 3 + 5 + 1 mm
  const Function minutes = Function::formula("t", {.value = "", .si = "", .time = "min"});
  EXPECT_DOUBLE_EQ(minutes({}, 90), 1.5);
  // In and out in degrees Celsius: absolute temperatures.
  const Function ambient = Function::formula("T + 10", {.value = "degC", .si = "K", .temperature = "degC"});
  EXPECT_DOUBLE_EQ(ambient({}, 0, 300), 310);
  const Function k = Function::formula("20 + 0.1*T", {.value = "W/(cm K)", .si = "W/(m K)", .temperature = "degC"});
  EXPECT_DOUBLE_EQ(k({}, 0, 293.15), 2200);
}

TEST(Formula, TellsWhatItDependsOn) {
  for (const char* place : {"x", "1 + y", "z^2", "exp(r)"}) {
    EXPECT_TRUE(formula(place).depends_on_place()) << place;
    EXPECT_FALSE(formula(place).depends_on_time() || formula(place).depends_on_temperature()) << place;
  }
  EXPECT_TRUE(formula("sin(t)").depends_on_time());
  EXPECT_TRUE(formula("T < 300 ? 1 : 2").depends_on_temperature());
  EXPECT_TRUE(formula("2*pi").is_constant());
  EXPECT_FALSE(formula("x").is_layered());
}

TEST(Formula, IsEvaluatedForManyPoints) {
  std::vector<Vec3> x;
  std::vector<double> T;
  for (int i = 0; i < 5000; ++i) {
    x.push_back({i * 0.01, 0, 0});
    T.push_back(i);
  }
  std::vector<double> out(x.size());
  formula("x + T + t").evaluate({.x = x, .t = 2, .T = T}, out);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_EQ(out[i], x[i].x + T[i] + 2);
  formula("7").evaluate({.x = x}, out);
  EXPECT_EQ(out.back(), 7);
  formula("x").evaluate({}, {});
}

TEST(Formula, HasADerivativeByTemperature) {
  const std::vector<double> T = {1, 300, 1000};
  const std::vector<Vec3> x(T.size(), {2, 0, 0});
  std::vector<double> out(T.size());
  formula("x*exp(T/300)").derivative({.x = x, .T = T}, out);
  for (std::size_t i = 0; i < T.size(); ++i) {
    const double exact = 2 * std::exp(T[i] / 300) / 300;
    EXPECT_NEAR(out[i], exact, 1e-10 * std::exp(T[i] / 300));
  }
  formula("x").derivative({.x = x}, out);
  EXPECT_EQ(out, std::vector<double>(3, 0.0));
  // Below zero there is no square root.
  formula("1 + T*sqrt(T)").derivative({.x = {x.data(), 1}, .T = std::vector{0.0}}, {out.data(), 1});
  EXPECT_NEAR(out[0], 0, 0.05);
}

TEST(Formula, RefusesSyntaxErrorsWithTheirPlace) {
  expect_refused("2*", "formula '2*': unexpected end of expression");
  expect_refused("2*(x", "parenthesis");
  expect_refused("x y", "unexpected");
  expect_refused("2x", "unexpected");
  expect_refused("sin()", "function \"sin\"");
  expect_refused("x $ 2", "$");
  expect_refused("", "");
  expect_refused("\"text\"", "formula");
  expect_refused("x ? 1", "formula");
}

TEST(Formula, RefusesWhatTheParserWouldTakeSilently) {
  expect_refused("1,5*x", "a comma outside the arguments of a function (character 2)");
  expect_refused("sin(x), 2", "a comma");
  expect_refused("(1,5)*x", "a comma");
  expect_refused("max(1, (2,5))", "a comma");
  expect_refused("x = 3", "a single '=' has no meaning (character 3): compare with '=='");
  expect_refused("x == 3 ? T = 1 : 0", "a single '='");
}

TEST(Formula, NamesUnknownSymbolsAndTheKnownOnes) {
  expect_refused("1 + bi",
                 "unknown symbol 'bi' (character 5): did you mean 'Bi'? known are T, r, t, x, y, z, Bi, e, pi and");
  expect_refused("sine(x)", "did you mean 'sin'?");
  expect_refused("temperature", "unknown symbol 'temperature'");
  EXPECT_NE(refusal([] { formula("x", {{"x", 1}}); }).problem().find("hides"), std::string::npos);
  EXPECT_NE(refusal([] { formula("x", {{"a-b", 1}}); }).problem().find("'a-b'"), std::string::npos);
  EXPECT_EQ(refusal([] { Function::formula("x", {.value = "mm", .si = "K"}, {}, here); }).location().line, 7);
}

TEST(Formula, SaysWhereItIsNotFinite) {
  const Error e = refusal([] { formula("1/x")({0, 2, 0}, 3, 300); });
  EXPECT_EQ(e.fault(), Fault::bad_case);
  EXPECT_EQ(e.location().line, 7);
  EXPECT_EQ(e.problem(), "formula '1/x' is inf at (x, y, z) = (0, 2, 0) m, t = 3 s, T = 300 K");
  EXPECT_NE(refusal([] { formula("sqrt(t)")({}, -1); }).problem().find("nan at"), std::string::npos);
  EXPECT_NE(refusal([] { formula("1/0")(); }).problem().find("inf at"), std::string::npos);
  // A temperature that is not finite is no fault of the case.
  EXPECT_EQ(refusal([] { formula("2*T")({}, 0, NAN); }).fault(), Fault::numbers);
}

TEST(Function, OfTemperatureIsItsCurve) {
  const Function f = Function::of_temperature(Curve::through({300, 400}, {20, 30}, Interpolation::linear), here);
  EXPECT_TRUE(f.depends_on_temperature());
  EXPECT_DOUBLE_EQ(f({}, 0, 350), 25);
  std::vector<double> slope(1);
  f.derivative({.x = std::vector<Vec3>(1), .T = std::vector{350.0}}, slope);
  EXPECT_DOUBLE_EQ(slope[0], 0.1);
  EXPECT_DOUBLE_EQ(f.curve(0, 1).integral(300), 6000);
}

TEST(Function, OfTimeBreaksAtItsKinks) {
  const Function f = Function::of_time(Curve::through({1, 2, 5}, {0, 10, 10}, Interpolation::linear), here);
  EXPECT_TRUE(f.depends_on_time());
  EXPECT_DOUBLE_EQ(f({}, 1.5), 5);
  EXPECT_EQ(f.changes().events, (std::vector{1., 2.}));  // level at the end
  EXPECT_EQ(f.with_breaks({1.5, 1}).changes().events, (std::vector{1., 1.5, 2.}));
  EXPECT_EQ(Function::formula("t", {}, {}, {}, {3, 1}).changes().events, (std::vector{1., 3.}));
  EXPECT_TRUE(formula("t").changes().events.empty());
}

TEST(Function, OfTimeByAFormulaTellsWhereItJumpsBeginsToChangeOrComesToRest) {
  const auto course = std::make_shared<Course>();
  const auto events = [&](const char* text) {
    return Function::formula(text, {}, {}, {}, {}, {}, course).changes().events;
  };
  EXPECT_TRUE(events("t > 3 ? 1 : 0").empty());  // before the run is known
  *course = {.end = 10, .places = {{0, 0, 0}, {1, 0, 0}}};
  const auto expect_near = [](const std::vector<double>& found, const std::vector<double>& expected, double within) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t n = 0; n < found.size(); ++n) EXPECT_NEAR(found[n], expected[n], within);
  };
  expect_near(events("t > 3 && t < pi ? 1 : 0"), {3, std::numbers::pi}, 1e-12);
  expect_near(events("x > 0.5 && t > 7 ? 1 : 0"), {7}, 1e-12);  // at one of the places
  expect_near(events("1 + exp(-((t - 5)/0.1)^2)"), {4.57, 5.43}, 0.03);
  expect_near(events("t < 4 ? log(4 - t) : log(-1)"), {}, 0);  // it fails from 4 s on
  for (const char* smooth : {"t", "sin(2*t)", "exp(-t)", "x + 3"}) EXPECT_TRUE(events(smooth).empty()) << smooth;
  // From mark to mark a fiftieth of the range: a hundred for a pulse, a hundred a period of a wave.
  const auto marks = [&](const char* text) {
    return Function::formula(text, {}, {}, {}, {}, {}, course).changes().marks;
  };
  EXPECT_NEAR(static_cast<double>(marks("exp(-((t - 5)/0.1)^2)").size()), 100, 3);
  EXPECT_NEAR(static_cast<double>(marks("sin(2*pi*t)").size()), 1000, 20);
  EXPECT_NEAR(static_cast<double>(marks("t < 4 ? 0 : t").size()), 30, 1);  // the jump is an event
  EXPECT_TRUE(marks("3").empty());
}

TEST(Function, OfLayersIsConstantInEachAndTheMeanBetweenTwo) {
  const Function f = Function::layers(2, 0.5, {1, 2, 1}, {10, 20, 40}, here);
  EXPECT_TRUE(f.is_layered());
  EXPECT_TRUE(f.depends_on_place());
  EXPECT_EQ(f({0, 0, 0.5}), 10);
  EXPECT_EQ(f({0, 0, 1.4}), 10);
  EXPECT_EQ(f({0, 0, 1.5}), 15);
  EXPECT_EQ(f({0, 0, 1.5 + 1e-12}), 15);
  EXPECT_EQ(f({0, 0, 1.6}), 20);
  EXPECT_EQ(f({0, 0, 3.5}), 30);
  EXPECT_EQ(f({0, 0, 4.5}), 40);
  const Error outside = refusal([&] { f({0, 0, 5}); });
  EXPECT_EQ(outside.problem(), "the layers reach from z = 0.5 m to 4.5 m, but a point lies at z = 5 m");
  EXPECT_EQ(refusal([] { Function::layers(0, 0, {1}, {1, 2}, here); }).location().line, 7);
  EXPECT_EQ(refusal([] { Function::layers(0, 0, {1, -1}, {1, 2}, here); }).fault(), Fault::bad_case);
}

TEST(Function, OfACallbackIsFilledByIt) {
  const Function f = Function::callback({.evaluate =
                                             [](const Arguments& args, std::span<double> out) {
                                               for (std::size_t i = 0; i < out.size(); ++i)
                                                 out[i] = args.x[i].x * args.T[i] * args.T[i];
                                             },
                                         .on = {.place = true, .temperature = true}});
  EXPECT_EQ(f({2, 0, 0}, 0, 3), 18);
  std::vector<double> slope(1);
  f.derivative({.x = std::vector<Vec3>{{2, 0, 0}}, .T = std::vector{3.0}}, slope);
  EXPECT_NEAR(slope[0], 12, 1e-10);
  EXPECT_EQ(refusal([&] { f({1e300, 0, 0}, 0, 1e300); }).fault(), Fault::numbers);
}

TEST(Function, OfTemperatureAloneBecomesACurve) {
  const Curve c = formula("exp(4*T)").curve(0, 1);
  EXPECT_NEAR(c.value(0.37), std::exp(4 * 0.37), 1e-11 * std::exp(4));
  EXPECT_TRUE(formula("3").curve(0, 1).is_constant());
  EXPECT_EQ(formula("3").curve(0, 1).value(9), 3);
  EXPECT_THROW(formula("x*T").curve(0, 1), std::logic_error);
  const Error e = refusal([] { formula("1/(T - 0.5)").curve(0, 1); });
  EXPECT_EQ(e.location().line, 7);  // also when sampled
}

}  // namespace
}  // namespace calor
