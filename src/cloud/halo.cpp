#include <petscsf.h>

#include <algorithm>
#include <vector>

#include "base/parallel.hpp"
#include "base/petsc.hpp"
#include "cloud/cloud.hpp"

namespace calor {
namespace {

void broadcast(PetscSF forest, MPI_Datatype unit, const void* owned, void* ghosts) {
  petsc::check(PetscSFBcastBegin(forest, unit, owned, ghosts, MPI_REPLACE));
  petsc::check(PetscSFBcastEnd(forest, unit, owned, ghosts, MPI_REPLACE));
}

}  // namespace

Halo::Halo(MPI_Comm comm, int owned, std::span<const std::int64_t> ghost_global) : owned_(owned) {
  const int ranks = size_of(comm);
  if (ranks == 1) return;
  std::vector<std::int64_t> first(ranks);
  const std::int64_t mine = offset(comm, owned);
  MPI_Allgather(&mine, 1, MPI_INT64_T, first.data(), 1, MPI_INT64_T, comm);
  std::vector<PetscSFNode> owner(ghost_global.size());
  for (std::size_t n = 0; n < owner.size(); ++n) {
    const auto next = std::ranges::upper_bound(first, ghost_global[n]);
    owner[n].rank = static_cast<PetscInt>(next - first.begin()) - 1;
    owner[n].index = static_cast<PetscInt>(ghost_global[n] - *(next - 1));
  }
  PetscSF forest = nullptr;
  petsc::check(PetscSFCreate(comm, &forest));
  forest_ = std::shared_ptr<_p_PetscSF>(forest, [](PetscSF f) {
    if (!petsc::is_finalized()) PetscSFDestroy(&f);
  });
  petsc::check(PetscSFSetGraph(forest, owned, static_cast<PetscInt>(owner.size()), nullptr, PETSC_COPY_VALUES,
                               owner.data(), PETSC_COPY_VALUES));
  petsc::check(PetscSFSetUp(forest));
}

void Halo::update(std::span<double> values) const {
  if (forest_) broadcast(forest_.get(), MPIU_REAL, values.data(), values.data() + owned_);
}

void Halo::update(std::span<Vec3> values) const {
  if (!forest_) return;
  MPI_Datatype vector = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(3, MPI_DOUBLE, &vector);
  MPI_Type_commit(&vector);
  broadcast(forest_.get(), vector, values.data(), values.data() + owned_);
  MPI_Type_free(&vector);
}

void Halo::raise(std::span<double> values) const {
  if (!forest_) return;
  petsc::check(PetscSFReduceBegin(forest_.get(), MPIU_REAL, values.data() + owned_, values.data(), MPI_MAX));
  petsc::check(PetscSFReduceEnd(forest_.get(), MPIU_REAL, values.data() + owned_, values.data(), MPI_MAX));
  update(values);
}

}  // namespace calor
