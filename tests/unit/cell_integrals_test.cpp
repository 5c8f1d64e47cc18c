#include "cloud/cell_integrals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "base/parallel.hpp"
#include "cloud/lattice.hpp"
#include "cloud/shapes.hpp"
#include "method_clouds.hpp"

namespace calor {
namespace {

constexpr double pi = std::numbers::pi;

template <class F>
Integrand integrand(const F& f, bool may_jump = true) {
  return {.f =
              [f](std::span<const Vec3> x, std::span<double> out) {
                for (std::size_t n = 0; n < x.size(); ++n) out[n] = f(x[n]);
              },
          .may_jump = may_jump};
}

double total(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

/// Body of 1 m along every axis, in 1D, 2D and 3D.
Cloud unit_box(int dimension, bool on_walls, MPI_Comm comm = MPI_COMM_SELF) {
  const int intervals = dimension == 3 ? 6 : 12;
  return box_cloud(std::vector<std::int64_t>(dimension, intervals + on_walls), 1. / intervals,
                   {.on_walls = on_walls, .comm = comm});
}

/// A number in [0, 1), the same on every machine.
Vec3 random(int n) { return hashed_uniform(7, n); }

TEST(CellIntegrals, GiveEveryCellItsPartOfARandomBox) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    for (const bool on_walls : {true, false}) {
      const Cloud cloud = unit_box(dimension, on_walls);
      const CellIntegrals integrals(cloud);
      for (int n = 0; n < 12; ++n) {
        const Vec3 low = 0.5 * random(2 * n), high = low + 0.1 * Vec3{1, 1, 1} + 0.5 * random(2 * n + 1);
        const auto is_in = [&](const Vec3& x) {
          for (int a = 0; a < dimension; ++a)
            if (x[a] < low[a] || x[a] >= high[a]) return 0.;
          return 1.;
        };
        const std::vector<double> V = integrals.over_cells(integrand(is_in));
        double whole = 1;
        for (int a = 0; a < dimension; ++a) whole *= std::min(high[a], 1.) - low[a];
        EXPECT_NEAR(total(V), whole, 1e-12) << dimension << "D, box " << n;
        for (int i = 0; i < cloud.owned; ++i) {
          double part = 1;
          for (int a = 0; a < dimension; ++a) {
            const auto [begin, end] = cloud.lattice->cell(a, cloud.lattice->index(cloud.id[i])[a]);
            part *= std::max(0., std::min(high[a], end) - std::max(low[a], begin));
          }
          EXPECT_NEAR(V[i], part, 1e-12);
        }
      }
    }
  }
}

TEST(CellIntegrals, DoNotCareWhetherAnEdgeBelongsToARegion) {
  // Edges on points, on the sides of cells and on walls: 3/12, 3.5/12 and 1.
  for (const bool on_walls : {true, false}) {
    const Cloud cloud = unit_box(2, on_walls);
    const CellIntegrals integrals(cloud);
    for (const double edge : {3. / 12, 3.5 / 12, 1.}) {
      EXPECT_NEAR(total(integrals.over_cells(integrand([&](const Vec3& x) { return x.x < edge; }))), edge, 1e-13);
      EXPECT_NEAR(total(integrals.over_cells(integrand([&](const Vec3& x) { return x.x <= edge; }))), edge, 1e-13);
    }
  }
}

TEST(CellIntegrals, GiveDiscsAndSpheresTheirMeasureToAThousandth) {
  // Centres anywhere, radii of 1 to 3 spacings.
  for (int n = 0; n < 10; ++n) {
    const Cloud cloud = unit_box(2, n % 2);
    const double radius = (1 + 0.2 * n) / 12;
    const Vec3 centre = Vec3{0.25, 0.25, 0} + 0.5 * random(n);
    const auto is_in = [&](const Vec3& x) { return std::hypot(x.x - centre.x, x.y - centre.y) < radius; };
    const double area = pi * radius * radius;
    EXPECT_NEAR(total(CellIntegrals(cloud).over_cells(integrand(is_in))), area, 1e-3 * area) << radius;
  }
  for (int n = 0; n < 4; ++n) {
    const Cloud cloud = unit_box(3, n % 2);
    const double radius = (1 + 0.5 * n) / 6;
    const Vec3 centre = Vec3{0.45, 0.45, 0.45} + 0.1 * random(n);
    const auto is_in = [&](const Vec3& x) { return norm(x - centre) < radius; };
    const double volume = 4 * pi / 3 * std::pow(radius, 3);
    EXPECT_NEAR(total(CellIntegrals(cloud).over_cells(integrand(is_in))), volume, 1e-3 * volume) << radius;
  }
}

TEST(CellIntegrals, LookAtASphereAmidTheCellsNoMoreOftenThanAtOneAnywhere) {
  // Lines of a grid on either side of its middle see the surface at one coordinate: that makes no plane of it.
  const Cloud cloud = unit_box(3, true);
  const double radius = 0.35, volume = 4 * pi / 3 * std::pow(radius, 3);
  std::vector<double> asked;
  for (const Vec3& centre : {Vec3{0.5, 0.5, 0.5}, Vec3{0.47, 0.51, 0.52}}) {
    double count = 0;
    const auto is_in = [&](const Vec3& x) { return ++count, norm(x - centre) < radius; };
    EXPECT_NEAR(total(CellIntegrals(cloud).over_cells(integrand(is_in))), volume, 1e-3 * volume);
    asked.push_back(count);
  }
  EXPECT_LT(asked[0], 1.5 * asked[1]);
}

TEST(CellIntegrals, AreExactForAHalfPlaneAtAnyAngle) {
  const Cloud cloud = unit_box(2, true);
  const CellIntegrals integrals(cloud);
  for (int n = 0; n < 8; ++n) {
    const double angle = 0.3 + 0.37 * n;
    const auto is_in = [&](const Vec3& x) { return (x.x - 0.5) * std::cos(angle) + (x.y - 0.5) * std::sin(angle) < 0; };
    EXPECT_NEAR(total(integrals.over_cells(integrand(is_in))), 0.5, 1e-5);
  }
}

TEST(CellIntegrals, OfPolynomialsAreExact) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    for (const bool on_walls : {true, false}) {
      const Cloud cloud = unit_box(dimension, on_walls);
      double exact = 1;
      for (int a = 0; a < dimension; ++a) exact *= 1. / 6 + 0.5 * a;
      const auto f = [&](const Vec3& x) {
        double product = 1;
        for (int a = 0; a < dimension; ++a) product *= std::pow(x[a], 5) + a * x[a];
        return product;
      };
      for (const bool may_jump : {true, false})
        EXPECT_NEAR(total(CellIntegrals(cloud).over_cells(integrand(f, may_jump))), exact, 1e-13);
    }
  }
}

TEST(CellIntegrals, FindAGaussianThatIsNarrowerThanACell) {
  const Cloud cloud = unit_box(2, true);
  const double sigma = 0.3 / 12;
  const auto f = [&](const Vec3& x) {
    const double u = (x.x - 0.52) / sigma, v = (x.y - 0.47) / sigma;
    return std::exp(-0.5 * (u * u + v * v)) / (2 * pi * sigma * sigma);
  };
  EXPECT_NEAR(total(CellIntegrals(cloud).over_cells(integrand(f, false))), 1, 1e-6);
}

TEST(CellIntegrals, OfAFunctionThatJumpsAndVariesAreThoseOfItsParts) {
  const Cloud cloud = unit_box(2, true);
  const auto f = [](const Vec3& x) { return x.x < 0.347 ? x.x * x.y : x.y > 0.611 ? 2 - x.x : 0; };
  const double exact = 0.5 * 0.347 * 0.347 * 0.5 + (2 * 0.653 - 0.5 * (1 - 0.347 * 0.347)) * 0.389;
  EXPECT_NEAR(total(CellIntegrals(cloud).over_cells(integrand(f))), exact, 1e-12);
}

TEST(CellIntegrals, OnIrregularCloudsFindARegionToAPercentOfACell) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Cloud cloud = box_cloud({13, 13}, 1. / 12, {.jitter = 0.3, .seed = seed});
    const auto is_in = [](const Vec3& x) { return x.x < 0.3712 && x.y < 0.52; };
    EXPECT_NEAR(total(CellIntegrals(cloud).over_cells(integrand(is_in))), 0.3712 * 0.52, 2e-3 * 0.3712 * 0.52);
  }
}

TEST(CellIntegrals, ValuesAreThoseAtThePointsButMeansWhereAFunctionJumps) {
  const Cloud cloud = box_cloud({11}, 0.1);
  const auto f = [](const Vec3& x) { return (x.x < 0.475 ? 0 : 1) + x.x * x.x; };
  const std::vector<double> v = CellIntegrals(cloud).values(integrand(f));
  for (int i = 0; i < cloud.owned; ++i) {
    const double x = cloud.x[i].x;
    const double mean = (std::pow(0.55, 3) - std::pow(0.45, 3)) / 0.3 + 0.75;
    EXPECT_NEAR(v[i], std::abs(x - 0.5) < 0.01 ? mean : f(cloud.x[i]), 1e-12);
  }
}

/// Area of the facets on one face, or on all, in which the indicator is true.
template <class F>
double area(const Cloud& cloud, const F& is_in, int face = -1) {
  std::vector<int> facets;
  for (std::size_t n = 0; n < cloud.facets.size(); ++n)
    if (face < 0 || cloud.facets[n].face == face) facets.push_back(static_cast<int>(n));
  const CellSamples rule = CellIntegrals(cloud).facets(facets, integrand(is_in));
  double area = 0;
  for (std::size_t n = 0; n < rule.x.size(); ++n) area += is_in(rule.x[n]) ? rule.weight[n] : 0;
  return area;
}

TEST(CellIntegrals, FacetsOfALatticeAreSelectedExactly) {
  for (const bool on_walls : {true, false}) {
    const auto band = [](const Vec3& x) { return x.x > 0.1234 && x.x <= 0.77; };
    EXPECT_NEAR(area(unit_box(2, on_walls), band, 3), 0.77 - 0.1234, 1e-13);
    const auto patch = [](const Vec3& x) { return x.x > 0.1234 && x.x <= 0.77 && x.y < 0.5; };
    EXPECT_NEAR(area(unit_box(3, on_walls), patch, 5), (0.77 - 0.1234) * 0.5, 1e-13);
    const auto disc = [](const Vec3& x) { return std::hypot(x.x - 0.4, x.y - 0.53) < 0.31; };
    EXPECT_NEAR(area(unit_box(3, on_walls), disc, 5), pi * 0.31 * 0.31, 1e-3 * pi * 0.31 * 0.31);
  }
}

TEST(CellIntegrals, FacetsOfOtherCloudsAreSelectedWhereTheyLie) {
  // The side of a disc of radius 1 m: an arc; of a jittered square: a part of a wall.
  const Cloud disc = distribute(MPI_COMM_SELF, make_rings(MPI_COMM_SELF, {.radius = 1, .rings = 8}), 0.4);
  const double arc = 2 * std::acos(0.3);
  EXPECT_NEAR(area(disc, [](const Vec3& x) { return x.x > 0.3; }), arc, 2e-3 * arc);
  const Cloud square = box_cloud({13, 13}, 1. / 12, {.jitter = 0.3});
  EXPECT_NEAR(area(
                  square, [](const Vec3& x) { return x.x < 0.3712; }, 2),
              0.3712, 1e-6);
  const Cloud cells = box_cloud({12, 12}, 1. / 12, {.jitter = 0.3, .on_walls = false});
  EXPECT_NEAR(area(
                  cells, [](const Vec3& x) { return x.x < 0.3712; }, 2),
              0.3712, 1e-6);
  const Cloud cube = box_cloud({9, 9, 9}, 1. / 8, {.jitter = 0.3});
  EXPECT_NEAR(area(
                  cube, [](const Vec3& x) { return x.x < 0.3712; }, 4),
              0.3712, 1e-2 * 0.3712);
  const Cloud cylinder =
      distribute(MPI_COMM_SELF, make_rings(MPI_COMM_SELF, {.radius = 1, .rings = 8, .height = 1, .levels = 9}), 0.4);
  EXPECT_NEAR(area(
                  cylinder, [](const Vec3& x) { return x.z < 0.3712; }, 0),
              2 * pi * 0.3712, 1e-2 * 2 * pi);
  EXPECT_NEAR(area(
                  cylinder, [](const Vec3& x) { return x.x * x.x + x.y * x.y < 0.3; }, 2),
              pi * 0.3, 1e-2 * pi * 0.3);
}

TEST(CellIntegrals, WeighAsMuchAsTheirFacets) {
  for (const double jitter : {0., 0.3}) {
    const Cloud cloud = box_cloud({6, 7}, 0.1, {.jitter = jitter, .section = 0.2});
    std::vector<int> facets(cloud.facets.size());
    std::iota(facets.begin(), facets.end(), 0);
    const CellSamples rule = CellIntegrals(cloud).facets(facets);
    for (std::size_t k = 0; k < facets.size(); ++k) {
      double sum = 0;
      for (auto n = rule.row[k]; n < rule.row[k + 1]; ++n) sum += rule.weight[n];
      EXPECT_NEAR(sum, cloud.facets[k].area, 1e-15);
      EXPECT_EQ(rule.point[k], cloud.facets[k].point);
    }
  }
}

TEST(CellIntegralsParallel, DoNotDependOnTheRanks) {
  const auto is_in = [](const Vec3& x) { return norm(x - Vec3{0.4, 0.3, 0.2}) < 0.33; };
  for (const double jitter : {0., 0.3}) {
    for (const std::vector<std::int64_t>& points :
         {std::vector<std::int64_t>{13, 11}, std::vector<std::int64_t>{8, 7, 6}}) {
      BoxOptions o{.jitter = jitter};
      const Cloud serial = box_cloud(points, 0.1, o);
      o.comm = MPI_COMM_WORLD;
      const Cloud cloud = box_cloud(points, 0.1, o);
      const std::vector<double> all = CellIntegrals(serial).over_cells(integrand(is_in));
      const std::vector<double> mine = CellIntegrals(cloud).over_cells(integrand(is_in));
      std::vector<int> of_id(serial.owned);
      for (int i = 0; i < serial.owned; ++i) of_id[serial.id[i]] = i;
      for (int i = 0; i < cloud.owned; ++i) EXPECT_EQ(mine[i], all[of_id[cloud.id[i]]]);
    }
  }
}

}  // namespace
}  // namespace calor
