// Bodies of revolution described by half of their axial section: x is the distance from the axis, y the height.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "case_models.hpp"
#include "cloud/cell_integrals.hpp"
#include "cloud/points.hpp"
#include "conduction/correction.hpp"
#include "results.hpp"

namespace calor {
namespace {

constexpr double pi = std::numbers::pi;

/// The [cloud] of a tube from a to b and of height H with n intervals a unit of length, on the walls.
struct Tube {
  double a = 0.5, b = 1.5, H = 1;
  int n = 10;
  std::string more = {};

  std::string text() const {
    const auto points = [&](double length) { return std::lround(length * n) + (at_walls() ? 1 : 0); };
    return fmt::format(
        "[cloud]\nshape = \"box\"\naxisymmetric = true\nsize = [\"{} m\", \"{} m\"]\norigin = [\"{} m\", \"-0.3 m\"]\n"
        "points = [{}, {}]\n{}\n",
        b - a, H, a, points(b - a), points(H), more);
  }
  bool at_walls() const { return more.find("cells") == more.npos; }
};

/// Rows with other numbers of points, from the axis to x = 1 m.
const char* const rows = R"toml([cloud]
shape = "rows"
axisymmetric = true
length = "1 m"
y = ["0 m", "0.1 m", "0.2 m", "0.3 m", "0.4 m", "0.5 m"]
points = [11, 11, 13, 13, 9, 9]
)toml";

std::string start(const std::string& method) { return "title = \"test\"\nmethod = \"" + method + "\"\n"; }

const std::string unit_material = simple_material({.k = "1", .rho = "1", .c = "1"});
const std::string transient = "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n";

/// An insulated body of rho = c = k = 1.
std::string insulated(const std::string& method, const std::string& cloud) {
  return start(method) + cloud + unit_material + transient;
}

/// What conjugate gradients leave of a cell's balance, over the face of a cell.
constexpr double round_off = 5e-12;

/// Largest of |F_i + A_i.g - S_i g_x| over the faces of a cell for the temperature g.x: what a linear temperature does
/// to a cell besides the heat through its walls and div grad (x g_x) = g_x / x.
double linear_error(const CaseModel& m, const Vec3& g) {
  const Cloud& cloud = m.cloud();
  std::vector<double> T(cloud.local());
  for (int i = 0; i < cloud.local(); ++i) T[i] = dot(g, cloud.x[i]);
  const Rates rates = m.rates(0, T);
  double largest = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 face = face_size(cloud, i);
    largest = std::max(largest,
                       std::abs(rates.F[i] + dot(cloud.area[i], g) - cloud.hoop[i] * g.x) / std::max(face.x, face.y));
  }
  return max(cloud.comm, largest);
}

/// The steady state of a body whose walls hold T, a formula.
std::string held(const std::string& method, const std::string& cloud, const std::string& T, bool solid) {
  return start(method) + cloud + simple_material({.k = "1"}) +
         fmt::format(
             "[boundary.walls]\non = [{}\"xmax\", \"ymin\", \"ymax\"]\ntemperature = {{ formula = \"{}\", unit = \"K\" "
             "}}\n[steady]\n",
             solid ? "" : "\"xmin\", ", T);
}

struct Errors {
  double rms, largest;
};

/// Of the steady temperatures, weighted by volumes.
template <class F>
Errors errors(const std::string& text, const F& exact) {
  const CaseModel m(text);
  const Cloud& cloud = m.cloud();
  State state = m.steady();
  const std::vector<double> T = m.system().temperatures(state.T);
  double squares = 0, volume = 0, largest = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    const double error = T[i] - exact(cloud.x[i]);
    squares += cloud.volume[i] * error * error, volume += cloud.volume[i];
    largest = std::max(largest, std::abs(error));
  }
  return {std::sqrt(squares / volume), largest};
}

double order(double coarse, double fine, double ratio) { return std::log(coarse / fine) / std::log(ratio); }

std::vector<std::string> clouds() {
  return {Tube{}.text(),
          Tube{.a = 0}.text(),
          Tube{.more = "grading = [4, 0.5]"}.text(),
          Tube{.a = 0, .more = "jitter = 0.2"}.text(),
          Tube{.more = "jitter = 0.3"}.text(),
          rows};
}

class Axisymmetric : public testing::TestWithParam<const char*> {};

TEST(AxisymmetricCloud, VolumesAndAreasAreThoseOfTheWholeBody) {
  for (const std::string& text : clouds()) {
    const CaseModel m(insulated("sph", text));
    const Cloud& cloud = m.cloud();
    const CloudCheck is = check(cloud);
    const bool jittered = !cloud.lattice && cloud.nearest_volumes;
    EXPECT_LT(is.volume_error, jittered ? 5e-4 : 1e-13) << text;
    EXPECT_LT(is.area_sum, 1e-13) << text;
    EXPECT_LT(is.moment_sum, 1e-13) << text;
    double outer = 0, top = 0, radius = 0;
    for (const Facet& facet : cloud.facets) {
      radius = std::max(radius, cloud.x[facet.point].x);
      if (cloud.faces[facet.face] == "xmax") outer += facet.area;
      if (cloud.faces[facet.face] == "ymax") top += facet.area;
      EXPECT_GT(facet.area, 0);
      EXPECT_FALSE(cloud.faces[facet.face] == "xmin" && cloud.x[facet.point].x == 0);
    }
    double inner = radius, height = 0;
    for (const Vec3& x : cloud.x) inner = std::min(inner, x.x), height = std::max(height, x.y - cloud.x[0].y);
    EXPECT_NEAR(outer, 2 * pi * radius * height, 1e-12 * outer) << text;
    EXPECT_NEAR(top, pi * (radius * radius - inner * inner), 1e-12 * top) << text;
  }
}

TEST(AxisymmetricCloud, BodiesOfAnyOutlineHaveTheVolumeThatPappusTells) {
  // A cone, a frustum with a bore, and a ring of square section with a square hole: 2 pi times area times the distance
  // of its centroid from the axis.
  struct Body {
    std::string part;
    double volume;
  };
  const std::vector<Body> bodies = {{R"(x = ["0 m", "0.3 m", "0 m"]
y = ["0 m", "0 m", "0.2 m"])",
                                     pi * 0.3 * 0.3 * 0.2 / 3},
                                    {R"(x = ["0.1 m", "0.4 m", "0.2 m", "0.1 m"]
y = ["0 m", "0 m", "0.3 m", "0.3 m"])",
                                     pi * 0.3 * ((0.4 * 0.4 + 0.4 * 0.2 + 0.2 * 0.2) / 3 - 0.1 * 0.1)},
                                    {R"(x = ["0.2 m", "0.6 m", "0.6 m", "0.2 m"]
y = ["0 m", "0 m", "0.4 m", "0.4 m"]
[[cloud.part.hole]]
x = ["0.4 m", "0.5 m", "0.5 m", "0.4 m"]
y = ["0.1 m", "0.1 m", "0.3 m", "0.3 m"])",
                                     2 * pi * (0.4 * 0.4 * 0.4 - 0.1 * 0.2 * 0.45)}};
  for (const Body& body : bodies)
    for (const char* spacing : {"0.04 m", "0.02 m"}) {
      const CaseModel m(insulated("sph", "[cloud]\nshape = \"surface\"\naxisymmetric = true\nspacing = \"" +
                                             std::string(spacing) + "\"\n[[cloud.part]]\nshape = \"polygon\"\n" +
                                             body.part + "\n"));
      const CloudCheck is = check(m.cloud());
      EXPECT_NEAR(is.volume / body.volume, 1, 1e-12) << body.part;
      EXPECT_LT(is.volume_error, 1e-12) << body.part;
      for (int i = 0; i < m.cloud().owned; ++i) EXPECT_GT(m.cloud().volume[i], 0);
    }
}

TEST(AxisymmetricCloud, CellsOfALatticeAreRings) {
  const CaseModel m(insulated("sph", Tube{.a = 0, .b = 0.4, .H = 0.2}.text()));
  const Cloud& cloud = m.cloud();
  for (int i = 0; i < cloud.owned; ++i) {
    const double r = cloud.x[i].x, low = std::max(0.0, r - 0.05), high = std::min(0.4, r + 0.05);
    const bool end = cloud.x[i].y < -0.25 || cloud.x[i].y > -0.15;
    EXPECT_NEAR(cloud.volume[i], pi * (high * high - low * low) * (end ? 0.05 : 0.1), 1e-15);
  }
}

TEST_P(Axisymmetric, LinearTemperaturesAreExact) {
  for (const std::string& text : clouds()) {
    const CaseModel m(insulated(GetParam(), text));
    EXPECT_LT(linear_error(m, {1, 0, 0}), round_off) << text;
    EXPECT_LT(linear_error(m, {0, 1, 0}), round_off) << text;
    const Errors z = errors(held(GetParam(), text, "y", text.find("origin = [\"0.5") == text.npos),
                            [](const Vec3& x) { return x.y; });
    EXPECT_LT(z.largest, 1e-12) << text;
  }
}

TEST_P(Axisymmetric, HeatIsConserved) {
  for (const std::string& text : clouds()) {
    const CaseModel m(insulated(GetParam(), text));
    const Rates rates = m.rates(0, scattered_temperatures(m.cloud(), 300, 50));
    double sum = 0, size = 0;
    for (const double F : rates.F) sum += F, size += std::abs(F);
    EXPECT_LT(std::abs(sum), 1e-13 * size) << text;
  }
}

TEST_P(Axisymmetric, AHollowCylinderIsOfSecondOrder) {
  for (const char* more : {"", "jitter = 0.2"}) {
    const auto solve = [&](int n) {
      return errors(held(GetParam(), Tube{.a = 0.5, .b = 1.5, .H = 1, .n = n, .more = more}.text(), "log(x)", false),
                    [](const Vec3& x) { return std::log(x.x); });
    };
    const Errors coarse = solve(20), fine = solve(60);
    EXPECT_GT(order(coarse.rms, fine.rms, 3), 1.7) << more << ' ' << coarse.rms << ' ' << fine.rms;
    EXPECT_LT(fine.largest, 2e-4) << more;
  }
}

TEST_P(Axisymmetric, ASolidCylinderIsOfSecondOrderUpToItsAxis) {
  for (const char* more : {"", "jitter = 0.2"}) {
    const auto solve = [&](int n) {
      return errors(held(GetParam(), Tube{.a = 0, .b = 1, .H = 1, .n = n, .more = more}.text(),
                         "y^3 - 1.5*y*x^2 + y^2 - x^2/2", true),
                    [](const Vec3& p) {
                      const double r = p.x, z = p.y;
                      return z * z * z - 1.5 * z * r * r + z * z - r * r / 2;
                    });
    };
    const Errors coarse = solve(10), fine = solve(30);
    if (fine.largest < 1e-12) continue;  // the five points of SPH on a lattice are exact
    EXPECT_GT(order(coarse.rms, fine.rms, 3), 1.7) << more << ' ' << coarse.rms << ' ' << fine.rms;
    EXPECT_LT(fine.rms, 6e-4) << more;
  }
}

TEST_P(Axisymmetric, CellsOffTheWallsAreOfSecondOrderToo) {
  if (std::string(GetParam()) == "mlpg") return;  // wants points on the walls
  const Tube tube{.more = "at = \"cells\""};
  EXPECT_LT(linear_error(CaseModel(insulated(GetParam(), tube.text())), {1, 1, 0}), 1e-12);
  const auto solve = [&](int n) {
    return errors(held(GetParam(), Tube{.a = 0.5, .n = n, .more = tube.more}.text(), "log(x)", false),
                  [](const Vec3& x) { return std::log(x.x); });
  };
  const Errors coarse = solve(10), fine = solve(30);
  EXPECT_GT(order(coarse.rms, fine.rms, 3), 1.7) << coarse.rms << ' ' << fine.rms;
}

TEST_P(Axisymmetric, TheHeatThroughATubeIsThatOfTheWholeTube) {
  // 2 pi H k (T_a - T_air) / (ln(b / a) + k / (h b)), by resistances in series.
  const Tube tube{.a = 0.5, .b = 1.5, .H = 0.4, .n = 20};
  const CaseModel m(start(GetParam()) + tube.text() + simple_material({.k = "3"}) + R"toml(
[boundary.xmin]
temperature = "400 K"
[boundary.xmax]
convection = { h = "5 W/(m^2 K)", ambient = "300 K" }
[steady]
)toml");
  const State state = m.steady();
  const double exact = 2 * pi * 0.4 * 3 * 100 / (std::log(3) + 3 / (5 * 1.5));
  EXPECT_NEAR(-m.rates(0, state.T).power[1], exact, 1e-3 * exact);
}

TEST_P(Axisymmetric, SourcesAndFluxesAreIntegratedOverRings) {
  // x <= 0.73 m of a disc: power 2 pi int x dx = pi 0.73^2, and the same part of its top.
  for (const char* more : {"", "jitter = 0.2"}) {
    const CaseModel m(start(GetParam()) + Tube{.a = 0, .b = 1, .H = 1, .n = 10, .more = more}.text() + unit_material +
                      R"toml([boundary.top]
on = "ymax"
where = "x <= 0.73"
flux = "1 W/m^2"
[source.core]
power_density = { formula = "x <= 0.73 ? 1 : 0", unit = "W/m^3" }
)toml" + transient);
    const Rates rates = m.rates(0, m.uniform(300));
    const double exact = pi * 0.73 * 0.73;
    // Between the points of a wall in disorder the part of one ends half way, but has the area of linear functions.
    EXPECT_NEAR(rates.power[0], exact, (more[0] ? 2 * pi * 0.1 * 0.1 / 24 * 1.4 : 1e-12)) << more;
    EXPECT_NEAR(rates.power[1], exact, (more[0] ? 2e-2 : 1e-12) * exact) << more;
  }
}

TEST_P(Axisymmetric, LayersAroundEachOtherConductInSeries) {
  // Two tubes, k = 2 and 0.5, that meet at x = 0.87 m, not at a point: by resistances in series.
  const auto flow = [&](int n) {
    const CaseModel m(start(GetParam()) + Tube{.a = 0.5, .b = 1.5, .H = 0.2, .n = n}.text() +
                      simple_material({.name = "inner", .k = "2"}) + simple_material({.name = "outer", .k = "0.5"}) +
                      R"toml([body]
along = "x"
start = "0.5 m"
[[body.layer]]
material = "inner"
thickness = "0.37 m"
[[body.layer]]
material = "outer"
thickness = "0.63 m"
contact = "4 W/(m^2 K)"
[boundary.xmin]
temperature = "400 K"
[boundary.xmax]
convection = { h = "5 W/(m^2 K)", ambient = "300 K" }
[steady]
)toml");
    return -m.rates(0, m.steady().T).power[1];
  };
  const double exact =
      2 * pi * 0.2 * 100 / (std::log(0.87 / 0.5) / 2 + 1 / (4 * 0.87) + std::log(1.5 / 0.87) / 0.5 + 1 / (5 * 1.5));
  EXPECT_NEAR(flow(40), exact, 2e-3 * exact);
}

INSTANTIATE_TEST_SUITE_P(Methods, Axisymmetric, testing::Values("sph", "peridynamics", "mlpg"),
                         [](const auto& info) { return std::string(info.param); });

TEST(AxisymmetricMlpg, ParametersAndPointsAgree) {
  for (const char* flux : {"parameters", "edge-stabilised"}) {
    for (const std::string& text : clouds()) {
      const CaseModel m(insulated("mlpg", text) + "[mlpg]\nflux = \"" + flux + "\"\n");
      EXPECT_LT(linear_error(m, {1, 1, 0}), round_off) << flux << '\n' << text;
    }
  }
}

/// A ball of radius 1 around the origin: half of its section in rings, with the volumes and areas of a plate 1 m thick.
std::string half_disc(const TemporaryFolder& folder, int rings) {
  std::string csv = "x [m],y [m],volume [m^3],area_x [m^2],area_y [m^2],face,area2_x [m^2],area2_y [m^2],face2\n";
  const double d = 1.0 / rings;
  for (int k = 0; k <= rings; ++k) {
    const int n = std::max(1, 3 * k);  // intervals on the half ring
    const double low = k == 0 ? 0 : (k - 0.5) * d, high = k == rings ? 1 : (k + 0.5) * d;
    for (int j = 0; j <= (k == 0 ? 0 : n); ++j) {
      const double step = pi / n, angle = k == 0 ? 0 : -pi / 2 + j * step;
      const bool end = k > 0 && (j == 0 || j == n);
      const double sector = k == 0 ? pi : (end ? 0.5 : 1) * step;
      const double x = k == 0 || end ? 0 : k * d * std::cos(angle), y = k == 0 ? 0 : k * d * std::sin(angle);
      csv += fmt::format("{:.17g},{:.17g},{:.17g},", x, y, 0.5 * sector * (high * high - low * low));
      // Chords of the outermost ring, in halves; on the axis the cut.
      Vec3 outer;
      if (k == rings)
        for (const int side : {-1, 1})
          if (j + side >= 0 && j + side <= n) {
            const Vec3 p{x, y, 0}, q{std::cos(angle + side * step), std::sin(angle + side * step), 0};
            outer += 0.5 * side * Vec3{(q - p).y, -(q - p).x, 0};
          }
      const double cut = k == 0 ? d : end ? high - low : 0;
      csv += k == rings ? fmt::format("{:.17g},{:.17g},surface,", outer.x, outer.y) : ",,,";
      csv += cut > 0 ? fmt::format("{:.17g},0,axis\n", -cut) : ",,\n";
    }
  }
  return folder.write(fmt::format("ball-{}.csv", rings), csv);
}

TEST_P(Axisymmetric, ABallFromAFileCools) {
  // Bi = h R / k = 1: T = sum C sin(z r) / (z r) exp(-z^2 Fo), 1 - z cot z = 1 (VDI heat atlas, E2): z = (n + 1/2) pi.
  const TemporaryFolder folder;
  const double Fo = 0.3;
  const auto exact = [&](const Vec3& x) {
    double T = 0;
    for (int n = 0; n < 12; ++n) {
      const double z = (n + 0.5) * pi, r = std::max(1e-9, norm(x));
      T += 4 * (std::sin(z) - z * std::cos(z)) / (2 * z - std::sin(2 * z)) * std::sin(z * r) / (z * r) *
           std::exp(-z * z * Fo);
    }
    return T;
  };
  const auto solve = [&](int rings) {
    const std::string text = start(GetParam()) + "[cloud]\nshape = \"csv\"\naxisymmetric = true\nfile = \"" +
                             half_disc(folder, rings) + "\"\n" + unit_material +
                             "[boundary.surface]\nconvection = { h = \"1 W/(m^2 K)\", ambient = \"0 K\" }\n"
                             "[initial]\ntemperature = \"1 K\"\n[time]\nend = \"0.3 s\"\nintegrator = \"tr-bdf2\"\n"
                             "tolerance = \"1e-6 K\"\n";
    const CaseModel m(text);
    EXPECT_LT(m.model().weights.at("weight_residual"), 1e-11);
    EXPECT_LT(check(m.cloud()).moment_sum, 1e-13);
    State state = m.start();
    make_integrator(m.description(), m.system(), state)->advance(m.system(), state, Fo, [](const State&) {
      return true;
    });
    const std::vector<double> T = m.system().temperatures(state.T);
    double squares = 0, volume = 0;
    for (int i = 0; i < m.cloud().owned; ++i)
      squares += m.cloud().volume[i] * std::pow(T[i] - exact(m.cloud().x[i]), 2), volume += m.cloud().volume[i];
    EXPECT_NEAR(volume, 4 * pi / 3, 0.02);
    return std::sqrt(squares / volume);
  };
  const double coarse = solve(8), fine = solve(24);
  EXPECT_GT(order(coarse, fine, 3), 1.7) << coarse << ' ' << fine;
  EXPECT_LT(fine, 3e-4);
}

TEST(AxisymmetricRefusals, NameWhatDoesNotFit) {
  const std::string tail = unit_material + transient;
  expect_refused(start("sph") + Tube{.a = -0.1, .b = 0.9}.text() + tail, {"beyond the axis", "shift the cloud"});
  expect_refused(start("sph") + Tube{.more = "thickness = \"1 m\""}.text() + tail, {"no thickness"});
  expect_refused(box_case({"1 m", "1 m", "1 m"}, {3, 3, 3}) + "axisymmetric = true\n" + tail, {"two coordinates"});
  expect_refused(start("sph") + Tube{.more = "at = \"cells\"\njitter = 0.1"}.text() + tail, {"lie on its walls"});
  expect_refused(start("sph") + Tube{.a = 0}.text() + tail + "[boundary.xmin]\ntemperature = \"300 K\"\n",
                 {"holds no point", "the axis is no wall"});
  for (const char* method : {"sph", "peridynamics"})
    expect_refused(start(method) + Tube{}.text() + tail + "[" + method + "]\ncorrection = \"paper\"\n",
                   {"knows no axisymmetric bodies"});
  expect_refused(start("mlpg") + Tube{}.text() + tail + "[mlpg]\nsubdomain = \"sphere\"\n", {"circles"});
}

TEST(AxisymmetricParallel, GiveTheSameTemperaturesOnAnyNumberOfRanks) {
  for (const char* method : {"sph", "peridynamics", "mlpg"}) {
    for (const char* more : {"", "jitter = 0.2"}) {
      const std::string text =
          held(method, Tube{.a = 0, .b = 1, .H = 1, .n = 12, .more = more}.text(), "y^2 - x^2/2", true);
      const CaseModel alone(text), together(text, MPI_COMM_WORLD);
      EXPECT_LT(linear_error(together, {1, 1, 0}), round_off);
      State one = alone.steady(), many = together.steady();
      const std::vector<double> a = by_id(alone.cloud(), alone.system().temperatures(one.T));
      const std::vector<double> b = by_id(together.cloud(), together.system().temperatures(many.T));
      const std::vector<double> S = by_id(alone.cloud(), alone.cloud().hoop),
                                S_together = by_id(together.cloud(), together.cloud().hoop);
      for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-9);
      EXPECT_EQ(S, S_together) << method << more;
    }
  }
}

}  // namespace
}  // namespace calor
