#include "conduction/pair_rows.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "conduction/pair_flux.hpp"

namespace calor {
namespace {

/// Shorter runs go into groups.
constexpr int shortest_run = 8;

/// Is row b row a, b - a farther?
bool is_repeated(const Neighbours& rows, std::span<const double> G, std::int32_t a, std::int32_t b) {
  const std::int64_t n = rows.row[a], m = rows.row[b], count = rows.row[a + 1] - n;
  if (rows.row[b + 1] - m != count) return false;
  for (std::int64_t e = 0; e < count; ++e)
    if (rows.column[m + e] - b != rows.column[n + e] - a || G[m + e] != G[n + e]) return false;
  return true;
}

std::size_t hash_of_row(const Neighbours& rows, std::span<const double> G, std::int32_t i) {
  std::size_t hash = 0;
  for (std::int64_t n = rows.row[i]; n < rows.row[i + 1]; ++n)
    for (const std::size_t part : {std::hash<std::int32_t>()(rows.column[n] - i), std::hash<double>()(G[n])})
      hash = (hash ^ part) * 0x9e3779b97f4a7c15;
  return hash;
}

/// sum[b] += sum over the stencil of the fluxes into `width` consecutive points, `blocks` times.
template <int width, int blocks, class Flux>
CALOR_ALWAYS_INLINE inline void add_stencil(const Flux& flux, std::int64_t first, const std::int32_t* offset,
                                            const double* weight, int count, double* F) {
  using State = decltype(flux.at(Consecutive<width>{0}));
  State own[blocks];
  Doubles<width> sum[blocks];
  for (int b = 0; b < blocks; ++b) own[b] = flux.at(Consecutive<width>{first + b * width}), sum[b] = Doubles<width>{};
  for (int n = 0; n < count; ++n) {
    const double G = weight[n];
    const std::int64_t neighbour = first + offset[n];
#pragma GCC unroll 8
    for (int b = 0; b < blocks; ++b)
      sum[b] += G * Flux::between(own[b], flux.at(Consecutive<width>{neighbour + b * width}));
  }
  for (int b = 0; b < blocks; ++b) *reinterpret_cast<UnalignedDoubles<width>*>(F + b * width) += sum[b];
}

}  // namespace

std::vector<double> PairRows::weights_of(const Neighbours& neighbours) {
  const std::size_t entries = neighbours.column.size();
  std::vector<double> G;
  G.reserve(entries + entries / 4);
  G.resize(entries);
  return G;
}

PairRows::PairRows(Neighbours neighbours, std::vector<double> G) {
  const auto rows = static_cast<std::int32_t>(neighbours.row.size() - 1);
  entries_ = static_cast<std::int64_t>(neighbours.column.size());
  where_.resize(rows);
  std::unordered_multimap<std::size_t, std::int32_t> known;  // runs by the hash of their rows
  std::vector<std::int32_t> others;
  for (std::int32_t i = 0, end = 0; i < rows; i = end) {
    for (end = i + 1; end < rows && is_repeated(neighbours, G, i, end);) ++end;
    if (end - i < shortest_run) {
      for (std::int32_t row = i; row < end; ++row) others.push_back(row);
      continue;
    }
    Run run{.first = i, .length = end - i, .begin = static_cast<std::int32_t>(offset_.size()), .end = 0};
    const std::size_t hash = hash_of_row(neighbours, G, i);
    const auto [from, to] = known.equal_range(hash);
    const auto same =
        std::find_if(from, to, [&](const auto& k) { return is_repeated(neighbours, G, runs_[k.second].first, i); });
    if (same != to) {
      run.begin = runs_[same->second].begin, run.end = runs_[same->second].end;
    } else {
      for (std::int64_t n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
        offset_.push_back(neighbours.column[n] - i), stencil_.push_back(G[n]);
      run.end = static_cast<std::int32_t>(offset_.size());
      known.emplace(hash, static_cast<std::int32_t>(runs_.size()));
    }
    std::fill(where_.begin() + i, where_.begin() + end, static_cast<std::int32_t>(runs_.size()));
    runs_.push_back(run);
  }
  column_ = std::move(neighbours.column), weight_ = std::move(G);
  pack_groups(neighbours.row, others);
}

void PairRows::pack_groups(std::span<const std::int64_t> start, std::span<const std::int32_t> rows) {
  const auto length = [&](std::int32_t i) { return static_cast<std::int32_t>(start[i + 1] - start[i]); };
  std::int64_t used = 0;  // the rows of runs leave
  for (const std::int32_t i : rows) {
    if (used != start[i]) {
      std::copy_n(column_.begin() + start[i], length(i), column_.begin() + used);
      std::copy_n(weight_.begin() + start[i], length(i), weight_.begin() + used);
    }
    used += length(i);
  }

  std::int64_t size = 0;
  for (std::size_t first = 0; first < rows.size(); first += lanes) {
    Group group{.begin = size, .end = size, .row = {}, .count = {}};
    std::int32_t longest = 0;
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const std::int32_t i = rows[std::min(first + lane, rows.size() - 1)];
      group.row[lane] = i;
      if (first + lane >= rows.size()) continue;
      group.count[lane] = length(i);
      where_[i] = -1 - static_cast<std::int32_t>(first + lane);
      longest = std::max(longest, group.count[lane]);
    }
    group.end = size += std::int64_t{lanes} * longest;
    groups_.push_back(group);
  }

  // Groups begin no earlier than their rows did, so from the last one on nothing is overwritten that is still wanted.
  column_.resize(size), weight_.resize(size);
  std::vector<std::int32_t> columns;
  std::vector<double> weights;
  for (std::size_t g = groups_.size(); g-- > 0;) {
    const Group& group = groups_[g];
    const std::int64_t count = std::accumulate(group.count, group.count + lanes, std::int64_t{0});
    used -= count;
    columns.assign(column_.begin() + used, column_.begin() + used + count);
    weights.assign(weight_.begin() + used, weight_.begin() + used + count);
    for (std::int64_t lane = 0, first = 0; lane < lanes; first += group.count[lane++]) {
      for (std::int64_t e = group.begin + lane, n = 0; e < group.end; e += lanes, ++n) {
        const bool is_there = n < group.count[lane];
        column_[e] = is_there ? columns[first + n] : group.row[lane];
        weight_[e] = is_there ? weights[first + n] : 0;
      }
    }
  }
  // What the rows of runs took goes back; room for a few entries more was never touched.
  if (static_cast<std::int64_t>(column_.capacity()) > size + size / 4) column_.shrink_to_fit();
  if (static_cast<std::int64_t>(weight_.capacity()) > size + size / 4) weight_.shrink_to_fit();
}

std::size_t PairRows::memory() const {
  const auto bytes = [](const auto&... array) { return ((array.size() * sizeof(array[0])) + ...); };
  return bytes(where_, runs_, offset_, stencil_, groups_, column_, weight_);
}

void PairRows::read(int i, Row& row) const {
  row.column.clear(), row.weight.clear();
  for_each_entry(i, [&](std::int32_t j, double G) { row.column.push_back(j), row.weight.push_back(G); });
}

void PairRows::read_columns(int i, std::vector<std::int32_t>& columns) const {
  columns.clear();
  for_each_entry(i, [&](std::int32_t j, double /*G*/) { columns.push_back(j); });
}

template <int width, class Flux>
CALOR_ALWAYS_INLINE inline void PairRows::add_runs(const Flux& flux, double* F) const {
  constexpr int blocks = 4, long_block = blocks * width;  // so many that additions of several overlap
  for (const Run& run : runs_) {
    const std::int32_t *offset = offset_.data() + run.begin, count = run.end - run.begin;
    const double* weight = stencil_.data() + run.begin;
    const std::int32_t end = run.first + run.length;
    std::int32_t i = run.first;
    for (; i + long_block <= end; i += long_block) add_stencil<width, blocks>(flux, i, offset, weight, count, F + i);
    for (; i + lanes <= end; i += lanes) add_stencil<width, lanes / width>(flux, i, offset, weight, count, F + i);
    if (i == end) continue;
    // The last points together with some before them, of which only they are wanted.
    double last[lanes] = {};
    add_stencil<width, lanes / width>(flux, end - lanes, offset, weight, count, last);
    for (; i < end; ++i) F[i] += last[lanes - (end - i)];
  }
}

template <int width, class Flux>
CALOR_ALWAYS_INLINE inline void PairRows::add_groups(const Flux& flux, double* F) const {
  constexpr int blocks = lanes / width;
  const std::int32_t* column = column_.data();
  const double* weight = weight_.data();
  for (const Group& group : groups_) {
    using State = decltype(flux.at(Gathered<width>{nullptr}));
    State own[blocks];
    Doubles<width> sum[blocks] = {};
    for (int b = 0; b < blocks; ++b) own[b] = flux.at(Gathered<width>{group.row + b * width});
    for (std::int64_t n = group.begin; n < group.end; n += lanes) {
#pragma GCC unroll 8
      for (int b = 0; b < blocks; ++b)
        sum[b] += Consecutive<width>{n + b * width}(weight)*Flux::between(
            own[b], flux.at(Gathered<width>{column + n + b * width}));
    }
    for (int lane = 0; lane < lanes; ++lane) F[group.row[lane]] += sum[lane / width][lane % width];
  }
}

template <class Flux>
void PairRows::add(const Flux& flux, std::span<double> F, InstructionSet set) const {
  run_vectorised(
      [&]<int width>() CALOR_ALWAYS_INLINE {
        add_runs<width>(flux, F.data());
        add_groups<width>(flux, F.data());
      },
      set);
}

void PairRows::add_fluxes(const Conductivity& k, std::span<const double> T, std::span<double> F,
                          InstructionSet set) const {
  with_flux(k, T, [&](const auto& flux) { add(flux, F, set); });
}

void PairRows::add_flux_changes(const Conductivity& k, std::span<const double> dk, std::span<const double> T,
                                std::span<double> F) const {
  if (k.mean == Mean::arithmetic)  // its change is the mean of the changes
    add(ArithmeticFlux{dk.data(), T.data()}, F, best_instruction_set());
  else
    add(HarmonicChange{k.k.data(), dk.data(), T.data()}, F, best_instruction_set());
}

}  // namespace calor
