#pragma once
// PETSc for C++: handles that own its objects, and calls whose failures become Errors. Whoever owns PETSc calls
// collect_errors() once, so that failures are told by these Errors alone and not by PETSc's traces too.
#include <petscsnes.h>

#include <concepts>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/parallel.hpp"

namespace calor::petsc {

/// From now on PETSc's messages wait for check() and are not printed.
void collect_errors();

/// Throws what a call to PETSc that failed has to say: the exception that waits in a callback, or Error(numbers) with
/// PETSc's own message.
void check(PetscErrorCode code, const char* file = __builtin_FILE(), int line = __builtin_LINE());

/// The current exception waits until C code has returned to check(). Returns the code that ends the C code.
PetscErrorCode hold_exception();

/// For callbacks, through whose C callers no exception may pass: they return what this returns.
PetscErrorCode callback(const std::invocable auto& work) {
  try {
    work();
  } catch (...) {
    return hold_exception();
  }
  return 0;
}

bool is_finalized();

/// Owns one object of PETSc, or none.
template <class Object, PetscErrorCode (*destroy)(Object*)>
class Handle {
 public:
  Handle() = default;
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Handle() {
    if (object_ && !is_finalized()) destroy(&object_);  // a destructor has nobody to tell of a failure
  }

  operator Object() const& { return object_; }
  operator Object() && = delete;  // it would not outlive the handle
  /// Where a function of PETSc puts a new object; the handle must be empty.
  Object* out() { return &object_; }

 private:
  Object object_ = nullptr;
};

using Matrix = Handle<Mat, MatDestroy>;
using Vector = Handle<Vec, VecDestroy>;
using LinearSolver = Handle<KSP, KSPDestroy>;
using NonlinearSolver = Handle<SNES, SNESDestroy>;

/// This rank's entries of a vector, to read or, where the type is not const, to write, while the view lives.
template <class Value>
class View {
 public:
  explicit View(Vec vector) : vector_(vector) {
    PetscInt size = 0;
    check(VecGetLocalSize(vector, &size));
    if constexpr (std::is_const_v<Value>)
      check(VecGetArrayRead(vector, &begin_));
    else
      check(VecGetArray(vector, &begin_));
    size_ = size;
  }
  ~View() {
    if constexpr (std::is_const_v<Value>)
      VecRestoreArrayRead(vector_, &begin_);
    else
      VecRestoreArray(vector_, &begin_);
  }
  View(const View&) = delete;
  View& operator=(const View&) = delete;
  std::span<Value> values() const { return {begin_, size_}; }

 private:
  Vec vector_;
  Value* begin_ = nullptr;
  std::size_t size_ = 0;
};

void copy(std::span<const double> from, Vec to);
void copy(Vec from, std::span<double> to);

/// Vectors that fit the rows of a matrix. Collective.
Vector create_vector(Mat matrix);

/// Square AIJ matrix: rows as `diagonal` is long, with at most so many entries in columns of this rank and of others.
/// Collective.
Matrix create_matrix(MPI_Comm comm, std::span<const PetscInt> diagonal, std::span<const PetscInt> off_diagonal);
/// One of so many rows on this rank that gets its entries later, by reserve(). Collective.
Matrix create_matrix(MPI_Comm comm, int rows);
void reserve(Mat matrix, std::span<const PetscInt> diagonal, std::span<const PetscInt> off_diagonal);
/// Collective.
void assemble(Mat matrix, CallSite at = CallSite::current());

/// Adds rows to a matrix. Columns are local indices; `number` has their place in the matrix, -1 for those that are left
/// out, and must outlive this.
class RowAdder {
 public:
  RowAdder(Mat matrix, const std::vector<PetscInt>& number) : matrix_(matrix), number_(number) {}
  /// Adds factor * values to the row of that number in the matrix.
  void add(std::int64_t row, std::span<const std::int32_t> columns, std::span<const double> values, double factor = 1);

 private:
  Mat matrix_;
  const std::vector<PetscInt>& number_;
  std::vector<PetscInt> columns_;
  std::vector<double> scaled_;
};

/// A unit for equations with a matrix of entries of about `size` (1 where that is not positive or not finite). PETSc
/// takes pivots below 2e-14 for zeros, in whatever unit: equations are handed to it divided by a power of two, which
/// costs no digit, far below their size, as pivots may be.
double unit_of(double size);
/// Makes a new solver factorise in place of iterating: Cholesky where the matrix is symmetric. On several ranks few
/// rows are factorised by every rank for itself, as messages would take much longer than that; many by MUMPS.
void factorise(KSP solver, std::int64_t rows, bool symmetric);
/// x = matrix^-1 b; false where that fails. b and x may be one vector. Collective.
bool solve(KSP solver, Vec b, Vec x, CallSite at = CallSite::current());

}  // namespace calor::petsc
