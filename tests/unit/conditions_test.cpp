#include "boundary/conditions.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "case_models.hpp"
#include "plate.hpp"

namespace calor {
namespace {

/// Flux and derivative at one temperature and time, the same everywhere.
std::pair<double, double> flux(const SurfaceTerm& term, double T, double t = 0) {
  const std::vector<double> at(term.x.size(), T);
  std::vector<double> q(at.size()), slope(at.size());
  term.flux->evaluate({.x = term.x, .t = t, .T = at}, q, slope);
  return {q.at(0), slope.at(0)};
}

TEST(Conditions, HoldOnTheFacesThatTheyName) {
  const Bound b(plate(R"toml(
[boundary.xmin]
flux = "1 W/m^2"
[boundary.mantle]
on = ["ymin", "ymax"]
flux = "2 W/m^2"
)toml"));
  ASSERT_EQ(b.conditions.fluxes.size(), 2u);
  EXPECT_EQ(b.conditions.accounts, (std::vector<std::string>{"xmin", "mantle"}));
  const SurfaceTerm &left = b.conditions.fluxes[0], &mantle = b.conditions.fluxes[1];
  EXPECT_EQ(left.name, "xmin.flux");
  EXPECT_EQ(left.point.size(), 3u);
  EXPECT_NEAR(total_area(left), 2 * 0.1, 1e-14);
  for (const Vec3& x : left.x) EXPECT_EQ(x.x, 0);
  EXPECT_EQ(mantle.point.size(), 10u);
  EXPECT_NEAR(total_area(mantle), 2 * 4 * 0.1, 1e-14);
  for (const Vec3& x : mantle.x) EXPECT_TRUE(x.y == 0 || x.y == 2);
}

TEST(Conditions, HoldWhereTheirFormulaIsTrue) {
  const Bound b(plate(R"toml(
[boundary.part]
on = "ymax"
where = "x > 1500"
length = "mm"
flux = "1 W/m^2"
[boundary.anywhere]
where = "x < 0.5"
flux = "1 W/m^2"
)toml"));
  const SurfaceTerm &part = b.conditions.fluxes[0], &anywhere = b.conditions.fluxes[1];
  EXPECT_EQ(part.point.size(), 3u);
  EXPECT_NEAR(total_area(part), (1 + 1 + 0.5) * 0.1, 1e-14);
  // The whole surface at x = 0: the face, and half a cell of those beside it.
  EXPECT_NEAR(total_area(anywhere), (2 + 2 * 0.5) * 0.1, 1e-14);
}

TEST(Conditions, PrescribeAtPointsOfAFaceAndOfAPartOfIt) {
  const Bound b(plate(R"toml(
[boundary.xmin]
temperature = { formula = "300 + 10*y + t", unit = "K" }
[boundary.pose]
on = "ymax"
where = "abs(x - 3) < 0.1"
temperature = "500 K"
)toml"));
  ASSERT_EQ(b.conditions.temperatures.size(), 2u);
  EXPECT_EQ(b.conditions.temperatures[0].point.size(), 3u);
  EXPECT_TRUE(std::ranges::is_sorted(b.conditions.temperatures[0].point));
  EXPECT_EQ(b.conditions.temperatures[0].share, std::vector<double>(3, 1.0));
  ASSERT_EQ(b.conditions.temperatures[1].x.size(), 1u);
  EXPECT_EQ(b.conditions.temperatures[1].x[0].x, 3);
  EXPECT_EQ(b.conditions.temperatures[1].x[0].y, 2);
  EXPECT_TRUE(b.conditions.notes.empty());
}

TEST(Conditions, LeaveWallsInsulatedWhereNothingIsSaid) {
  const CaseModel silent(plate("")), said(plate("[boundary.xmin]\ninsulated = true\n"));
  for (const CaseModel* m : {&silent, &said}) {
    const auto [F, power] = m->rates(0, m->uniform(512));
    for (double f : F) EXPECT_EQ(f, 0);
    for (double p : power) EXPECT_EQ(p, 0);
  }
}

TEST(Conditions, AddUpOnOneFace) {
  // A flux, convection and radiation in one section, and another flux on the same face.
  const std::string three = R"toml(
[boundary.xmax]
flux = "100 W/m^2"
convection = { h = "10 W/(m^2 K)", ambient = "300 K" }
radiation = { emissivity = 0.5, ambient = "300 K" }
[boundary.lamp]
on = "xmax"
flux = "30 W/m^2"
)toml";
  const CaseModel m(plate(three));
  const auto [F, power] = m.rates(0, m.uniform(450));
  const double area = 2 * 0.1;
  const double q = 100 + 10 * (300. - 450) + 0.5 * 5.670374419e-8 * (std::pow(300, 4) - std::pow(450, 4));
  EXPECT_NEAR(power[0], q * area, 1e-10);
  EXPECT_NEAR(power[1], 30 * area, 1e-12);
  for (int i = 0; i < m.cloud().owned; ++i) {
    const Vec3& x = m.cloud().x[i];
    const double here = x.x < 4 ? 0 : x.y == 1 ? area / 2 : area / 4;
    EXPECT_NEAR(F[i], (q + 30) * here, 1e-10);
  }
}

TEST(Conditions, TakeTheMeanWhereTwoTemperaturesMeetAndSaySo) {
  const std::string walls = R"toml(
[boundary.xmin]
temperature = "300 K"
[boundary.ymin]
temperature = { formula = "500 + 10*x + 3*t", unit = "K" }
[boundary.ymax]
temperature = "300 K"
)toml";
  const CaseModel m(plate(walls));
  const State state = m.start();
  std::vector<double> later(state.T);
  m.system().set_known(2, later);
  for (int i = 0; i < m.cloud().owned; ++i) {
    const Vec3& x = m.cloud().x[i];
    const bool on_xmin = x.x == 0, on_ymin = x.y == 0, on_ymax = x.y == 2;
    const double expected = on_xmin && on_ymin ? 400 : on_xmin || on_ymax ? 300 : on_ymin ? 500 + 10 * x.x : 400;
    EXPECT_NEAR(state.T[i], expected, 1e-12);
    if (on_xmin && on_ymin) {
      EXPECT_NEAR(later[i], (300 + 506) / 2., 1e-12);
    }
  }
  // The corner of two walls that agree is nothing to speak of.
  EXPECT_EQ(m.model().notes,
            (std::vector<std::string>{"1 point on 'xmin' and 'ymin' takes the mean of their temperatures"}));
  // Its reaction is booked half and half.
  const double C = 7870. * 447 * 0.25 * 0.1;  // of a corner
  EXPECT_NEAR(state.cumulative_heat[0], C * (-100 * 2) + 0.5 * C * 0 + 0.5 * C * -100, 1e-6 * C);
}

TEST(Conditions, MeetInTheEdgesOfABox) {
  const Bound b(box_case({"2 m", "2 m", "2 m"}, {3, 3, 3}) + R"toml(
[material.m]
library = "iron"
[boundary.xmin]
temperature = "300 K"
[boundary.ymin]
temperature = "400 K"
[boundary.zmin]
temperature = "800 K"
)toml");
  double share_sum = 0;
  for (const PrescribedTerm& term : b.conditions.temperatures)
    for (std::size_t n = 0; n < term.point.size(); ++n) {
      const Vec3& x = term.x[n];
      EXPECT_EQ(term.share[n], 1. / ((x.x == 0) + (x.y == 0) + (x.z == 0)));
      share_sum += term.share[n];
    }
  EXPECT_NEAR(share_sum, 27 - 8, 1e-12);  // all points of the three faces
  EXPECT_EQ(b.conditions.notes.size(), 3u);
  EXPECT_EQ(b.conditions.notes[0], "3 points on 'xmin' and 'ymin' take the mean of their temperatures");
}

TEST(Conditions, OfConvectionFollowNewtonsLaw) {
  const Bound b(plate(R"toml(
[boundary.xmax.convection]
h = { formula = "20 + 0.1*(T - 300) + t", unit = "W/(m^2 K)" }
ambient = { table = [[0, 20], [10, 120]], unit = "degC", time = "s" }
)toml"));
  const SurfaceTerm& term = b.conditions.fluxes.at(0);
  for (double t : {0., 4., 20.}) {
    const double T = 410, ambient = 293.15 + std::min(10 * t, 100.), h = 20 + 11 + t;
    const auto [q, slope] = flux(term, T, t);
    EXPECT_NEAR(q, h * (ambient - T), 1e-9);
    EXPECT_NEAR(slope, 0.1 * (ambient - T) - h, 1e-7);
    EXPECT_NEAR(term.flux->ambient(term.x, t).at(0), ambient, 1e-12);
  }
  EXPECT_EQ(term.flux->changes().events, (std::vector<double>{0, 10}));
  EXPECT_TRUE(term.flux->depends_on_temperature());
  EXPECT_FALSE(term.flux->linear_in_temperature());
}

TEST(Conditions, OfConvectionMayVaryFromPlaceToPlace) {
  const Bound b(plate(R"toml(
[boundary.ymax.convection]
h = { formula = "350/(1 + (x/1000)^2)", unit = "W/(m^2 K)", length = "mm" }
ambient = { formula = "300 + y", unit = "K" }
)toml"));
  const SurfaceTerm& term = b.conditions.fluxes.at(0);
  const std::vector<double> T(term.x.size(), 400);
  std::vector<double> q(T.size());
  term.flux->evaluate({.x = term.x, .T = T}, q, {});
  for (std::size_t p = 0; p < q.size(); ++p)
    EXPECT_NEAR(q[p], 350 / (1 + term.x[p].x * term.x[p].x) * (302 - 400), 1e-9);
  EXPECT_TRUE(term.flux->linear_in_temperature());
}

TEST(Conditions, OfRadiationFollowStefanAndBoltzmann) {
  const Bound b(plate(R"toml(
[boundary.xmax]
radiation = { emissivity = { formula = "0.2 + 0.001*T" }, ambient = { table = [[0, 300], [1, 800]], unit = "K" } }
)toml"));
  const SurfaceTerm& term = b.conditions.fluxes.at(0);
  constexpr double sigma = 5.670374419e-8;  // CODATA 2018
  const double T = 500, t = 0.5, ambient = 550, eps = 0.7;
  const double driving = std::pow(ambient, 4) - std::pow(T, 4);
  const auto [q, slope] = flux(term, T, t);
  EXPECT_NEAR(q, eps * sigma * driving, 1e-9);
  EXPECT_NEAR(slope, 0.001 * sigma * driving - 4 * eps * sigma * T * T * T, 1e-7);
  EXPECT_EQ(term.flux->changes().events, (std::vector<double>{0, 1}));
  EXPECT_EQ(flux(term, 300, 0).first, 0);
}

TEST(Conditions, OfFluxFollowTablesInTime) {
  const Bound b(plate(R"toml(
[boundary.xmax]
flux = { table = [[0, 0], [1, 6], [3, 10]], unit = "kW/m^2", time = "min" }
)toml"));
  const SurfaceTerm& term = b.conditions.fluxes.at(0);
  EXPECT_NEAR(flux(term, 300, 30).first, 3000, 1e-9);
  EXPECT_NEAR(flux(term, 300, 120).first, 8000, 1e-9);
  EXPECT_NEAR(flux(term, 300, 1e4).first, 10000, 1e-9);
  EXPECT_EQ(flux(term, 300, 30).second, 0);
  EXPECT_EQ(term.flux->changes().events, (std::vector<double>{0, 60, 180}));
}

TEST(Conditions, AreToldWhatTheirTablesGoBy) {
  const auto at = [](const std::string& more, double T, double t) {
    const Bound b(plate("[boundary.xmax]\nflux = { table = [[300, 1], [400, 2]], unit = \"W/m^2\"" + more + " }\n"));
    return flux(b.conditions.fluxes.at(0), T, t).first;
  };
  EXPECT_EQ(at(", of = \"time\"", 350, 400), 2);
  EXPECT_EQ(at(", of = \"temperature\"", 350, 400), 1.5);
  EXPECT_EQ(at(", temperature = \"K\"", 350, 400), 1.5);
  EXPECT_EQ(at(", time = \"min\"", 350, 300 * 60), 1);
  const auto refused = [&](const std::string& more, const std::vector<std::string>& words) {
    expect_error([&] { at(more, 0, 0); }, words);
  };
  refused("", {"test.toml:15:8", "the table of flux does not say what it goes by", "of = \"time\""});
  refused(", of = \"temperature\", time = \"s\"", {"'time' does not go with a table of temperature"});
  refused(", temperature = \"K\", time = \"s\"", {"'time' does not go with a table of temperature"});
}

/// That the plate with `text` in its case is refused.
void refused(const std::string& text, const std::vector<std::string>& words) { expect_refused(plate(text), words); }

TEST(Conditions, RefuseWhatContradictsItself) {
  const std::string held = "[boundary.xmin]\ntemperature = \"300 K\"\n";
  refused(held + "[boundary.b]\non = \"xmin\"\ntemperature = \"400 K\"\n",
          {"test.toml:17:6", "face 'xmin'", "a temperature from [boundary.xmin] and a temperature from [boundary.b]"});
  refused(held + "[boundary.b]\non = \"xmin\"\nflux = \"4 W/m^2\"\n", {"a heat flux from [boundary.b]", "where"});
  refused("[boundary.xmin]\ninsulated = true\n[boundary.b]\non = \"xmin\"\nflux = \"4 W/m^2\"\n", {"insulation"});
  refused("[boundary.xmin]\ntemperature = \"300 K\"\nflux = \"4 W/m^2\"\n", {"has a temperature and a flux"});
  refused("[boundary.xmin]\ninsulated = true\nflux = \"4 W/m^2\"\n", {"test.toml:15:13", "insulated and has a flux"});
  refused("[boundary.xmin]\non = \"xmin\"\n", {"says nothing of its wall"});
  refused("[boundary.xmin]\ntemperature = { formula = \"300 + T\", unit = \"K\" }\n",
          {"cannot depend on the temperature"});
}

TEST(Conditions, RefuseFacesAndSelectionsThatAreNotThere) {
  refused("[boundary.xmn]\nflux = \"4 W/m^2\"\n", {"no face 'xmn'", "did you mean 'xmin'?", "xmin, xmax, ymin, ymax"});
  refused("[boundary.b]\non = \"lid\"\nflux = \"4 W/m^2\"\n",
          {"test.toml:15:6", "no face 'lid'", "xmin, xmax, ymin, ymax"});
  refused("[boundary.b]\nwhere = \"x > 7\"\nflux = \"4 W/m^2\"\n",
          {"test.toml:15:9", "selects no piece of the surface"});
  refused("[boundary.b]\nwhere = \"x > 7\"\ntemperature = \"4 K\"\n", {"selects no point"});
  // The inside is not the surface.
  refused("[boundary.b]\nwhere = \"abs(x - 2) < 0.1 && abs(y - 1) < 0.1\"\nflux = \"4 W/m^2\"\n",
          {"selects no piece of the surface"});
}

TEST(Conditions, RefuseValuesOutOfRange) {
  refused("[boundary.xmin]\nconvection = { h = \"-3 W/(m^2 K)\", ambient = \"300 K\" }\n",
          {"test.toml:15:20", "heat transfer coefficient h is -3 W/(m^2 K)", "negative"});
  refused("[boundary.xmin]\nradiation = { emissivity = 1.2, ambient = \"300 K\" }\n",
          {"emissivity is 1.2", "between 0 and 1"});
  refused("[boundary.xmin]\nradiation = { emissivity = 0.2, ambient = \"-300 degC\" }\n",
          {"'ambient' is -26.85 K, below absolute zero"});
  refused("[boundary.xmin]\nconvection = { h = \"3 W/(m^2 K)\" }\n", {"ambient"});
  refused("[boundary.xmin]\nflux = { formula = \"1/(y - 1)\", unit = \"W/m^2\" }\n", {"(0, 1, 0)"});
}

TEST(Conditions, StopWhereAValueLeavesItsRangeInTheRun) {
  const CaseModel m(plate(
      "[boundary.xmin]\nconvection = { h = { formula = \"3 - t\", unit = \"W/(m^2 K)\" }, ambient = \"300 K\" }\n"));
  m.rates(3, m.uniform(400));
  expect_error([&] { m.rates(3.5, m.uniform(400)); }, {"h is -0.5 W/(m^2 K), t = 3.5 s"}, Fault::numbers);
}

TEST(Sources, GiveTheirPowerToTheVolume) {
  const CaseModel m(plate(R"toml(
[source.sun]
power_density = { formula = "100*x + T + t", unit = "W/m^3" }
[source.sink]
power_density = "-7 W/m^3"
)toml"));
  const auto [F, power] = m.rates(5, m.uniform(400));
  for (int i = 0; i < m.cloud().owned; ++i) {
    const double x = std::clamp(m.cloud().x[i].x, 0.25, 3.75);  // the middle of the cell, 0.5 m wide on walls
    EXPECT_NEAR(F[i], (100 * x + 405 - 7) * m.cloud().volume[i], 1e-10);
  }
  EXPECT_NEAR(power[0], (200 + 405) * 4 * 2 * 0.1, 1e-10);
  EXPECT_NEAR(power[1], -7 * 4 * 2 * 0.1, 1e-12);
  EXPECT_EQ(m.system().accounts(), (std::vector<std::string>{"sun", "sink"}));
  EXPECT_EQ(m.system().boundary_accounts(), 0);
}

TEST(Sources, RefuseWhatTheyCannotTell) {
  refused("[source.sun]\npower = \"7 W\"\nwhere = \"x > 9\"\n", {"heats nothing of the body"});
  refused("[source.sun]\npower = \"7 W\"\non = \"zmax\"\n", {"there is no face 'zmax'"});
  refused("[source.sun]\npower = \"7 W\"\nhalf = true\n", {"'half' goes with a source that moves"});
  refused("[source.sun]\npower_density = \"7 W/m^3\"\nwhere = \"x > 1\"\n", {"'where' goes with a power"});
  refused("[source.sun]\n", {"test.toml:14:1", "does not say how much heat"});
  refused("[boundary.xmin]\nflux = \"1 W/m^2\"\n[source.xmin]\npower_density = \"7 W/m^3\"\n",
          {"'xmin' is the name of a boundary too"});
  refused("[source.sun]\npower_density = \"7 W\"\n", {"test.toml:15:17", "W/m^3"});
}

const std::string places = R"toml(
[boundary.xmin]
temperature = "300 K"
[boundary.ymin]
temperature = "500 K"
[boundary.xmax]
where = "y > 0.5"
flux = "10 W/m^2"
convection = { h = "10 W/(m^2 K)", ambient = "300 K" }
)toml";

TEST(ConditionsParallel, AreTheSameOnAnyNumberOfRanks) {
  const Bound alone(plate(places)), shared(plate(places), MPI_COMM_WORLD);
  EXPECT_EQ(alone.conditions.notes, shared.conditions.notes);
  EXPECT_EQ(alone.conditions.accounts, shared.conditions.accounts);
  ASSERT_EQ(alone.conditions.fluxes.size(), shared.conditions.fluxes.size());
  for (std::size_t f = 0; f < alone.conditions.fluxes.size(); ++f)
    EXPECT_NEAR(total_area(alone.conditions.fluxes[f]), sum(MPI_COMM_WORLD, shared.conditions.fluxes[f].area), 1e-14);
  ASSERT_EQ(alone.conditions.temperatures.size(), shared.conditions.temperatures.size());
  for (std::size_t n = 0; n < alone.conditions.temperatures.size(); ++n)
    EXPECT_EQ(sum(MPI_COMM_SELF, alone.conditions.temperatures[n].share),
              sum(MPI_COMM_WORLD, shared.conditions.temperatures[n].share));
}

TEST(ConditionsParallel, RefuseOnAllRanks) {
  for (const std::string text : {"[boundary.b]\nwhere = \"x > 7\"\nflux = \"4 W/m^2\"\n",
                                 "[boundary.xmin]\nconvection = { h = { formula = \"1 - y\", unit = \"W/(m^2 K)\" }, "
                                 "ambient = \"300 K\" }\n"}) {
    EXPECT_EQ(error_of([&] { Bound b(plate(text), MPI_COMM_WORLD); }).fault(), Fault::bad_case);
  }
}

}  // namespace
}  // namespace calor
