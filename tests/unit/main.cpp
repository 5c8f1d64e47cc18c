// GoogleTest under PETSc and MPI; on several ranks only rank 0 prints, and one failing rank fails the run.
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/petsc.hpp"
#include "base/single_process.hpp"

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace {

/// What MPI and PETSc take when they start they keep, and unload in the end what a leak could be blamed on. So the leak
/// sanitizer looks at what is taken in between.
void start(int* argc, char*** argv) {
#ifdef __SANITIZE_ADDRESS__
  const __lsan::ScopedDisabler unseen;
#endif
  const calor::SingleProcess alone;
  PetscInitialize(argc, argv, nullptr, nullptr);
}

bool leaks() {
#ifdef __SANITIZE_ADDRESS__
  return __lsan_do_recoverable_leak_check() != 0;
#else
  return false;
#endif
}

}  // namespace

int main(int argc, char** argv) {
  // Properties are tried on the same random inputs each time, unless told otherwise: RC_PARAMS="seed=7".
  setenv("RC_PARAMS", "seed=1", 0);
  ::testing::InitGoogleTest(&argc, argv);
  start(&argc, &argv);
  calor::petsc::collect_errors();
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
  if (rank != 0) delete listeners.Release(listeners.default_result_printer());
  int failed = RUN_ALL_TESTS();
  if (leaks()) failed = 1;
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  PetscFinalize();
  return failed;
}
