#include "material/material_field.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "case_models.hpp"
#include "material/invert.hpp"
#include "material/library.hpp"
#include "material/mixing_rules.hpp"
#include "results.hpp"

namespace calor {
namespace {

// ---- the library ----------------------------------------------------------------------------------------------------

TEST(MaterialLibrary, HasPositiveValuesWithTheirSources) {
  ASSERT_GE(material_library().size(), 5u);
  for (const LibraryMaterial& m : material_library()) {
    SCOPED_TRACE(m.name);
    for (const LibraryValue* value : {&m.conductivity, &m.density, &m.specific_heat})
      EXPECT_GE(value->source.size(), 8u);
    const SimpleProperties p = m.properties();
    for (double T = 250; T <= 1600; T += 50) {
      EXPECT_GT(p.conductivity({}, 0, T), 0) << T;
      EXPECT_GT((*p.density)({}, 0, T), 0) << T;
      EXPECT_GT((*p.specific_heat)({}, 0, T), 0) << T;
    }
  }
}

TEST(MaterialLibrary, NamesWhatADesignNeeds) {
  for (const char* name : {"alumina", "zirconia", "Ti-6Al-4V", "mild steel", "air"}) {
    const LibraryMaterial* found = find_in_library(name);
    ASSERT_NE(found, nullptr) << name;
    EXPECT_EQ(found->name, name);
  }
  EXPECT_EQ(find_in_library("unobtainium"), nullptr);
}

TEST(MaterialLibrary, GivesAluminaTheConductivityThatWasMeasured) {
  // Munro (J. Am. Ceram. Soc. 80, 1997), table of recommended values: 33 W/(m K) at 20 degC, 7.22 at 1000 degC.
  const Function k = find_in_library("alumina")->properties().conductivity;
  EXPECT_NEAR(k({}, 0, 293.15), 33, 2);
  EXPECT_NEAR(k({}, 0, 1273.15), 7.2, 0.3);
}

TEST(MaterialLibrary, GivesTheValuesOfItsSourcesAtSingleTemperatures) {
  struct Figure {
    const char* name;
    double T, k, c;
  };
  // Worked out by hand from the formulas, or rows of the tables.
  for (const auto& [name, T, k, c] : {Figure{"stainless steel 316L", 1000, 24.958, 591.8},
                                      {"Inconel 625", 477.15, 12.5, 456},
                                      {"Inconel 718", 600, 14.90852, 489.08},
                                      {"Ti-6Al-4V", 723.15, 11.975, 640},
                                      {"alumina", 1000, 8.738271, 1223.7},
                                      {"silicon carbide", 1000, 98.0392, 1191.6451},
                                      {"uranium dioxide", 1000, 3.467073, 311.3687},
                                      {"mullite", 773.15, 1.485, 1149.0873},
                                      {"concrete EN 1992-1-2", 573.15, 1.0033, 1050}}) {
    SCOPED_TRACE(name);
    const SimpleProperties p = find_in_library(name)->properties();
    EXPECT_NEAR(p.conductivity({}, 0, T), k, 1e-4 * k);
    EXPECT_NEAR((*p.specific_heat)({}, 0, T), c, 1e-4 * c);
  }
}

TEST(MaterialLibrary, MeltsIceByItsLatentHeat) {
  const SimpleProperties p = find_in_library("water and ice")->properties();
  EXPECT_DOUBLE_EQ(p.conductivity({}, 0, 272), 2.14 + (2.3 - 2.14) * 0.65 / 9.5);
  EXPECT_DOUBLE_EQ(p.conductivity({}, 0, 283.15), 0.58);
  // From -0.5 to 0.5 degC: 333.6 kJ/kg, and the mean of both specific heats over 1 K.
  const auto material = make_simple_material("water and ice", p);
  const std::vector<Vec3> x(2);
  const auto properties = material->at(x, {.low = 250, .high = 320, .reference = 260});
  std::vector<double> H(2);
  properties->enthalpy(0, std::vector{272.65, 273.65}, H, {});
  EXPECT_NEAR(H[1] - H[0], 917 * (333.6e3 + 0.5 * (2110 + 4217.6)), 1e-6 * H[1]);
}

// ---- cases ----------------------------------------------------------------------------------------------------------

/// A lattice of 5 x 3 points in 4 m x 2 m.
std::string plate(const std::string& rest) {
  return box_case({"4 m", "2 m"}, {5, 3}) + R"toml([initial]
temperature = "400 K"
[time]
end = "1 s"
)toml" + rest;
}

struct Properties {
  std::vector<double> k, dk_dT, H, rho_c;
};
/// At all points, which are T warm.
Properties properties(const CaseModel& m, const std::vector<double>& T, double t = 0) {
  const std::size_t n = T.size();
  Properties p{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n), std::vector<double>(n)};
  m.system().material().conductivity(t, T, p.k, p.dk_dT);
  m.system().material().enthalpy(T, p.H, p.rho_c);
  return p;
}
Properties properties(const CaseModel& m, double T, double t = 0) { return properties(m, m.uniform(T), t); }

TEST(Material, TakesNumbersTablesAndFormulas) {
  const CaseModel m(plate(R"toml(
[material.m]
conductivity = { formula = "10 + x + 2*y + 0.1*t + 0.01*T", unit = "W/(m K)" }
density = { formula = "1000*(1 + x)", unit = "kg/m^3" }
specific_heat = { table = [[0, 400], [100, 500], [300, 900]], unit = "J/(kg K)", temperature = "degC" }
)toml"));
  const Properties p = properties(m, 323.15, 3);
  for (int i = 0; i < m.cloud().local(); ++i) {
    const Vec3& x = m.cloud().x[i];
    EXPECT_NEAR(p.k[i], 10 + x.x + 2 * x.y + 0.3 + 3.2315, 1e-12);
    EXPECT_NEAR(p.dk_dT[i], 0.01, 1e-9);
    EXPECT_NEAR(p.rho_c[i], 1000 * (1 + x.x) * 450, 1e-6);
  }
  EXPECT_TRUE(m.system().material().conductivity_depends_on_time());
  EXPECT_TRUE(m.system().material().capacity_depends_on_T());
}

TEST(Material, HoldsTheIntegralOfItsCapacity) {
  // From the mean of the start, 400 K: c = 300 + T/2.
  const CaseModel m(plate(simple_material({.k = "1", .rho = "10", .c = "300 + T/2"})));
  for (double T : {250., 400., 777.}) {
    const double expected = 10 * (300 * (T - 400) + (T * T - 400 * 400) / 4);
    for (double H : properties(m, T).H) EXPECT_NEAR(H, expected, 1e-9 * (1 + std::abs(expected)));
  }
}

TEST(Material, HoldsTheIntegralOfDensityTimesSpecificHeatWhateverEitherDependsOn) {
  using Law = double (*)(double x, double T);
  const std::vector<std::pair<const char*, Law>> densities = {
      {"10", [](double, double) { return 10.; }},
      {"10 + 2*x", [](double x, double) { return 10 + 2 * x; }},
      {"12 - 0.005*T", [](double, double T) { return 12 - 0.005 * T; }},
      {"12 - 0.005*T + x", [](double x, double T) { return 12 - 0.005 * T + x; }}};
  const std::vector<std::pair<const char*, Law>> heats = {
      {"300", [](double, double) { return 300.; }},
      {"300 + 50*x", [](double x, double) { return 300 + 50 * x; }},
      {"300 + T/2", [](double, double T) { return 300 + T / 2; }},
      {"300 + T/2 + 50*x", [](double x, double T) { return 300 + T / 2 + 50 * x; }}};
  for (const auto& [rho_text, rho] : densities)
    for (const auto& [c_text, c] : heats) {
      const CaseModel m(plate(simple_material({.k = "1", .rho = rho_text, .c = c_text})));
      for (const double T : {250., 400., 777.}) {
        const Properties p = properties(m, T);
        for (int i = 0; i < m.cloud().owned; ++i) {
          const double x = m.cloud().x[i].x;
          const auto rho_c = [&](double at) { return rho(x, at) * c(x, at); };
          // The rule of Simpson, exact for polynomials of the third degree.
          const double H = (T - 400) / 6 * (rho_c(400) + 4 * rho_c(0.5 * (400 + T)) + rho_c(T));
          EXPECT_NEAR(p.rho_c[i], rho_c(T), 1e-9 * rho_c(T)) << rho_text << ", " << c_text;
          EXPECT_NEAR(p.H[i], H, 1e-9 * (1 + std::abs(H))) << rho_text << ", " << c_text;
        }
      }
    }
}

TEST(Material, SeesAPeakFarFromTheTemperaturesOfTheStart) {
  // Steel that melts at 1700 K, in a body between 300 K and 1000 K: what it holds at 1800 K has the latent heat in it.
  const std::string text = plate(simple_material({.k = "1", .rho = "10", .c = "500 + 2e4*exp(-((T - 1700)/10)^2)"}));
  const std::string wide = replaced(text, "\"400 K\"", "{ formula = \"300 + 175*x\", unit = \"K\" }");
  for (const std::string& start : {text, wide}) {
    const CaseModel m(start);
    const double below = properties(m, 1600).H[0], peak = properties(m, 1700).rho_c[0],
                 above = properties(m, 1800).H[0];
    EXPECT_NEAR(peak / (10 * 20500), 1, 1e-4);
    EXPECT_NEAR((above - below) / (10 * (500 * 200 + 2e4 * 10 * std::sqrt(std::numbers::pi))), 1, 1e-5);
  }
}

const std::string phases = simple_material({.name = "a", .k = "30 - 0.01*T", .rho = "4000", .c = "1000"}) +
                           simple_material({.name = "b", .k = "2 + 0.005*T", .rho = "6000", .c = "500 + 0.1*T"});

TEST(Material, MixesByMass) {
  // rho = 1 / ((1-a)/rho1 + a/rho2), c = (1-a) c1 + a c2, k = (1-a) k1 + a k2 with the fraction as it is.
  const CaseModel m(plate(phases + R"toml(
[material.m]
mix = "voigt"
phases = ["a", "b"]
fraction = { formula = "x/4" }
basis = "mass"
)toml"));
  const double T = 500;
  const Properties p = properties(m, T);
  for (int i = 0; i < m.cloud().local(); ++i) {
    const double a = m.cloud().x[i].x / 4, rho = 1 / ((1 - a) / 4000 + a / 6000);
    EXPECT_NEAR(p.k[i], (1 - a) * (30 - 5) + a * (2 + 2.5), 1e-10);
    EXPECT_NEAR(p.dk_dT[i], (1 - a) * -0.01 + a * 0.005, 1e-8);
    EXPECT_NEAR(p.rho_c[i], rho * ((1 - a) * 1000 + a * 550), 1e-6);
  }
}

TEST(Material, MixesByVolume) {
  const CaseModel m(plate(phases + R"toml(
[material.m]
mix = "voigt"
phases = ["a", "b"]
fraction = { layers = [0, 0.25, 1], along = "x", thickness = ["1 m", "1 m", "2 m"] }
basis = "volume"
)toml"));
  const Properties p = properties(m, 500);
  for (int i = 0; i < m.cloud().local(); ++i) {
    const double a = std::vector{0., 0.125, 0.625, 1., 1.}[std::lround(m.cloud().x[i].x)];  // means at the interfaces
    EXPECT_NEAR(p.k[i], (1 - a) * 25 + a * 4.5, 1e-10);
    EXPECT_NEAR(p.rho_c[i], (1 - a) * 4000 * 1000 + a * 6000 * 550, 1e-6);
  }
  EXPECT_EQ(m.system().material().mean(), Mean::harmonic);  // the fraction jumps
}

TEST(Material, MixesBothBasesAlikeWhereTheDensitiesAreTheSame) {
  const std::string same = simple_material({.name = "a", .k = "30", .rho = "4000", .c = "1000"}) + R"toml(
[material.b]
library = "zirconia"
density = "4000 kg/m^3"
[material.m]
mix = "voigt"
phases = ["a", "b"]
fraction = 0.3
)toml";
  const CaseModel mass(plate(same + "basis = \"mass\"\n")), volume(plate(same + "basis = \"volume\"\n"));
  const Properties p = properties(mass, 500), q = properties(volume, 500);
  for (std::size_t i = 0; i < p.k.size(); ++i) {
    EXPECT_NEAR(p.rho_c[i], 4000 * (0.7 * 1000 + 0.3 * 600), 1e-6);
    EXPECT_NEAR(p.rho_c[i], q.rho_c[i], 1e-6);
    EXPECT_NEAR(p.k[i], 0.7 * 30 + 0.3 * 2.8, 1e-12);
  }
}

TEST(Material, StandsInLayers) {
  const CaseModel m(plate(phases + R"toml(
[body]
along = "x"
[[body.layer]]
material = "a"
thickness = "1.5 m"
[[body.layer]]
material = "b"
thickness = "1.5 m"
[[body.layer]]
material = "a"
thickness = "1 m"
)toml"));
  const Properties p = properties(m, 500);
  for (int i = 0; i < m.cloud().local(); ++i) {
    const double share_of_b =
        std::vector{0., 0., 1., 0.5, 0.}[std::lround(m.cloud().x[i].x)];  // x = 3 m: the interface
    EXPECT_NEAR(p.k[i], (1 - share_of_b) * 25 + share_of_b * 4.5, 1e-10);
    EXPECT_NEAR(p.rho_c[i], (1 - share_of_b) * 4e6 + share_of_b * 6000 * 550, 1e-6);
  }
  EXPECT_EQ(m.system().material().mean(), Mean::arithmetic);  // inside the layers
}

TEST(Material, StandsInRegions) {
  const CaseModel m(plate(phases + R"toml(
[material.c]
library = "copper"
[body]
material = "a"
[[body.region]]
material = "b"
where = "x > 1500"
length = "mm"
[[body.region]]
material = "c"
where = "x > 2.5 && y > 1.5"
)toml"));
  const Properties p = properties(m, 500);
  for (int i = 0; i < m.cloud().local(); ++i) {
    const Vec3& x = m.cloud().x[i];
    EXPECT_NEAR(p.k[i], x.x > 2.5 && x.y > 1.5 ? 401 : x.x > 1.5 ? 4.5 : 25, 1e-10);
  }
}

TEST(Material, StandsWhereTheTagsOfACloudSay) {
  std::ostringstream rows;
  rows << "x [m],y [m],volume [m^3],tag,area_x [m^2],area_y [m^2]\n";
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      const double width = a % 3 ? 1 : 0.5, height = b % 3 ? 1 : 0.5;
      const double area_x = a == 0 ? -height : a == 3 ? height : 0, area_y = b == 0 ? -width : b == 3 ? width : 0;
      rows << a << "," << b << "," << width * height << "," << (a > 1 ? "core" : "shell") << "," << area_x << ","
           << area_y << "\n";
    }
  const TemporaryFolder folder;
  const std::string cloud = fmt::format(
      "title = \"test\"\nmethod = \"sph\"\n[cloud]\nshape = \"csv\"\nfile = \"{}\"\n[initial]\ntemperature = \"400 "
      "K\"\n[time]\nend = "
      "\"1 s\"\n",
      folder.write("tags.csv", rows.str()));
  const std::string body = "[body]\nmaterial = \"a\"\n[[body.region]]\nmaterial = \"b\"\ntag = \"{}\"\n";
  const CaseModel m(cloud + phases + fmt::format(fmt::runtime(body), "core"));
  const Properties p = properties(m, 500);
  for (int i = 0; i < m.cloud().local(); ++i) EXPECT_NEAR(p.k[i], m.cloud().x[i].x > 1 ? 4.5 : 25, 1e-10);
  expect_refused(cloud + phases + fmt::format(fmt::runtime(body), "cor"), {"no point has the tag 'cor'", "core"});
}

TEST(Material, ChoosesTheMeanThatFits) {
  const auto mean = [](const std::string& text) { return CaseModel(plate(text)).system().material().mean(); };
  const auto simple = [](const std::string& k) {
    return "[material.m]\ndensity = \"1 kg/m^3\"\nspecific_heat = \"1 J/(kg K)\"\nconductivity = " + k + "\n";
  };
  EXPECT_EQ(mean(simple("{ formula = \"1 + T\", unit = \"W/(m K)\" }")), Mean::integral);
  EXPECT_EQ(mean(simple("\"1 W/(m K)\"")), Mean::integral);
  EXPECT_EQ(mean(simple("{ formula = \"1 + x + T\", unit = \"W/(m K)\" }")), Mean::arithmetic);
  EXPECT_EQ(mean(simple("{ layers = [1, 2], along = \"x\", thickness = \"2 m\", unit = \"W/(m K)\" }")),
            Mean::harmonic);
  EXPECT_EQ(
      mean(simple("{ formula = \"1 + T\", unit = \"W/(m K)\" }") + "[body]\nconductivity_mean = \"arithmetic\"\n"),
      Mean::arithmetic);
  EXPECT_EQ(mean(phases + "[material.m]\nmix = \"voigt\"\nphases = [\"a\", \"b\"]\nfraction = 0.3\nbasis = \"mass\"\n"),
            Mean::integral);
  expect_refused(
      plate(simple("{ formula = \"1 + x\", unit = \"W/(m K)\" }") + "[body]\nconductivity_mean = \"integral\"\n"),
      {"test.toml:16:21", "depends on temperature alone", "arithmetic"});
}

TEST(Material, TakesThreeThetaDerivativesAsOne) {
  // d theta / dT = k, for a formula, a table and a mixture.
  for (const std::string& material :
       {simple_material({.k = "5.85 + 26524.4*exp(-0.002*T)/(242.85 + T)", .rho = "1", .c = "1"}), std::string(R"toml(
[material.m]
conductivity = { table = [[200, 5], [500, 9], [900, 4]], unit = "W/(m K)" }
density = "1 kg/m^3"
specific_heat = "1 J/(kg K)"
)toml"),
        phases + R"toml(
[material.m]
mix = "voigt"
phases = ["a", "b"]
fraction = 0.4
basis = "volume"
)toml"}) {
    const CaseModel m(plate(material));
    const int n = m.cloud().local();
    for (double T : {301., 460., 777.}) {
      std::vector<double> low(n), high(n);
      m.system().material().theta(std::vector<double>(n, T - 0.5), low);
      m.system().material().theta(std::vector<double>(n, T + 0.5), high);
      // The integral over 1 K is the mean of k there.
      const double k = (properties(m, T - 0.5).k[0] + 4 * properties(m, T).k[0] + properties(m, T + 0.5).k[0]) / 6;
      EXPECT_NEAR(high[0] - low[0], k, 1e-8);
    }
  }
}

// ---- what is refused ------------------------------------------------------------------------------------------------

std::string with_conductivity(const std::string& k) {
  return plate("[material.m]\nconductivity = " + k + "\ndensity = \"1 kg/m^3\"\nspecific_heat = \"1 J/(kg K)\"\n");
}

TEST(Material, RefusesPropertiesThatAreNotPositive) {
  expect_refused(with_conductivity("\"0 W/(m K)\""), {"test.toml:12:16", "conductivity of 'm'", "is 0 W/(m K)"});
  expect_refused(with_conductivity("\"-1 W/(m K)\""), {"test.toml:12:16", "-1"});
  expect_refused(with_conductivity("{ formula = \"3 - x\", unit = \"W/(m K)\" }"),
                 {"test.toml:12:28", "conductivity of 'm' is 0 W/(m K) at (3, 0, 0) m", "positive everywhere"});
  expect_refused(plate(simple_material({.k = "1", .rho = "0", .c = "1"})),
                 {"test.toml:13:11", "density of 'm' is 0 kg/m^3"});
  expect_refused(plate(simple_material({.k = "1", .rho = "1", .c = "-y"})),
                 {"test.toml:14:29", "specific heat of 'm'"});
  expect_refused(with_conductivity("{ formula = \"1/(x - 1)\", unit = \"W/(m K)\" }"),
                 {"test.toml:12:28", "(1, 0, 0)"});
}

TEST(Material, StopsWhereAPropertyTurnsNonPositive) {
  // With the point, and the temperature it has there.
  for (const std::string k : {"5 - 0.01*T", "(5 - 0.01*T)*(1 + x)"}) {
    const CaseModel m(plate(simple_material({.k = k, .rho = "1", .c = "1"})));
    std::vector<double> T = m.uniform(400);
    m.rates(0, T);
    const int hot = 4;
    T[hot] = 501;
    const Vec3& x = m.cloud().x[hot];
    expect_error([&] { m.rates(0.25, T); },
                 {"conductivity of 'm' is -0.0", "T = 501 K", fmt::format("({:.6g}, {:.6g}, 0) m", x.x, x.y)},
                 Fault::numbers);
  }
}

TEST(Material, StopsWhereAPropertyIsNotANumber) {
  const CaseModel m(plate(simple_material({.k = "sqrt(450 - T)*(1 + x)", .rho = "1", .c = "1"})));
  std::vector<double> T = m.uniform(400);
  m.rates(0, T);
  T[7] = 460;
  const Vec3& x = m.cloud().x[7];
  expect_words(error_of([&] { m.rates(0, T); }).what(),
               {"test.toml:12:28", "T = 460 K", fmt::format("({:.6g}, {:.6g}, 0) m", x.x, x.y)});
}

TEST(Material, StopsWhereTheHeatCapacityTurnsNonPositive) {
  const CaseModel m(plate(simple_material({.k = "1", .rho = "1", .c = "600 - T"})));
  std::vector<double> T = m.uniform(400), C(m.cloud().owned);
  T[3] = 650;
  expect_error([&] { m.system().capacity(T, C); }, {"heat capacity of 'm' is -50", "T = 650 K"}, Fault::numbers);
  // Nor is there a temperature for every enthalpy: at most 200^2 / 2 J/m^3 above 400 K.
  std::vector<double> E(m.cloud().owned, 0);
  E[2] = 3e4;
  T = m.uniform(400);
  expect_error([&] { m.system().temperature(E, T); }, {"no temperature holds the enthalpy"}, Fault::numbers);
}

TEST(Material, RefusesSeveralConductivitiesAndNamesTheKeyForDirections) {
  for (const std::string k :
       {"[\"1 W/(m K)\", \"2 W/(m K)\"]", "[1, 2, 3]", "[[1, 0], [0, 2]]", "{ x = \"1 W/(m K)\", y = \"2 W/(m K)\" }",
        "{ formula = [\"1 + T\", \"2\"], unit = \"W/(m K)\" }",
        "{ xx = { formula = \"1\", unit = \"W/(m K)\" }, yy = \"2 W/(m K)\" }"})
    expect_refused(with_conductivity(k), {"test.toml:12:", "same in all directions", "`anisotropy`"});
}

TEST(Material, RefusesWhatDoesNotFitTogether) {
  const std::string mixture = "[material.m]\nmix = \"voigt\"\nphases = [\"a\", \"b\"]\nbasis = \"mass\"\n";
  expect_refused(plate(phases + mixture + "fraction = 1.5\n"), {"fraction in 'm' is 1.5", "between 0 and 1"});
  expect_refused(plate(phases + mixture + "fraction = { formula = \"x\" }\n"), {"fraction in 'm'", "between 0 and 1"});
  expect_refused(plate(phases + mixture + "fraction = { formula = \"t\" }\n"), {"depends on time"});
  expect_refused(plate(phases + mixture), {"fraction"});
  expect_refused(plate(phases + mixture + "fraction = 0.5\nconductivity = \"1 W/(m K)\"\n"), {"is a mixture"});
  expect_refused(plate("[material.m]\nmix = \"voigt\"\nphases = [\"m\", \"copper\"]\nfraction = 0.5\nbasis = "
                       "\"mass\"\n[body]\nmaterial "
                       "= \"m\"\n"),
                 {"'m' is a phase of itself"});
  expect_refused(plate(phases), {"which of a, b the body is made of"});
  expect_refused(plate(phases + "[body]\nmaterial = \"c\"\n"), {"there is no material 'c'"});
  expect_refused(plate("[material.m]\nlibrary = \"coper\"\n"), {"did you mean \"copper\"?"});
  expect_refused(plate("[material.m]\nconductivity = \"1 W/(m K)\"\ndensity = \"1 kg/m^3\"\n"),
                 {"has no specific_heat, which a case with [time] needs"});
  expect_refused(plate("[material.m]\nconductivity = \"1 W/(m K)\"\nspecific_heat = \"1 J/(kg K)\"\ndensity = { "
                       "formula = \"1 + t\", unit = \"kg/m^3\" }\n"),
                 {"density of 'm' depends on time"});
}

TEST(Material, RefusesLayersThatDoNotFillTheBody) {
  const auto layers = [](const std::string& axis, const std::string& thickness) {
    return plate(phases + "[body]\nalong = \"" + axis + "\"\n[[body.layer]]\nmaterial = \"a\"\nthickness = \"" +
                 thickness + "\"\n[[body.layer]]\nmaterial = \"b\"\nthickness = \"1 m\"\n");
  };
  CaseModel good(layers("x", "3 m"));
  expect_refused(layers("x", "2 m"), {"the layers are 3 m thick together", "0 m to 4 m"});
  expect_refused(layers("x", "4 m"), {"the layers are 5 m thick together"});
  expect_refused(layers("z", "3 m"), {"no axis z"});
  expect_refused(layers("x", "-3 m"), {"thickness is -3 m"});
}

// ---- segments
// ---------------------------------------------------------------------------------------------------------

TEST(Inversion, FindsTheRootOfAnyIncreasingFunction) {
  EXPECT_TRUE(rc::check("H(T) = H is solved to round-off for piecewise slopes over six decades", [] {
    const double low = std::pow(10, *rc::gen::inRange(-3, 4)), high = std::pow(10, *rc::gen::inRange(-3, 4));
    const double knee = *rc::gen::inRange(1, 2000), width = std::pow(10, *rc::gen::inRange(-1, 3));
    // Slope from `low` to `high` around the knee: H = low T + (high - low) width log(1 + exp((T - knee)/width)).
    const Increasing f = [&](std::span<const double> T, std::span<double> H, std::span<double> slope) {
      for (std::size_t i = 0; i < T.size(); ++i) {
        const double s = (T[i] - knee) / width;
        const double soft = s > 30 ? s : std::log1p(std::exp(s)), step = 1 / (1 + std::exp(-s));
        H[i] = low * T[i] + (high - low) * width * soft;
        slope[i] = low + (high - low) * step;
      }
    };
    std::vector<double> wanted, guess;
    for (int n = 0; n < 20; ++n) {
      wanted.push_back(1000 + 999 * scattered(*rc::gen::inRange(0, 10000)));
      guess.push_back(1000 + 999 * scattered(*rc::gen::inRange(0, 10000)));
    }
    std::vector<double> H(wanted.size()), slope(wanted.size());
    f(wanted, H, slope);
    RC_ASSERT(invert_increasing(f, H, guess) == -1);
    for (std::size_t i = 0; i < H.size(); ++i) {
      const double conditioning =
          4 * std::numeric_limits<double>::epsilon() * (std::abs(H[i]) + 2000 * (low + high)) / slope[i];
      RC_ASSERT(std::abs(guess[i] - wanted[i]) <= 1e-12 * wanted[i] + conditioning);
    }
  }));
}

TEST(MaterialParallel, RefusesOnAllRanksWhatIsWrongOnOne) {
  const CaseModel m(plate(simple_material({.k = "5 - 0.01*T", .rho = "1", .c = "1"})), MPI_COMM_WORLD);
  std::vector<double> T = m.uniform(400);
  for (int i = 0; i < m.cloud().local(); ++i)
    if (m.cloud().id[i] == 14) T[i] = 600;
  expect_words(error_of([&] { m.rates(0, T); }).what(), {"(4, 2, 0) m, T = 600 K"});
}

}  // namespace
}  // namespace calor
