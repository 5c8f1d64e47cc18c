// Graded materials from case files: fractions, pores, properties, what is refused, and expectations on properties.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "app/model.hpp"
#include "app/schema.hpp"
#include "case/case.hpp"
#include "errors.hpp"
#include "material/mixing_rules.hpp"
#include "output/expect.hpp"

namespace calor {
namespace {

const std::string bar = R"toml(title  = "graded bar"
method = "sph"
[cloud]
shape  = "box"
size   = "10 mm"
points = 11
[initial]
temperature = "300 K"
[boundary.ends]
on          = ["xmin", "xmax"]
temperature = "300 K"
[steady]
[material.metal]
conductivity  = { formula = "7.5 + 0.01*(T - 300)", unit = "W/(m K)" }
density       = "4420 kg/m^3"
specific_heat = { formula = "537 + 0.2*(T - 300)", unit = "J/(kg K)" }
[material.ceramic]
conductivity  = "2.09 W/(m K)"
density       = "5331 kg/m^3"
specific_heat = "456.7 J/(kg K)"
[material.pore]
conductivity  = { formula = "0.02625*T/300", unit = "W/(m K)" }
density       = "1.204 kg/m^3"
specific_heat = "1.005 J/(kg K)"
)toml";

std::string plate(const std::string& rule, const std::string& fraction, const std::string& pores = "") {
  return bar + "[material.plate]\nmix = \"" + rule +
         "\"\nphases = [\"metal\", \"ceramic\"]\nbasis = \"volume\"\nfraction = " + fraction + "\n" +
         (pores.empty() ? "" : "pores = { material = \"pore\", " + pores + " }\n") + "[body]\nmaterial = \"plate\"\n";
}

/// A case up to its heat system.
struct Built {
  explicit Built(const std::string& text) : description(Case::parse(text, "test.toml", schema())) {
    Phases phases;
    model.emplace(build_model(description, MPI_COMM_SELF, phases));
  }
  const MaterialField& material() const { return model->system->material(); }
  std::size_t points() const { return model->cloud->x.size(); }

  std::vector<double> conductivity(double T) const {
    std::vector<double> k(points());
    material().conductivity(0, std::vector<double>(points(), T), k, {});
    return k;
  }
  std::vector<double> heat_capacity(double T) const {
    std::vector<double> c(points());
    material().enthalpy(std::vector<double>(points(), T), {}, c);
    return c;
  }
  std::vector<double> fraction(const std::string& ingredient) const {
    std::vector<double> v(points());
    material().volume_fraction(ingredient, v);
    return v;
  }
  double x(std::size_t i) const { return model->cloud->x[i].x; }

  Case description;
  std::optional<Model> model;
};

void expect_refused(const std::string& text, const std::vector<std::string>& words) {
  expect_error([&] { Built{text}; }, words);
}

const std::string linear = R"toml({ power = 1, along = "x", from = "0 mm", to = "10 mm" })toml";
const std::string parabola =
    R"toml(porosity = { hump = [1, 1], factor = 3, along = "x", from = "0 mm", to = "10 mm" })toml";

TEST(GradedMaterial, SharesTheVolumeBetweenPhasesAndPores) {
  const Built b(plate("voigt", linear, parabola));
  EXPECT_EQ(b.material().ingredients(), (std::vector<std::string>{"metal", "ceramic", "pore"}));
  const auto metal = b.fraction("metal"), ceramic = b.fraction("ceramic"), pore = b.fraction("pore");
  for (std::size_t i = 0; i < b.points(); ++i) {
    const double eta = b.x(i) / 0.01, P = 3 * eta * (1 - eta);
    EXPECT_NEAR(pore[i], P, 1e-15);
    EXPECT_NEAR(metal[i], (1 - P) * (1 - eta), 1e-15);
    EXPECT_NEAR(ceramic[i], (1 - P) * eta, 1e-15);
  }
}

TEST(GradedMaterial, HoldsTheHeatOfItsPartsByVolume) {
  const Built b(plate("kerner", linear, parabola));
  const auto c = b.heat_capacity(350);
  for (std::size_t i = 0; i < b.points(); ++i) {
    const double eta = b.x(i) / 0.01, P = 3 * eta * (1 - eta);
    const double expected = (1 - P) * ((1 - eta) * 4420 * (537 + 0.2 * 50) + eta * 5331 * 456.7) + P * 1.204 * 1.005;
    EXPECT_NEAR(c[i], expected, 1e-8 * expected);
  }
}

TEST(GradedMaterial, TakesPoresOneAfterTheOtherOrAllAtOnce) {
  // Mid-height, T = 300 K, P = 1/4; plain arithmetic of Maxwell's formula: 4.42536 W/(m K) for the solid alone.
  const std::string quarter = "porosity = 0.25";
  EXPECT_NEAR(Built(plate("kerner", "0.5")).conductivity(300)[5], 4.4253599, 1e-6);
  EXPECT_NEAR(Built(plate("kerner", "0.5", quarter)).conductivity(300)[5], 2.9618836, 1e-6);
  EXPECT_NEAR(Built(plate("kerner", "0.5", quarter + ", as = \"third\"")).conductivity(300)[5], 3.10057, 5e-6);
}

TEST(GradedMaterial, TakesPoresByAFactorAsTheyAreGiven) {
  // 1 - 1.5 P of the solid's 4.42536 W/(m K) at P = 1/4; the heat of the pores is that of their volume.
  const std::string functions = "[function.P]\nformula = \"0.25\"\n";
  const std::string pores = R"(porosity = { formula = "P" }, factor = { formula = "1 - 1.5*P" })";
  const Built b(plate("kerner", "0.5", pores) + functions), other(plate("kerner", "0.5", "porosity = 0.25"));
  EXPECT_NEAR(b.conductivity(300)[5], 0.625 * 4.4253599, 1e-6);
  EXPECT_EQ(b.heat_capacity(350), other.heat_capacity(350));
}

TEST(GradedMaterial, OfEveryRuleHasTheDerivativeOfItsConductivity) {
  // All three phases or two of them depend on temperature; against central differences of fourth order.
  for (const MixingRule& rule : mixing_rules())
    for (const char* as : {"\"sequential\"", "\"third\"", "\"factor\", factor = 0.7"}) {
      const Built b(plate(rule.name, linear, parabola + ", as = " + as));
      std::vector<double> k(b.points()), dk(b.points());
      b.material().conductivity(0, std::vector<double>(b.points(), 400), k, dk);
      const auto up = b.conductivity(401), down = b.conductivity(399), up2 = b.conductivity(402),
                 down2 = b.conductivity(398);
      for (std::size_t i = 0; i < b.points(); ++i) {
        const double difference = (8 * (up[i] - down[i]) - (up2[i] - down2[i])) / 12;
        EXPECT_NEAR(dk[i], difference, 1e-9) << rule.name << ", " << as << ", point " << i;
        EXPECT_GT(k[i], 0);
      }
    }
}

TEST(GradedMaterial, WithoutPoresIsThatOfPorosityZero) {
  for (const MixingRule& rule : mixing_rules()) {
    const Built solid(plate(rule.name, linear)), empty(plate(rule.name, linear, "porosity = 0"));
    const auto a = solid.conductivity(350), b = empty.conductivity(350);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-13 * a[i]) << rule.name;
  }
}

TEST(GradedMaterial, OfOneCompositionHasTheIntegralOfItsConductivity) {
  // d theta / dT = k for every rule, pores included.
  for (const MixingRule& rule : mixing_rules()) {
    const Built b(plate(rule.name, "0.3", "porosity = 0.1"));
    ASSERT_EQ(b.material().mean(), Mean::integral);
    const auto theta = [&](double T) {
      std::vector<double> out(b.points());
      b.material().theta(std::vector<double>(b.points(), T), out);
      return out[0];
    };
    const double slope = (8 * (theta(351) - theta(349)) - (theta(352) - theta(348))) / 12;
    EXPECT_NEAR(slope, b.conductivity(350)[0], 1e-8) << rule.name;
  }
}

TEST(GradedMaterial, SaysWhatALayeredBodyIsMadeOf) {
  const Built b(bar + R"toml([body]
along = "x"
layer = [{ material = "metal", thickness = "5 mm" }, { material = "ceramic", thickness = "5 mm" }]
)toml");
  const auto metal = b.fraction("metal");
  EXPECT_EQ(metal[0], 1);
  EXPECT_EQ(metal[5], 0.5);  // the interface
  EXPECT_EQ(metal[10], 0);
}

TEST(GradedMaterial, ByMassKnowsItsVolumes) {
  // Half the mass: v = (1/rho2) / (1/rho1 + 1/rho2) of the volume.
  std::string text = plate("voigt", "0.5");
  text.replace(text.find("\"volume\""), 8, "\"mass\"");
  EXPECT_NEAR(Built(text).fraction("ceramic")[3], 4420. / (4420 + 5331), 1e-15);
}

TEST(GradedMaterial, IsRefusedWithTheValueAndThePlace) {
  expect_refused(plate("kerner", "1.5"), {"test.toml:29:12", "the fraction in 'plate' is 1.5"});
  expect_refused(plate("kerner", "{ formula = \"150*x\" }"), {"is 1.05 at (0.007, 0, 0) m", "between 0 and 1"});
  expect_refused(plate("kerner", "-0.1"), {"is -0.1"});
  expect_refused(plate("kerner", "0.5", "porosity = 1"),
                 {"test.toml:30:41", "the porosity of 'plate' is 1", "below 1"});
  expect_refused(plate("kerner", "0.5", "porosity = -0.5"), {"the porosity of 'plate' is -0.5"});
  expect_refused(plate("kerner", "0.5",
                       R"toml(porosity = { hump = [1, 1], factor = 4, along = "x", from = "0 mm", to = "10 mm" })toml"),
                 {"the porosity of 'plate' is 1 at (0.005, 0, 0) m"});
  expect_refused(plate("kerner", "0.5", "porosity = { formula = \"T\" }"),
                 {"porosity of 'plate' depends on temperature"});
  expect_refused(plate("kerner", "0.5", "porosity = 0.1, as = \"fourth\""), {"'as' cannot be \"fourth\""});
  expect_refused(plate("kerner", "0.5", "porosity = 0.1, as = \"factor\""), {"needs 'factor'"});
  expect_refused(plate("kerner", "0.5", "porosity = 0.1, as = \"third\", factor = 0.5"),
                 {"'factor' goes with as = \"factor\""});
  expect_refused(plate("kerner", "0.5", "porosity = 0.1, as = \"factor\", factor = 1.2"),
                 {"the factor of the pores of 'plate' is 1.2"});
  std::string by_mass = plate("kerner", "0.5");
  by_mass.replace(by_mass.find("\"volume\""), 8, "\"mass\"");
  expect_refused(by_mass, {"the rule 'kerner' takes fractions of the volume"});
  expect_refused(bar + "[material.m]\nconductivity = \"1 W/(m K)\"\npores = { material = \"pore\", porosity = 0.1 }\n",
                 {"'pores' goes with 'mix'"});
  expect_refused(plate("kernel", "0.5"), {"did you mean \"kerner\"?"});
}

TEST(GradedMaterial, TakesWhatRoundingPutsBeyondAnEnd) {
  EXPECT_EQ(Built(plate("kerner", "{ formula = \"1 + 1e-14\" }")).fraction("ceramic")[0], 1);
  EXPECT_EQ(Built(plate("kerner", "{ formula = \"-1e-14\" }")).fraction("ceramic")[0], 0);
}

// Laws as a case writes them

double fraction_at(const std::string& law, std::size_t point) {
  return Built(plate("voigt", law)).fraction("ceramic")[point];
}

TEST(Law, IsAPowerAnExponentialAHumpOrATable) {
  EXPECT_NEAR(fraction_at(R"toml({ power = 2, along = "x", from = "0 mm", to = "10 mm" })toml", 5), 0.25, 1e-15);
  EXPECT_NEAR(fraction_at(R"toml({ power = 2, along = "x", from = "10 mm", to = "0 mm", values = [1, 0] })toml", 4),
              1 - 0.36, 1e-15);
  EXPECT_NEAR(
      fraction_at(R"toml({ exponential = 1.5, along = "r", from = "0 mm", to = "10 mm", values = [0.2, 0.4] })toml", 5),
      0.2 + 0.2 * std::expm1(0.75) / std::expm1(1.5), 1e-15);
  EXPECT_NEAR(fraction_at(R"toml({ hump = [2, 1], factor = 0.5, along = "x", from = "0 mm", to = "10 mm" })toml", 5),
              0.5 * 0.125, 1e-15);
  EXPECT_NEAR(fraction_at(R"toml({ table = [[0, 0.1], [4, 0.3], [10, 0.9]], along = "x", length = "mm" })toml", 7), 0.6,
              1e-14);
}

TEST(Law, OfAPropertyHasValuesWithUnits) {
  const auto conductivity = [](const std::string& law) {
    return Built(bar + "[material.m]\nconductivity = " + law + "\n[body]\nmaterial = \"m\"\n").conductivity(300)[5];
  };
  const std::string place = R"toml(along = "x", from = "0 mm", to = "10 mm")toml";
  const std::string units = R"toml(values = ["1 W/(m K)", "0.02 W/(cm K)"])toml", unit = R"toml(unit = "W/(cm K)")toml";
  EXPECT_NEAR(conductivity("{ exponential = 0, " + place + ", " + units + " }"), 1.5, 1e-14);
  EXPECT_NEAR(conductivity("{ power = 1, " + place + ", values = [1, 2], " + unit + " }"), 150, 1e-12);
}

TEST(Law, IsRefusedWhereItsNumbersMakeNoSense) {
  const std::string place = R"toml(along = "x", from = "0 mm", to = "10 mm")toml";
  const auto refused = [&](const std::string& law, const std::vector<std::string>& words) {
    expect_refused(plate("voigt", law), words);
  };
  refused("{ power = 0, " + place + " }", {"test.toml:29:22", "the power is 0", "above 0"});
  refused("{ power = \"a\", " + place + " }", {"'power' cannot be the text"});
  refused("{ power = 1, along = \"x\", from = \"1 mm\", to = \"1 mm\" }", {"the same place"});
  refused("{ power = 1, along = \"x\", from = \"1 mm\" }", {"needs 'to'"});
  refused("{ power = 1, along = \"t\", from = \"0 mm\", to = \"1 mm\" }", {"'along' cannot be \"t\""});
  refused("{ power = 1, " + place + ", values = [1] }", {"takes two numbers"});
  refused("{ power = 1, " + place + ", factor = 2 }", {"'factor' is not a key of fraction = { power = ... }"});
  refused("{ hump = [1, -1], factor = 1, " + place + " }", {"a power of the hump is negative"});
  refused("{ hump = 1, factor = 1, " + place + " }", {"takes two numbers"});
  refused("{ hump = [1, 1], " + place + " }", {"needs 'factor'"});
  refused("{ table = [[0, 0], [1, 1]], along = \"x\", of = \"time\" }", {"'of' and 'along'"});
  refused("{ table = [[1, 0], [0, 1]], along = \"x\" }", {"sort the rows by x"});
  expect_refused(bar + "[material.m]\nconductivity = { power = 1, " + place + " }\n[body]\nmaterial = \"m\"\n",
                 {"needs 'values'", "W/(m K)"});
}

TEST(Law, LetsAVariantChangeOneOfItsNumbers) {
  const std::string text = plate("voigt", linear) + R"toml(
[[variant]]
name = "steep"
set  = { material.plate.fraction.power = 3 }
[[variant]]
name = "formula"
set  = { material.plate.fraction = { formula = "0.25" } }
)toml";
  const auto fraction = [&](const std::string& variant) {
    return Case::parse(text, "test.toml", schema(), {"variant=" + variant})
        .section("material")
        .sub("plate")
        .function("fraction");
  };
  EXPECT_NEAR(fraction("steep")({.x = 0.005}), 0.125, 1e-15);
  EXPECT_EQ(fraction("formula")({.x = 0.005}), 0.25);
}

// Expectations on properties

Verdict verdict(const std::string& expect) {
  const Built b(plate("voigt", linear, "porosity = 0.5") + "[[expect]]\n" + expect);
  const Probes probes(b.description, *b.model->cloud);
  Expectations expectations(b.description, {*b.model->cloud, b.material(), probes}, "");
  expectations.observe({}, true, std::vector<double>(b.points(), 300));
  return expectations.verdicts({}, {}).at(0);
}

TEST(Expectations, CompareProperties) {
  const Verdict k = verdict(
      "quantity = \"conductivity\"\nfield = true\nwithin = \"1e-12 W/(m K)\"\nvalue = { formula = "
      "\"0.5*(7.5*(1 - 100*x) + 2.09*100*x) + 0.5*0.02625\", unit = \"W/(m K)\" }\n");
  EXPECT_TRUE(k.passed) << k.error;
  EXPECT_EQ(k.unit, "W/(m K)");
  const Verdict c = verdict(
      "quantity = \"volumetric_heat_capacity\"\nwhere = \"x < 1e-9\"\nwithin = \"1 kJ/(m^3 K)\"\n"
      "value = \"1.18577 MJ/(m^3 K)\"\n");  // (4420 537 + 1.204 1.005)/2 = 1186770.6
  EXPECT_NEAR(c.error, 1000.6, 0.05);
  EXPECT_FALSE(c.passed);
  const Verdict v =
      verdict("quantity = \"volume_fraction\"\nmaterial = \"pore\"\nfield = true\nvalue = 0.5\nwithin = 1e-15\n");
  EXPECT_TRUE(v.passed) << v.error;
  EXPECT_EQ(v.unit, "");
}

TEST(Expectations, OfPropertiesAreRefusedWhereTheyMeanNothing) {
  const auto refused = [](const std::string& expect, const std::vector<std::string>& words) {
    expect_words(error_of([&] { verdict(expect); }).what(), words);
  };
  const std::string fraction = "quantity = \"volume_fraction\"\nfield = true\nvalue = 0.5\n";
  refused(fraction + "within = 1\n", {"needs 'material'"});
  refused(fraction + "within = 1\nmaterial = \"gold\"\n",
          {"'gold' is not mixed into the body", "metal, ceramic, pore"});
  refused(fraction + "within = \"1 K\"\nmaterial = \"pore\"\n", {"no difference of volume fractions"});
  refused("quantity = \"conductivity\"\nfield = true\nvalue = \"300 K\"\nwithin = \"1 %\"\n", {"'value' = \"300 K\""});
  refused("field = true\nmaterial = \"pore\"\nvalue = \"300 K\"\nwithin = \"1 %\"\n",
          {"'material' goes with quantity = \"volume_fraction\""});
}

}  // namespace
}  // namespace calor
