#include "base/petsc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <string>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace calor::petsc {
namespace {

std::exception_ptr held;
std::string message;

PetscErrorCode collect(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type,
                       const char* text, void*) {
  if (type == PETSC_ERROR_INITIAL) message = text ? text : "";
  return code;
}

template <class Object>
MPI_Comm comm_of(Object object) {
  return PetscObjectComm(reinterpret_cast<PetscObject>(object));
}

}  // namespace

void collect_errors() { check(PetscPushErrorHandler(collect, nullptr)); }

void check(PetscErrorCode code, const char* file, int line) {
  if (code == 0) return;
  const std::string said = std::exchange(message, "");
  if (held) std::rethrow_exception(std::exchange(held, nullptr));
  const char* kind = nullptr;
  PetscErrorMessage(code, &kind, nullptr);
  const std::string path = file;
  if (code == PETSC_ERR_MEM) throw std::bad_alloc();
  throw Error(Fault::numbers,
              fmt::format("PETSc failed ({}:{}): {}{}{}", path.substr(path.rfind('/') + 1), line,
                          kind ? kind : "unknown error", said.empty() ? "" : ": ", said),
              "please report this, with the case file");
}

PetscErrorCode hold_exception() {
  held = std::current_exception();
  return PETSC_ERR_USER;
}

bool is_finalized() {
  PetscBool finalized = PETSC_FALSE;
  PetscFinalized(&finalized);
  return finalized == PETSC_TRUE;
}

void copy(std::span<const double> from, Vec to) { std::ranges::copy(from, View<double>(to).values().begin()); }

void copy(Vec from, std::span<double> to) {
  const View<const double> view(from);
  std::copy_n(view.values().begin(), to.size(), to.begin());
}

Vector create_vector(Mat matrix) {
  Vector vector;
  check(MatCreateVecs(matrix, nullptr, vector.out()));
  return vector;
}

Matrix create_matrix(MPI_Comm comm, int rows) {
  Matrix matrix;
  check(MatCreate(comm, matrix.out()));
  check(MatSetSizes(matrix, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(matrix, MATAIJ));
  return matrix;
}

void reserve(Mat matrix, std::span<const PetscInt> diagonal, std::span<const PetscInt> off_diagonal) {
  // Each does nothing to a matrix of the other kind.
  check(MatSeqAIJSetPreallocation(matrix, 0, diagonal.data()));
  check(MatMPIAIJSetPreallocation(matrix, 0, diagonal.data(), 0, off_diagonal.data()));
}

Matrix create_matrix(MPI_Comm comm, std::span<const PetscInt> diagonal, std::span<const PetscInt> off_diagonal) {
  Matrix matrix = create_matrix(comm, static_cast<int>(diagonal.size()));
  reserve(matrix, diagonal, off_diagonal);
  return matrix;
}

void assemble(Mat matrix, CallSite at) {
  check_collective(comm_of(matrix), at);
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

void RowAdder::add(std::int64_t row, std::span<const std::int32_t> columns, std::span<const double> values,
                   double factor) {
  columns_.clear(), scaled_.clear();
  for (const std::int32_t j : columns) columns_.push_back(number_[j]);  // PETSc skips -1
  for (const double value : values) scaled_.push_back(factor * value);
  const auto number = static_cast<PetscInt>(row);
  check(MatSetValues(matrix_, 1, &number, static_cast<PetscInt>(columns_.size()), columns_.data(), scaled_.data(),
                     ADD_VALUES));
}

double unit_of(double size) { return size > 0 && std::isfinite(size) ? std::exp2(std::ilogb(size) - 40) : 1; }

void factorise(KSP solver, std::int64_t rows, bool symmetric) {
  constexpr std::int64_t few = 5'000;
  PC preconditioner = nullptr;
  check(KSPGetPC(solver, &preconditioner));
  check(KSPSetType(solver, KSPPREONLY));
  const bool alone = size_of(comm_of(solver)) == 1;
  if (!alone && rows <= few) {
    check(PCSetType(preconditioner, PCREDUNDANT));  // with LU inside
    return;
  }
  check(PCSetType(preconditioner, symmetric ? PCCHOLESKY : PCLU));
  check(PCFactorSetMatSolverType(preconditioner, alone ? MATSOLVERPETSC : MATSOLVERMUMPS));
}

bool solve(KSP solver, Vec b, Vec x, CallSite at) {
  check_collective(comm_of(solver), at);
  check(KSPSolve(solver, b, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(solver, &reason));
  return reason > 0;
}

}  // namespace calor::petsc
