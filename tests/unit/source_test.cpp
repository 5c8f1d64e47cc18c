// MovingSource sources: where their heat goes, that its sum is the power asked for, and their paths.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "base/parallel.hpp"
#include "case_models.hpp"
#include "method_clouds.hpp"
#include "results.hpp"
#include "source/path.hpp"
#include "source/source.hpp"

namespace calor {
namespace {

/// What every case needs besides.
const std::string head = box_case({"1 m"}, {2}) + "[material.m]\nlibrary = \"iron\"\n[time]\nend = \"1 s\"\n";

std::vector<std::unique_ptr<Source>> sources_of(const std::string& text, const Cloud& cloud) {
  const Case c = Case::parse(head + text, "weld.toml", schema());
  return make_sources(c, cloud);
}

/// Power into every owned point at a time.
std::vector<double> power(Source& source, double t, const Cloud& cloud) {
  std::vector<double> P(cloud.owned), T(cloud.owned, 300.0);
  source.prepare(t);
  source.add_power(t, T, P);
  return P;
}

const std::string along_the_edge = R"(
[[source.arc.pass]]
from = ["0 mm", "0 mm"]
to = ["20 mm", "0 mm"]
speed = "10 mm/s"
)";

TEST(Source, PowerIsExactAtEdgesAndInHalfModels) {
  for (const bool on_walls : {true, false}) {
    const Cloud cloud = box_cloud({21, 11}, 1e-3, {.section = 2e-3, .on_walls = on_walls});
    for (const char* kind : {"column = { sigma = \"2 mm\" }", "column = { radius = \"1 mm\" }", "line = {}"}) {
      const auto all = sources_of(
          fmt::format("[source.arc]\npower = \"1 kW\"\nefficiency = 0.8\nhalf = true\n{}\n{}", kind, along_the_edge),
          cloud);
      for (double t : {0.0, 0.03, 0.5, 1.0, 1.97, 2.0})
        EXPECT_NEAR(sum(cloud.comm, power(*all[0], t, cloud)), 400, 400e-14) << kind << " at " << t;
      EXPECT_EQ(sum(cloud.comm, power(*all[0], 2.1, cloud)), 0);
      EXPECT_DOUBLE_EQ(all[0]->asked(1.0).value(), 400);
      EXPECT_DOUBLE_EQ(all[0]->energy_asked(1.5).value(), 600);
    }
  }
}

TEST(Source, ACellGetsTheIntegralOfTheGaussianOverIt) {
  const Cloud cloud = box_cloud({41, 41}, 1e-3);
  const auto all = sources_of(
      "[source.pose]\npower = \"1 W\"\nat = [\"20.3 mm\", \"19.1 mm\"]\ncolumn = { sigma = \"1.5 mm\" }\n", cloud);
  const auto P = power(*all[0], 0, cloud);
  const auto part = [](double x) {  // of N(0, 1.5 mm) in the cell around x
    return 0.5 * (std::erf((x + 0.5e-3) / (std::numbers::sqrt2 * 1.5e-3)) -
                  std::erf((x - 0.5e-3) / (std::numbers::sqrt2 * 1.5e-3)));
  };
  for (int i = 0; i < cloud.owned; ++i)
    EXPECT_NEAR(P[i], part(cloud.x[i].x - 20.3e-3) * part(cloud.x[i].y - 19.1e-3), 1e-15);
}

TEST(Source, MirrorImagesKeepTheHeatSymmetricAboutAWall) {
  // A quarter of a plate with the source in its corner gets what a quarter of the whole plate gets.
  const Cloud quarter = box_cloud({11, 11}, 1e-3), whole = box_cloud({21, 21}, 1e-3);
  const auto at_corner =
      sources_of("[source.s]\npower = \"1 W\"\nat = [\"0 m\", \"0 m\"]\ncolumn = { sigma = \"1 mm\" }\n", quarter);
  const auto in_middle =
      sources_of("[source.s]\npower = \"4 W\"\nat = [\"10 mm\", \"10 mm\"]\ncolumn = { sigma = \"1 mm\" }\n", whole);
  const auto P = power(*at_corner[0], 0, quarter), Q = power(*in_middle[0], 0, whole);
  for (int i = 0; i < quarter.owned; ++i)
    for (int j = 0; j < whole.owned; ++j) {
      if (norm(whole.x[j] - (quarter.x[i] + Vec3{10e-3, 10e-3, 0})) > 1e-9) continue;
      const double cut = quarter.volume[i] / whole.volume[j];  // cells on the cut are halves and a quarter
      EXPECT_NEAR(P[i], cut * Q[j], 1e-14);
    }
}

TEST(Source, TheDoubleEllipsoidHasItsPartsAheadAndBehind) {
  const Cloud cloud = box_cloud({61, 21, 11}, 1e-3);
  const auto all = sources_of(R"([source.arc]
power = "1 kW"
goldak = { width = "4 mm", depth = "4 mm", front = "5 mm", rear = "10 mm", into = "z" }
[[source.arc.pass]]
from = ["10.5 mm", "10 mm", "0 mm"]
to = ["50.5 mm", "10 mm", "0 mm"]
speed = "10 mm/s"
)",
                              cloud);
  const auto P = power(*all[0], 2, cloud);
  double ahead = 0;
  for (int i = 0; i < cloud.owned; ++i)
    if (cloud.x[i].x > 30.5e-3) ahead += P[i];
  // The cells' walls lie at half millimetres: f_f / 2 = c_f / (c_f + c_r) = 1/3.
  EXPECT_NEAR(ahead, 1000. / 3, 1e-9);
  EXPECT_NEAR(sum(cloud.comm, P), 1000, 1e-11);
}

TEST(Source, ADoubleEllipsoidThatMovesObliquelyIsTurned) {
  // Along the motion the mean is sqrt(2 / pi) (sigma_f - sigma_r); across it the variance is sigma^2, to which points
  // that stand for 4^3 samples in cells of 1 mm add (1 - 1/16) / 12 mm^2. Points that are jittered do not know the
  // centroids of their cells.
  for (const double jitter : {0.0, 0.2}) {
    const Cloud cloud = box_cloud({41, 41, 9}, 1e-3, {.jitter = jitter});
    const auto all = sources_of(R"([source.arc]
power = "1 kW"
goldak = { width = "5 mm", depth = "4 mm", front = "5 mm", rear = "10 mm", into = "z" }
[[source.arc.pass]]
from = ["14 mm", "12 mm", "0 mm"]
to = ["26 mm", "28 mm", "0 mm"]
speed = "10 mm/s"
)",
                                cloud);
    const auto P = power(*all[0], 1, cloud);
    double along = 0, across = 0;
    for (int i = 0; i < cloud.owned; ++i) {
      const Vec3 r = 1e3 * (cloud.x[i] - Vec3{20e-3, 20e-3, 0});
      along += P[i] / 1000 * (0.6 * r.x + 0.8 * r.y);
      across += P[i] / 1000 * std::pow(0.6 * r.y - 0.8 * r.x, 2);
    }
    EXPECT_NEAR(along, -std::sqrt(2 / std::numbers::pi) * 5 / std::sqrt(6), jitter == 0 ? 1e-3 : 2e-2);
    EXPECT_NEAR(across, 25. / 6 + 15. / 16 / 12, jitter == 0 ? 1e-3 : 5e-2);
  }
}

TEST(Source, TheDoubleEllipsoidWrittenAsAFormulaIsAsGoodAsTheBuiltInOne) {
  // Semi-axes of 3 to 8 mm on points 1.5 mm apart. The formula jumps nowhere, but it compares.
  const Cloud cloud = box_cloud({41, 15, 9}, 1.5e-3);
  const auto all = sources_of(R"toml([source.arc]
power = "1 kW"
goldak = { width = "4 mm", depth = "3 mm", front = "4 mm", rear = "8 mm", into = "z" }
[[source.arc.pass]]
from = ["20.2 mm", "10.5 mm", "0 mm"]
to = ["50 mm", "10.5 mm", "0 mm"]
speed = "10 mm/s"
[source.formula]
power_density = { formula = "6*sqrt(3)*2/12*1000/(4*3*pi*sqrt(pi))*1e9*exp(-3*((x-20.2-10*t)^2/(x>20.2+10*t ? 16 : 64) + (y-10.5)^2/16 + z^2/9))", unit = "W/m^3", length = "mm" }
)toml",
                              cloud);
  for (const double t : {0., 0.57}) {
    const auto P = power(*all[0], t, cloud), Q = power(*all[1], t, cloud);
    const double most = *std::ranges::max_element(P);
    // Images at the walls give the built-in one what little would fall beside the body.
    EXPECT_NEAR(sum(cloud.comm, Q), 1000, 0.2);
    for (int i = 0; i < cloud.owned; ++i) EXPECT_NEAR(Q[i], P[i], 3e-4 * most);
  }
}

TEST(Source, ReversedMotionReversesTheDoubleEllipsoid) {
  const Cloud cloud = box_cloud({31, 11, 6}, 1e-3);
  const auto moving = [&](const char* from, const char* to) {
    return sources_of(fmt::format(R"([source.arc]
power = "1 W"
goldak = {{ width = "3 mm", depth = "3 mm", front = "3 mm", rear = "6 mm", into = "z" }}
[[source.arc.pass]]
from = ["{} mm", "5 mm", "0 mm"]
to = ["{} mm", "5 mm", "0 mm"]
speed = "10 mm/s"
)",
                                  from, to),
                      cloud);
  };
  const auto there = moving("5", "25"), back = moving("25", "5");
  const auto P = power(*there[0], 1, cloud), Q = power(*back[0], 1, cloud);
  for (int i = 0; i < cloud.owned; ++i) {
    for (int j = 0; j < cloud.owned; ++j) {
      if (norm(cloud.x[j] - Vec3{30e-3 - cloud.x[i].x, cloud.x[i].y, cloud.x[i].z}) < 1e-9) {
        EXPECT_NEAR(P[i], Q[j], 1e-15);
      }
    }
  }
}

TEST(Source, SurfaceHeatEntersByItsFaceAlone) {
  const Cloud cloud = box_cloud({21, 21, 5}, 1e-3);
  const auto all = sources_of(
      "[source.s]\npower = \"5 W\"\nat = [\"7 mm\", \"3 mm\", \"4 mm\"]\nsurface = { face = \"zmax\", sigma = \"1.5 "
      "mm\" }\n",
      cloud);
  const auto P = power(*all[0], 0, cloud);
  EXPECT_NEAR(sum(cloud.comm, P), 5, 1e-13);
  for (int i = 0; i < cloud.owned; ++i) {
    if (cloud.x[i].z < 3.9e-3) {
      EXPECT_EQ(P[i], 0);
    }
  }
}

TEST(SourceParallel, ASpotOnARoundFaceHeatsAroundItsPlaceAlone) {
  // On a circle of radius R a Gaussian of the chord is von Mises' distribution of the angle, whose mean cosine is
  // I1(kappa)/I0(kappa), kappa = (R/sigma)^2 (Mardia & Jupp, Directional Statistics, 2000, 3.5.4).
  const CaseModel m("title = \"t\"\nmethod = \"sph\"\n[cloud]\nshape = \"disc\"\nradius = \"20 mm\"\nrings = 20\n" +
                        simple_material({.k = "30", .rho = "7800", .c = "600"}) +
                        "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n",
                    MPI_COMM_WORLD);
  const double R = 20e-3, kappa = std::pow(20.0 / 3, 2);
  const double mean_cosine = std::cyl_bessel_i(1, kappa) / std::cyl_bessel_i(0, kappa);
  struct Place {
    double angle, height, within;  // from a point of the surface, in spacings; above it, m
  };
  for (const auto& [angle, height, within] :
       {Place{0, 0, 1e-9}, {30, 0, 1e-9}, {10, 0, 1e-9}, {10, 4e-3, 1e-9}, {7.5, 0, 2e-4}, {-42.3, 0, 2e-4}}) {
    const double a = 2 * std::numbers::pi * angle / 120;
    const Vec3 out{std::cos(a), std::sin(a)};
    const auto all = sources_of(
        fmt::format("[source.torch]\npower = \"5 W\"\nat = [\"{} m\", \"{} m\"]\nsurface = {{ face = \"side\", sigma = "
                    "\"3 mm\" }}\n",
                    (R + height) * out.x, (R + height) * out.y),
        m.cloud());
    const auto P = power(*all[0], 0, m.cloud());
    Vec3 moment;
    for (int i = 0; i < m.cloud().owned; ++i) {
      moment += P[i] * m.cloud().x[i];
      EXPECT_TRUE(P[i] < 1e-10 || dot(m.cloud().x[i], out) > 0.3 * R);
    }
    const std::vector<double> sums_of_all = sums(m.cloud().comm, std::vector{moment.x, moment.y}, 2);
    const Vec3 mean{sums_of_all[0] / 5 / R, sums_of_all[1] / 5 / R};
    EXPECT_NEAR(sum(m.cloud().comm, P), 5, 1e-12);
    EXPECT_NEAR(dot(mean, out), mean_cosine, within) << angle;
    EXPECT_NEAR(mean.x * out.y - mean.y * out.x, 0, within) << angle;
  }
}

TEST(Source, OnALensASpotHeatsItsOwnSide) {
  const CaseModel m(R"toml(title = "t"
method = "sph"
[cloud]
shape = "surface"
spacing = "1 mm"
[[cloud.part]]
shape = "ellipsoid"
semi_axes = ["8 mm", "8 mm", "1.5 mm"]
turn = ["30 deg", "0 deg", "0 deg"]
)toml" + simple_material({.k = "30", .rho = "7800", .c = "600"}) +
                    "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n");
  ASSERT_EQ(m.cloud().faces.size(), 1);
  const Vec3 up{0, -0.5, std::sqrt(0.75)}, top = 1.5e-3 * up;
  const auto all = sources_of(
      fmt::format(
          "[source.spot]\npower = \"5 W\"\nat = [\"{} m\", \"{} m\", \"{} m\"]\nsurface = {{ face = \"{}\", sigma "
          "= \"3 mm\" }}\n",
          top.x, top.y, top.z, m.cloud().faces[0]),
      m.cloud());
  const auto P = power(*all[0], 0, m.cloud());
  EXPECT_NEAR(sum(m.cloud().comm, P), 5, 1e-12);
  for (int i = 0; i < m.cloud().owned; ++i) EXPECT_TRUE(P[i] == 0 || dot(m.cloud().x[i], up) > -0.2e-3);
}

TEST(Source, WithoutNormalisingWhatFallsBesideTheBodyIsLost) {
  const Cloud cloud = box_cloud({41, 41}, 1e-3);
  const auto all = sources_of(
      "[source.s]\npower = \"1 W\"\nnormalise = false\nat = [\"0 m\", \"20 mm\"]\ncolumn = { sigma = \"2 mm\" }\n",
      cloud);
  EXPECT_NEAR(sum(cloud.comm, power(*all[0], 0, cloud)), 0.5, 1e-12);
  EXPECT_EQ(all[0]->asked(0).value(), 1);
  const auto half = sources_of(
      "[source.s]\npower = \"1 W\"\nhalf = true\nnormalise = false\nat = [\"20 mm\", \"0 mm\"]\ncolumn = { sigma = \"2 "
      "mm\" }\n",
      cloud);
  EXPECT_NEAR(sum(cloud.comm, power(*half[0], 0, cloud)), 0.5, 1e-12);
  EXPECT_EQ(half[0]->asked(0).value(), 0.5);
}

TEST(Source, OverlappingSubdomainsGetTheRawIntegralsOfTheirSamples) {
  // Two samples a point, of its volume each: what goes in is twice the power, and normalised the power. A body source
  // takes the volume of the samples.
  const Cloud cloud = box_cloud({41, 21}, 1e-3, {.section = 2e-3});
  CellSamples samples;
  for (int i = 0; i < cloud.owned; ++i) {
    samples.point.push_back(i);
    samples.x.insert(samples.x.end(), 2, cloud.x[i]);
    samples.weight.insert(samples.weight.end(), 2, cloud.volume[i]);
    samples.row.push_back(2 * (i + 1));
  }
  for (const bool normalise : {false, true}) {
    const auto all = sources_of(
        fmt::format("[source.arc]\npower = \"1 kW\"\nhalf = true\nat = [\"1 mm\", \"0 mm\"]\nnormalise = {}\n"
                    "column = {{ sigma = \"2 mm\" }}\n[source.body]\npower_density = \"3 W/m^3\"\n",
                    normalise),
        cloud);
    for (const auto& source : all) source->integrate_over(samples);
    const auto P = power(*all[0], 0, cloud);
    // The density folded at both walls of the corner; its sums over equidistant points are exact.
    EXPECT_NEAR(sum(cloud.comm, P), normalise ? 500 : 1000, 1e-3);
    const auto density = [](double x, double y) {
      return 1000 / (2 * std::numbers::pi * 4e-6 * 2e-3) * std::exp(-(x * x + y * y) / 8e-6);
    };
    for (int i = 0; i < cloud.owned; ++i) {
      const Vec3& x = cloud.x[i];
      const double folded = density(x.x - 1e-3, x.y) + density(x.x + 1e-3, x.y);
      if (norm(x) < 5e-3) {
        EXPECT_NEAR(P[i], (normalise ? 1 : 2) * folded * cloud.volume[i], 1e-5 * P[i]);
      }
    }
    EXPECT_NEAR(sum(cloud.comm, power(*all[1], 0, cloud)), 2 * 3 * sum(cloud.comm, cloud.volume), 1e-12);
  }
}

TEST(SourceParallel, PowerIsExactOnIrregularCloudsAndForObliqueMotion) {
  for (const double jitter : {0.0, 0.2}) {
    const Cloud cloud = box_cloud({16, 10, 5}, 1e-3, {.jitter = jitter, .comm = MPI_COMM_WORLD});
    for (const char* kind :
         {"goldak = { width = \"4 mm\", depth = \"4 mm\", front = \"4 mm\", rear = \"8 mm\", into = \"z\" }",
          "column = { sigma = \"1.5 mm\", along = \"z\" }", "surface = { face = \"zmin\", radius = \"4 mm\" }",
          "line = { along = \"z\" }"}) {
      const auto all = sources_of(fmt::format(R"([source.arc]
power = "2 kW"
{}
[[source.arc.pass]]
from = ["0 mm", "0 mm", "0 mm"]
to = ["15 mm", "9 mm", "0 mm"]
speed = "10 mm/s"
)",
                                              kind),
                                  cloud);
      for (double t : {0.0, 0.4, 1.3, 1.7})
        EXPECT_NEAR(sum(cloud.comm, power(*all[0], t, cloud)), 2000, 2e-9) << kind << " at " << t;
    }
  }
}

TEST(Source, PassesChainWithPausesDwellsAndPowersOfTheirOwn) {
  const Case c = Case::parse(head + R"([source.arc]
power = "100 W"
column = { sigma = "1 mm" }
[[source.arc.pass]]
from = ["0 mm", "0 mm"]
to = ["10 mm", "0 mm"]
speed = "10 mm/s"
start = "1 s"
[[source.arc.pass]]
to = ["10 mm", "5 mm"]
speed = "5 mm/s"
power = "50 W"
dwell = "2 s"
[[source.arc.pass]]
pause = "3 s"
from = ["0 mm", "5 mm"]
to = ["10 mm", "5 mm"]
speed = "10 mm/s"
)",
                             "weld.toml", schema());
  const Path path = Path::read(c.section("source").sub("arc"), 2);
  EXPECT_FALSE(path.at(0.5));
  EXPECT_NEAR(path.at(1.25)->place.x, 2.5e-3, 1e-15);
  EXPECT_NEAR(path.at(2.5)->place.y, 2.5e-3, 1e-15);
  EXPECT_NEAR(path.at(2.5)->direction.y, 1, 1e-15);
  EXPECT_EQ(path.at(2.5)->power, 50);
  EXPECT_NEAR(path.at(4)->place.y, 5e-3, 1e-15);  // at rest
  EXPECT_FALSE(path.at(6));
  EXPECT_EQ(path.at(8.5)->power, 100);
  EXPECT_NEAR(path.energy(100).value(), 100 + 50 * 3 + 100, 1e-12);
  const std::vector<double> events = path.changes().events, expected = {1, 2, 3, 5, 8, 9};
  ASSERT_EQ(events.size(), expected.size());
  for (std::size_t n = 0; n < events.size(); ++n) EXPECT_NEAR(events[n], expected[n], 1e-12);
  EXPECT_NEAR(path.fastest(0, 10), 10e-3, 1e-15);
  EXPECT_EQ(path.fastest(3.1, 4.9), 0);
}

TEST(Source, ThePathOfAFileIsLinearBetweenRowsWithItsOwnPower) {
  const TemporaryFolder folder;
  const std::string file =
      folder.write("path.csv", "t [s],x [mm],y [mm],power [W]\n0,0,0,100\n1,10,0,200\n1,10,0,400\n2,20,1,400\n");
  const Case c = Case::parse(head + "[source.arc]\ncolumn = { sigma = \"1 mm\" }\npath = \"" + file + "\"\n",
                             "weld.toml", schema());
  const Path path = Path::read(c.section("source").sub("arc"), 2);
  EXPECT_NEAR(path.at(0.5)->place.x, 5e-3, 1e-15);
  EXPECT_NEAR(path.at(0.5)->power, 150, 1e-12);
  EXPECT_NEAR(path.at(1.5)->power, 400, 1e-12);
  EXPECT_FALSE(path.at(2.5));
  EXPECT_NEAR(path.energy(2).value(), 150 + 400, 1e-12);
  EXPECT_EQ(path.changes().events, (std::vector<double>{0, 1, 2}));  // the power jumps at 1 s
}

TEST(Source, OneAtRestMayHaveAPowerOfTime) {
  // 200 W in two pulses of a tenth of a second, by a formula and by a table: 40 J go into the body.
  const char* powers[] = {
      R"({ formula = "(t > 0.2 && t < 0.3) || (t > 0.7 && t < 0.8) ? 200 : 0", unit = "W" })",
      R"({ table = [[0, 0], [0.2, 0], [0.2, 200], [0.3, 200], [0.3, 0], [0.7, 0], [0.7, 200], [0.8, 200], [0.8, 0]], of = "time", unit = "W" })"};
  for (const std::string power : powers) {
    const CaseModel m(box_case({"20 mm", "10 mm"}, {21, 11}) + simple_material({.k = "30", .rho = "7800", .c = "600"}) +
                      "[initial]\ntemperature = \"300 K\"\n[time]\nend = \"1 s\"\n[source.laser]\nat = [\"10 mm\", "
                      "\"5 mm\"]\ncolumn = { sigma = \"2 mm\" }\npower = " +
                      power + "\n");
    State state = m.start();
    const double E = std::accumulate(state.E.begin(), state.E.end(), 0.0);
    make_integrator(m.description(), m.system(), state)->advance(m.system(), state, 1, [](const State&) {
      return true;
    });
    EXPECT_NEAR(std::accumulate(state.E.begin(), state.E.end(), 0.0) - E, 40, 1e-6) << power;
  }
}

TEST(Source, StepsGoNoFartherThanAThirdOfSigma) {
  const Cloud cloud = box_cloud({21, 11}, 1e-3);
  const auto all = sources_of("[source.arc]\npower = \"1 W\"\ncolumn = { sigma = \"3 mm\" }\n" + along_the_edge, cloud);
  EXPECT_NEAR(all[0]->longest_step(0, 1), 0.3 * 3 / 10, 1e-12);
  EXPECT_TRUE(std::isinf(all[0]->longest_step(2.1, 5)));
}

TEST(Source, OneThatNeverTouchesTheBodyIsRefused) {
  const Cloud cloud = box_cloud({21, 11}, 1e-3);
  const std::string beside =
      "[source.s]\npower = \"1 W\"\nat = [\"50 mm\", \"0 mm\"]\ncolumn = { radius = \"3 mm\" }\n";
  expect_words(error_of([&] { sources_of(beside, cloud); }).what(), {"never touches the body"});
}

}  // namespace
}  // namespace calor
