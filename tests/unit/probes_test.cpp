#include "output/probes.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <cmath>

#include "case_models.hpp"
#include "conduction/mlpg.hpp"
#include "method_clouds.hpp"
#include "output/observer.hpp"
#include "results.hpp"

namespace calor {
namespace {

/// A polynomial of all monomials up to a degree, with scattered coefficients.
double polynomial(const Vec3& x, int degree, int dimension) {
  double sum = 0;
  int n = 0;
  for (int a = 0; a <= degree; ++a)
    for (int b = 0; b <= (dimension > 1 ? degree - a : 0); ++b)
      for (int c = 0; c <= (dimension > 2 ? degree - a - b : 0); ++c)
        sum += scattered(++n) * std::pow(x.x, a) * std::pow(x.y, b) * std::pow(x.z, c);
  return sum;
}

std::vector<double> field(const Cloud& cloud, int degree) {
  std::vector<double> T;
  for (int i = 0; i < cloud.owned; ++i) T.push_back(polynomial(cloud.x[i], degree, cloud.dimension));
  return T;
}

TEST(Probes, AreExactForCubicsOnLattices) {
  const std::vector<Cloud> clouds = [] {
    std::vector<Cloud> all;
    for (const bool on_walls : {true, false}) {
      all.push_back(box_cloud({9}, 0.125, {.on_walls = on_walls}));
      all.push_back(box_cloud({9, 8}, 0.125, {.on_walls = on_walls}));
      all.push_back(box_cloud({8, 7, 6}, 0.125, {.on_walls = on_walls}));
    }
    return all;
  }();
  EXPECT_TRUE(rc::check("a cubic is sampled to round-off anywhere in the body", [&] {
    const Cloud& cloud = clouds[*rc::gen::inRange<std::size_t>(0, clouds.size())];
    Vec3 place, high;
    for (const Vec3& x : cloud.x)
      for (int a = 0; a < 3; ++a) high[a] = std::max(high[a], x[a]);
    for (int a = 0; a < cloud.dimension; ++a) place[a] = high[a] * *rc::gen::inRange(60, 1001) / 1000.;
    const Probes probes(cloud, {"p"}, {place});
    RC_ASSERT(std::abs(probes.sample(field(cloud, 3))[0] - polynomial(place, 3, cloud.dimension)) <= 1e-11);
  }));
}

TEST(Probes, InPartsThinnerThanTheSpacingAreExactForHeatThroughThem) {
  // An insulator across a metal bar: the temperature falls linearly through both. Lattices know where the interface
  // lies to a millionth of the spacing, over which it falls by up to 5e-4 K.
  int n = 0;
  for (const char* jitter : {"0", "0.2"}) {
    for (const double thickness : {0.01, 0.03, 0.06, 0.09}) {
      const double begin = 0.5 - (0.5 + 0.4 * scattered(++n)) * thickness, end = begin + thickness;
      SCOPED_TRACE(fmt::format("jitter {}: {} to {} m", jitter, begin, end));
      const double flux = 100 / ((1 - thickness) / 40 + thickness / 0.5);
      const std::string text =
          box_case({"1 m", "0.5 m"}, {21, 11}) + fmt::format("jitter = {}\n", jitter) +
          simple_material({.name = "metal", .k = "40"}) + simple_material({.name = "insulator", .k = "0.5"}) +
          "[body]\nmaterial = \"metal\"\n" +
          fmt::format("region = [{{ material = \"insulator\", where = \"x > {} && x < {}\" }}]\n", begin, end) +
          "[steady]\n[boundary.hot]\non = \"xmin\"\ntemperature = \"400 K\"\n"
          "[boundary.cold]\non = \"xmax\"\ntemperature = \"300 K\"\n";
      int probe = 0;
      std::string expected, places = "[probe]\n";
      for (const double part : {-0.1, 0.02, 0.3, 0.5, 0.9, 1.1}) {
        const double x = begin + part * thickness, inside = std::clamp(part, 0., 1.) * thickness;
        places += fmt::format("p{} = [\"{:.15g} m\", \"0.237 m\"]\n", ++probe, x);
        expected += fmt::format("[[expect]]\nprobe = \"p{}\"\nvalue = \"{:.15g} K\"\nwithin = \"5e-4 K\"\n", probe,
                                400 - flux * ((x - inside) / 40 + inside / 0.5));
      }
      for (const Verdict& v : run_into("", text + places + expected).verdicts)
        EXPECT_TRUE(v.passed) << v.what << ": " << v.value;
    }
  }
}

TEST(Probes, AreExactForCubicsOnJitteredCloudsAndRings) {
  std::vector<Cloud> clouds;
  clouds.push_back(box_cloud({11}, 0.1, {.jitter = 0.3}));
  clouds.push_back(box_cloud({11, 10}, 0.1, {.jitter = 0.2}));
  clouds.push_back(box_cloud({8, 7, 7}, 0.125, {.jitter = 0.2}));
  clouds.push_back(distribute(MPI_COMM_SELF, make_rings(MPI_COMM_SELF, {.radius = 1, .rings = 8}), 0.3));
  for (const Cloud& cloud : clouds) {
    SCOPED_TRACE(cloud.dimension);
    for (int n = 0; n < 30; ++n) {
      // Midway between a point and one of the others next to it.
      const int i = (7 * n) % cloud.owned;
      Vec3 place = cloud.x[i];
      for (int j = 0; j < cloud.owned; ++j)
        if (const double r = norm(cloud.x[j] - cloud.x[i]); r > 0 && r < 1.3 * cloud.spacing[i])
          place = 0.5 * (cloud.x[i] + cloud.x[j]);
      const Probes probes(cloud, {"p"}, {place});
      EXPECT_NEAR(probes.sample(field(cloud, 3))[0], polynomial(place, 3, cloud.dimension), 1e-10);
    }
  }
}

TEST(Probes, GiveTheValueOfThePointThatTheySitOn) {
  const Cloud cloud = box_cloud({6, 5}, 0.1, {.jitter = 0.2});
  std::vector<double> T(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) T[i] = scattered(i);
  const Probes probes(cloud, {"a", "b"}, {cloud.x[3], cloud.x[17]});
  EXPECT_EQ(probes.sample(T), (std::vector<double>{T[3], T[17]}));
}

TEST(Probes, DoWithWhatFewPointsAllow) {
  // Two points along an axis: linear in that direction.
  const Cloud cloud = box_cloud({9, 2}, 0.125);
  std::vector<double> T;
  const auto exact = [](const Vec3& x) { return 1 + x.x * x.x * x.x - 2 * x.y + x.x * x.y; };
  for (int i = 0; i < cloud.owned; ++i) T.push_back(exact(cloud.x[i]));
  for (const Vec3& place : {Vec3{0.3, 0.05}, Vec3{0.77, 0.1}})
    EXPECT_NEAR(Probes(cloud, {"p"}, {place}).sample(T)[0], exact(place), 1e-11);
  const Cloud pair = box_cloud({2}, 1);
  EXPECT_NEAR(Probes(pair, {"p"}, {{0.25}}).sample(std::vector<double>{3, 7})[0], 4, 1e-12);
}

TEST(Probes, InterpolateWithFourthOrder) {
  double last = 0;
  for (const int n : {11, 21, 41}) {
    const Cloud cloud = box_cloud({n, n}, 1. / (n - 1), {.jitter = 0.2});
    std::vector<double> T;
    for (int i = 0; i < cloud.owned; ++i) T.push_back(std::sin(3 * cloud.x[i].x) * std::cos(2 * cloud.x[i].y));
    double worst = 0;
    for (int k = 0; k < 60; ++k) {
      const Vec3 place{0.5 + 0.5 * scattered(k), 0.5 + 0.5 * scattered(k + 0.5)};
      worst = std::max(
          worst, std::abs(Probes(cloud, {"p"}, {place}).sample(T)[0] - std::sin(3 * place.x) * std::cos(2 * place.y)));
    }
    if (last > 0) {
      EXPECT_GE(std::log2(last / worst), 3);
    }
    last = worst;
  }
  EXPECT_LE(last, 1e-5);
}

TEST(Probes, RefusePlacesOutsideTheBody) {
  const std::string plate = box_case({"4 m", "2 m"}, {5, 3}) + "[material.m]\nlibrary = \"iron\"\n[probe]\n";
  const auto refused = [&](const std::string& probe, const std::vector<std::string>& words) {
    const Case c = parse_case(plate + probe);
    const Cloud cloud = make_cloud(MPI_COMM_SELF, c, 2);
    expect_error([&] { Probes probes(c, cloud); }, words);
  };
  refused("p = [\"5 m\", \"1 m\"]", {"test.toml:10:5", "probe 'p'", "(5, 1, 0) m", "x from 0 to 4 m, y from 0 to 2 m"});
  refused("p = [\"4.1 m\", \"1 m\"]", {"outside the body"});
  refused("p = [\"2 m\", \"-60 mm\"]", {"outside the body"});
  refused("p = [\"2 m\"]", {"1 coordinates in a body of 2 dimensions"});
  refused("p = [\"2 m\", \"1 m\", \"1 m\"]", {"3 coordinates in a body of 2 dimensions"});
  refused("\"a,b\" = [\"2 m\", \"1 m\"]", {"cannot be the name of a column"});
  const Case good = parse_case(plate + "p = [\"4 m\", \"2 m\", \"0 m\"]");
  EXPECT_EQ(Probes(good, make_cloud(MPI_COMM_SELF, good, 2)).names(), std::vector<std::string>{"p"});
}

TEST(Probes, KnowTheInsideOfADisc) {
  const Cloud cloud = distribute(MPI_COMM_SELF, make_rings(MPI_COMM_SELF, {.radius = 1, .rings = 6}), 0.4);
  for (int n = 0; n < 40; ++n) {
    const double angle = 0.157 * n;
    const Vec3 direction{std::cos(angle), std::sin(angle)};
    Probes inside(cloud, {"p"}, {0.97 * direction});
    error_of([&] { Probes outside(cloud, {"p"}, {1.05 * direction}); });
  }
}

TEST(Probes, TakeTemperaturesBetweenPointsFromTheShapeFunctionsOfTheMethod) {
  // T^h = Phi T^ anywhere: linear parameters give linear temperatures; and at a point, the point's own value, which is
  // not its parameter.
  const Cloud cloud = box_cloud({9, 8}, 0.125, {.jitter = 0.2});
  MlpgReport report;
  MlpgScheme scheme = mlpg_scheme(cloud, MlpgOptions::defaults(2, false), report);
  const SparseRows& phi = scheme.conduction->rows().value;
  const Dofs dofs(cloud, phi, std::move(scheme.shapes));
  const Vec3 on_a_point = cloud.x[30], between{0.31, 0.47}, at_a_wall{0.2, 0};
  const Probes probes(cloud, {"on", "between", "wall"}, {on_a_point, between, at_a_wall}, &dofs);
  const auto linear = field(cloud, 1), rough = field(cloud, 9);
  const auto T = probes.temperatures(linear);
  EXPECT_NEAR(T[0], polynomial(on_a_point, 1, 2), 1e-13);
  EXPECT_NEAR(T[1], polynomial(between, 1, 2), 1e-13);
  EXPECT_NEAR(T[2], polynomial(at_a_wall, 1, 2), 1e-13);
  EXPECT_NEAR(probes.temperatures(rough)[0], phi.times(30, rough), 1e-13);
  EXPECT_NE(probes.temperatures(rough)[0], rough[30]);
}

TEST(ProbesParallel, GiveTheSameBitsOnAnyNumberOfRanks) {
  const BoxOptions alone{.jitter = 0.2};
  BoxOptions shared = alone;
  shared.comm = MPI_COMM_WORLD;
  const Cloud a = box_cloud({9, 8}, 0.125, alone), b = box_cloud({9, 8}, 0.125, shared);
  std::vector<std::string> names;
  std::vector<Vec3> places;
  for (int n = 0; n < 20; ++n) {
    names.push_back(fmt::format("p{}", n));
    places.push_back({0.5 + 0.5 * scattered(n), 0.44 + 0.43 * scattered(n + 0.5)});
  }
  EXPECT_EQ(Probes(a, names, places).sample(field(a, 5)), Probes(b, names, places).sample(field(b, 5)));
  const auto by_shape_functions = [&](const Cloud& cloud) {
    MlpgReport report;
    MlpgScheme scheme = mlpg_scheme(cloud, MlpgOptions::defaults(2, true), report);
    const Dofs dofs(cloud, scheme.conduction->rows().value, std::move(scheme.shapes));
    std::vector<double> T;
    for (const Vec3& x : cloud.x) T.push_back(polynomial(x, 5, 2));
    return Probes(cloud, names, places, &dofs).temperatures(T);
  };
  EXPECT_EQ(by_shape_functions(a), by_shape_functions(b));
}

TEST(ProbesParallel, WriteTheirLog) {
  const TemporaryFolder folder(MPI_COMM_WORLD);
  const CaseModel m(
      box_case({"1 m", "0.875 m"}, {9, 8}) +
          "[material.m]\nlibrary = \"copper\"\n[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n",
      MPI_COMM_WORLD);
  const Probes probes(m.cloud(), {"left", "right"}, {{0, 0.2}, {0.9, 0.1}});
  State state = m.start();
  const State start = state;
  Phases phases;
  const RunSetup run{.description = m.description(),
                     .system = m.system(),
                     .probes = probes,
                     .weld = nullptr,
                     .start_E = start.E,
                     .start = start,
                     .folder = folder.path(),
                     .phases = phases};
  const auto log = make_probe_log(run);
  log->begin();
  for (const double t : {0., 0.1, 1. / 3}) {
    for (int i = 0; i < m.cloud().owned; ++i) state.T[i] = 300 + m.cloud().x[i].x + t;
    state.t = t;
    log->record(Moment(m.system(), state));
    const CsvTable table = read_csv(folder / "probes.csv");  // already complete
    EXPECT_EQ(table.header, (std::vector<std::string>{"time [s]", "left [K]", "right [K]"}));
    ASSERT_EQ(table.rows.back().size(), 3u);
    EXPECT_EQ(table.rows.back()[0], t);  // all digits
    EXPECT_NEAR(table.rows.back()[1], 300 + t, 1e-10);
    EXPECT_NEAR(table.rows.back()[2], 300.9 + t, 1e-10);
  }
}

}  // namespace
}  // namespace calor
