#include "conduction/mls.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/lattice.hpp"
#include "conduction/supports.hpp"
#include "method_clouds.hpp"
#include "shape_functions.hpp"

namespace calor {
namespace {

/// Points in general position around the origin, unit spacing, and their radii.
struct Scatter {
  std::vector<Vec3> x;
  std::vector<Vec3> R;
};

Scatter scatter(int dimension, double radius, double uneven = 0.2) {
  Scatter s;
  const int n = 4;
  for (int k = dimension == 3 ? -n : 0; k <= (dimension == 3 ? n : 0); ++k) {
    for (int j = dimension > 1 ? -n : 0; j <= (dimension > 1 ? n : 0); ++j) {
      for (int i = -n; i <= n; ++i) {
        const Vec3 u = hashed_uniform(5, s.x.size() + 1000 * s.R.size());
        Vec3 x{i + 0.4 * (u.x - 0.5), j + 0.4 * (u.y - 0.5), k + 0.4 * (u.z - 0.5)};
        for (int a = dimension; a < 3; ++a) x[a] = 0;
        const double R = radius * (1 + uneven * (u.z - 0.5));
        if (norm(x) < R) s.x.push_back(x), s.R.push_back({R, R, R});
      }
    }
  }
  return s;
}

ShapesAtPlace shape(const MovingLeastSquares& mls, const Vec3& x, const Scatter& s) {
  ShapesAtPlace N = shape_functions(mls, x, s.x, s.R);
  EXPECT_TRUE(N.fitted);
  return N;
}

/// Every dimension, degree and weight, with a support that suits it.
template <class Use>
void for_every_fit(const Use& use) {
  for (int dimension : {1, 2, 3}) {
    for (int degree : {1, 2}) {
      for (const MlsWeight weight : {MlsWeight::quartic, MlsWeight::wendland}) {
        SCOPED_TRACE(dimension * 100 + degree * 10 + static_cast<int>(weight));
        const double radius = (degree == 1 ? 2.3 : 2.8) * (weight == MlsWeight::quartic ? 1 : 1.3);
        use(MovingLeastSquares{dimension, degree, weight}, scatter(dimension, radius));
      }
    }
  }
}

TEST(MovingLeastSquares, ReproducePolynomialsUpToTheirDegreeAndTheirGradients) {
  for_every_fit([](const MovingLeastSquares& mls, const Scatter& s) {
    const auto N = shape(mls, {}, s);
    double one = 0;
    Vec3 slope_of_one;
    for (std::size_t k = 0; k < s.x.size(); ++k) one += N.phi[k], slope_of_one += N.gradient[k];
    EXPECT_NEAR(one, 1, 1e-12);
    EXPECT_LE(norm(slope_of_one), 1e-12);
    for (int a = 0; a < mls.dimension; ++a) {
      double value = 0;
      Vec3 slope;
      for (std::size_t k = 0; k < s.x.size(); ++k) value += N.phi[k] * s.x[k][a], slope += s.x[k][a] * N.gradient[k];
      EXPECT_NEAR(value, 0, 1e-12);
      for (int b = 0; b < mls.dimension; ++b) EXPECT_NEAR(slope[b], a == b, 1e-12);
      if (mls.degree == 1) continue;
      for (int b = 0; b < mls.dimension; ++b) {
        double product = 0;
        Vec3 gradient;
        for (std::size_t k = 0; k < s.x.size(); ++k) {
          product += N.phi[k] * s.x[k][a] * s.x[k][b];
          gradient += s.x[k][a] * s.x[k][b] * N.gradient[k];
        }
        EXPECT_NEAR(product, 0, 1e-12);
        EXPECT_LE(norm(gradient), 1e-12);
      }
    }
  });
}

TEST(MovingLeastSquares, HaveTheGradientsOfTheirValues) {
  for_every_fit([](const MovingLeastSquares& mls, const Scatter& s) {
    const Vec3 x{0.03, mls.dimension > 1 ? -0.05 : 0, mls.dimension > 2 ? 0.02 : 0};
    const auto N = shape(mls, x, s);
    constexpr double e = 1e-4;
    for (int a = 0; a < mls.dimension; ++a) {
      Vec3 step;
      step[a] = e;
      // Fourth order: the difference is good to 1e-10 or so.
      const auto p = shape(mls, x + step, s), m = shape(mls, x - step, s);
      const auto pp = shape(mls, x + 2 * step, s), mm = shape(mls, x - 2 * step, s);
      for (std::size_t k = 0; k < s.x.size(); ++k) {
        const double slope = (8 * (p.phi[k] - m.phi[k]) - (pp.phi[k] - mm.phi[k])) / (12 * e);
        EXPECT_NEAR(N.gradient[k][a], slope, 1e-7);
      }
    }
  });
}

TEST(MovingLeastSquares, MoveTurnAndScaleWithTheirPoints) {
  for_every_fit([](const MovingLeastSquares& mls, const Scatter& s) {
    const auto N = shape(mls, {}, s);
    const double size = 1e-3, c = std::cos(0.7), q = std::sin(0.7);
    const auto turn = [&](const Vec3& v) {
      return mls.dimension == 1 ? -v : Vec3{c * v.x - q * v.y, q * v.x + c * v.y, v.z};
    };
    const Vec3 origin{200, mls.dimension > 1 ? -30. : 0., mls.dimension > 2 ? 7. : 0.};
    Scatter moved;
    for (std::size_t k = 0; k < s.x.size(); ++k)
      moved.x.push_back(origin + size * turn(s.x[k])), moved.R.push_back(size * s.R[k]);
    const auto M = shape(mls, origin, moved);
    for (std::size_t k = 0; k < s.x.size(); ++k) {
      // 200 m carry their digits to 3e-14 m, so 1e-3 m do so to 3e-11.
      EXPECT_NEAR(M.phi[k], N.phi[k], 1e-8);
      EXPECT_LE(norm(size * M.gradient[k] - turn(N.gradient[k])), 1e-7);
    }
  });
}

TEST(MovingLeastSquares, RefuseTooFewPointsAndPointsOnALineOrPlane) {
  const std::vector<Vec3> R(9, {3, 3, 3});
  const std::vector<Vec3> line = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const std::vector<Vec3> plane = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 0, 0}};
  const auto fits = [&](int dimension, int degree, std::span<const Vec3> x) {
    const MovingLeastSquares mls{dimension, degree};
    const Vec3 place{0.3, 0, 0};
    const bool regular = shape_functions(mls, place, x, std::span(R).first(x.size())).fitted;
    std::vector<MlsNode> nodes;
    for (const Vec3& node : x) nodes.push_back({node, quotient({1, 1, 1}, R[0])});
    EXPECT_EQ(regular, mls.condition(place, nodes) < 1e10);
    return regular;
  };
  EXPECT_TRUE(fits(1, 2, line));
  EXPECT_FALSE(fits(2, 1, line));
  EXPECT_FALSE(fits(2, 1, std::span(plane).first(2)));
  EXPECT_TRUE(fits(2, 1, plane));
  EXPECT_FALSE(fits(2, 2, plane));
  EXPECT_FALSE(fits(3, 1, plane));
}

TEST(MovingLeastSquares, OfAPlaceHaveTheSameBitsWhateverOtherPlacesAreEvaluatedWithIt) {
  for_every_fit([](const MovingLeastSquares& mls, const Scatter& s) {
    std::vector<MlsNode> all;
    for (std::size_t k = 0; k < s.x.size(); ++k) all.push_back({s.x[k], quotient({1, 1, 1}, s.R[k])});
    const auto place = [&](int l) {
      Vec3 x = 0.3 * hashed_uniform(7, l);
      for (int a = mls.dimension; a < 3; ++a) x[a] = 0;
      return x;
    };
    // Each of eight places sees most of the nodes, others than the next place.
    const auto sees = [](int l, std::size_t k) { return (k + l) % 5 != 0; };
    const auto rows = [&](std::span<const int> of) {
      MlsPlaces places;
      std::vector<MlsNode> nodes;
      std::vector<std::uint8_t> bits;
      for (const int l : of) places.add(place(l), {1, 2, 3});
      for (std::size_t k = 0; k < all.size(); ++k) {
        std::uint8_t bit = 0;
        for (std::size_t n = 0; n < of.size(); ++n) bit |= static_cast<std::uint8_t>(sees(of[n], k) << n);
        if (bit != 0) nodes.push_back(all[k]), bits.push_back(bit);
      }
      std::vector<MlsPlaces::Lanes> phi(nodes.size()), slope(nodes.size());
      EXPECT_EQ(mls.evaluate(places, nodes, bits, phi, slope), (1u << of.size()) - 1);
      std::vector<std::vector<double>> rows(of.size());
      for (std::size_t k = 0; k < nodes.size(); ++k)
        for (std::size_t n = 0; n < of.size(); ++n)
          if (bits[k] >> n & 1) rows[n].push_back(phi[k][n]), rows[n].push_back(slope[k][n]);
      return rows;
    };
    const auto together = rows(std::vector{0, 1, 2, 3, 4, 5, 6, 7}), others = rows(std::vector{7, 6, 3, 1, 0});
    EXPECT_EQ(others[0], together[7]);
    EXPECT_EQ(others[2], together[3]);
    for (const int l : {0, 3, 7}) EXPECT_EQ(rows(std::vector{l})[0], together[l]);
  });
}

/// Points halfway between neighbours, and the points themselves.
std::vector<Vec3> places_of(const Cloud& cloud) {
  std::vector<Vec3> places(cloud.x.begin(), cloud.x.begin() + cloud.owned);
  const auto neighbours = find_neighbours(cloud, 1.5);
  for (int i = 0; i < cloud.owned; ++i)
    for (const int j : neighbours.of(i)) places.push_back(0.5 * (cloud.x[i] + cloud.x[j]));
  return places;
}

double linear_error(const Cloud& cloud, const ShapeRows& rows, std::span<const Vec3> places) {
  double largest = 0;
  for (std::size_t q = 0; q < places.size(); ++q) {
    double one = 0;
    Vec3 x;
    for (auto n = rows.phi.row[q]; n < rows.phi.row[q + 1]; ++n) {
      one += rows.phi.value[n];
      x += rows.phi.value[n] * (cloud.x[rows.phi.column[n]] - places[q]);
    }
    largest = std::max({largest, std::abs(one - 1), norm(x) / cloud.spacing[0]});
  }
  return largest;
}

TEST(SupportsParallel, AreEnlargedWhereAPlaceSeesTooFewPoints) {
  // A support of 1.1 spacings is too small for a jittered cloud; every fit must come out all the same, and alike on any
  // number of ranks.
  const Cloud cloud = box_cloud({9, 8, 7}, 0.1, {.jitter = 0.3, .support = 6, .comm = MPI_COMM_WORLD});
  const auto places = places_of(cloud);
  SupportReport report;
  const auto rows = shape_rows(cloud, {3, 1}, {.spacings = 1.1, .least = 9}, places, places, report);
  EXPECT_GT(report.enlarged, 100);
  EXPECT_LE(report.largest, 2.5);
  for (std::size_t q = 0; q < rows.phi.count(); ++q) EXPECT_GE(rows.phi.row[q + 1] - rows.phi.row[q], 9);
  EXPECT_LE(linear_error(cloud, rows, places), 1e-12);
  ASSERT_EQ(rows.slope.size(), rows.phi.value.size());
  // A sum over all rows does not depend on who makes them.
  std::vector<double> squares;
  for (std::size_t q = 0; q < rows.phi.count(); ++q)
    for (auto n = rows.phi.row[q]; n < rows.phi.row[q + 1]; ++n)
      squares.push_back(rows.phi.value[n] * rows.phi.value[n]);
  const Cloud whole = box_cloud({9, 8, 7}, 0.1, {.jitter = 0.3, .support = 6});
  const auto all = shape_rows(whole, {3, 1}, {.spacings = 1.1, .least = 9}, places_of(whole), {}, report);
  std::vector<double> all_squares;
  for (double phi : all.phi.value) all_squares.push_back(phi * phi);
  EXPECT_EQ(sum(cloud.comm, squares), sum(MPI_COMM_SELF, all_squares));
}

TEST(SupportsParallel, ByNumberOfNeighboursHoldThatMany) {
  const Cloud cloud = box_cloud({12, 11}, 0.1, {.jitter = 0.3, .support = 8, .comm = MPI_COMM_WORLD});
  std::vector<Vec3> places(cloud.x.begin(), cloud.x.begin() + cloud.owned);
  SupportReport report;
  const auto rows = shape_rows(cloud, {2, 2}, {.neighbours = 14}, places, {}, report);
  EXPECT_EQ(report.enlarged, 0);
  EXPECT_TRUE(rows.slope.empty());
  EXPECT_LE(linear_error(cloud, rows, places), 1e-12);
  const double mean = static_cast<double>(total(cloud.comm, static_cast<std::int64_t>(rows.phi.value.size()))) / 132;
  EXPECT_NEAR(mean, 17, 3);
}

TEST(Supports, ThatNoEnlargingHelpsNameThePlaceAndTheConditionNumber) {
  Cloud cloud = box_cloud({9, 9}, 0.1);
  for (Vec3& x : cloud.x) x.y = x.x;  // all on a line
  SupportReport report;
  try {
    shape_rows(cloud, {2, 1}, {}, std::vector<Vec3>{{0.4, 0.4, 0}}, {}, report);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(e.problem().find("(0.4, 0.4, 0)"), std::string::npos) << e.problem();
    EXPECT_NE(e.problem().find("condition number"), std::string::npos) << e.problem();
  }
}

}  // namespace
}  // namespace calor
