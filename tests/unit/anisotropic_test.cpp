// Bodies that conduct by k R: see material/anisotropy.hpp.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "case_models.hpp"
#include "material/anisotropy.hpp"
#include "mlpg_systems.hpp"

namespace calor {
namespace {

const std::vector<std::string> all_methods = {"sph", "peridynamics", "mlpg"};

/// Factors along three axes, and the angles that turn them, deg.
struct Grain {
  Vec3 factors = {1, 1, 1};
  std::vector<double> turn = {};

  std::string text() const {
    std::string angles;
    for (const double angle : turn) angles += fmt::format("{}\"{} deg\"", angles.empty() ? "" : ", ", angle);
    return fmt::format("anisotropy = {{ x = {}, y = {}, z = {}{} }}\n", factors.x, factors.y, factors.z,
                       angles.empty() ? "" : ", turn = [" + angles + "]");
  }
  /// R^power, as a case reads it.
  Symmetric3 R(double power = 1) const {
    const Case c = parse_case(box_case({"1 m"}, {5}) + simple_material({.k = "1"}) + text());
    return read_anisotropy(c.section("material").sub("m"))->power(power);
  }
};

/// k = 3 W/(m K), rho c = 1 J/(m^3 K), insulated, in time.
std::string body(const std::string& method, const std::vector<int>& points, double jitter, const Grain& grain,
                 const std::string& more = "") {
  std::vector<std::string> size;
  for (const int n : points) size.push_back(fmt::format("{} m", 0.1 * (n - 1)));
  return box_case(size, points, method) + fmt::format("jitter = {}\n", jitter) +
         simple_material({.k = "3", .rho = "1", .c = "1"}) + grain.text() +
         "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n" + more;
}

/// The heat into every cell for T = slope.x is what leaves by its share of the surface, -k n.R slope, and the flux is
/// -k R slope everywhere.
void expect_linear_patch(const std::string& text, const Symmetric3& R, double tolerance) {
  const CaseModel m(text);
  const Cloud& cloud = m.cloud();
  const Vec3 slope{7, cloud.dimension > 1 ? -4. : 0., cloud.dimension > 2 ? 2. : 0.};
  std::vector<double> T(cloud.local());
  for (int i = 0; i < cloud.local(); ++i) T[i] = 300 + dot(slope, cloud.x[i]);
  std::vector<double> u = T;
  ASSERT_TRUE(m.system().dofs().are_temperatures());
  const Vec3 flux = -3 * (R * slope);
  const std::vector<double> F = m.rates(0, u).F;
  double largest = 0;
  for (int i = 0; i < cloud.owned; ++i) largest = std::max(largest, std::abs(F[i] - dot(flux, cloud.area[i])));
  EXPECT_LE(largest, tolerance * norm(flux) * std::pow(0.1, cloud.dimension - 1));
  std::vector<Vec3> q(cloud.owned);
  m.system().heat_flux(0, u, q);
  for (const Vec3& value : q) EXPECT_LE(norm(value - flux), 100 * tolerance * norm(flux));
}

TEST(Anisotropy, TurnsItsAxesAboutZThenAboutTheirOwnYThenAboutTheirOwnX) {
  const Symmetric3 quarter = Grain{{5, 2, 1}, {90}}.R();
  EXPECT_TRUE(quarter.is_diagonal());
  EXPECT_LE(norm(quarter.diagonal() - Vec3{2, 5, 1}), 1e-14);
  // About z: x -> y, y -> -x. About the new y: what pointed along y points along -z, z along y.
  const Symmetric3 R = Grain{{5, 2, 1}, {90, 90}}.R();
  EXPECT_LE(norm(R.diagonal() - Vec3{2, 1, 5}), 1e-14);
  // 30 deg in the plane: c^2 k1 + s^2 k2, c s (k1 - k2).
  const Symmetric3 plane = Grain{{10, 1, 1}, {30}}.R();
  EXPECT_NEAR(plane.xx, 0.75 * 10 + 0.25, 1e-14);
  EXPECT_NEAR(plane.xy, std::sqrt(3) / 4 * 9, 1e-14);
}

TEST(Anisotropy, HasARootAndAnInverseRoot) {
  const Anisotropy a{.factors = {4, 9, 0.25}};
  const Vec3 v = a.power(-0.5) * (a.power(0.5) * Vec3{1, 2, 3});
  EXPECT_NEAR(norm(v - Vec3{1, 2, 3}), 0, 1e-14);
  EXPECT_EQ(a.power(0.5).diagonal(), (Vec3{2, 3, 0.5}));
}

TEST(Anisotropy, OfACylinderIsRadialHoopAndAxial) {
  Anisotropy a{.factors = {2, 3, 5}};
  a.cylinder = Anisotropy::Cylinder{.axis = 2, .centre = {1, 0, 0}};
  const Symmetric3 above = a.at({1, 4, 7}), beside = a.at({3, 0, 0}), middle = a.at({1, 0, 2});
  EXPECT_EQ(above.diagonal(), (Vec3{3, 2, 5}));
  EXPECT_EQ(beside.diagonal(), (Vec3{2, 3, 5}));
  EXPECT_EQ(middle.diagonal(), (Vec3{2.5, 2.5, 5}));
}

TEST(Anisotropic, LinearTemperaturesAreExactOnIrregularPointsByAllMethods) {
  for (const std::string& method : all_methods) {
    for (int seed = 1; seed <= 3; ++seed) {
      SCOPED_TRACE(fmt::format("{} {}", method, seed));
      const auto factor = [&](int n) { return std::pow(5, 0.5 * (1 + scattered(10 * seed + n))); };  // 1 to 5
      const Grain flat{{factor(1), factor(2), 1}, {180 * scattered(seed)}};
      expect_linear_patch(body(method, {11, 9}, 0.2, flat), flat.R(), 1e-10);
      const Grain solid{{factor(3), factor(4), factor(5)},
                        {180 * scattered(seed + 5), 90 * scattered(seed + 6), 90 * scattered(seed + 7)}};
      expect_linear_patch(body(method, {7, 6, 7}, 0.2, solid), solid.R(), 1e-10);
    }
  }
}

TEST(Anisotropic, LinearTemperaturesAreExactOnLatticesAtAnyRatioAlongTheirAxes) {
  for (const std::string& method : all_methods) {
    SCOPED_TRACE(method);
    const Grain grain{{1, 1000, 0.1}};
    expect_linear_patch(body(method, {9, 8}, 0, grain), grain.R(), 1e-12);
    expect_linear_patch(body(method, {6, 5, 7}, 0, grain), grain.R(), 1e-12);
  }
}

TEST(Anisotropic, LinearTemperaturesAreExactByMlpgAtAnyRatioAndAngle) {
  for (const double ratio : {10., 100., 1000.}) {
    const Grain grain{{ratio, 1, 1}, {30}};
    for (const double jitter : {0., 0.2}) expect_linear_patch(body("mlpg", {11, 9}, jitter, grain), grain.R(), 1e-11);
    const Grain solid{{ratio, 1, 3}, {30, 20, 50}};
    for (const double jitter : {0., 0.2}) expect_linear_patch(body("mlpg", {7, 6, 7}, jitter, solid), solid.R(), 1e-11);
  }
}

TEST(Anisotropic, PartsOfDifferentTensorsConductInSeriesAcrossAndSideBySideAlongTheirInterface) {
  // T = 300 + 5 x + h(y), the heat through the layers the same in both: h' k_y = 6 W/m^2.
  const std::string layers =
      "[material.other]\nconductivity = \"2 W/(m K)\"\nanisotropy = { x = 8, y = 0.25 }\ndensity = \"1 kg/m^3\"\n"
      "specific_heat = \"1 J/(kg K)\"\n[body]\nalong = \"y\"\n[[body.layer]]\nmaterial = \"m\"\nthickness = \"0.33 "
      "m\"\n"
      "[[body.layer]]\nmaterial = \"other\"\nthickness = \"0.47 m\"\n";
  for (const std::string& method : all_methods) {
    SCOPED_TRACE(method);
    const CaseModel m(body(method, {9, 9}, 0, {.factors = {0.1, 4, 1}}, layers));
    const Cloud& cloud = m.cloud();
    std::vector<double> T(cloud.local());
    for (int i = 0; i < cloud.local(); ++i) {
      const double y = cloud.x[i].y;
      T[i] = 300 + 5 * cloud.x[i].x + 6 / 12. * std::min(y, 0.33) + 6 / 0.5 * std::max(0.0, y - 0.33);
    }
    const std::vector<double> F = m.rates(0, T).F;
    std::vector<Vec3> q(cloud.owned);
    m.system().heat_flux(0, T, q);
    for (int i = 0; i < cloud.owned; ++i) {
      if (cloud.on_faces[i] == 0) {
        EXPECT_NEAR(F[i], 0, 1e-11);
      }
      EXPECT_NEAR(q[i].y, -6, 1e-10);
      const double y = cloud.x[i].y;
      if (y < 0.25 || y > 0.45) {
        EXPECT_NEAR(q[i].x, y < 0.3 ? -5 * 0.3 : -5 * 16., 1e-10);
      }
    }
  }
}

TEST(Anisotropic, HeatIsConservedAndPairsAreSymmetric) {
  for (const std::string& method : all_methods) {
    SCOPED_TRACE(method);
    const CaseModel m(body(method, {11, 9}, 0.2, {.factors = {5, 1, 1}, .turn = {30}}));
    const std::vector<double> F = m.rates(0, scattered_temperatures(m.cloud(), 300, 50)).F;
    double total = 0, size = 0;
    for (const double f : F) total += f, size += std::abs(f);
    EXPECT_LE(std::abs(total), 1e-13 * size);
    for (const double f : m.rates(0, m.uniform(300)).F) EXPECT_EQ(f, 0);
    EXPECT_EQ(m.system().jacobian_is_symmetric(), method != "mlpg");
  }
}

TEST(Anisotropic, ALatticeIsTheIsotropicOneStretched) {
  // k = 1, 4 on a square of n x n points is k = 1 on half the height, with half the thickness.
  for (const std::string& method : all_methods) {
    SCOPED_TRACE(method);
    const std::string rest =
        "[boundary.walls]\non = [\"xmin\", \"ymin\"]\ntemperature = { formula = \"300 + 9*sin(5*x)\", unit = \"K\" }\n"
        "[boundary.top]\non = \"xmax\"\nflux = \"7 W/m^2\"\n[mlpg]\nflux = \"edge-stabilised\"\n[steady]\n";
    const auto square =
        box_case({"1 m", "1 m"}, {13, 13}, method) + simple_material({.k = "1"}) + "anisotropy = { y = 4 }\n" + rest;
    const auto flat = box_case({"1 m", "0.5 m"}, {13, 13}, method) + simple_material({.k = "1"}) + rest;
    const CaseModel a(square), b(flat);
    const State T = a.steady(), U = b.steady();
    for (int i = 0; i < a.cloud().owned; ++i) {
      if (method == "peridynamics") {
        EXPECT_NEAR(T.T[i], U.T[i], 0.01);  // its lines reach as far as horizons do
      } else {
        EXPECT_NEAR(T.T[i], U.T[i], 1e-9);
      }
    }
  }
}

/// T = 2 + exp(2 p.x) sin(2 q.x + 0.3), p and q the first columns of R^(-1/2), on the unit square with T on its walls.
double error_on_square(const std::string& method, int n, double jitter, double ratio, double angle) {
  const Grain grain{{ratio, 1, 1}, {angle}};
  const Symmetric3 root = grain.R(-0.5);
  const std::string formula =
      fmt::format("2 + exp(2*({}*x + {}*y))*sin(2*({}*x + {}*y) + 0.3)", root.xx, root.xy, root.xy, root.yy);
  const CaseModel m(box_case({"1 m", "1 m"}, {n, n}, method) + fmt::format("jitter = {}\n", jitter) +
                    simple_material({.k = "1"}) + grain.text() +
                    "[boundary.walls]\non = [\"xmin\", \"xmax\", \"ymin\", \"ymax\"]\ntemperature = { formula = \"" +
                    formula + "\", unit = \"K\" }\n[steady]\n");
  const State s = m.steady();
  double squares = 0;
  for (int i = 0; i < m.cloud().owned; ++i) {
    const Vec3& x = m.cloud().x[i];
    const double T =
        2 + std::exp(2 * (root.xx * x.x + root.xy * x.y)) * std::sin(2 * (root.xy * x.x + root.yy * x.y) + 0.3);
    squares += (s.T[i] - T) * (s.T[i] - T);
  }
  return std::sqrt(squares / m.cloud().owned);
}

double order_on_square(const std::string& method, double jitter, double ratio, double angle) {
  return std::log2(error_on_square(method, 21, jitter, ratio, angle) /
                   error_on_square(method, 41, jitter, ratio, angle));
}

TEST(Anisotropic, MlpgIsOfSecondOrderAtAnyRatioAndAngle) {
  for (const double ratio : {10., 100.})
    for (const double jitter : {0., 0.2}) {
      SCOPED_TRACE(fmt::format("{} {}", ratio, jitter));
      EXPECT_GE(order_on_square("mlpg", jitter, ratio, 30), 1.8);
    }
}

TEST(Anisotropic, LatticesAlongTheAxesAreOfSecondOrder) {
  for (const std::string method : {"sph", "mlpg"}) {
    SCOPED_TRACE(method);
    EXPECT_GE(order_on_square(method, 0, 10, 0), 1.8);
    EXPECT_GE(order_on_square(method, 0, 100, 90), 1.8);
  }
  // The lines of peridynamics reach as far as horizons do, and end at walls.
  EXPECT_GE(order_on_square("peridynamics", 0, 10, 0), 1.7);
  EXPECT_GE(order_on_square("peridynamics", 0, 100, 90), 1.2);
}

TEST(Anisotropic, PairsAtAnAngleAreOfSecondOrderUpToOneToFive) {
  EXPECT_GE(order_on_square("sph", 0, 5, 30), 1.8);
  EXPECT_GE(order_on_square("sph", 0.2, 5, 30), 1.4);  // of two clouds of displaced points: 1.5 to 2.0 over seeds
  // Where the fit of second moments has less room, near walls, it is of first order only.
  EXPECT_LE(error_on_square("peridynamics", 41, 0, 5, 30), 6e-5);
  EXPECT_GE(order_on_square("peridynamics", 0, 5, 30), 0.9);
}

TEST(Anisotropic, PairsServeAnyRatioOnIrregularPointsSpacedByItsRoot) {
  for (const std::string method : {"sph", "peridynamics"}) {
    SCOPED_TRACE(method);
    const Grain grain{{100, 1, 1}};
    const std::string text = body(method, {9, 81}, 0.1, grain);  // spacings 0.1 m, made 0.01 m along y
    expect_linear_patch(replaced(text, "\"8 m\"", "\"0.8 m\""), grain.R(), 1e-10);
  }
}

TEST(Anisotropic, MlpgDoesNotGrowInTime) {
  for (const double ratio : {10., 100., 1000.}) {
    for (const double jitter : {0., 0.2}) {
      const Cloud cloud = box_cloud({12, 12}, 0.1, {.jitter = jitter, .support = 6});
      MlpgOptions o = MlpgOptions::defaults(2, jitter == 0);
      o.flux = MlpgFlux::edge_stabilised;
      const double c = std::cos(std::numbers::pi / 6), s = 0.5;
      o.anisotropy = Anisotropy{.factors = {ratio, 1, 1}, .axes = {{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}}};
      const MlpgSystem m(cloud, o);
      Eigen::MatrixXd rates = Eigen::MatrixXd(m.K);
      for (int i = 0; i < cloud.owned; ++i) rates.row(i) /= cloud.volume[i];
      const auto values = Eigen::EigenSolver<Eigen::MatrixXd>(rates, false).eigenvalues();
      EXPECT_GE(values.real().minCoeff(), -1e-8 * values.real().maxCoeff()) << ratio << " " << jitter;
    }
  }
}

TEST(Anisotropic, WallsOffThePointsConductAcrossByTheFactorAcross) {
  // A slab: 50 W/m^2 in below, h = 20 W/(m^2 K) to 300 K above; k_y = 3 * 0.2 W/(m K).
  for (const std::string method : {"sph", "peridynamics"}) {
    SCOPED_TRACE(method);
    const CaseModel m(box_case({"1 m", "1 m"}, {6, 10}, method) + "at = \"cells\"\n" + simple_material({.k = "3"}) +
                      "anisotropy = { y = 0.2 }\n[boundary.heater]\non = \"ymin\"\nflux = \"50 W/m^2\"\n"
                      "[boundary.air]\non = \"ymax\"\nconvection = { h = \"20 W/(m^2 K)\", ambient = \"300 K\" }\n"
                      "[steady]\n");
    const State s = m.steady();
    for (int i = 0; i < m.cloud().owned; ++i)
      EXPECT_NEAR(s.T[i], 300 + 50 / 20. + 50 / 0.6 * (1 - m.cloud().x[i].y), 1e-8);
  }
}

TEST(Anisotropic, AWoundBodyConductsByItsRadialAndHoopFactors) {
  // T = log r between r = 0.2 and 0.5 m does not feel the hoop; a quarter of the ring, cut from a square, is too crude
  // for its own sake: the whole disc of a square with T given on its walls, T = r^n cos(n' phi), n'^2 hoop = n^2
  // radial. Here n' = 2, hoop = 4, radial = 1: n = 4.
  std::vector<double> errors;
  for (const int n : {21, 41}) {
    const std::string T = "300 + ((x - 0.5)^2 - (y - 0.5)^2)*((x - 0.5)^2 + (y - 0.5)^2)*100";
    const CaseModel m(box_case({"1 m", "1 m"}, {n, n}, "mlpg") + "jitter = 0.2\n" + simple_material({.k = "1"}) +
                      "anisotropy = { hoop = 4, centre = [\"0.5 m\", \"0.5 m\"] }\n[boundary.walls]\n"
                      "on = [\"xmin\", \"xmax\", \"ymin\", \"ymax\"]\ntemperature = { formula = \"" +
                      T + "\", unit = \"K\" }\n[steady]\n");
    const State s = m.steady();
    double squares = 0;
    for (int i = 0; i < m.cloud().owned; ++i) {
      const Vec3 r = m.cloud().x[i] - Vec3{0.5, 0.5, 0};
      const double e = s.T[i] - 300 - 100 * (r.x * r.x - r.y * r.y) * dot(r, r);
      squares += e * e;
    }
    errors.push_back(std::sqrt(squares / m.cloud().owned));
  }
  EXPECT_LE(errors[1], 0.02);
  EXPECT_GE(std::log2(errors[0] / errors[1]), 1.6);
}

TEST(AnisotropicParallel, GivesTheSameRatesOnAnyNumberOfRanks) {
  for (const std::string& method : all_methods) {
    for (const double jitter : {0., 0.2}) {
      const std::string text = body(method, {13, 11}, jitter, {.factors = {4, 1, 1}, .turn = {30}});
      const CaseModel one(text), all(text, MPI_COMM_WORLD);
      const auto F = one.rates(0, scattered_temperatures(one.cloud(), 300, 50)).F;
      const auto G = all.rates(0, scattered_temperatures(all.cloud(), 300, 50)).F;
      EXPECT_EQ(by_id(one.cloud(), F), by_id(all.cloud(), G)) << method << " " << jitter;
    }
  }
}

TEST(AnisotropicParallel, PartsGiveTheSameRatesOnAnyNumberOfRanks) {
  const std::string regions =
      "[material.other]\nconductivity = \"2 W/(m K)\"\nanisotropy = { x = 8, y = 0.25 }\ndensity = \"1 kg/m^3\"\n"
      "specific_heat = \"1 J/(kg K)\"\n[body]\nmaterial = \"m\"\n[[body.region]]\nmaterial = \"other\"\n"
      "where = \"x + y > 1\"\n";
  for (const std::string& method : all_methods) {
    const std::string text = body(method, {13, 11}, 0, {.factors = {0.1, 4, 1}}, regions);
    const CaseModel one(text), all(text, MPI_COMM_WORLD);
    const auto F = one.rates(0, scattered_temperatures(one.cloud(), 300, 50)).F;
    const auto G = all.rates(0, scattered_temperatures(all.cloud(), 300, 50)).F;
    EXPECT_EQ(by_id(one.cloud(), F), by_id(all.cloud(), G)) << method;
  }
}

TEST(Anisotropic, BodiesThatPairsCannotServeAreRefused) {
  const std::string rest = "[boundary.w]\non = \"xmin\"\ntemperature = \"300 K\"\n[steady]\n";
  const auto square = [&](const std::string& method, const std::string& cloud, const std::string& anisotropy) {
    return box_case({"1 m", "1 m"}, {9, 9}, method) + cloud + simple_material({.k = "1"}) +
           "anisotropy = " + anisotropy + "\n" + rest;
  };
  for (const std::string method : {"sph", "peridynamics"}) {
    expect_refused(square(method, "jitter = 0.2\n", "{ x = 100, turn = \"30 deg\" }"), {"times better", "mlpg"});
    expect_refused(square(method, "", "{ hoop = 2 }"), {"from place to place", "mlpg"});
    expect_refused(square(method, "at = \"cells\"\n", "{ x = 2, turn = \"30 deg\" }"), {"off the walls"});
  }
  expect_refused(square("mlpg", "", "{ x = 2, turn = [\"30 deg\", \"20 deg\"] }"), {"leave the body", "about z alone"});
}

}  // namespace
}  // namespace calor
