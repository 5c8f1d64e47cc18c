// Convergence of MLPG on lattices and jittered clouds against exact solutions.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "../unit/mlpg_systems.hpp"

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

TEST(MlpgConvergence, SteadyHarmonicTemperatureIsOfSecondOrder) {
  // T = e^x sin y; tiles on the lattice, virtual faces on clouds jittered by 0.2 d, mean of five seeds.
  const Field T = [](const Vec3& x) { return std::exp(x.x) * std::sin(x.y); };
  for (const double jitter : {0.0, 0.2}) {
    for (const MlpgFlux flux : {MlpgFlux::parameters, MlpgFlux::edge_stabilised}) {
      SCOPED_TRACE(testing::Message() << jitter << ' ' << static_cast<int>(flux));
      const auto e = errors({10, 20, 40}, jitter > 0 ? 5 : 1, [&](int n, int seed) {
        const Cloud cloud = unit_square(n, jitter, seed);
        auto o = MlpgOptions::defaults(2, cloud.box_lattice);
        o.flux = flux;
        const MlpgSystem s(cloud, o);
        return s.error(s.steady(T, [](const Vec3&) { return 0; }), T);
      });
      EXPECT_GE(last_rate(e), 1.8);
    }
  }
}

TEST(MlpgConvergence, CoolingCosineIsOfSecondOrder) {
  // T = cos(pi x) cos(pi y) exp(-2 pi^2 t), insulated, at t = 0.05.
  const Field start = [](const Vec3& x) { return std::cos(pi * x.x) * std::cos(pi * x.y); };
  const Field end = [&](const Vec3& x) { return start(x) * std::exp(-2 * pi * pi * 0.05); };
  for (const double jitter : {0.0, 0.2}) {
    for (const MlpgFlux flux : {MlpgFlux::parameters, MlpgFlux::edge_stabilised}) {
      SCOPED_TRACE(testing::Message() << jitter << ' ' << static_cast<int>(flux));
      const auto e = errors({10, 20, 40}, jitter > 0 ? 3 : 1, [&](int n, int seed) {
        const Cloud cloud = unit_square(n, jitter, seed);
        auto o = MlpgOptions::defaults(2, cloud.box_lattice);
        o.flux = flux;
        const MlpgSystem s(cloud, o);
        return s.error(s.cooled(start, 0.05, n * 5), end);
      });
      EXPECT_GE(last_rate(e), 1.8);
    }
  }
}

}  // namespace
}  // namespace calor
