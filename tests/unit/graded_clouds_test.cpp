// Graded clouds: box lattices with intervals that grow along the axes, and rows of points that thin out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "cloud/lattice.hpp"
#include "method_clouds.hpp"

namespace calor {
namespace {

/// n intervals from 0 to 1, the last `ratio` times the first.
std::vector<double> geometric(int n, double ratio) {
  const double q = std::pow(ratio, 1.0 / (n - 1));
  std::vector<double> x;
  for (int i = 0; i <= n; ++i) x.push_back((std::pow(q, i) - 1) / (std::pow(q, n) - 1));
  return x;
}

BoxLattice graded_box(std::vector<std::vector<double>> coordinates, bool on_walls = true) {
  BoxLattice box{.dimension = static_cast<int>(coordinates.size()), .on_walls = on_walls};
  std::copy(coordinates.begin(), coordinates.end(), box.coordinates.begin());
  return box;
}

/// The weld plate of Dan: 930 points in 20 rows on 200 mm x 100 mm.
Rows thinned_rows() {
  Rows rows{.length = 0.2, .y = {}, .points = {}, .thickness = 0.0015};
  for (int i = 0; i < 10; ++i) rows.y.push_back(i / 300.0), rows.points.push_back(61);
  for (double y : {0.035, 0.040, 0.045, 0.050}) rows.y.push_back(y), rows.points.push_back(41);
  for (double y : {0.17 / 3, 0.19 / 3, 0.07}) rows.y.push_back(y), rows.points.push_back(31);
  for (double y : {0.08, 0.09, 0.1}) rows.y.push_back(y), rows.points.push_back(21);
  return rows;
}

Cloud alone(Points points, double reach = 3) { return distribute(MPI_COMM_SELF, std::move(points), Support{reach}); }

std::vector<Cloud> graded_clouds() {
  std::vector<Cloud> clouds;
  clouds.push_back(alone(make_box(MPI_COMM_SELF, graded_box({geometric(20, 10)}))));
  clouds.push_back(alone(make_box(MPI_COMM_SELF, graded_box({geometric(12, 4), geometric(9, 0.25)}))));
  clouds.push_back(
      alone(make_box(MPI_COMM_SELF, graded_box({{0, 0.3, 1.2, 1.7, 2}, {-1, -0.8, 0, 0.5}, geometric(6, 3)}))));
  clouds.push_back(alone(make_rows(MPI_COMM_SELF, thinned_rows())));
  return clouds;
}

TEST(GradedClouds, HaveExactVolumesAndBalancedAreas) {
  for (const Cloud& cloud : graded_clouds()) {
    SCOPED_TRACE(testing::Message() << cloud.dimension << "D, " << cloud.count << " points");
    const CloudCheck c = check(cloud);
    EXPECT_LE(c.volume_error, 1e-13);
    EXPECT_LE(c.area_sum, 1e-14);
    EXPECT_LE(c.moment_sum, 1e-14);
    EXPECT_FALSE(cloud.box_lattice);
    // sum x.A = D V: the areas fit the body.
    double sum = 0;
    for (int i = 0; i < cloud.owned; ++i) sum += dot(cloud.x[i], cloud.area[i]);
    EXPECT_NEAR(sum, cloud.dimension * c.volume, 1e-13 * c.volume);
  }
}

TEST(GradedLattice, GivesItsPointsTheProductsOfHalfIntervals) {
  const Cloud cloud = alone(make_box(MPI_COMM_SELF, graded_box({{1, 1.5, 3}, {0, 4, 5}})));
  for (int i = 0; i < cloud.owned; ++i) {
    if (cloud.id[i] == 4) {  // the middle
      EXPECT_EQ(cloud.x[i], (Vec3{1.5, 4, 0}));
      EXPECT_DOUBLE_EQ(cloud.volume[i], 1 * 2.5);
      EXPECT_DOUBLE_EQ(cloud.spacing[i], 4);  // the largest interval beside it
    }
    if (cloud.id[i] == 2) {  // the corner at x = 3, y = 0
      EXPECT_DOUBLE_EQ(cloud.volume[i], 0.75 * 2);
      EXPECT_DOUBLE_EQ(cloud.full_volume[i], 1.5 * 4);
      EXPECT_DOUBLE_EQ(cloud.area[i].x, 2);
      EXPECT_DOUBLE_EQ(cloud.area[i].y, -0.75);
    }
  }
}

TEST(GradedLattice, InCellsHasItsPointsInTheMiddleOfTheGivenCells) {
  const Cloud cloud = alone(make_box(MPI_COMM_SELF, graded_box({{1, 1.5, 3}, {0, 4, 5}}, false)));
  ASSERT_EQ(cloud.count, 4);
  EXPECT_EQ(cloud.x[0], (Vec3{1.25, 2, 0}));
  EXPECT_DOUBLE_EQ(cloud.volume[0], 0.5 * 4);
  EXPECT_DOUBLE_EQ(cloud.full_volume[0], 0.5 * 4);
  EXPECT_DOUBLE_EQ(cloud.spacing[0], 2.5);
  EXPECT_LE(check(cloud).moment_sum, 1e-15);
}

TEST(GradedLattice, FillsItsCellsWithSamplesExactly) {
  for (const bool on_walls : {true, false}) {
    const Cloud cloud = alone(make_box(MPI_COMM_SELF, graded_box({geometric(7, 5), geometric(5, 0.3)}, on_walls)));
    const CellSamples s = CellSampler(cloud).all();
    double x = 0, xy = 0;  // midpoint rules are exact for products of linear functions
    for (std::size_t n = 0; n < s.x.size(); ++n) x += s.weight[n] * s.x[n].x, xy += s.weight[n] * s.x[n].x * s.x[n].y;
    EXPECT_NEAR(x, 0.5, 1e-14);
    EXPECT_NEAR(xy, 0.25, 1e-14);
  }
}

TEST(Rows, AreThe930PointsOfTheThinnedWeldPlate) {
  const Cloud cloud = alone(make_rows(MPI_COMM_SELF, thinned_rows()));
  ASSERT_EQ(cloud.count, 930);
  for (int i = 0; i < cloud.owned; ++i) {
    if (cloud.id[i] == 9 * 61 + 7) {
      EXPECT_NEAR(cloud.spacing[i], 0.005, 1e-15);  // the gap above, wider than the row's 10/3 mm
    }
    if (cloud.id[i] == 3 * 61 + 7) {
      EXPECT_NEAR(cloud.volume[i], 0.0015 * 1e-4 / 9, 1e-18);
    }
  }
}

/// Counts grid points nearest to every point.
TEST(Rows, GiveEveryPointTheAreaThatIsNearestToIt) {
  const Rows rows{.length = 6, .y = {0, 1, 2.5, 3}, .points = {7, 4, 9, 2}, .thickness = 1};
  const std::vector<Point> p = make_rows(MPI_COMM_SELF, rows).points;
  constexpr int n = 600;
  std::vector<double> area(p.size(), 0.0);
  for (int a = 0; a < 2 * n; ++a) {
    for (int b = 0; b < n; ++b) {
      const Vec3 x{(a + 0.5) * 3 / n, (b + 0.5) * 3 / n, 0};
      const auto nearest = std::ranges::min_element(p, {}, [&](const Point& q) { return norm(q.x - x); });
      area[nearest - p.begin()] += 9.0 / n / n;
    }
  }
  for (std::size_t i = 0; i < p.size(); ++i) EXPECT_NEAR(p[i].volume, area[i], 5e-3) << i;
}

TEST(GradedClouds, TakeConsistentWeights) {
  for (const Cloud& cloud : graded_clouds()) {
    for (const double smoothing : {1.0, 1.2}) {
      SCOPED_TRACE(testing::Message() << cloud.dimension << "D, " << cloud.count << " points, " << smoothing);
      const Weights w = sph_weights(cloud, smoothing);
      EXPECT_LE(w.report.residual, 1e-11);
      EXPECT_EQ(w.report.negative, 0);
      EXPECT_EQ(w.report.lattice_shortcut, smoothing == 1 && cloud.lattice != nullptr);
    }
  }
}

TEST(GradedLattice, HasNoSelfEquilibratedStressWithExactWeights) {
  // Second moments 2 V I at every point, walls and corners included.
  for (const bool on_walls : {true, false}) {
    const Cloud cloud =
        alone(make_box(MPI_COMM_SELF, graded_box({geometric(7, 5), {0, 1, 1.2, 3}, geometric(4, 0.3)}, on_walls)));
    const Weights w = sph_weights(cloud, 1);
    EXPECT_LE(w.report.residual, 1e-13);
    if (!on_walls) continue;  // points off the walls lack what the walls carry
    for (int i = 0; i < cloud.owned; ++i) {
      Vec3 squares;
      for (auto n = w.neighbours.row[i]; n < w.neighbours.row[i + 1]; ++n) {
        const Vec3 r = cloud.x[w.neighbours.column[n]] - cloud.x[i];
        squares += w.G[n] * Vec3{r.x * r.x, r.y * r.y, r.z * r.z};
      }
      EXPECT_NEAR(norm((1 / (2 * cloud.volume[i])) * squares - Vec3{1, 1, 1}), 0, 1e-12);
    }
  }
}

/// Largest and root mean square error of a steady temperature prescribed on all walls, over its range.
struct SteadyError {
  double largest, rms;
};
template <class Exact, class Source>
SteadyError steady_error(const Cloud& cloud, double smoothing, const Exact& exact_at, const Source& source_at) {
  Weights w = sph_weights(cloud, smoothing);
  EXPECT_EQ(w.report.negative, 0);
  const PairConduction pairs(cloud, std::move(w.neighbours), std::move(w.G));
  const std::vector<double> k(cloud.local(), 1.0);
  std::vector<double> exact, fixed, b;
  for (int i = 0; i < cloud.owned; ++i) {
    exact.push_back(exact_at(cloud.x[i]));
    fixed.push_back(cloud.on_faces[i] ? exact[i] : std::nan(""));
    b.push_back(-cloud.volume[i] * source_at(cloud.x[i]));
  }
  SparseJacobian J;
  pairs.add_jacobian({.mean = Mean::arithmetic, .k = k, .dk_dT = {}, .theta = {}}, exact, J);
  const auto T = solve_with_fixed(J.matrix(cloud.owned), b, fixed);
  double squares = 0, volume = 0, largest = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    squares += cloud.volume[i] * (T[i] - exact[i]) * (T[i] - exact[i]);
    volume += cloud.volume[i];
    largest = std::max(largest, std::abs(T[i] - exact[i]));
  }
  const auto [low, high] = std::ranges::minmax(exact);
  return {largest / (high - low), std::sqrt(squares / volume) / (high - low)};
}

TEST(GradedClouds, ReproduceLinearTemperatures) {
  for (const Cloud& cloud : graded_clouds()) {
    const auto linear = [](const Vec3& x) { return 3 + x.x - 2 * x.y + 0.7 * x.z; };
    for (const double smoothing : {1.0, 1.2})
      EXPECT_LE(steady_error(cloud, smoothing, linear, [](const Vec3&) { return 0.0; }).largest, 1e-10);
  }
}

/// u = sin(2x + 0.5) exp(y), whose source is 3 u.
double order(const Cloud& coarse, const Cloud& fine, double smoothing) {
  const auto u = [](const Vec3& x) { return std::sin(2 * x.x + 0.5) * std::exp(x.y); };
  const auto source = [&](const Vec3& x) { return 3 * u(x); };
  const double a = steady_error(coarse, smoothing, u, source).rms, b = steady_error(fine, smoothing, u, source).rms;
  std::printf("%lld points: %.2e, %lld points: %.2e\n", static_cast<long long>(coarse.count), a,
              static_cast<long long>(fine.count), b);
  return std::log2(a / b);
}

TEST(GradedClouds, AreOfSecondOrder) {
  const auto lattice = [](int n, int dimension) {
    std::vector<std::vector<double>> x = {geometric(n, 4), geometric(n, 0.25)};
    if (dimension == 3) x.push_back(geometric(n, 2));
    return alone(make_box(MPI_COMM_SELF, graded_box(x)));
  };
  EXPECT_GE(order(lattice(20, 2), lattice(40, 2), 1), 1.7);
  EXPECT_GE(order(lattice(40, 2), lattice(80, 2), 1), 1.7);
  EXPECT_GE(order(lattice(8, 3), lattice(16, 3), 1), 1.7);
  // The thinned plate in units of its width, and its bisections.
  const auto rows = [](int refine) {
    const Rows plate = thinned_rows();
    Rows rows{.length = 2, .y = {0}, .points = {60 * refine + 1}, .thickness = 1};
    for (std::size_t r = 1; r < plate.y.size(); ++r) {
      for (int n = 1; n <= refine; ++n) {
        const double s = static_cast<double>(n) / refine;
        rows.y.push_back(10 * (plate.y[r - 1] + s * (plate.y[r] - plate.y[r - 1])));
        rows.points.push_back((plate.points[r] - 1) * refine + 1);
      }
    }
    return alone(make_rows(MPI_COMM_SELF, rows));
  };
  EXPECT_GE(order(rows(1), rows(2), 1.2), 1.7);
}

TEST(GradedCloudsParallel, AreTheSameOnAnyNumberOfRanks) {
  const auto points = [](MPI_Comm comm, int which) {
    if (which == 0) return make_rows(comm, thinned_rows());
    if (which == 1) return make_box(comm, graded_box({geometric(40, 30), geometric(30, 20)}));
    return make_box(comm, graded_box({geometric(9, 5), geometric(8, 0.2), geometric(7, 3)}));
  };
  for (int which : {0, 1, 2}) {
    const Support support = sph_support(1.2);
    const Cloud cloud = distribute(MPI_COMM_WORLD, points(MPI_COMM_WORLD, which), support);
    const Cloud serial = distribute(MPI_COMM_SELF, points(MPI_COMM_SELF, which), support);
    const Neighbours mine = find_neighbours(cloud, support), all = find_neighbours(serial, support);
    std::vector<int> of_id(serial.owned);
    for (int i = 0; i < serial.owned; ++i) of_id[serial.id[i]] = i;
    for (int i = 0; i < cloud.owned; ++i) {
      const auto a = mine.of(i), b = all.of(of_id[cloud.id[i]]);
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t n = 0; n < a.size(); ++n) EXPECT_EQ(cloud.id[a[n]], serial.id[b[n]]);
    }
    // No ghost beyond the support of all owned points, but for rounding.
    for (int j = cloud.owned; j < cloud.local(); ++j) {
      bool seen = false;
      for (int i = 0; i < cloud.owned; ++i)
        seen = seen || norm(cloud.x[j] - cloud.x[i]) <=
                           support.radius(0.5 * (cloud.spacing[i] + cloud.spacing[j])) * (1 + 1e-8);
      EXPECT_TRUE(seen);
    }
    EXPECT_EQ(sph_weights(cloud, 1.2).report.residual, sph_weights(serial, 1.2).report.residual);
  }
}

}  // namespace
}  // namespace calor
