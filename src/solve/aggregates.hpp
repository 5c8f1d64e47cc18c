#pragma once
// Aggregates of points for multigrid, and the matrices of temperatures that are equal within them.
#include <petscksp.h>
#include <petscsf.h>

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/petsc.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// The bin of a row. Points of different spacing are in bins of different width, in powers of two: their class.
struct Bin {
  std::array<int, 3> width = {};  ///< class along every axis
  std::array<std::int64_t, 3> place = {};
  auto operator<=>(const Bin&) const = default;  // NOLINT(modernize-use-nullptr): of what the compiler writes
};

/// Bins of the owned points themselves, about one each. Collective.
std::vector<Bin> bins_of(const Cloud& cloud);

/// The rows of a matrix that this rank owns, of one level of multigrid. Columns are numbered as the rows, those of
/// other ranks after them, in the order of their global numbers.
class MatrixRows {
 public:
  /// Of the owned rows of an AIJ matrix, which must stay as it is until they are dropped. Collective.
  explicit MatrixRows(Mat matrix);
  /// Sums over aggregates of rows and columns, times a factor. Collective.
  MatrixRows(const MatrixRows& fine, std::span<const std::int32_t> aggregate_of, std::int32_t aggregates,
             double factor);

  std::int32_t count() const { return count_; }
  std::int64_t global_count() const { return global_count_; }
  std::int32_t columns() const { return count_ + static_cast<std::int32_t>(others_.size()); }
  std::int64_t entries() const { return own_.count(count_) + other_.count(count_); }
  MPI_Comm comm() const { return comm_; }

  /// Calls visit(j, a_ij) with the entries of row i that are not 0, by ascending columns.
  template <class Visit>
  void for_each_entry(std::int32_t i, const Visit& visit) const {
    for (const Block* block : {&own_, &other_})
      for (PetscInt n = block->begin(i); n < block->begin(i + 1); ++n)
        if (block->value[n] != 0) visit(block->first_column + block->column[n], block->value[n]);
  }
  std::vector<double> diagonal() const;
  /// Is there an entry off the diagonal?
  bool is_coupled(std::int32_t i) const;
  /// Values of the rows, on entry those of `columns` up to count(), become those of the other ranks' columns.
  /// Collective.
  template <class Value>
  void update(MPI_Datatype type, std::vector<Value>& of_columns) const {
    if (!exchange_) return;
    Value *own = of_columns.data(), *other = own + count_;
    petsc::check(PetscSFBcastBegin(exchange_, type, own, other, MPI_REPLACE));
    petsc::check(PetscSFBcastEnd(exchange_, type, own, other, MPI_REPLACE));
  }
  /// As a PETSc matrix. Collective.
  petsc::Matrix assembled() const;
  /// Frees what the entries take; the rest stays.
  void drop_entries();

 private:
  /// Compressed rows that lie elsewhere; none: no entries.
  struct Block {
    const PetscInt *row = nullptr, *column = nullptr;
    const PetscScalar* value = nullptr;
    std::int32_t first_column = 0;

    Block() = default;
    Block(Mat matrix, std::int32_t first);
    PetscInt begin(std::int32_t i) const { return row ? row[i] : 0; }
    PetscInt count(std::int32_t rows) const { return begin(rows); }
  };

  std::int32_t local(std::int64_t column) const;
  void number_rows();
  void connect();

  MPI_Comm comm_;
  Block own_, other_;  ///< columns of this rank, or all; and of other ranks
  std::vector<PetscInt> row_, column_;
  std::vector<double> value_;  ///< of a coarse level, to which own_ points
  petsc::Handle<PetscLayout, PetscLayoutDestroy> layout_;
  std::int32_t count_ = 0;
  std::int64_t first_ = 0, global_count_ = 0;
  std::vector<std::int64_t> others_;                 ///< global numbers of the columns of other ranks
  petsc::Handle<PetscSF, PetscSFDestroy> exchange_;  ///< of more than one rank
};

/// The aggregate of every row, and their bins: the rows in bins twice as wide along the axes along which they are
/// coupled strongly. Rows that couple to nothing belong to none, -1: a sweep solves them. Collective.
std::vector<std::int32_t> aggregate(const MatrixRows& rows, std::vector<Bin>& bins);

}  // namespace calor
