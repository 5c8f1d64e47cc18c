// Thermal stress of beams, plates and discs against closed forms.
#include "output/thermal_stress.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "case_models.hpp"

namespace calor {
namespace {

const std::string metal = "youngs_modulus = \"100 GPa\"\npoisson_ratio = 0.3\nexpansion = \"10e-6 1/K\"\n";
constexpr double E = 100e9, nu = 0.3, alpha = 10e-6, h = 4e-3, free_at = 300;

/// A wall of 4 mm, its temperature in K a formula of x in mm.
std::string wall(const std::string& T, const std::string& method = "sph", int points = 21) {
  return box_case({"4 mm"}, {points}, method) + "[steady]\n[boundary.xmin]\ntemperature = \"300 K\"\n" +
         "[initial]\ntemperature = { formula = \"" + T + "\", unit = \"K\", length = \"mm\" }\n";
}
std::string stress(const std::string& body, const std::string& support = "free") {
  return "[stress]\nbody = \"" + body + "\"\nfrom = \"0 mm\"\nto = \"4 mm\"\nfree_at = \"300 K\"\nsupport = \"" +
         support + "\"\n";
}
const std::string of_metal = simple_material({.k = "20"}) + metal;

/// The deformation of a case at its first temperatures, and what it is made from.
struct Stressed {
  CaseModel model;
  Probes probes;
  std::shared_ptr<const ThermalStress> stress;
  State state;
  Deformation d;

  explicit Stressed(const std::string& text, MPI_Comm comm = MPI_COMM_SELF)
      : model(text, comm),
        probes(model.description(), model.cloud(), &model.system().dofs()),
        stress(ThermalStress::make(model.description(), model.system(), probes)),
        state(model.start_without_walls()),
        d((model.system().temperatures(state.T), stress->deformation(state.T))) {}
};

TEST(ThermalStress, AFreePlateWithALinearTemperatureBendsWithoutStress) {
  for (const char* method : {"sph", "peridynamics", "mlpg"})
    for (const char* body : {"beam", "plate"}) {
      const Stressed plate(wall("400 + 25*x", method) + of_metal + stress(body));
      EXPECT_NEAR(plate.d.curvature, alpha * 25e3, 1e-10 * alpha * 25e3) << method;
      EXPECT_NEAR(plate.d.strain, alpha * 150, 1e-10 * alpha * 150);
      EXPECT_NEAR(plate.d.highest, 0, 1e-10 * E * alpha * 100);
      EXPECT_NEAR(plate.d.lowest, 0, 1e-10 * E * alpha * 100);
    }
}

TEST(ThermalStress, SupportsTakeLengthAndCurvature) {
  const Stressed flat(wall("400 + 25*x") + of_metal + stress("plate", "flat"));
  const double biaxial = E * alpha / (1 - nu);
  EXPECT_NEAR(flat.d.highest, biaxial * 50, 1e-10 * biaxial * 100);
  EXPECT_NEAR(flat.d.lowest, -biaxial * 50, 1e-10 * biaxial * 100);
  EXPECT_EQ(flat.d.curvature, 0);
  const Stressed clamped(wall("400 + 25*x") + of_metal + stress("plate", "clamped"));
  EXPECT_NEAR(clamped.d.highest, -biaxial * 100, 1e-10 * biaxial * 100);
  EXPECT_NEAR(clamped.d.lowest, -biaxial * 200, 1e-10 * biaxial * 100);
  const Stressed beam(wall("400 + 25*x") + of_metal + stress("beam", "clamped"));
  EXPECT_NEAR(beam.d.lowest, -E * alpha * 200, 1e-10 * E * alpha * 100);
}

TEST(ThermalStress, ABimetalStripBendsAsTimoshenkoSays) {
  // J. Opt. Soc. Am. 11 (1925) 233: k = 6 (a2 - a1) dT (1+m)^2 / (h (3 (1+m)^2 + (1 + m n) (m^2 + 1/(m n)))). The
  // interface lies between points.
  const double m = 1.37 / 2.63, n = 100. / 210;
  const double expected = 6 * (17e-6 - 10e-6) * 80 * (1 + m) * (1 + m) /
                          (h * (3 * (1 + m) * (1 + m) + (1 + m * n) * (m * m + 1 / (m * n))));
  const std::string layers =
      "[material.m]\nconductivity = \"20 W/(m K)\"\n" + metal +
      "[material.other]\nconductivity = \"50 W/(m K)\"\nyoungs_modulus = \"210 GPa\"\npoisson_ratio = 0.3\n"
      "expansion = \"17e-6 1/K\"\n[body]\nalong = \"x\"\n[[body.layer]]\nmaterial = \"m\"\nthickness = \"1.37 "
      "mm\"\n[[body.layer]]\n"
      "material = \"other\"\nthickness = \"2.63 mm\"\n";
  const Stressed strip(wall("380") + layers + stress("beam"));
  EXPECT_NEAR(strip.d.curvature, expected, 1e-10 * expected);
}

TEST(ThermalStress, AGradedPlateHasTheStressOfItsMoments) {
  // E = E0 exp(b s), thermal strain alpha c s^2: the moments I_n of exp(b s) s^n give strain and curvature.
  const double b = 500, c = 5e6;  // 1/m, K/m^2
  double I[5];
  I[0] = std::expm1(b * h) / b;
  for (int n = 1; n < 5; ++n) I[n] = (std::exp(b * h) * std::pow(h, n) - n * I[n - 1]) / b;
  const double det = I[0] * I[2] - I[1] * I[1], f = alpha * c;
  const double d0 = f * (I[2] * I[2] - I[1] * I[3]) / det, d1 = f * (I[0] * I[3] - I[1] * I[2]) / det;
  const std::string graded = simple_material({.k = "20"}) +
                             "youngs_modulus = { formula = \"100e9*exp(0.5*x)\", unit = \"Pa\", length = \"mm\" }\n"
                             "poisson_ratio = 0.3\nexpansion = \"10e-6 1/K\"\n";
  const Stressed plate(wall("300 + 5*x^2") + graded + stress("plate"));
  EXPECT_NEAR(plate.d.curvature, d1, 1e-9 * d1);
  EXPECT_NEAR(plate.d.strain, d0 + 0.5 * h * d1, 1e-9 * std::abs(d0));
  const double at_end = E * std::exp(b * h) / (1 - nu) * (d0 + h * d1 - f * h * h);
  EXPECT_NEAR(plate.d.lowest, at_end, 1e-9 * std::abs(at_end));
}

/// A disc of radius 20 mm and 4 mm thick, its temperature a formula of x (the radius) and y in mm.
std::string disc(const std::string& T) {
  return "title = \"disc\"\nmethod = \"sph\"\n[cloud]\naxisymmetric = true\nshape = \"box\"\nsize = [\"20 mm\", \"4 "
         "mm\"]\n"
         "points = [41, 9]\n[steady]\n[boundary.ymin]\ntemperature = \"300 K\"\n[initial]\ntemperature = { formula = "
         "\"" +
         T + "\", unit = \"K\", length = \"mm\" }\n" + of_metal +
         "[stress]\nbody = \"disc\"\nradius = \"20 mm\"\nfrom = [\"0 mm\", \"0 mm\"]\nto = [\"0 mm\", \"4 mm\"]\n"
         "free_at = \"300 K\"\n";
}

TEST(ThermalStress, AHotMiddleOfADiscIsPressedAndItsRimPulled) {
  // T = 300 K + 100 K (1 - r^2/R^2): radial -alpha E 100 K (1 - r^2/R^2)/4, hoop -alpha E 100 K (1 - 3 r^2/R^2)/4.
  const Stressed hot(disc("300 + 100*(1 - (x/20)^2)"));
  const double scale = alpha * E * 100 / 4;
  for (std::size_t i = 0; i < hot.d.T.size(); ++i) {
    const double square = std::pow(hot.stress->r()[i] / 20e-3, 2);
    EXPECT_NEAR(hot.d.stress[0][i], -scale * (1 - square), 1e-8 * scale);
    EXPECT_NEAR(hot.d.stress[1][i], -scale * (1 - 3 * square), 1e-8 * scale);
  }
  EXPECT_NEAR(hot.d.highest, 2 * scale, 1e-8 * scale);
  EXPECT_NEAR(hot.d.curvature, 0, 1e-6);
}

TEST(ThermalStress, TheLargestStressOfAPlateMayLieBetweenTwoPlacesOfItsSection) {
  // T - 300 K = a s^2: E alpha a / (1 - nu) (s h - s^2 - h^2/6), largest at s = h/2: a h^2/12 = 8 K.
  for (const int points : {9, 20, 21}) {
    const Stressed plate(wall("300 + 6*x^2", "sph", points) + of_metal + stress("plate"));
    const double largest = E * alpha / (1 - nu) * 8;
    EXPECT_NEAR(plate.d.highest, largest, 1e-9 * largest);
  }
}

TEST(ThermalStress, ADiscThatIsHotOnOneSideIsAPlate) {
  const Stressed round(disc("300 + 6*y^2"));
  const Stressed plate(wall("300 + 6*x^2", "sph", 9) + of_metal + stress("plate"));
  EXPECT_NEAR(round.d.highest, plate.d.highest, 1e-8 * plate.d.highest);
  EXPECT_NEAR(round.d.lowest, plate.d.lowest, 1e-8 * plate.d.highest);
  EXPECT_NEAR(round.d.curvature, plate.d.curvature, 1e-8 * plate.d.curvature);
}

TEST(ThermalStress, PointsAndProbesHaveTheStressOfTheSection) {
  Stressed plate(wall("300 + 5*x^2") + of_metal + stress("plate") + "[probe]\nmiddle = \"2 mm\"\n");
  const std::vector<double> T = plate.model.system().temperatures(plate.state.T);
  const std::vector<double> at_points = plate.stress->at_points(plate.d, 0, T);
  const double at_probe = plate.stress->at_probes(plate.d, 0, plate.probes.temperatures(plate.state.T))[0];
  EXPECT_NEAR(at_points[10], at_probe, 1e-6);
  EXPECT_NEAR(at_points[0], plate.d.stress[0].front(), 1e-6);
  // The force of the section by Simpson's rule, exact for a parabola: without support none.
  double force = 0;
  for (int i = 0; i < 21; ++i) force += (i == 0 || i == 20 ? 1 : i % 2 ? 4 : 2) * at_points[i];
  EXPECT_NEAR(force, 0, 1e-8 * plate.d.highest);
}

TEST(ThermalStressParallel, IsTheSameOnAnyNumberOfRanks) {
  const std::string text = wall("300 + 5*x^2") + of_metal + stress("plate");
  const Stressed alone(text), together(text, MPI_COMM_WORLD);
  EXPECT_EQ(alone.d.d, together.d.d);
  EXPECT_EQ(alone.d.highest, together.d.highest);
}

/// E, nu and thermal strain of spheres of a second phase, 30 %, and pores of 10 % where asked for, at 400 K.
ElasticState mixed(const std::string& rule, const std::string& more = "") {
  const std::string mixture =
      "[material.m]\nconductivity = \"20 W/(m K)\"\n" + metal +
      "[material.other]\nconductivity = \"2 W/(m K)\"\nyoungs_modulus = \"380 GPa\"\npoisson_ratio = 0.22\n"
      "expansion = \"7e-6 1/K\"\n[material.both]\nmix = \"voigt\"\nphases = [\"m\", \"other\"]\nfraction = 0.3\n"
      "basis = \"volume\"\n" +
      more;
  const CaseModel model(wall("400") + mixture);
  const Vec3 x[1] = {{2e-3, 0, 0}};
  const int tag[1] = {0};
  const Elasticity elasticity(model.description(), MPI_COMM_SELF, model.system().material(), x, tag,
                              *elastic_rules().find(rule), free_at);
  return elasticity.at(std::array{400.});
}

TEST(ElasticMixtures, AreThoseOfMoriTanakaAndLevin) {
  // Benveniste, Mech. Mater. 6 (1987) 147: K = K1 + v2 (K2 - K1)/(1 + v1 (K2 - K1)/(K1 + 4 G1/3)), G alike with
  // f1 = G1 (9 K1 + 8 G1)/(6 (K1 + 2 G1)); Levin: a = a1 + (a2 - a1) (1/K - 1/K1)/(1/K2 - 1/K1).
  const double K1 = E / (3 * (1 - 2 * nu)), G1 = E / (2 * (1 + nu)), K2 = 380e9 / (3 * 0.56), G2 = 380e9 / 2.44;
  const double K = K1 + 0.3 * (K2 - K1) / (1 + 0.7 * (K2 - K1) / (K1 + 4 * G1 / 3));
  const double f = G1 * (9 * K1 + 8 * G1) / (6 * (K1 + 2 * G1));
  const double G = G1 + 0.3 * (G2 - G1) / (1 + 0.7 * (G2 - G1) / (G1 + f));
  const double a = alpha + (7e-6 - alpha) * (1 / K - 1 / K1) / (1 / K2 - 1 / K1);
  for (const char* rule : {"mori-tanaka", "kerner"}) {
    const ElasticState s = mixed(rule);
    EXPECT_NEAR(s.E[0], 9 * K * G / (3 * K + G), 1e-12 * E);
    EXPECT_NEAR(s.nu[0], (3 * K - 2 * G) / (2 * (3 * K + G)), 1e-12);
    EXPECT_NEAR(s.thermal_strain[0], a * 100, 1e-12 * a * 100);
  }
  const ElasticState upper = mixed("voigt"), lower = mixed("reuss");
  EXPECT_NEAR(upper.E[0] / (3 * (1 - 2 * upper.nu[0])), 0.7 * K1 + 0.3 * K2, 1e-3);
  EXPECT_NEAR(3 * (1 - 2 * lower.nu[0]) / lower.E[0], 0.7 / K1 + 0.3 / K2, 1e-24);
  EXPECT_NEAR(lower.thermal_strain[0], (0.7 * alpha + 0.3 * 7e-6) * 100, 1e-15);
}

TEST(ElasticMixtures, PoresSoftenAndDoNotExpand) {
  const std::string pores = "pores = { material = \"air\", porosity = 0.1 }\n";
  const ElasticState dense = mixed("mori-tanaka"), porous = mixed("mori-tanaka", pores);
  EXPECT_LT(porous.E[0], 0.9 * dense.E[0]);
  EXPECT_GT(porous.E[0], 0.7 * dense.E[0]);
  EXPECT_NEAR(porous.thermal_strain[0], dense.thermal_strain[0], 0.02 * dense.thermal_strain[0]);
}

TEST(ThermalStress, WhatItCannotKnowIsRefused) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& words) {
    expect_error([&] { Stressed wrong(text); }, words);
  };
  const std::string plain = simple_material({.k = "20"});
  refused(wall("400") + plain + stress("plate"), {"[material.m] has no youngs_modulus"});
  refused(wall("400") + plain + "youngs_modulus = \"1 GPa\"\n" + stress("plate"), {"no poisson_ratio"});
  refused(wall("400") + of_metal + stress("disc"), {"a disc has a radius"});
  refused(wall("400") + of_metal + stress("disc") + "radius = \"1 m\"\n", {"a disc has a thickness and a radius"});
  refused(wall("400") + of_metal + stress("plate") + "radius = \"1 m\"\n", {"'radius' goes with body = \"disc\""});
  refused(wall("400") + of_metal + replaced(stress("plate"), "4 mm", "5 mm"), {"[stress]", "outside"});
  refused(wall("400") + of_metal + replaced(stress("plate"), "4 mm", "0 mm"), {"ends where it begins"});
  expect_error([&] { Stressed wrong(wall("400") + replaced(of_metal, "0.3", "0.5") + stress("plate")); },
               {"Poisson's ratio of 0.5"}, Fault::numbers);
}

}  // namespace
}  // namespace calor
