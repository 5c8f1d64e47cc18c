#pragma once
// Weights of pairs, row by row, packed for the sum that every explicit step is made of, F_i += sum_j G_ij flux_ij.
// Where a row repeats the row before it, all columns one farther and the weights the same to the last bit, as inside
// lattices, both share one stencil and a vector holds consecutive points. The other rows lie in groups of eight, one in
// a lane of a vector; they follow one another as the points do, whose neighbours then lie in the same lines of the
// cache. Either way a row is summed in the order of its neighbours: its sum has the same bits whichever way it is
// packed, hence on any number of ranks.
#include <cstdint>
#include <span>
#include <vector>

#include "base/simd.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/evaluation.hpp"

namespace calor {

class PairRows {
 public:
  PairRows() = default;
  /// Of the rows of `neighbours`, which have no images; G[n] belongs to neighbours.column[n]. Both are packed where
  /// they lie: on clouds they are by far the largest arrays of a run, and no second copy is made of them.
  PairRows(Neighbours neighbours, std::vector<double> G);
  /// A weight 0 for every entry, and room for those that fill up groups when the weights are packed; room that is never
  /// used costs no memory.
  static std::vector<double> weights_of(const Neighbours& neighbours);

  int count() const { return static_cast<int>(where_.size()); }
  std::int64_t entries() const { return entries_; }
  std::size_t memory() const;  ///< bytes

  struct Row {
    std::vector<std::int32_t> column;
    std::vector<double> weight;
  };
  /// Row i as it was given.
  void read(int i, Row& row) const;
  void read_columns(int i, std::vector<std::int32_t>& columns) const;
  /// Calls use(column, weight), which may be CALOR_ALWAYS_INLINE, for the entries of row i.
  template <class Use>
  CALOR_ALWAYS_INLINE void for_each_entry(int i, const Use& use) const {
    if (where_[i] >= 0) {
      const Run& run = runs_[where_[i]];
      for (std::int32_t n = run.begin; n < run.end; ++n) use(i + offset_[n], stencil_[n]);
      return;
    }
    const std::int32_t at = -1 - where_[i], lane = at % lanes;
    const Group& group = groups_[at / lanes];
    for (std::int64_t n = group.begin + lane, left = group.count[lane]; left > 0; n += lanes, --left)
      use(column_[n], weight_[n]);
  }

  /// F_i += sum_j G_ij kbar_ij (T_j - T_i) of all rows.
  void add_fluxes(const Conductivity& k, std::span<const double> T, std::span<double> F,
                  InstructionSet set = best_instruction_set()) const;
  /// F_i += sum_j G_ij dkbar_ij (T_j - T_i) of all rows, where dk changes the conductivities; not of the integral mean.
  void add_flux_changes(const Conductivity& k, std::span<const double> dk, std::span<const double> T,
                        std::span<double> F) const;

 private:
  static constexpr int lanes = 8;

  struct Run {
    std::int32_t first, length;  ///< rows
    std::int32_t begin, end;     ///< of its stencil
  };
  struct Group {
    std::int64_t begin, end;    ///< of its entries, lane by lane
    std::int32_t row[lanes];    ///< the last one again where there are fewer
    std::int32_t count[lanes];  ///< of entries; those beyond have weight 0 and the row as column
  };

  void pack_groups(std::span<const std::int64_t> start, std::span<const std::int32_t> rows);
  template <class Flux>
  void add(const Flux& flux, std::span<double> F, InstructionSet set) const;
  template <int width, class Flux>
  void add_runs(const Flux& flux, double* F) const;
  template <int width, class Flux>
  void add_groups(const Flux& flux, double* F) const;

  std::int64_t entries_ = 0;
  std::vector<std::int32_t> where_;  ///< of every row: its run, or -1 - (lanes * its group + its lane)
  std::vector<Run> runs_;
  std::vector<std::int32_t> offset_;  ///< column less row, of the stencils
  std::vector<double> stencil_;       ///< their weights
  std::vector<Group> groups_;
  std::vector<std::int32_t> column_;  ///< of the groups
  std::vector<double> weight_;
};

}  // namespace calor
