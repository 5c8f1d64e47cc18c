#include "conduction/correction.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "conduction/correction.hpp"
#include "method_clouds.hpp"

namespace calor {
namespace {

constexpr double not_fixed = std::numeric_limits<double>::quiet_NaN();

double weight(const Weights& w, int i, int j) {
  const auto row = w.neighbours.of(i);
  const auto found = std::find(row.begin(), row.end(), j);
  return found == row.end() ? 0 : w.G[w.neighbours.row[i] + (found - row.begin())];
}

void expect_symmetric_to_the_last_bit(const Cloud& cloud, const Weights& w) {
  int different = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    for (const int j : w.neighbours.of(i)) different += weight(w, i, j) != weight(w, j, i);
  }
  EXPECT_EQ(different, 0);
}

/// sum_j G_ij x_ji + A_i, the largest over the points and relative to the area of a cell.
double linear_error(const Cloud& cloud, const Weights& w) {
  double largest = 0;
  for (int i = 0; i < cloud.owned; ++i) {
    Vec3 sum = cloud.area[i];
    for (const int j : w.neighbours.of(i)) sum += weight(w, i, j) * (cloud.x[j] - cloud.x[i]);
    largest = std::max(largest, norm(sum) / std::pow(cloud.spacing[i], cloud.dimension - 1) / cloud.cross_section);
  }
  return largest;
}

std::vector<Cloud> rough_clouds() {
  std::vector<Cloud> clouds;
  clouds.push_back(box_cloud({21}, 0.1, {.jitter = 0.3}));
  clouds.push_back(box_cloud({13, 11}, 0.1, {.jitter = 0.2}));
  clouds.push_back(box_cloud({9, 12}, 0.1, {.jitter = 0.3, .section = 0.02, .seed = 7}));
  clouds.push_back(box_cloud({7, 8, 6}, 0.1, {.jitter = 0.2}));
  clouds.push_back(box_cloud({6, 6, 3}, 0.1, {.jitter = 0.2, .seed = 3}));
  return clouds;
}

/// Three points in a line, in series along it; the ends have a negative weight of their own.
TEST(CorrectionParallel, TellsWhetherDifferencesDecay) {
  const Cloud cloud = box_cloud({3}, 0.1, {.support = 2.4, .comm = MPI_COMM_WORLD});
  const Neighbours neighbours = find_neighbours(cloud, 2.2);
  const auto least = [&](double of_ends) {
    std::vector<double> G(neighbours.column.size());
    for (int i = 0; i < cloud.owned; ++i)
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
        G[n] = std::abs(cloud.x[neighbours.column[n]].x - cloud.x[i].x) > 0.15 ? of_ends : 1;
    return lowest_eigenvalue(cloud, neighbours, G);
  };
  // The ends conduct 1/2 to each other through the middle.
  EXPECT_NEAR(least(-0.4), 0, 1e-12);
  EXPECT_NEAR(least(-0.6), -0.125, 1e-12);  // of (1, 0, -1): (1 - 2 * 0.6) / (1 + 0.6)
}

TEST(Correction, GivesConsistentSymmetricWeightsOnJitteredClouds) {
  for (const Cloud& cloud : rough_clouds()) {
    SCOPED_TRACE(cloud.dimension);
    const auto w = sph_weights(cloud, 1.2);
    EXPECT_LE(linear_error(cloud, w), 1e-12);
    EXPECT_NEAR(w.report.residual, linear_error(cloud, w), 1e-13);
    EXPECT_FALSE(w.report.lattice_shortcut);
    EXPECT_EQ(w.report.negative, 0);
    EXPECT_EQ(w.report.pairs, static_cast<std::int64_t>(w.G.size()));
    expect_symmetric_to_the_last_bit(cloud, w);
  }
}

TEST(Correction, GivesConsistentWeightsOnLatticesWithAnySupport) {
  for (const double smoothing : {0.8, 1.0, 1.2, 1.5}) {
    for (const bool on_walls : {true, false}) {
      for (const auto& points : {std::vector<std::int64_t>{9}, {8, 11}, {6, 5, 7}}) {
        SCOPED_TRACE(testing::Message() << smoothing << (on_walls ? " walls " : " cells ") << points.size());
        const Cloud cloud = box_cloud(points, 0.25, {.support = 2 * smoothing, .on_walls = on_walls});
        const auto w = sph_weights(cloud, smoothing);
        EXPECT_LE(linear_error(cloud, w), 1e-12);
        expect_symmetric_to_the_last_bit(cloud, w);
      }
    }
  }
}

TEST(Correction, TakesTheExactWeightsOfABoxLattice) {
  for (const bool on_walls : {true, false}) {
    for (const auto& points : {std::vector<std::int64_t>{9}, {2}, {8, 11}, {5, 2}, {2, 2}, {6, 5, 7}, {4, 2, 5}}) {
      SCOPED_TRACE(testing::Message() << (on_walls ? "walls " : "cells ") << points.size() << " " << points[0]);
      const Cloud cloud = box_cloud(points, 0.1, {.section = points.size() < 3 ? 0.3 : 1, .on_walls = on_walls});
      const auto w = sph_weights(cloud, 1);
      EXPECT_TRUE(w.report.lattice_shortcut);
      EXPECT_EQ(w.report.lambda_solves, 0);
      EXPECT_LE(linear_error(cloud, w), 1e-13);
      expect_symmetric_to_the_last_bit(cloud, w);
    }
  }
}

TEST(Correction, TakesTheExactWeightsOfALayerOneCellThick) {
  const auto w = sph_weights(box_cloud({7, 1}, 0.1, {.on_walls = false}), 1);
  EXPECT_TRUE(w.report.lattice_shortcut);
  for (const double G : w.G) EXPECT_NEAR(G, 1.0, 1e-13);  // a row of cells conducts like a bar: area / distance
}

TEST(Correction, HasNoSelfEquilibratedStressOnALattice) {
  // Second moments 2 V I at every point, cut cells and corners included.
  const Cloud cloud = box_cloud({6, 7, 5}, 0.1);
  const auto w = sph_weights(cloud, 1);
  for (int i = 0; i < cloud.owned; ++i) {
    Vec3 squares;
    for (const int j : w.neighbours.of(i)) {
      const Vec3 r = cloud.x[j] - cloud.x[i];
      squares += weight(w, i, j) * Vec3{r.x * r.x, r.y * r.y, r.z * r.z};
    }
    EXPECT_NEAR(squares.x / (2 * cloud.volume[i]), 1, 1e-12);
    EXPECT_NEAR(squares.y / (2 * cloud.volume[i]), 1, 1e-12);
    EXPECT_NEAR(squares.z / (2 * cloud.volume[i]), 1, 1e-12);
  }
}

TEST(Correction, DoesNotDependOnWhereTheBodyStandsNorOnItsSize) {
  for (const auto& points : {std::vector<std::int64_t>{9, 8}, {6, 5, 6}}) {
    const Cloud cloud = box_cloud(points, 0.1, {.jitter = 0.2});
    const auto w = sph_weights(cloud, 1.2);

    // Turned about z (2D) or about z and x (3D), moved and enlarged.
    const double scale = 250, c = std::cos(0.4), s = std::sin(0.4);
    const auto turn = [&](Vec3 a) {
      a = {c * a.x - s * a.y, s * a.x + c * a.y, a.z};
      return cloud.dimension == 2 ? a : Vec3{a.x, c * a.y - s * a.z, s * a.y + c * a.z};
    };
    const double length = scale, area = std::pow(scale, cloud.dimension - 1), volume = area * scale;
    Cloud other = cloud;
    for (int i = 0; i < cloud.local(); ++i) {
      other.x[i] = length * turn(cloud.x[i]) + Vec3{30, -20, cloud.dimension == 2 ? 0.0 : 10.0};
      other.area[i] = area * turn(cloud.area[i]);
      other.volume[i] *= volume;
      other.full_volume[i] *= volume;
      other.spacing[i] *= length;
      other.metric[i] = {other.spacing[i], other.spacing[i], other.spacing[i]};
    }
    CorrectionReport report;
    const auto G = sph_consistent_weights(other, w.neighbours, 1.2, report);
    double largest = 0;
    for (std::size_t n = 0; n < w.G.size(); ++n) {
      largest = std::max(largest, std::abs(G[n] / volume * length * length - w.G[n]));
    }
    // The moment fit stops at 1e-3, so round-off in its input leaves a trace of about 1e-10.
    EXPECT_LE(largest, 1e-8 * *std::max_element(w.G.begin(), w.G.end()));
  }
}

/// Root mean square error of the steady temperature exp(x) sin(y), prescribed on all walls, over its range.
double harmonic_error(std::int64_t n, int dimension) {
  const double d = 1.0 / static_cast<double>(n - 1);
  const Cloud cloud = box_cloud(std::vector<std::int64_t>(dimension, n), d, {.jitter = 0.2, .seed = 5});
  const PairConduction pairs = sph_pairs(cloud, 1.2);
  const std::vector<double> k(cloud.local(), 1.0), zero(cloud.local(), 0.0);
  std::vector<double> exact, fixed;
  for (int i = 0; i < cloud.owned; ++i) {
    exact.push_back(std::exp(cloud.x[i].x) * std::sin(cloud.x[i].y));
    fixed.push_back(cloud.on_faces[i] ? exact[i] : not_fixed);
  }
  SparseJacobian J;
  pairs.add_jacobian({.mean = Mean::arithmetic, .k = k, .dk_dT = {}, .theta = {}}, exact, J);
  const auto T = solve_with_fixed(J.matrix(cloud.owned), zero, fixed);
  double squares = 0;
  for (int i = 0; i < cloud.owned; ++i) squares += cloud.volume[i] * (T[i] - exact[i]) * (T[i] - exact[i]);
  return std::sqrt(squares);
}

TEST(Correction, IsOfSecondOrderOnJitteredClouds) {
  const double coarse = harmonic_error(11, 2), middle = harmonic_error(21, 2), fine = harmonic_error(41, 2);
  EXPECT_LE(fine, 1e-3);
  EXPECT_GE(std::log2(coarse / fine) / 2, 1.7) << coarse << " " << middle << " " << fine;
  EXPECT_GE(std::log2(harmonic_error(9, 3) / harmonic_error(17, 3)), 1.7);
}

TEST(Correction, TakesHardlyMoreIterationsOnLargeBodies) {
  // The blocks of the points alone take as many times more as there are points more along an edge: four times.
  const auto iterations = [](std::int64_t n) {
    const auto report = sph_weights(box_cloud({n, n}, 1, {.jitter = 0.2}), 1.2).report;
    return static_cast<double>(report.lambda_iterations) / report.lambda_solves;
  };
  EXPECT_LE(iterations(121), 2.5 * iterations(31));  // 52 against 25.5
}

TEST(Correction, RefusesATrussThatCannotStand) {
  // Two bars in a line under a force across them: no weights can balance it.
  Cloud cloud = box_cloud({3, 2}, 1);
  Neighbours line;
  line.row = {0};
  for (int i = 0; i < cloud.owned; ++i) {
    for (int j = 0; j < cloud.owned; ++j) {
      if (i != j && cloud.x[i].y == cloud.x[j].y) line.column.push_back(j);
    }
    line.row.push_back(static_cast<std::int64_t>(line.column.size()));
  }
  CorrectionReport report;
  try {
    consistent_weights(
        cloud, line, [&] { return std::vector<double>(line.column.size(), 1.0); }, {}, report);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::numbers);
    EXPECT_NE(error.problem().find("point is number"), std::string::npos) << error.problem();
    EXPECT_NE(error.cure().find("let them see farther"), std::string::npos);
  }
}

// The sum over pairs of weight times a number that depends on both ids: any changed bit shows.
double checksum(const Cloud& cloud, const Weights& w) {
  std::vector<double> terms;
  for (int i = 0; i < cloud.owned; ++i) {
    for (const int j : w.neighbours.of(i)) {
      const double label =
          1 + std::fmod(0.618 * static_cast<double>(cloud.id[i]) + 0.414 * static_cast<double>(cloud.id[j]), 1.0);
      terms.push_back(weight(w, i, j) * label);
    }
  }
  return sum(cloud.comm, terms);
}

TEST(CorrectionParallel, GivesTheSameBitsOnAnyNumberOfRanks) {
  for (const auto& points : {std::vector<std::int64_t>{15}, {14, 9}, {8, 7, 6}}) {
    for (const bool on_walls : {true, false}) {
      const BoxOptions options{.jitter = 0.2, .support = 2.4, .on_walls = on_walls};
      BoxOptions shared = options;
      shared.comm = MPI_COMM_WORLD;
      const Cloud alone = box_cloud(points, 0.1, options), split = box_cloud(points, 0.1, shared);
      const auto a = sph_weights(alone, 1.2), b = sph_weights(split, 1.2);
      EXPECT_EQ(checksum(alone, a), checksum(split, b));
      EXPECT_EQ(a.report.lambda_iterations, b.report.lambda_iterations);
      EXPECT_EQ(a.report.moment_iterations, b.report.moment_iterations);
      EXPECT_EQ(a.report.residual, b.report.residual);
    }
  }
}

TEST(CorrectionParallel, StandsRanksWithoutPoints) {
  const Cloud cloud = box_cloud({2, 2}, 0.1, {.support = 2.4, .comm = MPI_COMM_WORLD});
  EXPECT_LE(sph_weights(cloud, 1).report.residual, 1e-13);
  EXPECT_LE(sph_weights(cloud, 1.2).report.residual, 1e-12);
}

}  // namespace
}  // namespace calor
