// Multigrid by aggregation: its coarse matrices, and bodies that single precision is too little for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "case_models.hpp"
#include "solve/aggregates.hpp"

namespace calor {
namespace {

std::string heated_cube(const std::string& k) {
  return box_case({"1 m", "1 m", "1 m"}, {41, 41, 41}) + simple_material({.k = k}) +
         "[boundary.air]\non = \"xmin\"\nconvection = { h = \"1 W/(m^2 K)\", ambient = \"300 K\" }\n"
         "[source.q]\npower_density = \"1 W/m^3\"\n[initial]\ntemperature = \"300 K\"\n[steady]\n";
}

// P^T A P of aggregates of two rows, P = 1 within them: rows of A = (-1, 2, -1) add up to (-1, 2, -1).
TEST(AggregationMultigridParallel, AddsUpRowsAndColumnsOfAggregates) {
  MPI_Comm comm = MPI_COMM_WORLD;
  const int rank = rank_of(comm), ranks = size_of(comm), owned = rank == 1 ? 0 : 6;  // one has no rows
  const int first = 6 * (rank > 1 ? rank - 1 : rank), count = 6 * (ranks > 1 ? ranks - 1 : 1);
  const petsc::Matrix A = petsc::create_matrix(comm, std::vector<PetscInt>(owned, 3), std::vector<PetscInt>(owned, 2));
  for (PetscInt i = first; i < first + owned; ++i)
    for (PetscInt j = std::max(i - 1, 0); j <= std::min(i + 1, count - 1); ++j)
      petsc::check(MatSetValue(A, i, j, i == j ? 2 : -1, INSERT_VALUES));
  petsc::assemble(A);
  const MatrixRows fine(A);
  const std::vector<std::int32_t> aggregate_of = {0, 0, 1, 1, 2, 2};
  const MatrixRows coarse(fine, std::span(aggregate_of).first(owned), owned / 2, 0.5);
  EXPECT_EQ(coarse.global_count(), count / 2);
  const petsc::Matrix half = coarse.assembled();
  for (PetscInt i = first / 2; i < (first + owned) / 2; ++i) {
    PetscInt entries = 0;
    const PetscInt* column = nullptr;
    const PetscScalar* value = nullptr;
    petsc::check(MatGetRow(half, i, &entries, &column, &value));
    EXPECT_EQ(entries, (i > 0) + 1 + (i < count / 2 - 1));
    for (PetscInt n = 0; n < entries; ++n) {
      EXPECT_LE(std::abs(column[n] - i), 1);
      EXPECT_EQ(value[n], column[n] == i ? 1 : -0.5);
    }
    petsc::check(MatRestoreRow(half, i, &entries, &column, &value));
  }
}

// 1 W leaves by the wall of 1 m^2 and 1 W/(m^2 K), at 301 K; within, T - 301 K = (x - x^2/2) / k.
TEST(AggregationMultigridParallel, SolvesWhereNextToNothingHoldsTheLevelOfTheTemperatures) {
  for (const double k : {1.0, 1e4}) {
    const CaseModel model(heated_cube(std::to_string(static_cast<int>(k))), MPI_COMM_WORLD);
    const State state = model.steady();
    const Cloud& cloud = model.cloud();
    double off = 0;
    for (int i = 0; i < cloud.owned; ++i) {
      const double x = cloud.x[i].x;
      off = std::max(off, std::abs(state.T[i] - 301 - (x - x * x / 2) / k));
    }
    EXPECT_LE(max(cloud.comm, off), 1e-8) << k;
  }
}

}  // namespace
}  // namespace calor
