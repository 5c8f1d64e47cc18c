// Convergence of MLPG on lattices and jittered clouds against exact solutions.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "../unit/case_models.hpp"
#include "../unit/mlpg_systems.hpp"
#include "solve/integrator.hpp"

namespace calor {
namespace {

constexpr double pi = std::numbers::pi;

Cloud unit_square(int n, double jitter, std::uint64_t seed = 1) {
  return box_cloud({n + 1, n + 1}, 1.0 / n, {.jitter = jitter, .seed = seed});
}

/// Mean error over the seeds for n intervals an edge.
template <class Error>
std::vector<double> errors(const std::vector<int>& intervals, int seeds, const Error& error) {
  std::vector<double> mean;
  for (const int n : intervals) {
    double sum = 0;
    for (int seed = 1; seed <= seeds; ++seed) sum += error(n, seed);
    mean.push_back(sum / seeds);
  }
  return mean;
}

double last_rate(const std::vector<double>& e) { return std::log2(e[e.size() - 2] / e.back()); }

/// A case by MLPG on a unit square of n intervals an edge, which `rest` completes.
std::string unit_square_case(int n, double jitter, int seed, const std::string& rest) {
  return box_case({"1 m", "1 m"}, {n + 1, n + 1}, "mlpg") + fmt::format("jitter = {}\nseed = {}\n", jitter, seed) +
         rest;
}

/// Root of the mean square of T - exact, weighted with the volumes.
double rms_error(const CaseModel& m, State state, const Field& exact) {
  const std::vector<double> T = m.system().temperatures(state.T);
  double square = 0;
  for (int i = 0; i < m.cloud().owned; ++i) square += m.cloud().volume[i] * std::pow(T[i] - exact(m.cloud().x[i]), 2);
  return std::sqrt(square);
}

/// That `error(system, n)`, n intervals an edge, is of second order for both fluxes: by tiles on the lattice, and by
/// virtual faces on clouds jittered by 0.2 d, where it is the mean of so many seeds.
template <class Error>
void expect_second_order(int seeds, const Error& error) {
  for (const double jitter : {0.0, 0.2}) {
    for (const MlpgFlux flux : {MlpgFlux::parameters, MlpgFlux::edge_stabilised}) {
      SCOPED_TRACE(testing::Message() << jitter << ' ' << static_cast<int>(flux));
      const auto e = errors({10, 20, 40}, jitter > 0 ? seeds : 1, [&](int n, int seed) {
        const Cloud cloud = unit_square(n, jitter, seed);
        auto o = MlpgOptions::defaults(2, cloud.box_lattice);
        o.flux = flux;
        return error(MlpgSystem(cloud, o), n);
      });
      EXPECT_GE(last_rate(e), 1.8);
    }
  }
}

/// T = e^x sin y.
const Field harmonic = [](const Vec3& x) { return std::exp(x.x) * std::sin(x.y); };

TEST(MlpgConvergence, SteadyHarmonicTemperatureIsOfSecondOrder) {
  const Field no_source = [](const Vec3&) { return 0; };
  expect_second_order(5, [&](const MlpgSystem& s, int) { return s.error(s.steady(harmonic, no_source), harmonic); });
}

TEST(MlpgConvergence, PenaltyIsOfTheOrderOfCollocation) {
  // The same temperature, from case files.
  const std::string walls = R"toml(
[material.m]
conductivity = "1 W/(m K)"
[boundary.walls]
on = ["xmin", "xmax", "ymin", "ymax"]
temperature = { formula = "exp(x)*sin(y)", unit = "K" }
[steady]
[mlpg]
)toml";
  for (const auto& [jitter, cells] :
       {std::pair<double, std::string>{0, ""}, {0.2, ""}, {0, "subdomain = \"sphere\"\n"}}) {
    SCOPED_TRACE(testing::Message() << jitter << ' ' << cells);
    const auto study = [&](const std::string& prescribed) {
      return errors({10, 20, 40}, jitter > 0 ? 3 : 1, [&](int n, int seed) {
        const std::string options = cells + "prescribed = \"" + prescribed + "\"\n";
        const CaseModel m(unit_square_case(n, jitter, seed, walls + options));
        return rms_error(m, m.steady(), harmonic);
      });
    };
    const auto by_collocation = study("collocation"), by_penalty = study("penalty");
    EXPECT_NEAR(last_rate(by_penalty) / last_rate(by_collocation), 1, 0.1);
    EXPECT_NEAR(by_penalty.back() / by_collocation.back(), 1, 0.1);
  }
}

TEST(MlpgConvergence, CoolingCosineIsOfSecondOrder) {
  // T = cos(pi x) cos(pi y) exp(-2 pi^2 t), insulated, at t = 0.05.
  const Field start = [](const Vec3& x) { return std::cos(pi * x.x) * std::cos(pi * x.y); };
  const Field end = [&](const Vec3& x) { return start(x) * std::exp(-2 * pi * pi * 0.05); };
  expect_second_order(3, [&](const MlpgSystem& s, int n) { return s.error(s.cooled(start, 0.05, n * 5), end); });
}

TEST(MlpgConvergence, CoolingWithPropertiesThatDependOnTemperatureIsOfSecondOrder) {
  // With k = c = 1 + T the heat equation is linear in theta = T + T^2/2:
  // theta = 1.5 + cos(pi x) cos(pi y) exp(-2 pi^2 t), insulated, at t = 0.05.
  const double end = 0.05;
  const Field exact = [&](const Vec3& x) {
    const double theta = 1.5 + std::cos(pi * x.x) * std::cos(pi * x.y) * std::exp(-2 * pi * pi * end);
    return std::sqrt(1 + 2 * theta) - 1;
  };
  const std::string body = simple_material({.k = "1 + T", .rho = "1", .c = "1 + T"}) + R"toml(
[initial]
temperature = { formula = "sqrt(4 + 2*cos(pi*x)*cos(pi*y)) - 1", unit = "K" }
[time]
end = "0.05 s"
step = "0.5 ms"
)toml";
  const std::string implicit = "integrator = \"tr-bdf2\"\n";
  for (const auto& [jitter, integrator] : {std::pair<double, std::string>{0, ""}, {0.2, ""}, {0, implicit}}) {
    SCOPED_TRACE(testing::Message() << jitter << ' ' << integrator);
    const auto e = errors({10, 20, 40}, jitter > 0 ? 3 : 1, [&](int n, int seed) {
      const CaseModel m(unit_square_case(n, jitter, seed, body + integrator));
      State state = m.start();
      make_integrator(m.description(), m.system(), state)->advance(m.system(), state, end, [](const State&) {
        return true;
      });
      double swing = 0;
      for (const Vec3& x : m.cloud().x) swing = std::max(swing, std::abs(exact(x) - 1));
      return rms_error(m, state, exact) / swing;
    });
    EXPECT_GE(last_rate(e), 1.8);
    EXPECT_LE(e.back(), 5e-4);  // of the largest difference to the mean
  }
}

}  // namespace
}  // namespace calor
