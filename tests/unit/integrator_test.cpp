#include "solve/integrator.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "app/run.hpp"
#include "case_models.hpp"
#include "output/energy.hpp"
#include "solve/stepper.hpp"

namespace calor {
namespace {

StepOptions steps_of(double step) {
  StepOptions options;
  options.step = step;
  return options;
}
StepOptions within(double tolerance) {
  StepOptions options;
  options.tolerance = tolerance;
  return options;
}
/// What makes the integrator of that name.
auto maker(const std::string& name) { return integrators().find(name)->make; }
const AfterStep go_on = [](const State&) { return true; };

struct Named {
  std::string name;
  std::unique_ptr<Integrator> (*make)(const StepOptions&);
  int order;
};
const std::vector<Named>& all_integrators() {
  static const std::vector<Named> all = {{"euler", maker("euler"), 1},
                                         {"rkl2", maker("rkl2"), 2},
                                         {"backward-euler", maker("backward-euler"), 1},
                                         {"crank-nicolson", maker("crank-nicolson"), 2},
                                         {"tr-bdf2", maker("tr-bdf2"), 2}};
  return all;
}

// A rod of nine points with everything of size 1; 2 / lambda_max is 1/128 s or more.
const std::string rod = box_case({"1 m"}, {9}) + R"toml(
[time]
end = "1 s"
[initial]
temperature = { formula = "1.5 + 0.5*cos(pi*x)", unit = "K" }
)toml";
const std::string simple = simple_material({.k = "1", .rho = "1", .c = "1"});
const std::string of_temperature = simple_material({.k = "0.5 + 0.3*T", .rho = "1", .c = "0.7 + 0.4*T"});
const std::string source = R"toml(
[source.s]
power_density = { formula = "(2 + x)*sin(7*t)", unit = "W/m^3" }
)toml";
const std::string wall = R"toml(
[boundary.xmin]
temperature = { formula = "2 + 0.4*sin(6*t)", unit = "K" }
)toml";
const std::string air = R"toml(
[boundary.xmax.convection]
h = { formula = "2 + sin(5*t)", unit = "W/(m^2 K)" }
ambient = { formula = "1 + 0.5*sin(4*t)", unit = "K" }
)toml";

/// By MLPG; the unknowns are parameters of moving least squares.
std::string by_parameters(const std::string& text) { return replaced(text, "\"sph\"", "\"mlpg\""); }

struct Problem {
  std::string name, text;
  bool is_damped;  ///< by a wall: otherwise what is wrong in the mean stays wrong
};
const std::vector<Problem>& problems() {
  static const std::vector<Problem> all = {
      {"time-dependent source", rod + simple + source, false},
      {"time-dependent prescribed wall", rod + simple + wall, true},
      {"c(T), k(T)", rod + of_temperature + "[boundary.xmax]\nflux = \"1 W/m^2\"\n", false},
      {"c(T), k(T), parameters", by_parameters(rod + of_temperature + "[boundary.xmax]\nflux = \"1 W/m^2\"\n"), false},
      {"all of them, and convection", rod + of_temperature + source + wall + air, true},
  };
  return all;
}

/// Temperatures of the owned points at `end` by the classical Runge-Kutta method, on the enthalpies, whose values at
/// prescribed points count for nothing.
std::vector<double> by_runge_kutta(const CaseModel& m, double end, int steps) {
  HeatSystem& system = m.system();
  const State start = m.start();
  const std::size_t n = start.E.size();
  std::vector<double> E = start.E, T = start.T, power(system.accounts().size());
  const auto rate = [&](double t, const std::vector<double>& at) {
    std::vector<double> F(n);
    system.temperature(at, T);
    system.set_known(t, T);
    system.rate(t, T, F, power);
    return F;
  };
  const double dt = end / steps;
  const auto moved = [&](const std::vector<double>& F, double by) {
    std::vector<double> out = E;
    for (std::size_t i = 0; i < n; ++i) out[i] += by * F[i];
    return out;
  };
  for (int step = 0; step < steps; ++step) {
    const double t = step * dt;
    const auto a = rate(t, E), b = rate(t + dt / 2, moved(a, dt / 2)), c = rate(t + dt / 2, moved(b, dt / 2)),
               d = rate(t + dt, moved(c, dt));
    for (std::size_t i = 0; i < n; ++i) E[i] += dt / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }
  system.temperature(E, T);
  system.set_known(end, T);
  return {T.begin(), T.begin() + static_cast<std::ptrdiff_t>(n)};
}

double largest_difference(std::span<const double> a, std::span<const double> b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// Error at `end` with a fixed step.
double error_with(const Named& kind, const Problem& problem, double end, double step, std::span<const double> exact) {
  const CaseModel m(problem.text);
  State state = m.start();
  kind.make(steps_of(step))->advance(m.system(), state, end, go_on);
  EXPECT_EQ(state.t, end);
  return largest_difference(exact, state.T);
}

TEST(Integrators, ConvergeWithTheirOrderInTime) {
  constexpr double end = 0.5;
  for (const Problem& problem : problems()) {
    const auto exact = by_runge_kutta(CaseModel(problem.text), end, 2000);
    for (const Named& kind : all_integrators()) {
      const double step = kind.name == "euler" ? end / 512 : end / 16;
      const double coarse = error_with(kind, problem, end, step, exact),
                   middle = error_with(kind, problem, end, step / 2, exact),
                   fine = error_with(kind, problem, end, step / 4, exact);
      const auto report = fmt::format("{}, {}: {:.3e} {:.3e} {:.3e}", kind.name, problem.name, coarse, middle, fine);
      EXPECT_GE(std::log2(middle / fine), kind.order - 0.15) << report;
      EXPECT_GE(std::log2(coarse / fine) / 2, kind.order - 0.25) << report;
      EXPECT_LE(fine, kind.order == 1 ? 1e-2 : 1e-3) << report;
    }
  }
}

TEST(Integrators, KeepTheErrorWithinAFewTolerances) {
  // The tolerance is that of a step; what steps add up to is damped by walls of given temperature.
  for (const Problem& problem : problems()) {
    for (const double end : {0.02, 0.5}) {
      const auto exact = by_runge_kutta(CaseModel(problem.text), end, 2000);
      for (const auto make : {maker("rkl2"), maker("tr-bdf2")}) {
        double last = std::numeric_limits<double>::infinity();
        for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5}) {
          const CaseModel m(problem.text);
          State state = m.start();
          const auto integrator = make(within(tolerance));
          integrator->advance(m.system(), state, end, go_on);
          const double error = largest_difference(exact, state.T);
          const double few = problem.is_damped ? 5 : std::max(5., static_cast<double>(integrator->counts.steps));
          EXPECT_LE(error, few * tolerance) << integrator->name() << ", " << problem.name << ", end " << end;
          // Where the data keep the steps short the tolerance hardly matters.
          EXPECT_LE(error, 1.01 * last) << integrator->name() << ", " << problem.name;
          last = error;
        }
      }
    }
  }
}

TEST(Integrators, KeepTheErrorWithinAFewTolerancesAfterAJumpOfTheWall) {
  const std::string text = rod + simple + "[boundary.xmin]\ntemperature = \"3 K\"\n";
  for (const double end : {0.001, 0.01, 0.1}) {
    const auto exact = by_runge_kutta(CaseModel(text), end, 2000);
    for (const auto make : {maker("rkl2"), maker("tr-bdf2")})
      for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        const CaseModel m(text);
        State state = m.start();
        const auto integrator = make(within(tolerance));
        integrator->advance(m.system(), state, end, go_on);
        EXPECT_LE(largest_difference(exact, state.T), 4 * tolerance) << integrator->name() << ", end " << end;
      }
  }
}

TEST(Integrators, MarchToTheExactModeOfARod) {
  // T = 1.5 + 0.5 cos(pi x) exp(-lambda t), lambda = 2/dx^2 (1 - cos(pi dx)): an eigenmode of nine points in a line.
  const double lambda = 2 * 64 * (1 - std::cos(std::numbers::pi / 8)), end = 0.1;
  for (const Named& kind : all_integrators()) {
    const CaseModel m(rod + simple);
    State state = m.start();
    kind.make(steps_of(1e-4))->advance(m.system(), state, end, go_on);
    for (int i = 0; i < m.cloud().owned; ++i)
      EXPECT_NEAR(state.T[i], 1.5 + 0.5 * std::cos(std::numbers::pi * m.cloud().x[i].x) * std::exp(-lambda * end),
                  kind.order == 1 ? 1e-4 : 1e-7)
          << kind.name;
  }
}

TEST(Integrators, StoreExactlyWhatAFluxThatJumpsBrings) {
  const std::string text = rod + of_temperature + R"toml(
[boundary.xmax]
flux = { formula = "t < 0.13 ? 5 : t < 0.4 ? -2 : 1", unit = "W/m^2", breaks = ["0.13 s", "0.4 s"] }
[source.s]
power_density = { formula = "t < 0.31 ? 0.5 : 3", unit = "W/m^3", breaks = ["0.31 s"] }
)toml";
  const double flux = 5 * 0.13 - 2 * (0.4 - 0.13) + 0.1, sources = 0.5 * 0.31 + 3 * (0.5 - 0.31);
  for (const Named& kind : all_integrators()) {
    SCOPED_TRACE(kind.name);
    const CaseModel m(text);
    State state = m.start();
    const State start = state;
    std::vector<double> times;
    // 0.007 divides none of the intervals between the events.
    kind.make(steps_of(0.007))->advance(m.system(), state, 0.5, [&](const State& s) {
      times.push_back(s.t);
      return true;
    });
    for (double at : {0.13, 0.31, 0.4, 0.5}) EXPECT_EQ(std::ranges::count(times, at), 1) << at;
    double stored = 0;
    for (std::size_t i = 0; i < state.E.size(); ++i) stored += state.E[i] - start.E[i];
    EXPECT_NEAR(state.cumulative_heat[0], flux, 1e-12);
    EXPECT_NEAR(state.cumulative_heat[1], sources, 1e-12);
    EXPECT_NEAR(stored, flux + sources, 1e-12);
  }
}

TEST(Integrators, LandOnTheRowsOfTables) {
  const std::string text = rod + simple + R"toml(
[boundary.xmin]
temperature = { table = [[0.1, 2], [0.25, 3], [0.6, 2.5]], unit = "K" }
[boundary.xmax]
flux = { table = [[0, 0], [0.4, 4]], unit = "W/m^2", of = "time" }
)toml";
  for (const Named& kind : all_integrators())
    for (const bool fixed : {true, false}) {
      if (!fixed && (kind.name == "backward-euler" || kind.name == "crank-nicolson")) continue;
      const CaseModel m(text);
      EXPECT_EQ(m.system().events(), (std::vector<double>{0, 0.1, 0.25, 0.4, 0.6}));
      State state = m.start();
      std::vector<double> times;
      const StepOptions options = fixed ? steps_of(0.0078) : within(1e-2);
      kind.make(options)->advance(m.system(), state, 0.5, [&](const State& s) {
        times.push_back(s.t);
        return true;
      });
      for (double at : {0.1, 0.25, 0.4, 0.5}) EXPECT_EQ(std::ranges::count(times, at), 1) << kind.name << " " << at;
      EXPECT_TRUE(std::ranges::is_sorted(times));
      // Linear in time between the rows: a rule of second order integrates it exactly, each stage with its own time.
      if (kind.order == 2 && kind.name != "crank-nicolson") {
        EXPECT_NEAR(state.cumulative_heat[1], 0.5 * 4 * 0.4 + 4 * 0.1, 1e-9);
      }
    }
}

TEST(Integrator, APulseThatRisesSmoothlyIsNotLostBetweenTwoSteps) {
  // 2 kJ/m^2 in 20 ms of 10 s, in a slab whose own steps are longer than that.
  const std::vector<std::string> pulses = {
      R"x({ formula = "abs(t - 5) < 0.01 ? 1e5*(1 + cos(pi*(t - 5)/0.01)) : 0", unit = "W/m^2" })x",
      R"x({ formula = "2e5/(0.002*sqrt(pi))*0.01*exp(-((t - 5)/0.002)^2)", unit = "W/m^2" })x",
      R"x({ table = [[0, 0], [4.99, 0], [5, 2e5], [5.01, 0], [10, 0]], interpolation = "cubic", of = "time", unit = "W/m^2" })x"};
  for (const std::string& pulse : pulses)
    for (const Named& kind : all_integrators()) {
      if (kind.name == "backward-euler" || kind.name == "crank-nicolson") continue;  // their steps are given
      const CaseModel m(
          box_case({"20 mm"}, {5}) + simple_material({.k = "1", .rho = "2000", .c = "800"}) +
          "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"10 s\"\n[boundary.laser]\non = \"xmin\"\nflux = " +
          pulse + "\n");
      State state = m.start();
      kind.make(within(1e-4))->advance(m.system(), state, 10, [](const State&) { return true; });
      EXPECT_NEAR(state.cumulative_heat[0], 2000, kind.order == 2 ? 5 : 60) << kind.name << " " << pulse;
    }
}

/// A plate with every kind of exchange; its walls jump at t = 0.
const std::string plate = box_case({"50 mm", "40 mm"}, {6, 5}) + R"toml(
jitter = 0.2
thickness = "10 mm"
[initial]
temperature = { formula = "400 + 2000*x", unit = "K" }
[boundary.hot]
on = "xmin"
temperature = { formula = "600 + 3*t", unit = "K" }
[boundary.cold]
on = "ymin"
temperature = "500 K"
[boundary.air]
on = "xmax"
convection = { h = { formula = "50 + 0.2*T", unit = "W/(m^2 K)" }, ambient = "300 K" }
radiation = { emissivity = 0.6, ambient = { formula = "300 + 20*t", unit = "K" } }
[boundary.burner]
on = "ymax"
flux = { table = [[0, 0], [7, 2e4], [12, 1e3]], unit = "W/m^2", of = "time" }
[source.reaction]
power_density = { formula = "1e6*exp(-T/1000)*(1 + x)", unit = "W/m^3" }
[time]
end = "20 s"
)toml";
const std::string steel = simple_material({.k = "40", .rho = "8000", .c = "400"});
const std::string steel_of_T =
    simple_material({.k = "60 - 0.03*T", .rho = "8000", .c = "400 + 0.2*T + 300*exp(-((T - 550)/30)^2)"});

/// The books of a march to 20 s that begins before the walls jump.
struct Books {
  double worst_imbalance;
  EnergyBalance at_end;
};
Books books_of(const CaseModel& m, Integrator& integrator) {
  State state = m.start_without_walls();
  EnergyLog energy(m.system(), state.E);
  m.system().impose(0, state.T, state.E, state.cumulative_heat);
  EnergyBalance balance;
  integrator.advance(m.system(), state, 20, [&](const State& s) {
    balance = energy.add(s);
    return true;
  });
  return {energy.worst_imbalance(), balance};
}

TEST(Integrators, ConserveHeat) {
  const std::string parameters = by_parameters(plate + steel_of_T),
                    penalty = parameters + "[mlpg]\nprescribed = \"penalty\"\n";
  for (const std::string& text : {plate + steel, plate + steel_of_T, parameters, penalty})
    for (const Named& kind : all_integrators()) {
      if (text == penalty && (kind.name == "euler" || kind.name == "rkl2")) continue;  // too stiff
      const CaseModel m(text);
      const auto integrator = kind.make(steps_of(kind.name == "euler" ? 0.5 : 1));
      const Books books = books_of(m, *integrator);
      // Implicit steps take the enthalpies from the rates of their stages, so that no solver's tolerance enters.
      EXPECT_LE(books.worst_imbalance, 1e-12) << kind.name;
      for (double heat : books.at_end.through) EXPECT_GT(std::abs(heat), 1) << kind.name;
    }
}

TEST(Integrators, ConserveHeatWithStepsOfTheirOwn) {
  for (const std::string& text : {plate + steel_of_T, by_parameters(plate + steel_of_T)})
    for (const auto make : {maker("euler"), maker("rkl2"), maker("tr-bdf2")}) {
      const CaseModel m(text);
      const auto integrator = make({});
      EXPECT_LE(books_of(m, *integrator).worst_imbalance, 1e-12) << integrator->name();
    }
}

TEST(Integrators, KeepABodyAtRestAtRest) {
  for (const std::string& material : {steel, steel_of_T})
    for (const Named& kind : all_integrators()) {
      const CaseModel m(R"toml(
title = "test"
method = "sph"
[cloud]
shape = "disc"
radius = "1 m"
rings = 4
[initial]
temperature = "431 K"
[boundary.side]
convection = { h = "20 W/(m^2 K)", ambient = "431 K" }
radiation = { emissivity = 0.4, ambient = "431 K" }
[time]
end = "100 s"
)toml" + material);
      State state = m.start();
      EnergyLog energy(m.system(), state.E);
      kind.make(steps_of(10))->advance(m.system(), state, 100, go_on);
      for (int i = 0; i < m.cloud().owned; ++i) EXPECT_NEAR(state.T[i], 431, 1e-9) << kind.name;
      energy.add(state);
      EXPECT_EQ(energy.worst_imbalance(), 0) << kind.name;
    }
}

TEST(Integrators, StopWhenTheyAreTold) {
  for (const Named& kind : all_integrators()) {
    const CaseModel m(rod + simple);
    State state = m.start();
    int steps = 0;
    const auto integrator = kind.make(steps_of(0.005));
    integrator->advance(m.system(), state, 1, [&](const State&) { return ++steps < 3; });
    EXPECT_EQ(steps, 3);
    EXPECT_EQ(integrator->counts.steps, 3);
    EXPECT_NEAR(state.t, 0.015, 1e-12);
  }
}

TEST(Integrators, TakeNoMoreStepsThanTheyNeed) {
  // Two decades of decay to 1e-3 of the start: both adaptive integrators lengthen their steps far beyond Euler's.
  for (const auto make : {maker("rkl2"), maker("tr-bdf2")}) {
    const CaseModel m(rod + simple + "[boundary.xmin]\ntemperature = \"3 K\"\n");
    State state = m.start();
    const auto integrator = make(within(1e-3));
    integrator->advance(m.system(), state, 5, go_on);
    EXPECT_LE(integrator->counts.steps, 100) << integrator->name();  // Euler: 640
    EXPECT_LE(integrator->counts.rejected, integrator->counts.steps / 4) << integrator->name();
    EXPECT_GE(integrator->counts.largest_step, 0.1) << integrator->name();
  }
}

/// The integrator that a case leads to.
std::unique_ptr<Integrator> choose(const std::string& text) {
  const CaseModel m(text);
  State state = m.start();
  return make_integrator(m.description(), m.system(), state);
}

/// Cells in a line: the Gershgorin bound 4 a / dx^2 lies above the largest rate 2 a / dx^2 (1 + cos(pi / n)); of four
/// cells by 17 percent.
std::string cells(const std::string& keys) {
  return box_case({"4 m"}, {4}) + "at = \"cells\"\n" + simple + R"toml([initial]
temperature = { formula = "300 + x", unit = "K" }
[time]
end = "10 s"
)toml" + keys;
}

TEST(ChoiceOfIntegrator, AcceptsAStepUpToTheGershgorinBoundInSilence) {
  const auto chosen = choose(cells("integrator = \"euler\"\nstep = \"0.5 s\"\n"));
  EXPECT_EQ(chosen->name(), "euler");
  EXPECT_TRUE(chosen->notes.empty());
}

TEST(ChoiceOfIntegrator, WarnsOfAStepAboveTheGershgorinBound) {
  const double limit = 1 / (1 + std::cos(std::numbers::pi / 4));  // 0.586 s
  const auto chosen = choose(cells(fmt::format("integrator = \"euler\"\nstep = \"{} s\"\n", 0.99 * limit)));
  EXPECT_EQ(chosen->name(), "euler");
  ASSERT_EQ(chosen->notes.size(), 1u);
  expect_words(chosen->notes.front(), {"test.toml:17:8", "above the Gershgorin bound of 0.5 s", "0.585786 s"});
}

TEST(ChoiceOfIntegrator, RefusesAnUnstableStep) {
  const double limit = 1 / (1 + std::cos(std::numbers::pi / 4));
  expect_error([&] { choose(cells(fmt::format("integrator = \"euler\"\nstep = \"{} s\"\n", 1.01 * limit))); },
               {"test.toml:17:8", "unstable", "0.585786 s", "at most 0.5 s"});
}

TEST(ChoiceOfIntegrator, LeavesTheStepsOfStableIntegratorsAlone) {
  for (const std::string name : {"rkl2", "backward-euler", "crank-nicolson", "tr-bdf2"})
    EXPECT_TRUE(choose(cells(fmt::format("integrator = \"{}\"\nstep = \"5 s\"\n", name)))->notes.empty());
}

TEST(ChoiceOfIntegrator, TakesTheOneThatFits) {
  EXPECT_EQ(choose(cells(""))->name(), "tr-bdf2");
  EXPECT_EQ(choose(plate + steel)->name(), "rkl2");
  EXPECT_EQ(choose(by_parameters(plate + steel))->name(), "tr-bdf2");
  EXPECT_EQ(choose(by_parameters(plate + steel_of_T))->name(), "rkl2");
  EXPECT_EQ(choose(plate + steel + "[sph]\ncorrection = \"paper\"\n")->name(), "euler");
}

TEST(ChoiceOfIntegrator, RefusesWhatDoesNotFit) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& words) {
    expect_error([&] { choose(text); }, words);
  };
  refused(cells("integrator = \"backward-euler\"\n"), {"test.toml:16:14", "fixed steps", "tr-bdf2"});
  refused(cells("integrator = \"crank-nicolson\"\n"), {"test.toml:16:14", "fixed steps"});
  refused(cells("step = \"0 s\"\n"), {"test.toml:16:8", "a step of 0 is not positive"});
  refused(cells("tolerance = \"-1 K\"\n"), {"test.toml:16:13", "a tolerance of -1 is not positive"});
  refused(cells("safety = 1.5\n"), {"test.toml:16:10", "safety of 1.5"});
  refused(plate + "integrator = \"rkl2\"\n" + steel + "[sph]\ncorrection = \"paper\"\n",
          {"rkl2 does not know the algebraic wall points", "\"euler\""});
}

TEST(SteadyState, IsFoundWhereKDependsOnT) {
  // k = 1 + a T between 0 and 1 K: T + a T^2 / 2 is linear in x, whatever the number of points.
  for (const double a : {1., 4., 20.}) {
    const CaseModel m(box_case({"1 m"}, {11}) + simple_material({.k = fmt::format("1 + {}*T", a)}) + R"toml(
[boundary.xmin]
temperature = "0 K"
[boundary.xmax]
temperature = "1 K"
[steady]
)toml");
    State state = m.start();
    const SteadyReport report = solve_steady(m.description(), m.system(), state);
    for (int i = 0; i < m.cloud().owned; ++i) {
      const double x = m.cloud().x[i].x;
      EXPECT_NEAR(state.T[i], (std::sqrt(1 + a * (2 + a) * x) - 1) / a, 1e-11);
    }
    EXPECT_LE(report.newton_iterations, 12);
    EXPECT_LE(report.residual, 1e-11);
  }
}

TEST(SteadyState, LeavesAnInsulatorAsItIsAndFindsTheRest) {
  // Below y = 0.7 m k = 1 + T between 0 K and 1 K; nothing conducts above, whose top air cools.
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    const CaseModel m(box_case({"1 m", "1 m"}, {11, 11}, method) + simple_material({.k = "1 + T"}) + R"toml(
[material.void]
conductivity = "0 W/(m K)"
[body]
material = "m"
[[body.region]]
material = "void"
where = "y > 0.75"
length = "m"
[initial]
temperature = "0.5 K"
[boundary.cold]
on = "xmin"
temperature = "0 K"
[boundary.warm]
on = "xmax"
temperature = "1 K"
[boundary.top]
on = "ymax"
convection = { h = "1 W/(m^2 K)", ambient = "2 K" }
[steady]
)toml");
    State state = m.steady();
    const std::vector<double> T = m.system().temperatures(state.T);
    for (int i = 0; i < m.cloud().owned; ++i) {
      const Vec3& x = m.cloud().x[i];
      const bool is_held = x.x < 1e-9 || x.x > 1 - 1e-9;
      if (x.y > 0.72 && is_held) continue;
      const double exact = x.y < 0.72 ? std::sqrt(1 + 3 * x.x) - 1 : x.y < 0.95 ? 0.5 : 2;
      EXPECT_NEAR(T[i], exact, x.y < 0.72 ? 5e-3 : 1e-9) << method << " at " << x.x << ", " << x.y;
    }
  }
}

/// The self-heating slab: its first guess has no flow at all.
std::string self_heating(const std::string& method, const std::string& steady = "") {
  return box_case({"2 m"}, {21}, method) + simple_material({.k = "1"}) + R"toml(
[source.reaction]
power_density = { formula = "0.8*exp(T)", unit = "W/m^3", temperature = "K" }
[boundary.xmin]
temperature = "0 K"
[boundary.xmax]
temperature = "0 K"
[steady]
)toml" + steady;
}

TEST(SteadyState, MeetsItsToleranceFromAGuessWithoutFlow) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    double before = 1;
    for (const double tolerance : {1e-2, 1e-6, 1e-11}) {
      const CaseModel m(self_heating(method, fmt::format("tolerance = {}\n", tolerance)));
      State state = m.start();
      const SteadyReport report = solve_steady(m.description(), m.system(), state);
      EXPECT_LE(report.residual, tolerance) << method;
      EXPECT_LT(report.residual, 0.1 * before) << method;
      EXPECT_LE(report.imbalance, report.residual * report.flow * (1 + 1e-6)) << method;
      EXPECT_FALSE(report.at_round_off) << method;
      before = report.residual;
    }
  }
}

TEST(SteadyState, ThatStallsAtRoundOffIsFound) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    const CaseModel m(self_heating(method, "tolerance = 1e-40\n"));
    State state = m.start();
    const SteadyReport report = solve_steady(m.description(), m.system(), state);
    EXPECT_LE(report.imbalance, 1e-13 * report.flow) << method;
  }
}

TEST(SteadyStateParallel, IsFoundWhereSomeRanksHaveNeitherWallNorSource) {
  // A source at one end, a wall at 0 K at the other: the power Q flows through all of the rod, T = Q (L - x) / (k A).
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    const CaseModel m(box_case({"2 m"}, {41}, method) + simple_material({.k = "1"}) + R"toml(
[boundary.xmin]
flux = "1 W/m^2"
[boundary.xmax]
temperature = "0 K"
[steady]
)toml",
                      MPI_COMM_WORLD);
    State state = m.start();
    const SteadyReport report = solve_steady(m.description(), m.system(), state);
    EXPECT_LE(report.residual, 1e-11);
    EXPECT_NEAR(report.flow, 1, 1e-9);
    const std::vector<double> T = m.system().temperatures(state.T);
    for (int i = 0; i < m.cloud().owned; ++i) EXPECT_NEAR(T[i], 2 - m.cloud().x[i].x, 1e-10);
  }
}

/// Iterations with the linear equations of a steady state, and that of a body with twice as many points along edges.
std::pair<long, long> linear_iterations(const std::vector<std::string>& size, const std::vector<int>& points,
                                        const std::string& rest, MPI_Comm comm) {
  const auto count = [&](int refinement) {
    std::vector<int> refined;
    for (const int n : points) refined.push_back(refinement * (n - 1) + 1);
    const CaseModel m(box_case(size, refined) + rest, comm);
    State state = m.start();
    return solve_steady(m.description(), m.system(), state).linear_iterations;
  };
  return {count(1), count(2)};
}

// Iterations of an incomplete factorisation grow with the points along an edge: here to more than twice as many.
TEST(SteadyStateParallel, TakesAsManyLinearIterationsWithMorePoints) {
  const std::string walls = R"toml(
[boundary.cold]
on = "xmin"
temperature = "0 K"
[boundary.warm]
on = "zmax"
convection = { h = "3 W/(m^2 K)", ambient = "1 K" }
[steady]
)toml";
  const std::vector<std::string> cube = {"1 m", "1 m", "1 m"};
  const std::string inclusion = R"toml(
[body]
material = "m"
[material.copper]
conductivity = "1000 W/(m K)"
[[body.region]]
material = "copper"
where = "max(abs(x - 0.5), max(abs(y - 0.5), abs(z - 0.5))) < 0.2"
length = "m"
)toml";
  const struct {
    std::string what;
    std::vector<std::string> size;
    std::vector<int> points;
    std::string rest;
  } bodies[] = {
      {"a cube", cube, {15, 15, 15}, simple_material({.k = "1"})},
      {"with k(T)", cube, {15, 15, 15}, simple_material({.k = "exp(2*T)"})},
      {"with k(x, T)", cube, {15, 15, 15}, simple_material({.k = "(0.2 + x)*exp(T) + (1 - x)*(0.3 + 0.5*T)"})},
      {"with an inclusion", cube, {15, 15, 15}, simple_material({.k = "1"}) + inclusion},
  };
  for (const auto& body : bodies) {
    const auto [few, many] = linear_iterations(body.size, body.points, body.rest + walls, MPI_COMM_WORLD);
    EXPECT_GT(few, 5) << body.what;  // none of these is solved directly
    EXPECT_LE(many, 1.5 * few + 4) << body.what;
  }
}

TEST(SteadyState, BalancesRadiationAndFlux) {
  // A plate heated by 5 kW/m^2 on one side radiates them on the other: T = (q / (eps sigma) + T_a^4)^(1/4) there, and
  // q L / k more on the heated side.
  const CaseModel m(box_case({"0.1 m", "0.05 m"}, {11, 6}) + R"toml(
jitter = 0.2
[material.m]
conductivity = "2 W/(m K)"
[boundary.xmin]
flux = "5 kW/m^2"
[boundary.xmax]
radiation = { emissivity = 0.7, ambient = "300 K" }
[steady]
)toml");
  const State state = m.steady();
  const double cold = std::pow(5000 / (0.7 * 5.670374419e-8) + std::pow(300, 4), 0.25);
  for (int i = 0; i < m.cloud().owned; ++i) EXPECT_NEAR(state.T[i], cold + 5000 / 2. * (0.1 - m.cloud().x[i].x), 1e-7);
}

TEST(SteadyState, IsFoundWhereABodyRadiatesToSpace) {
  for (const std::string method : {"sph", "peridynamics", "mlpg"}) {
    const CaseModel m(box_case({"10 mm"}, {11}, method) + R"toml(
[material.m]
conductivity = "10 W/(m K)"
[boundary.xmin]
flux = "1 MW/m^2"
[boundary.xmax]
radiation = { emissivity = 1, ambient = "0 K" }
[steady]
)toml");
    State state = m.steady();
    const std::vector<double> T = m.system().temperatures(state.T);
    const double cold = std::pow(1e6 / 5.670374419e-8, 0.25);
    for (int i = 0; i < m.cloud().owned; ++i) EXPECT_NEAR(T[i], cold + 1e5 * (0.01 - m.cloud().x[i].x), 1e-6) << method;
  }
}

TEST(SteadyState, OfAPropertyThatTurnsNegativeIsRefusedWithPointAndTemperature) {
  // At 500 K the conductivity is zero; 2 kW/m^2 would need more.
  const std::string material = simple_material({.k = "(5 - 0.01*T)*(1 + x)/2", .rho = "1", .c = "1"});
  const std::string text = box_case({"1 m"}, {6}) + material + R"toml(
[initial]
temperature = "300 K"
[boundary.xmin]
temperature = "300 K"
[boundary.xmax]
flux = "2 kW/m^2"
)toml";
  const auto expect_reason = [](const std::function<void()>& work) {
    expect_error(work, {"conductivity of 'm' is -", "at (1, 0, 0) m, T = 5"}, Fault::numbers);
  };
  const CaseModel steady(text + "[steady]\n");
  expect_reason([&] { steady.steady(); });
  for (const Named& kind : all_integrators()) {
    const CaseModel m(text + "[time]\nend = \"1 s\"\n");
    State state = m.start();
    expect_reason([&] { kind.make(steps_of(0.005))->advance(m.system(), state, 1, go_on); });
  }
}

/// Wall points of the paper on SPH, which hold no heat, with k(T).
const std::string algebraic_walls = simple_material({.k = "1 + 0.002*T", .rho = "1", .c = "1"}) + R"toml(
[sph]
correction = "paper"
[boundary.xmin]
temperature = "300 K"
[boundary.xmax]
convection = { h = "3 W/(m^2 K)", ambient = "500 K" }
radiation = { emissivity = 0.7, ambient = "400 K" }
[boundary.ymin]
flux = "70 W/m^2"
)toml";

TEST(SteadyState, OfAlgebraicWallsIsThatOfTheirMarch) {
  const std::string text = box_case({"1 m", "1 m"}, {6, 6}) + algebraic_walls;
  const State at_rest = CaseModel(text + "[steady]\n").steady();
  const CaseModel marching(text + "[initial]\ntemperature = \"350 K\"\n[time]\nend = \"10 s\"\n");
  State state = marching.start();
  maker("euler")({})->advance(marching.system(), state, 10, go_on);
  EXPECT_LE(largest_difference(at_rest.T, state.T), 1e-8);
}

TEST(AlgebraicWalls, AreMarchedAlikeByAllIntegratorsThatKnowThem) {
  // Massless wall points follow the others without delay: what is left is the error of time, of the first order for the
  // two Euler methods (which err to opposite sides), of the second for the others.
  const std::string text = box_case({"1 m", "0.6 m"}, {8, 6}) + algebraic_walls +
                           "[initial]\ntemperature = \"350 K\"\n[time]\nend = \"0.1 s\"\n";
  const auto at_end = [&](const auto& make, double step) {
    const CaseModel m(text);
    State state = m.start();
    make(steps_of(step))->advance(m.system(), state, 0.1, go_on);
    return state.T;
  };
  const auto exact = at_end(maker("tr-bdf2"), 2.5e-4);
  const auto order = [&](const auto& make) {
    const double coarse = largest_difference(at_end(make, 4e-3), exact),
                 fine = largest_difference(at_end(make, 2e-3), exact);
    EXPECT_LE(fine, 1);  // K, of a span of 200
    return std::log2(coarse / fine);
  };
  EXPECT_NEAR(order(maker("backward-euler")), 1, 0.15);
  EXPECT_NEAR(order(maker("crank-nicolson")), 2, 0.4);
  EXPECT_NEAR(order(maker("tr-bdf2")), 2, 0.4);
  const auto euler = at_end(maker("euler"), 5e-4), half = at_end(maker("euler"), 2.5e-4);
  EXPECT_NEAR(largest_difference(euler, exact) / largest_difference(half, exact), 2, 0.2);
}

TEST(SteadyState, EndsATransientRunThatReachesIt) {
  const auto end_of = [](const std::string& bound) {
    const std::string text = box_case({"1 m"}, {9}) + simple + R"toml(
[initial]
temperature = "0 K"
[boundary.xmin]
temperature = "1 K"
[time]
end = "100 s"
integrator = "tr-bdf2"
)toml";
    return run_into("", text + bound).numbers;
  };
  EXPECT_EQ(end_of("").at("end"), 100);
  // The slowest mode decays like exp(-(pi/2)^2 t), its rate is 4/pi (pi/2)^2 exp(...): 1e-4 K/s after 4.2 s. The mean
  // rate of the last step counts.
  constexpr double pi = std::numbers::pi;
  const double expected = std::log(4 / pi * std::pow(pi / 2, 2) / 1e-4) / std::pow(pi / 2, 2);
  const auto numbers = end_of("steady_below = \"1e-4 K/s\"\n");
  EXPECT_GE(numbers.at("end"), 0.95 * expected);
  EXPECT_LE(numbers.at("end"), expected + 2 * numbers.at("largest_step"));
}

TEST(SteadyState, DoesNotEndARunBeforeASourceBegins) {
  // 1 W/m^2 from 50 s on, into a wall that is held on its other side: 1 K more in the end.
  const std::string text = box_case({"1 m"}, {9}) + simple + R"toml(
[initial]
temperature = "0 K"
[boundary.xmin]
temperature = "0 K"
[boundary.xmax]
flux = { formula = "t > 50 ? 1 : 0", unit = "W/m^2" }
[probe]
hot = ["1 m"]
[time]
end = "100 s"
integrator = "tr-bdf2"
steady_below = "1e-6 K/s"
)toml";
  const RunResult result = run_into("", text);
  EXPECT_GT(result.numbers.at("end"), 55);
  EXPECT_LT(result.numbers.at("end"), 65);
  EXPECT_NEAR(result.highest.T, 1, 1e-4);
}

TEST(Integrators, DoNotStepOverAPulseThatAFormulaGives) {
  // What a body at rest is given in a thousandth of the run warms it by 100 K, whatever the shape of the pulse in time.
  for (const char* pulse : {"t > 0.5 && t < 0.501 ? 1e5 : 0", "1e4*exp(-pi*((t - 0.5)/0.01)^2)"}) {
    SCOPED_TRACE(pulse);
    const CaseModel m(box_case({"1 m"}, {9}) + simple + "[initial]\ntemperature = \"300 K\"\n" +
                      fmt::format("[boundary.xmin]\nflux = {{ formula = \"{}\", unit = \"W/m^2\" }}\n", pulse) +
                      "[time]\nend = \"1 s\"\nintegrator = \"tr-bdf2\"\n");
    State state = m.start();
    const double E = std::accumulate(state.E.begin(), state.E.end(), 0.0);
    make_integrator(m.description(), m.system(), state)->advance(m.system(), state, 1, [](const State&) {
      return true;
    });
    EXPECT_NEAR(std::accumulate(state.E.begin(), state.E.end(), 0.0) - E, 100, 0.05);
  }
}

TEST(Integrators, AreStableByExplicitStepsOfMlpgWhereTheDiffusivityGrowsAsItCools) {
  // Ice and the like: 8 times the diffusivity where it is cold, near the wall. Against implicit steps.
  const auto at_end = [](const std::string& integrator) {
    const CaseModel m(box_case({"0.1 m"}, {21}, "mlpg") + R"toml(
[mlpg]
capacity = "one-point"
[material.m]
conductivity = { table = [[200, 4], [300, 1]], unit = "W/(m K)", temperature = "K" }
density = "1000 kg/m^3"
specific_heat = { table = [[200, 2000], [300, 4000]], unit = "J/(kg K)", temperature = "K" }
[initial]
temperature = "300 K"
[boundary.xmin]
temperature = "200 K"
[time]
end = "1 h"
)toml" + "integrator = \"" +
                      integrator + "\"\n");
    State state = m.start();
    make_integrator(m.description(), m.system(), state)->advance(m.system(), state, 3600, [](const State&) {
      return true;
    });
    return m.system().temperatures(state.T);
  };
  const auto euler = at_end("euler"), implicit = at_end("tr-bdf2");
  for (std::size_t i = 0; i < euler.size(); ++i) EXPECT_NEAR(euler[i], implicit[i], 0.2);
}

}  // namespace
}  // namespace calor
