#include "base/parallel.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "base/error.hpp"
#include "errors.hpp"

namespace calor {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Numbers of both signs over many powers of ten; the same on every rank.
std::vector<double> wild_numbers(std::size_t n, double decades, unsigned seed = 1) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> exponent(-decades / 2, decades / 2), sign(-1, 1);
  std::vector<double> x(n);
  for (double& v : x) v = std::copysign(std::pow(10, exponent(random)), sign(random));
  return x;
}

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

/// The entries of `all` that a rank owns under three rules: blocks, deal like cards, everything on the last rank.
std::vector<double> share(const std::vector<double>& all, int rule, MPI_Comm comm) {
  const std::size_t rank = rank_of(comm), size = size_of(comm), n = all.size();
  if (rule == 0) return {all.begin() + n * rank / size, all.begin() + n * (rank + 1) / size};
  if (rule == 2) return rank + 1 == size ? all : std::vector<double>{};
  std::vector<double> mine;
  for (std::size_t i = rank; i < n; i += size) mine.push_back(all[i]);
  return mine;
}

TEST(ParallelSums, AreExactForWholeNumbers) {
  std::vector<double> x(100'000);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i + 1);
  EXPECT_EQ(sum(MPI_COMM_SELF, x), 5000050000.0);          // n (n + 1) / 2
  EXPECT_EQ(dot(MPI_COMM_SELF, x, x), 333338333350000.0);  // n (n + 1) (2 n + 1) / 6
}

TEST(ParallelSums, KeepSmallNumbersBesideLargeOnesThatCancel) {
  EXPECT_EQ(sum(MPI_COMM_SELF, std::vector<double>{1e16, 1, -1e16}), 1);        // left to right gives 0
  EXPECT_EQ(sum(MPI_COMM_SELF, std::vector<double>{0.1, 0.2, -0.3}), 0x1p-55);  // exact, in fractions
}

TEST(ParallelSums, OfNothingAndOfZerosAreZero) {
  EXPECT_EQ(sum(MPI_COMM_SELF, {}), 0);
  EXPECT_EQ(sum(MPI_COMM_SELF, std::vector<double>(5000, 0.0)), 0);
  EXPECT_TRUE(sums(MPI_COMM_SELF, {}, 0).empty());
}

TEST(ParallelSums, OfTheSmallestAndOfLargeNumbersAreExact) {
  const double smallest = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(sum(MPI_COMM_SELF, std::vector<double>(3000, smallest)), 3000 * smallest);
  EXPECT_EQ(sum(MPI_COMM_SELF, std::vector<double>(3000, 1e295)), 3000 * 1e295);
}

TEST(ParallelSums, BeyondTheRangeAreThoseOfAPlainLoop) {
  EXPECT_EQ(sum(MPI_COMM_SELF, std::vector<double>{1, inf, 2}), inf);
  EXPECT_EQ(sum(MPI_COMM_SELF, std::vector<double>{1, -inf, 2}), -inf);
  EXPECT_TRUE(std::isnan(sum(MPI_COMM_SELF, std::vector<double>{1, inf, -inf})));
  EXPECT_TRUE(std::isnan(sum(MPI_COMM_SELF, std::vector<double>{1, nan, 2})));
  EXPECT_TRUE(std::isnan(sum(MPI_COMM_SELF, std::vector<double>{nan})));
  EXPECT_EQ(sum(MPI_COMM_SELF, std::vector<double>{1e308, 1e308}), inf);
  EXPECT_EQ(sum(MPI_COMM_SELF, std::vector<double>{1.5e308, -1e308}), 0.5e308);
  EXPECT_TRUE(std::isnan(dot(MPI_COMM_SELF, std::vector<double>{0, 1}, std::vector<double>{inf, 1})));
}

RC_GTEST_PROP(ParallelSums, HaveTheSameBitsInAnyOrder, (std::vector<double> x, unsigned seed)) {
  const double before = sum(MPI_COMM_SELF, x);
  std::shuffle(x.begin(), x.end(), std::mt19937_64(seed));
  RC_ASSERT(bits(sum(MPI_COMM_SELF, x)) == bits(before));
}

TEST(ParallelSums, HaveTheSameBitsInAnyOrderOverManyBlocks) {
  for (const double decades : {0., 5., 40., 400.}) {
    std::vector<double> x = wild_numbers(20'000, decades);
    const double before = sum(MPI_COMM_SELF, x);
    for (unsigned seed = 0; seed < 5; ++seed) {
      std::shuffle(x.begin(), x.end(), std::mt19937_64(seed));
      EXPECT_EQ(bits(sum(MPI_COMM_SELF, x)), bits(before)) << decades;
    }
    std::ranges::sort(x);
    EXPECT_EQ(bits(sum(MPI_COMM_SELF, x)), bits(before)) << decades;
  }
}

TEST(ParallelSums, AreAsAccurateAsALoopInExtendedPrecision) {
  const std::vector<double> a = wild_numbers(50'000, 6, 2), b = wild_numbers(50'000, 6, 3);
  __float128 exact_sum = 0, exact_dot = 0, magnitude = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double product = a[i] * b[i];
    exact_sum += a[i];
    exact_dot += product;
    magnitude += std::abs(product);
  }
  EXPECT_EQ(sum(MPI_COMM_SELF, a), static_cast<double>(exact_sum));
  // Each product loses less than 2^-59 of the largest; they span 12 decades.
  EXPECT_NEAR(dot(MPI_COMM_SELF, a, b), static_cast<double>(exact_dot), 1e-16 * static_cast<double>(magnitude));
}

TEST(ParallelSums, OfColumnsAreTheSumsOfEachColumn) {
  const std::size_t rows = 3001;
  std::vector<std::vector<double>> columns;
  for (unsigned c = 0; c < 3; ++c) columns.push_back(wild_numbers(rows, 10, c));
  columns[1][17] = nan;  // stays in its column
  std::vector<double> table(3 * rows);
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t c = 0; c < 3; ++c) table[3 * i + c] = columns[c][i];
  }
  const std::vector<double> found = sums(MPI_COMM_SELF, table, 3);
  EXPECT_EQ(bits(found[0]), bits(sum(MPI_COMM_SELF, columns[0])));
  EXPECT_TRUE(std::isnan(found[1]));
  EXPECT_EQ(bits(found[2]), bits(sum(MPI_COMM_SELF, columns[2])));
}

TEST(ParallelSumsParallel, HaveTheSameBitsForEveryDistribution) {
  for (const double decades : {0., 12., 300.}) {
    const std::vector<double> a = wild_numbers(10'007, decades, 4), b = wild_numbers(10'007, decades / 2, 5);
    const double whole_sum = sum(MPI_COMM_SELF, a), whole_dot = dot(MPI_COMM_SELF, a, b);
    for (int rule = 0; rule < 3; ++rule) {
      const std::vector<double> mine = share(a, rule, MPI_COMM_WORLD), other = share(b, rule, MPI_COMM_WORLD);
      EXPECT_EQ(bits(sum(MPI_COMM_WORLD, mine)), bits(whole_sum)) << decades << ' ' << rule;
      EXPECT_EQ(bits(dot(MPI_COMM_WORLD, mine, other)), bits(whole_dot)) << decades << ' ' << rule;
    }
  }
}

TEST(ParallelSumsParallel, TellEveryRankOfANumberThatIsNotFinite) {
  const bool last = rank_of(MPI_COMM_WORLD) + 1 == size_of(MPI_COMM_WORLD);
  EXPECT_TRUE(std::isnan(sum(MPI_COMM_WORLD, std::vector<double>{last ? nan : 1.0})));
  EXPECT_EQ(sum(MPI_COMM_WORLD, std::vector<double>{last ? inf : 1.0}), inf);
}

TEST(ReductionsParallel, CountAndCompareOverAllRanks) {
  const int rank = rank_of(MPI_COMM_WORLD), size = size_of(MPI_COMM_WORLD);
  EXPECT_EQ(calor::max(MPI_COMM_WORLD, rank), size - 1);
  EXPECT_EQ(calor::min(MPI_COMM_WORLD, rank), 0);
  EXPECT_EQ(total(MPI_COMM_WORLD, rank + 1), size * (size + 1) / 2);
  EXPECT_EQ(offset(MPI_COMM_WORLD, rank + 1), rank * (rank + 1) / 2);
  EXPECT_TRUE(any(MPI_COMM_WORLD, rank == size - 1));
  EXPECT_FALSE(any(MPI_COMM_WORLD, false));
}

TEST(TogetherParallel, RunsTheWorkOnEveryRank) {
  int done = 0;
  collective_try(MPI_COMM_WORLD, [&] { done = 1; });
  EXPECT_EQ(done, 1);
}

TEST(TogetherParallel, ThrowsTheErrorOfTheLowestFailingRankOnAll) {
  const int size = size_of(MPI_COMM_WORLD), rank = rank_of(MPI_COMM_WORLD), lowest = size / 2;
  try {
    collective_try(MPI_COMM_WORLD, [&] {
      if (rank >= lowest) {
        throw Error(Fault::file, {"a.csv", rank, 7}, "rank " + std::to_string(rank) + " cannot read", "look there");
      }
    });
    FAIL() << "nothing was thrown";
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::file);
    EXPECT_EQ(e.location().file, "a.csv");
    EXPECT_EQ(e.location().line, lowest);
    EXPECT_EQ(e.location().column, 7);
    EXPECT_EQ(e.problem(), "rank " + std::to_string(lowest) + " cannot read");
    EXPECT_EQ(e.cure(), "look there");
  }
}

TEST(TogetherParallel, TurnsOtherExceptionsIntoErrors) {
  const bool last = rank_of(MPI_COMM_WORLD) + 1 == size_of(MPI_COMM_WORLD);
  try {
    collective_try(MPI_COMM_WORLD, [&] {
      if (last) throw std::runtime_error("out of luck");
    });
    FAIL() << "nothing was thrown";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "out of luck");
  }
}

TEST(CollectiveCallsParallel, GatherInTheOrderOfTheRanks) {
  const int rank = rank_of(MPI_COMM_WORLD), size = size_of(MPI_COMM_WORLD);
  const std::vector<int> all = gather(MPI_COMM_WORLD, std::vector<int>(rank, rank));  // none from rank 0
  ASSERT_EQ(static_cast<int>(all.size()), size * (size - 1) / 2);
  EXPECT_TRUE(std::ranges::is_sorted(all));
  EXPECT_EQ(std::ranges::count(all, size - 1), size - 1);
}

TEST(CollectiveCallsParallel, TakeTurns) {
  const int rank = rank_of(MPI_COMM_WORLD);
  EXPECT_EQ(in_turns(MPI_COMM_WORLD, 5, [](int before) { return 2 * before; }), 5 << (rank + 1));
}

TEST(CollectiveCallsParallel, OnDifferentLinesAreToldWithBothPlaces) {
  const int rank = rank_of(MPI_COMM_WORLD);
  if (size_of(MPI_COMM_WORLD) == 1 || !std::getenv("CALOR_CHECK_COLLECTIVES")) GTEST_SKIP() << "nothing to compare";
  const int here = __LINE__;
  const auto disagree = [&] {
    // Also where an error is expected on one rank alone.
    collective_try(MPI_COMM_WORLD, [&] {
      if (rank == 0)
        max(MPI_COMM_WORLD, 1.0);
      else
        any(MPI_COMM_WORLD, true);
    });
  };
  try {
    disagree();
    ADD_FAILURE() << "nobody noticed";
  } catch (const CollectiveMismatch& e) {
    expect_words(e.what(), {"rank 0: parallel_test.cpp:" + std::to_string(here + 5),
                            "rank 1: parallel_test.cpp:" + std::to_string(here + 7)});
  }
  EXPECT_EQ(total(MPI_COMM_WORLD, 1), size_of(MPI_COMM_WORLD));  // and all go on together
}

}  // namespace
}  // namespace calor
