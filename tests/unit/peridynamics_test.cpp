#include "conduction/peridynamics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "app/model.hpp"
#include "app/run.hpp"
#include "app/schema.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "method_clouds.hpp"
#include "solve/integrator.hpp"

namespace calor {
namespace {

constexpr double pi = std::numbers::pi;

TEST(Peridynamics, HasTheMicroConductivitiesOfTheLiterature) {
  // With k = 1: 1D Bobaru & Duangpanya (2010); n = 1 in 2D and 3D 6 k / (pi delta^(D+1)).
  const double d = 0.3;
  EXPECT_NEAR(micro_conductivity(1, 0, d), 3 / (d * d * d), 1e-12);
  EXPECT_NEAR(micro_conductivity(1, 1, d), 2 / (d * d), 1e-12);
  EXPECT_NEAR(micro_conductivity(1, 2, d), 1 / d, 1e-12);
  EXPECT_NEAR(micro_conductivity(2, 0, d), 8 / (pi * std::pow(d, 4)), 1e-10);
  EXPECT_NEAR(micro_conductivity(2, 1, d), 6 / (pi * std::pow(d, 3)), 1e-11);
  EXPECT_NEAR(micro_conductivity(2, 2, d), 4 / (pi * d * d), 1e-12);
  EXPECT_NEAR(micro_conductivity(3, 0, d), 15 / (2 * pi * std::pow(d, 5)), 1e-9);
  EXPECT_NEAR(micro_conductivity(3, 1, d), 6 / (pi * std::pow(d, 4)), 1e-10);
  EXPECT_NEAR(micro_conductivity(3, 2, d), 9 / (2 * pi * std::pow(d, 3)), 1e-11);
}

/// A box of cells that look the same from everywhere, as images lie beyond all its walls, and its neighbours.
struct Inside {
  Cloud cloud;
  Neighbours neighbours;

  Inside(int dimension, double spacing, const Peridynamics& options) {
    const auto reach = options.support().radius(spacing) / spacing;
    const auto points = static_cast<std::int64_t>(std::ceil(reach));
    cloud = box_cloud(std::vector<std::int64_t>(dimension, points), spacing, {.support = reach, .on_walls = false});
    neighbours = find_neighbours(cloud, options.support(), (1u << 2 * dimension) - 1);
  }
  /// sum_j G_0j f(x_j0) / V_0.
  template <class F>
  double sum(std::span<const double> G, const F& f) const {
    double s = 0;
    for (auto n = neighbours.row[0]; n < neighbours.row[1]; ++n) s += G[n] * f(neighbours.x_ji(cloud.x, 0, n));
    return s / cloud.volume[0];
  }
};

TEST(Peridynamics, LosesConductivityWithoutItsCorrections) {
  // Conductivity of a lattice with horizon 3.015 d, without and with partial volumes, for n = 0, 1, 2, from lattice
  // sums in exact arithmetic. With the surface correction it is 1.
  const double without[3][3] = {{1.5325, 1.3201, 0.9950}, {1.0478, 1.0254, 0.9805}, {1.1307, 1.0987, 1.0627}};
  const double with[3][3] = {{1.0547, 1.0000, 0.8342}, {1.0534, 1.0177, 0.9674}, {1.1002, 1.0590, 1.0220}};
  for (int D = 1; D <= 3; ++D) {
    for (int n = 0; n <= 2; ++n) {
      for (const bool partial : {false, true}) {
        const Peridynamics options{.n = n, .horizon = 3.015, .partial_volumes = partial};
        const Inside body(D, 0.1, options);
        const auto half_square = [](const Vec3& x) { return 0.5 * x.x * x.x; };
        EXPECT_NEAR(body.sum(base_weights(body.cloud, body.neighbours, options), half_square),
                    (partial ? with : without)[D - 1][n], 6e-5);
        EXPECT_NEAR(body.sum(bond_weights(body.cloud, body.neighbours, options), half_square), 1, 1e-12);
      }
    }
  }
}

TEST(Peridynamics, ConvergesToTheNonlocalDecayRateAtFixedHorizon) {
  // Rate of a product of sines with k = (pi, ..) inside the body, over the classical one, delta = 0.15:
  // kappa integral of (1 - cos(k xi)) / |xi|^n dV by quadrature of its radial form (J0, sin(x)/x).
  const double exact[2][3] = {{.98166477, .98349102, .98623443}, {.97649852, .97805562, .98023887}};
  const std::map<int, double> bounds[2] = {
      {{2, 3.4e-3}, {3, 1.1e-3}, {4, 6.7e-4}, {6, 2.8e-4}, {10, 1.2e-4}, {20, 1.3e-5}},
      {{2, 3.4e-3}, {3, 1.4e-3}, {4, 7.8e-4}, {6, 2.8e-4}}};
  constexpr double delta = 0.15;
  for (int D = 2; D <= 3; ++D) {
    for (const auto& [m, bound] : bounds[D - 2]) {
      const Peridynamics options{.n = 2, .horizon = {0, delta}};
      const Inside body(D, delta / m, options);
      const auto G = bond_weights(body.cloud, body.neighbours, options);
      const double rate =
          body.sum(G, [](const Vec3& x) { return 1 - std::cos(pi * x.x) * std::cos(pi * x.y) * std::cos(pi * x.z); });
      EXPECT_NEAR(rate / (D * pi * pi), exact[D - 2][2], 1.3 * bound) << D << "D, m = " << m;
    }
  }
  // The other powers alike.
  for (int n = 0; n <= 1; ++n) {
    const Peridynamics options{.n = n, .horizon = {0, delta}};
    const Inside body(2, delta / 6, options);
    const double rate = body.sum(bond_weights(body.cloud, body.neighbours, options),
                                 [](const Vec3& x) { return 1 - std::cos(pi * x.x) * std::cos(pi * x.y); });
    EXPECT_NEAR(rate / (2 * pi * pi), exact[0][n], 5e-4) << n;
  }
}

TEST(Peridynamics, HasSymmetricPaperWeights) {
  const Cloud cloud = box_cloud({8, 7}, 0.1, {.jitter = 0.2, .on_walls = false});
  const Peridynamics options;
  const Neighbours neighbours = find_neighbours(cloud, options.support(), 0b0110);
  const auto G = bond_weights(cloud, neighbours, options);
  std::map<std::tuple<int, int, int>, double> weights;
  for (int i = 0; i < cloud.owned; ++i)
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
      weights[{i, neighbours.image[n], neighbours.column[n]}] = G[n];
  for (const auto& [pair, weight] : weights) {
    const auto& [i, set, j] = pair;
    EXPECT_EQ(weights.at({j, set, i}), weight);
  }
}

/// Root mean square error of the steady temperature exp(x) sin(y) on a jittered unit box, over its range, by the
/// command's own way: prescribed on all walls, at points or by images.
double harmonic_error(int intervals, int dimension, const std::string& at) {
  std::string size, points, faces;
  for (int a = 0; a < dimension; ++a) {
    const std::string comma = a > 0 ? "," : "", axis(1, "xyz"[a]);
    size += comma + "\"1 m\"";
    points += comma + std::to_string(intervals + (at == "walls" ? 1 : 0));
    faces += comma + "\"" + axis + "min\",\"" + axis + "max\"";
  }
  const std::string T = "{ formula = \"exp(x)*sin(y)\", unit = \"K\" }";
  const Case c = Case::parse(
      "title = \"t\"\nmethod = \"peridynamics\"\n[cloud]\nshape = \"box\"\njitter = 0.2\nseed = 5\nat = \"" + at +
          "\"\nsize = [" + size + "]\npoints = [" + points +
          "]\n[material.m]\nconductivity = \"1 W/(m K)\"\n[peridynamics]\nhorizon = 2\n" + "[boundary.all]\non = [" +
          faces + "]\ntemperature = " + T + "\n[steady]\n[[expect]]\nfield = true\nnorm = \"rms\"\nvalue = " + T +
          "\nwithin = \"1 K\"\n",
      "test.toml", schema());
  return run(c, MPI_COMM_SELF, {.folder = "", .quiet = true}).verdicts.at(0).error;
}

TEST(Peridynamics, IsOfSecondOrderOnJitteredClouds) {
  for (const std::string at : {"walls", "cells"}) {
    SCOPED_TRACE(at);
    const double coarse = harmonic_error(10, 2, at), fine = harmonic_error(40, 2, at);
    EXPECT_GE(std::log2(coarse / fine) / 2, 1.7) << coarse << " " << fine;
    EXPECT_LE(fine, 1e-3);
    const double coarse_3d = harmonic_error(8, 3, at), fine_3d = harmonic_error(16, 3, at);
    EXPECT_GE(std::log2(coarse_3d / fine_3d), 1.7) << coarse_3d << " " << fine_3d;
  }
}

TEST(Peridynamics, IsLinearInTheTemperatureOfTheWall) {
  // The plate of Wang et al., figs. 12 and 13, with equal steps: T - T0 in proportion to T1 - T0 to round-off.
  const auto final_rise = [](double T1) {
    const Case c =
        Case::read(CALOR_SOURCE_DIR "/cases/wang/fig12-fig13.toml", schema(),
                   {"cloud.points=200", "time.step=\"0.02 s\"", "time.integrator=\"rkl2\"", "time.end=\"1 s\"",
                    "boundary.ceramic.temperature=\"" + std::to_string(T1) + " degC\"", "expect=[]"});
    Phases phases;
    Model model = build_model(c, MPI_COMM_SELF, phases);
    State state = model.system->start(0, model.T_start);
    auto integrator = make_integrator(c, *model.system, state);
    integrator->advance(*model.system, state, 1, [](const State&) { return true; });
    std::vector<double> rise;
    for (int i = 0; i < model.cloud->owned; ++i) rise.push_back(state.T[i] - 293.15);
    return rise;
  };
  const auto low = final_rise(200), high = final_rise(720);
  for (std::size_t i = 0; i < low.size(); ++i) EXPECT_NEAR(high[i] / 700, low[i] / 180, 1e-10);
}

TEST(Peridynamics, RefusesWhatItCannotDo) {
  const auto message = [](const std::string& options) -> std::string {
    const Case c = Case::parse(
        "title = \"t\"\nmethod = \"peridynamics\"\n[cloud]\nshape = \"box\"\nsize = [\"1 m\", \"0.3 m\"]\npoints = "
        "[10, 3]\nat = "
        "\"cells\"\n"
        "[material.m]\nconductivity = \"1 W/(m K)\"\n[boundary.xmin]\ntemperature = \"1 "
        "K\"\n[steady]\n[peridynamics]\n" +
            options,
        "test.toml", schema());
    Phases phases;
    try {
      build_model(c, MPI_COMM_SELF, phases);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(message(""), "");
  EXPECT_EQ(message("horizon = \"0.3 m\""), "");
  EXPECT_NE(message("n = 3").find("test.toml:14:"), std::string::npos);
  EXPECT_NE(message("horizon = 0.5").find("between 1 and 30"), std::string::npos);
  EXPECT_NE(message("horizon = \"2 s\"").find("no length"), std::string::npos);
  EXPECT_NE(message("surface_correction = false").find("belongs to correction"), std::string::npos);
  EXPECT_NE(message("horizon = 4").find("thick"), std::string::npos);
  EXPECT_EQ(message("horizon = 4\ninsulated = \"truncated\""), "");
}

}  // namespace
}  // namespace calor
