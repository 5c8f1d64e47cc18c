#include "solve/heat_system.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "case_models.hpp"
#include "solve/integrator.hpp"

namespace calor {
namespace {

const std::string lattice_plate = box_case({"0.5 m", "0.4 m"}, {6, 5}) + "thickness = \"0.1 m\"\n";
const std::string jittered_plate = lattice_plate + "jitter = 0.2\n";

const std::string of_T_alone = simple_material({.k = "20 + 0.03*T + 1e-5*T^2", .rho = "8000", .c = "400 + 0.2*T"});
const std::string of_place_and_T =
    simple_material({.k = "(20 + 0.03*T)*(1 + x + y^2)", .rho = "8000*(1 + x)", .c = "400 + 0.2*T"});
const std::string constant = simple_material({.k = "20", .rho = "8000", .c = "400"});
const std::string two_layers = simple_material({.name = "a", .k = "20 + 0.03*T", .rho = "8000", .c = "400"}) + R"toml(
[material.b]
conductivity = { table = [[250, 1], [500, 2], [800, 7], [1200, 8]], unit = "W/(m K)", interpolation = "cubic" }
density = "2000 kg/m^3"
specific_heat = { table = [[250, 700], [500, 800], [1200, 900]], unit = "J/(kg K)", interpolation = "cubic" }
[body]
along = "x"
[[body.layer]]
material = "a"
thickness = "0.25 m"
[[body.layer]]
material = "b"
thickness = "0.25 m"
)toml";
/// Of temperature and time.
const std::string contact = "contact = { formula = \"20 + 0.05*T + 1e-7*T^3 + 10*t\", unit = \"W/(m^2 K)\" }\n";
/// A layer between the points, with contacts on both sides that hang on each other.
const std::string between_contacts = replaced(replaced(two_layers, "0.25 m", "0.21 m"), "0.25 m", "0.28 m") + contact +
                                     "[[body.layer]]\nmaterial = \"a\"\nthickness = \"0.01 m\"\n" + contact;
const std::string graded = simple_material({.name = "a", .k = "20 + 0.03*T", .rho = "8000", .c = "400 + 0.2*T"}) +
                           simple_material({.name = "b", .k = "5 + 4e-6*T^2", .rho = "3000", .c = "800"}) + R"toml(
[material.m]
mix = "voigt"
phases = ["a", "b"]
fraction = { formula = "x/0.5" }
basis = "mass"
)toml";

/// Everything that can enter a derivative by temperature, and a wall of prescribed temperature.
const std::string all_exchanges = R"toml(
[initial]
temperature = "500 K"
[boundary.hot]
on = "xmin"
temperature = { formula = "600 + 40*t + 50*y", unit = "K" }
[boundary.air]
on = "xmax"
convection = { h = { formula = "50 + 0.2*T + 10*t", unit = "W/(m^2 K)" }, ambient = "300 K" }
radiation = { emissivity = { formula = "0.3 + 2e-4*T" }, ambient = { formula = "300 + 20*t", unit = "K" } }
[boundary.burner]
on = "ymax"
flux = { formula = "2000 - 3*T", unit = "W/m^2" }
[source.reaction]
power_density = { formula = "1e4*exp(-T/1000)*(1 + x)", unit = "W/m^3" }
[time]
end = "1 s"
)toml";
const std::string insulated = R"toml(
[initial]
temperature = "500 K"
[time]
end = "1 s"
)toml";
const std::string arithmetic = "[body]\nconductivity_mean = \"arithmetic\"\n";
const std::string harmonic = "[body]\nconductivity_mean = \"harmonic\"\n";
const std::string paper = "[sph]\ncorrection = \"paper\"\n";

struct Named {
  std::string name, text;
};

/// Cases of every mean, with and without algebraic walls.
const std::vector<Named>& systems() {
  static const std::vector<Named> all = {
      {"integral mean", jittered_plate + of_T_alone + all_exchanges},
      {"arithmetic mean of k(T)", jittered_plate + of_T_alone + arithmetic + all_exchanges},
      {"arithmetic mean of k(x, T)", jittered_plate + of_place_and_T + all_exchanges},
      {"harmonic mean of k(T)", jittered_plate + of_T_alone + harmonic + all_exchanges},
      {"layers", lattice_plate + two_layers + all_exchanges},
      {"walls that cut layers", lattice_plate + "at = \"cells\"\n" +
                                    replaced(replaced(two_layers, "0.25 m", "0.23 m"), "0.25 m", "0.27 m") +
                                    all_exchanges},
      {"a layer before a wall", lattice_plate + "at = \"cells\"\n" +
                                    replaced(replaced(two_layers, "0.25 m", "0.47 m"), "0.25 m", "0.03 m") +
                                    all_exchanges},
      {"a contact between points", lattice_plate + two_layers + contact + all_exchanges},
      {"a contact that cuts points off", jittered_plate + two_layers + contact + all_exchanges},
      {"two contacts in one pair", lattice_plate + between_contacts + all_exchanges},
      {"mixture", jittered_plate + graded + all_exchanges},
      {"constant properties", lattice_plate + constant + all_exchanges},
      {"algebraic walls, integral mean", lattice_plate + of_T_alone + paper + all_exchanges},
      {"algebraic walls, arithmetic mean", lattice_plate + of_place_and_T + paper + all_exchanges},
      {"algebraic walls, layers", lattice_plate + two_layers + paper + all_exchanges},
  };
  return all;
}

Eigen::MatrixXd jacobian(HeatSystem& system, double t, std::vector<double> T, double capacity_factor,
                         double rate_factor) {
  const int n = system.cloud().owned;
  const petsc::Matrix J = system.create_jacobian();
  system.jacobian(t, T, capacity_factor, rate_factor, J);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  for (PetscInt i = 0; i < n; ++i) {
    PetscInt count = 0;
    const PetscInt* column = nullptr;
    const PetscScalar* value = nullptr;
    MatGetRow(J, i, &count, &column, &value);
    for (PetscInt m = 0; m < count; ++m) dense(i, column[m]) = value[m];
    MatRestoreRow(J, i, &count, &column, &value);
  }
  return dense;
}

/// d/dT_j of the residual, capacity_factor (0 or 1) E - rate_factor F, by differences of fourth order.
Eigen::VectorXd column_by_differences(HeatSystem& system, double t, const std::vector<double>& T, int j,
                                      double capacity_factor, double rate_factor) {
  constexpr double step = 0.1;  // K
  const int n = system.cloud().owned;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
  for (const auto& [at, weight] : {std::pair{-2., 1. / 12}, {-1., -8. / 12}, {1., 8. / 12}, {2., -1. / 12}}) {
    std::vector<double> moved = T, R(n);
    const std::vector<double> known(capacity_factor == 0 ? 0 : n);
    moved[j] += at * step;
    system.residual(t, moved, rate_factor, known, R);
    for (int i = 0; i < n; ++i) sum[i] += weight / step * R[i];
  }
  return sum;
}

TEST(HeatSystem, HasTheJacobianOfItsResidual) {
  for (const auto& [name, text] : systems()) {
    SCOPED_TRACE(name);
    const CaseModel m(text);
    HeatSystem& system = m.system();
    const int n = m.cloud().owned;
    const std::vector<double> T = scattered_temperatures(m.cloud(), 600, 200);
    const auto held = system.prescribed();
    for (const auto& [capacity_factor, rate_factor] : {std::pair{0., 1.}, {1., 50.}}) {
      const double t = 0.3;
      const Eigen::MatrixXd J = jacobian(system, t, T, capacity_factor, rate_factor);
      double worst = 0;
      for (int j = 0; j < n; ++j) {
        if (std::ranges::count(held, j)) {
          EXPECT_GT(J(j, j), 0);  // in the unit of the other rows
          EXPECT_EQ(J.col(j), J(j, j) * Eigen::VectorXd::Unit(n, j));
          EXPECT_EQ(J.row(j), J(j, j) * Eigen::RowVectorXd::Unit(n, j));
          continue;
        }
        const Eigen::VectorXd column = column_by_differences(system, t, T, j, capacity_factor, rate_factor);
        for (int i = 0; i < n; ++i) {
          if (std::ranges::count(held, i)) continue;
          worst = std::max(worst, std::abs(J(i, j) - column[i]) / J.row(i).cwiseAbs().maxCoeff());
        }
      }
      EXPECT_LE(worst, 1e-8);  // 1e-6 is promised
    }
  }
}

/// By MLPG, with the parameters of moving least squares as unknowns.
std::string by_parameters(const std::string& text, const std::string& capacity) {
  return replaced(text, "\"sph\"", "\"mlpg\"") + "[mlpg]\ncapacity = \"" + capacity + "\"\n";
}

Eigen::MatrixXd values_of_parameters(HeatSystem& system) {
  const SparseRows& phi = system.dofs().phi();
  Eigen::MatrixXd Phi = Eigen::MatrixXd::Zero(system.cloud().owned, system.cloud().owned);
  for (int i = 0; i < Phi.rows(); ++i)
    for (auto n = phi.row[i]; n < phi.row[i + 1]; ++n) Phi(i, phi.column[n]) = phi.value[n];
  return Phi;
}

TEST(HeatSystem, HasTheJacobianOfItsResidualForParametersToo) {
  const std::string plate = jittered_plate + of_place_and_T + all_exchanges;
  const std::string consistent = by_parameters(plate, "consistent"), one_point = by_parameters(plate, "one-point");
  for (const std::string& text : {consistent, one_point, one_point + "prescribed = \"penalty\"\n"}) {
    const CaseModel m(text);
    HeatSystem& system = m.system();
    const int n = m.cloud().owned;
    m.start();  // sets the scale of the rows of prescribed points
    const std::vector<double> T = scattered_temperatures(m.cloud(), 600, 200);
    const double t = 0.3, factor = 50;
    const Eigen::MatrixXd J = jacobian(system, t, T, 1, factor);
    double worst = 0;
    for (int j = 0; j < n; ++j) {
      const Eigen::VectorXd exact = column_by_differences(system, t, T, j, 1, factor);
      for (int i = 0; i < n; ++i)
        worst = std::max(worst, std::abs(J(i, j) - exact[i]) / J.row(i).cwiseAbs().maxCoeff());
    }
    EXPECT_LE(worst, 1e-8) << text;
  }
}

TEST(HeatSystem, KnowsWhenItsJacobianIsSymmetricAndConstant) {
  for (const auto& [name, text] : systems()) {
    SCOPED_TRACE(name);
    const CaseModel m(text);
    const auto T = scattered_temperatures(m.cloud(), 600, 200);
    const Eigen::MatrixXd J = jacobian(m.system(), 0, T, 1, 10);
    if (m.system().jacobian_is_symmetric()) {
      EXPECT_LE((J - J.transpose()).norm(), 1e-12 * J.norm());
    }
    if (m.system().jacobian_is_constant()) {
      EXPECT_LE((J - jacobian(m.system(), 1, T, 1, 10)).norm(), 1e-12 * J.norm());
    }
  }
  const std::string convection = "[boundary.xmax]\nconvection = { h = \"30 W/(m^2 K)\", ambient = \"300 K\" }\n";
  const CaseModel simple(jittered_plate + constant + convection + insulated);
  EXPECT_TRUE(simple.system().jacobian_is_symmetric());
  EXPECT_TRUE(simple.system().jacobian_is_constant());
  EXPECT_FALSE(CaseModel(jittered_plate + of_T_alone + convection + insulated).system().jacobian_is_symmetric());
}

const std::vector<Named>& materials() {
  static const std::vector<Named> all = {
      {"constant", constant},
      {"c(T)", of_T_alone},
      {"rho(x), c(T)", of_place_and_T},
      {"layers, one with a table", two_layers},
      {"mixture by mass", graded},
      {"rho(T), c(T)", simple_material({.k = "20", .rho = "8000 - 0.3*T", .c = "400 + 0.2*T"})},
      {"c(x, T)", simple_material({.k = "20", .rho = "8000", .c = "400*(1 + x) + 0.2*T"})},
      {"a peak in c(T), as of a change of phase",
       simple_material({.k = "20", .rho = "8000", .c = "500 + 20000*exp(-((T - 700)/10)^2)"})}};
  return all;
}

TEST(HeatSystem, FindsTheTemperaturesOfItsEnthalpies) {
  for (const auto& [name, text] : materials()) {
    const CaseModel m(jittered_plate + text + insulated);
    const int n = m.cloud().owned;
    EXPECT_TRUE(rc::check("temperature(energy(T)) is T, whatever the guess: " + name, [&] {
      const double seed = *rc::gen::inRange(0, 100000);
      const auto T = scattered_temperatures(m.cloud(), 700, 400, seed);
      auto found = scattered_temperatures(m.cloud(), 700, 400, seed + 11);
      std::vector<double> E(n);
      m.system().energy(T, E);
      m.system().temperature(E, found);
      for (int i = 0; i < n; ++i) RC_ASSERT(std::abs(found[i] - T[i]) <= 1e-12 * T[i]);
    }));
  }
}

TEST(HeatSystem, FindsTheParametersOfItsEnthalpies) {
  for (const auto& [name, text] : materials()) {
    const CaseModel m(by_parameters(jittered_plate + text + insulated, "one-point"));
    const int n = m.cloud().owned;
    const Eigen::MatrixXd Phi = values_of_parameters(m.system());
    const auto T = scattered_temperatures(m.cloud(), 700, 50);
    auto found = scattered_temperatures(m.cloud(), 700, 50, 11);
    std::vector<double> E(n);
    m.system().energy(T, E);
    m.system().temperature(E, found);
    for (int i = 0; i < n; ++i) {
      double difference = 0;
      for (int j = 0; j < n; ++j) difference += Phi(i, j) * (found[j] - T[j]);
      EXPECT_LE(std::abs(difference), 1e-10) << name;
    }
  }
}

TEST(HeatSystem, HasTheCapacityThatItsEnthalpyHas) {
  for (const auto& [name, text] : materials()) {
    SCOPED_TRACE(name);
    const CaseModel m(jittered_plate + text + insulated);
    const auto T = scattered_temperatures(m.cloud(), 700, 300);
    const int n = m.cloud().owned;
    constexpr double step = 0.05;
    std::vector<double> C(n), sum(n), E(n);
    m.system().capacity(T, C);
    for (const auto& [at, weight] : {std::pair{-2., 1. / 12}, {-1., -8. / 12}, {1., 8. / 12}, {2., -1. / 12}}) {
      auto moved = T;
      for (double& value : moved) value += at * step;
      m.system().energy(moved, E);
      for (int i = 0; i < n; ++i) sum[i] += weight / step * E[i];
    }
    for (int i = 0; i < n; ++i) EXPECT_NEAR(sum[i] / C[i], 1, 1e-8);
  }
}

TEST(HeatSystem, BooksTheHeatThroughWallsHeldByAPenalty) {
  // T = 600 K - 300 K/m x: 20 W/(m K) * 300 K/m through the wall of 0.4 m * 0.1 m, exact by moving least squares.
  const std::string walls =
      "[boundary.xmin]\ntemperature = \"600 K\"\n[boundary.xmax]\ntemperature = \"450 K\"\n[steady]\n";
  const CaseModel m(by_parameters(jittered_plate + constant + walls, "consistent") + "prescribed = \"penalty\"\n");
  State state = m.steady();
  const auto [F, power] = m.rates(0, state.T);
  EXPECT_NEAR(power[0], 240, 1e-7);
  EXPECT_NEAR(power[1], -240, 1e-7);
  const std::vector<double> T = m.system().temperatures(state.T);
  for (int i = 0; i < m.cloud().owned; ++i) EXPECT_NEAR(T[i], 600 - 300 * m.cloud().x[i].x, 1e-8);
}

TEST(HeatSystem, KeepsPrescribedPointsWhateverTheirEnthalpy) {
  const CaseModel m(jittered_plate + of_T_alone + all_exchanges);
  State state = m.start();
  const auto T = state.T;
  for (int i : m.system().prescribed()) state.E[i] = -1e12;
  m.system().temperature(state.E, state.T);
  for (int i : m.system().prescribed()) EXPECT_EQ(state.T[i], T[i]);
}

TEST(HeatSystem, BooksTheReactionOfPrescribedWalls) {
  // The jump from 500 K to the walls' 600 K + 50 K/m y takes the heat that the wall points then hold more.
  const CaseModel m(jittered_plate + constant + all_exchanges);
  const State before = m.start_without_walls(), after = m.start();
  double expected = 0;
  for (int i : m.system().prescribed()) {
    EXPECT_NEAR(after.T[i], 600 + 50 * m.cloud().x[i].y, 1e-10);
    expected += 8000 * 400 * m.cloud().volume[i] * (after.T[i] - 500);
  }
  EXPECT_GT(expected, 0);
  EXPECT_NEAR(after.cumulative_heat[0] / expected, 1, 1e-12);
  for (std::size_t a = 1; a < after.cumulative_heat.size(); ++a) EXPECT_EQ(after.cumulative_heat[a], 0);
  EXPECT_EQ(m.system().accounts(), (std::vector<std::string>{"hot", "air", "burner", "reaction"}));
  EXPECT_EQ(m.system().boundary_accounts(), 3);
}

TEST(HeatSystem, ConservesHeatOnAnyCloud) {
  EXPECT_TRUE(rc::check("the heat rates of all points add up to the powers of the accounts", [] {
    const int dimension = *rc::gen::inRange(1, 4), seed = *rc::gen::inRange(1, 1000);
    const int material = *rc::gen::inRange(0, 3), n = *rc::gen::inRange(4, dimension == 3 ? 6 : 9);
    // Some clouds of few points in space that are jittered more have no good weights, and are refused.
    const std::string each = fmt::format("{:.1f}", *rc::gen::inRange(0, dimension == 3 ? 3 : 4) / 10.);
    const std::string cloud = box_case(std::vector<std::string>(dimension, "0.5 m"), std::vector<int>(dimension, n)) +
                              fmt::format("jitter = {}\nseed = {}\n", each, seed);
    const std::string exchanges = R"toml(
[boundary.air]
on = "xmax"
convection = { h = { formula = "50 + 0.2*T", unit = "W/(m^2 K)" }, ambient = "300 K" }
radiation = { emissivity = 0.8, ambient = "400 K" }
[boundary.burner]
where = "x < 0.3"
flux = { formula = "2e4*(1 + y)", unit = "W/m^2" }
[source.reaction]
power_density = { formula = "1e6*exp(-T/1000)*(1 + x)", unit = "W/m^3" }
)toml";
    const CaseModel m(cloud + std::vector{of_T_alone, of_place_and_T, two_layers}[material] + exchanges + insulated);
    const auto [F, power] = m.rates(0.1, scattered_temperatures(m.cloud(), 600, 200, seed));
    double net = 0, gross = 0;
    for (double f : F) net += f, gross += std::abs(f);
    for (double p : power) net -= p, gross += std::abs(p);
    RC_ASSERT(std::abs(net) <= 1e-13 * gross);
    for (double p : power) RC_ASSERT(p != 0);
  }));
}

TEST(HeatSystem, IsAtRestAtOneTemperature) {
  for (const std::string& material : {constant, of_T_alone, of_place_and_T, two_layers, graded}) {
    const CaseModel m(jittered_plate + material + insulated);
    const auto [F, power] = m.rates(0, m.uniform(612.3));
    for (double f : F) EXPECT_EQ(f, 0);
  }
}

TEST(HeatSystem, GivesTheExactFluxOfALinearTemperature) {
  const CaseModel m(jittered_plate + constant + insulated);
  std::vector<double> T(m.cloud().local());
  for (int i = 0; i < m.cloud().local(); ++i) T[i] = 300 + 70 * m.cloud().x[i].x - 40 * m.cloud().x[i].y;
  std::vector<Vec3> q(m.cloud().owned);
  m.system().heat_flux(0, T, q);
  for (const Vec3& flux : q) {
    EXPECT_NEAR(flux.x, -20 * 70, 1e-9);
    EXPECT_NEAR(flux.y, 20 * 40, 1e-9);
    EXPECT_EQ(flux.z, 0);
  }
}

/// The largest eigenvalue of C^-1 J, where J is the Jacobian of free points alone.
double largest_eigenvalue(HeatSystem& system, const std::vector<double>& T) {
  Eigen::MatrixXd J = jacobian(system, 0, T, 0, 1);
  std::vector<double> C(system.cloud().owned);
  system.capacity(T, C);
  for (int i = 0; i < J.rows(); ++i) J.row(i) /= C[i];
  for (int i : system.prescribed()) J(i, i) = 0;
  return J.eigenvalues().real().maxCoeff();
}

TEST(HeatSystem, FindsItsLargestRateFromBelowWithinAPercent) {
  // Properties that depend on T come in frozen: J itself would have terms in dk/dT.
  const std::string walls = R"toml(
[boundary.hot]
on = "xmin"
temperature = "600 K"
[boundary.air]
on = "xmax"
convection = { h = "5 kW/(m^2 K)", ambient = "300 K" }
)toml";
  const std::string of_place = simple_material({.k = "20*(1 + 5*x)", .rho = "8000*(1 + y)", .c = "400"});
  for (const std::string& text : {jittered_plate + constant, jittered_plate + of_place, lattice_plate + constant}) {
    const CaseModel m(text + walls + insulated);
    auto T = scattered_temperatures(m.cloud(), 600, 200);
    const double exact = largest_eigenvalue(m.system(), T), found = m.system().largest_rate(0, T);
    EXPECT_LE(found, exact * (1 + 1e-10));
    EXPECT_GE(found, exact * 0.99);
  }
}

TEST(HeatSystem, BoundsItsLargestRate) {
  for (const auto& [name, text] : systems()) {
    const CaseModel m(text);
    EXPECT_TRUE(rc::check("the Gershgorin bound is not below the largest rate: " + name, [&] {
      auto T = scattered_temperatures(m.cloud(), 600, 200, *rc::gen::inRange(0, 100000));
      RC_ASSERT(m.system().rate_bound(0, T) >= m.system().largest_rate(0, T) * (1 - 1e-12));
    }));
  }
}

TEST(HeatSystem, KnowsTheLargestRateOfExplicitStepsOfParameters) {
  // The largest eigenvalue of C^-1 J Phi^-1 between free points: what explicit steps of the enthalpies see.
  const std::string wall = "[boundary.xmin]\ntemperature = \"600 K\"\n";
  for (const std::string& cloud : {lattice_plate, jittered_plate})
    for (const std::string& walls : {std::string(), wall}) {
      const CaseModel m(by_parameters(cloud + constant + walls + insulated, "one-point"));
      HeatSystem& system = m.system();
      State state = m.start();
      Eigen::MatrixXd A = jacobian(system, 0, state.T, 0, 1) * values_of_parameters(system).inverse();
      std::vector<double> C(m.cloud().owned);
      system.capacity(state.T, C);
      for (int i = 0; i < A.rows(); ++i) A.row(i) /= C[i];
      for (const int i : system.prescribed()) A.row(i).setZero(), A.col(i).setZero();
      const double exact = A.eigenvalues().real().maxCoeff();
      const double bound = system.explicit_rate_bound(0, state.T);
      EXPECT_GE(bound, exact);
      EXPECT_LE(bound, 1.1 * exact);
    }
}

std::string rod(const std::string& at, int points) {
  return box_case({"0.8 m"}, {points}) + fmt::format("at = \"{}\"\nsection = \"0.01 m^2\"\n", at) + constant;
}

TEST(HeatSystem, HasTheRatesOfARodThatAreKnown) {
  const double a = 20 / (8000. * 400), dx = 0.1;
  // Points on the walls, insulated: the fastest mode alternates in sign from point to point and decays with 4 a / dx^2,
  // which is the bound.
  const CaseModel walls(rod("walls", 9) + insulated);
  State state = walls.start();
  EXPECT_NEAR(walls.system().rate_bound(0, state.T) * dx * dx / (4 * a), 1, 1e-12);
  EXPECT_NEAR(walls.system().largest_rate(0, state.T) * dx * dx / (4 * a), 1, 1e-6);

  // Cells, insulated: 2 a / dx^2 (1 - cos(pi (n - 1) / n)).
  const CaseModel cells(rod("cells", 8) + insulated);
  state = cells.start();
  EXPECT_NEAR(cells.system().rate_bound(0, state.T) * dx * dx / (4 * a), 1, 1e-12);
  EXPECT_NEAR(cells.system().largest_rate(0, state.T) * dx * dx / (2 * a), 1 - std::cos(std::numbers::pi * 7 / 8),
              1e-5);

  // Both ends prescribed: 7 free points between, 2 a / dx^2 (1 + cos(pi / 8)).
  const CaseModel held(rod("walls", 9) +
                       "[boundary.xmin]\ntemperature = \"600 K\"\n[boundary.xmax]\ntemperature = \"300 K\"\n" +
                       insulated);
  state = held.start();
  EXPECT_NEAR(held.system().rate_bound(0, state.T) * dx * dx / (4 * a), 1, 1e-12);
  EXPECT_NEAR(held.system().largest_rate(0, state.T) * dx * dx / (2 * a), 1 + std::cos(std::numbers::pi / 8), 1e-5);

  // Convection: the wall point holds half a cell, so the bound there is (4 k / dx^2 + 2 h / dx) / (rho c).
  const CaseModel air(rod("walls", 9) +
                      "[boundary.xmax]\nconvection = { h = \"90 W/(m^2 K)\", ambient = \"300 K\" }\n" + insulated);
  state = air.start();
  EXPECT_NEAR(air.system().rate_bound(0, state.T) * (8000. * 400) / (4 * 20 / (dx * dx) + 2 * 90 / dx), 1, 1e-12);
}

TEST(HeatSystem, KnowsWhatFixesTheLevelOfASteadyTemperature) {
  const auto is_fixed = [](const std::string& conditions) {
    return CaseModel(jittered_plate + constant + conditions + insulated).system().level_is_fixed();
  };
  EXPECT_FALSE(is_fixed(""));
  EXPECT_FALSE(is_fixed("[boundary.xmin]\ninsulated = true\n"));
  EXPECT_FALSE(is_fixed("[boundary.xmin]\nflux = \"10 W/m^2\"\n"));
  EXPECT_FALSE(is_fixed("[source.s]\npower_density = \"10 W/m^3\"\n"));
  EXPECT_TRUE(is_fixed("[boundary.xmin]\ntemperature = \"300 K\"\n"));
  EXPECT_TRUE(is_fixed("[boundary.xmin]\nconvection = { h = \"3 W/(m^2 K)\", ambient = \"300 K\" }\n"));
  EXPECT_TRUE(is_fixed("[boundary.xmin]\nradiation = { emissivity = 0.5, ambient = \"300 K\" }\n"));
  const std::string free = jittered_plate + constant + "[boundary.xmin]\nflux = \"10 W/m^2\"\n[steady]\n";
  expect_words(error_of([&] { CaseModel(free).steady(); }).what(), {"nothing fixes the level"});
}

TEST(HeatSystem, NamesThePointWhoseTemperatureIsNotFinite) {
  const CaseModel m(jittered_plate + constant + insulated);
  State state = m.start();
  m.system().require_finite(0, state.T);
  state.T[7] = std::numeric_limits<double>::quiet_NaN();
  expect_error([&] { m.system().require_finite(2.5, state.T); },
               {fmt::format("point {}", m.cloud().id[7]), fmt::format("({:.6g}", m.cloud().x[7].x), "t = 2.5 s"},
               Fault::numbers);
}

TEST(HeatSystemParallel, GivesTheSameRatesOnAnyNumberOfRanks) {
  for (const auto& [name, text] : systems()) {
    SCOPED_TRACE(name);
    const CaseModel alone(text), shared(text, MPI_COMM_WORLD);
    const auto rates = [](const CaseModel& m) {
      auto T = scattered_temperatures(m.cloud(), 600, 200);
      std::vector<double> R(m.cloud().owned);
      m.system().residual(0.2, T, 1, {}, R);
      return by_id(m.cloud(), R);
    };
    EXPECT_EQ(rates(alone), rates(shared));
    auto a = scattered_temperatures(alone.cloud(), 600, 200), b = scattered_temperatures(shared.cloud(), 600, 200);
    EXPECT_EQ(alone.system().rate_bound(0, a), shared.system().rate_bound(0, b));
    EXPECT_NEAR(alone.system().largest_rate(0, a) / shared.system().largest_rate(0, b), 1, 1e-6);
    EXPECT_EQ(alone.system().temperature_span(0, a), shared.system().temperature_span(0, b));
  }
}

}  // namespace
}  // namespace calor
