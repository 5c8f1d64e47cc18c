#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "conduction/pair_rows.hpp"
#include "method_clouds.hpp"

namespace calor {
namespace {

/// Rows of a cloud with random symmetric weights, or of a lattice with its own.
struct Rows {
  Cloud cloud;
  Neighbours neighbours;
  std::vector<double> G;
  PairRows packed;

  Rows(Cloud c, double support, bool random) : cloud(std::move(c)), neighbours(find_neighbours(cloud, support)) {
    for (int i = 0; i < cloud.owned; ++i)
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
        const Vec3 r = neighbours.x_ji(cloud.x, i, n);
        const double distance = std::round(1e6 * dot(r, r));
        const auto ids = std::minmax(cloud.id[i], cloud.id[neighbours.column[n]]);
        const double noise = random ? std::sin(1.0 + 17.0 * static_cast<double>(ids.first + 3 * ids.second)) : 0;
        G.push_back(1 / (1 + distance) + 0.1 * noise);
      }
    packed = PairRows(neighbours, G);
  }
};

std::vector<Rows> examples(MPI_Comm comm = MPI_COMM_SELF) {
  std::vector<Rows> all;
  all.emplace_back(box_cloud({40, 9, 6}, 0.1, {.comm = comm}), 2.3, false);  // runs and what lies at walls
  all.emplace_back(box_cloud({37, 11}, 0.1, {.comm = comm}), 2.1, true);     // no row like another
  all.emplace_back(box_cloud({200}, 0.1, {.comm = comm}), 2.1, false);       // one run
  all.emplace_back(box_cloud({9, 8, 7}, 0.1, {.jitter = 0.2, .comm = comm}), 1.9, true);
  all.emplace_back(box_cloud({3, 2}, 0.1, {.comm = comm}), 1.5, false);  // fewer rows than lanes
  return all;
}

struct State {
  std::vector<double> T, k, theta;

  explicit State(const Cloud& cloud) {
    for (int i = 0; i < cloud.local(); ++i) {
      const double value = std::sin(1.0 + 0.37 * static_cast<double>(cloud.id[i]));
      T.push_back(300 + 100 * value), k.push_back(2 + value * value), theta.push_back(50 + 7 * value);
    }
  }
  Conductivity with(Mean mean) const { return {.mean = mean, .k = k, .dk_dT = {}, .theta = theta}; }
  double flux(Mean mean, int i, int j) const {
    if (mean == Mean::integral) return theta[j] - theta[i];
    const double kbar = mean == Mean::arithmetic ? (k[i] + k[j]) / 2 : 2 / (1 / k[i] + 1 / k[j]);
    return kbar * (T[j] - T[i]);
  }
};

constexpr Mean means[] = {Mean::integral, Mean::arithmetic, Mean::harmonic};

TEST(PairRows, AreReadAsTheyWereGiven) {
  for (const Rows& r : examples()) {
    EXPECT_EQ(r.packed.count(), r.cloud.owned);
    EXPECT_EQ(r.packed.entries(), static_cast<std::int64_t>(r.G.size()));
    PairRows::Row row;
    std::vector<std::int32_t> columns;
    for (int i = 0; i < r.cloud.owned; ++i) {
      r.packed.read(i, row);
      r.packed.read_columns(i, columns);
      const auto given = r.neighbours.of(i);
      ASSERT_TRUE(std::ranges::equal(row.column, given));
      ASSERT_EQ(columns, row.column);
      ASSERT_TRUE(std::equal(row.weight.begin(), row.weight.end(), r.G.begin() + r.neighbours.row[i]));
    }
  }
}

TEST(PairRows, SumTheFluxesOfAllPairsWithEveryMeanAndInstructionSet) {
  for (const Rows& r : examples()) {
    const State state(r.cloud);
    for (const Mean mean : means) {
      std::vector<double> wanted(r.cloud.owned, 1.0);
      double size = 0;
      for (int i = 0; i < r.cloud.owned; ++i) {
        for (auto n = r.neighbours.row[i]; n < r.neighbours.row[i + 1]; ++n)
          wanted[i] += r.G[n] * state.flux(mean, i, r.neighbours.column[n]);
        size = std::max(size, std::abs(wanted[i]));
      }
      for (const auto set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
        if (set > best_instruction_set()) continue;
        std::vector<double> F(r.cloud.owned, 1.0);
        r.packed.add_fluxes(state.with(mean), state.T, F, set);
        for (int i = 0; i < r.cloud.owned; ++i) ASSERT_NEAR(F[i], wanted[i], 1e-13 * size) << name_of(set);
      }
    }
  }
}

TEST(PairRows, ConserveHeatToRoundOffAndLeaveAUniformTemperatureAlone) {
  for (const Rows& r : examples()) {
    State state(r.cloud);
    for (const Mean mean : means) {
      std::vector<double> F(r.cloud.owned);
      r.packed.add_fluxes(state.with(mean), state.T, F);
      double sum = 0, size = 0;
      for (const double f : F) sum += f, size += std::abs(f);
      EXPECT_LE(std::abs(sum), 1e-14 * size);
    }
    std::ranges::fill(state.T, 273.15), std::ranges::fill(state.theta, 0.1);
    for (const Mean mean : means) {
      std::vector<double> F(r.cloud.owned);
      r.packed.add_fluxes(state.with(mean), state.T, F);
      EXPECT_TRUE(std::ranges::all_of(F, [](double f) { return f == 0; }));
    }
  }
}

TEST(PairRowsParallel, SumARowToTheSameBitsOnAnyNumberOfRanks) {
  const auto parts = examples(MPI_COMM_WORLD), whole = examples();
  for (std::size_t e = 0; e < parts.size(); ++e) {
    for (const Mean mean : means) {
      const auto rates = [&](const Rows& r) {
        std::vector<double> F(r.cloud.owned), by_id(whole[e].cloud.owned);
        const State state(r.cloud);
        r.packed.add_fluxes(state.with(mean), state.T, F);
        for (int i = 0; i < r.cloud.owned; ++i) by_id[r.cloud.id[i]] = F[i];
        return by_id;
      };
      const std::vector<double> here = rates(parts[e]), all = rates(whole[e]);
      for (int i = 0; i < parts[e].cloud.owned; ++i) {
        const auto id = parts[e].cloud.id[i];
        ASSERT_EQ(here[id], all[id]);
      }
    }
  }
}

}  // namespace
}  // namespace calor
