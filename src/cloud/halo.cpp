#include <petscsf.h>

#include <algorithm>
#include <vector>

#include "base/parallel.hpp"
#include "base/petsc.hpp"
#include "cloud/cloud.hpp"

namespace calor {
namespace {

MPI_Comm comm_of(PetscSF forest) { return PetscObjectComm(reinterpret_cast<PetscObject>(forest)); }

void broadcast(PetscSF forest, MPI_Datatype unit, const void* owned, void* ghosts, CallSite at) {
  check_collective(comm_of(forest), at);
  petsc::check(PetscSFBcastBegin(forest, unit, owned, ghosts, MPI_REPLACE));
  petsc::check(PetscSFBcastEnd(forest, unit, owned, ghosts, MPI_REPLACE));
}

}  // namespace

Halo::Halo(MPI_Comm comm, int owned, std::span<const std::int64_t> ghost_global) : owned_(owned) {
  if (size_of(comm) == 1) return;
  const std::vector<std::int64_t> first = gather(comm, std::vector{offset(comm, owned)});
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

void Halo::update(std::span<double> values, CallSite at) const {
  if (forest_) broadcast(forest_.get(), MPIU_REAL, values.data(), values.data() + owned_, at);
}

void Halo::update(std::span<Vec3> values, CallSite at) const {
  if (!forest_) return;
  MPI_Datatype vector = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(3, MPI_DOUBLE, &vector);
  MPI_Type_commit(&vector);
  broadcast(forest_.get(), vector, values.data(), values.data() + owned_, at);
  MPI_Type_free(&vector);
}

void Halo::raise(std::span<double> values, CallSite at) const { reduce(values, MPI_MAX, at); }
void Halo::add_up(std::span<double> values, CallSite at) const { reduce(values, MPI_SUM, at); }

void Halo::reduce(std::span<double> values, MPI_Op operation, CallSite at) const {
  if (!forest_) return;
  check_collective(comm_of(forest_.get()), at);
  petsc::check(PetscSFReduceBegin(forest_.get(), MPIU_REAL, values.data() + owned_, values.data(), operation));
  petsc::check(PetscSFReduceEnd(forest_.get(), MPIU_REAL, values.data() + owned_, values.data(), operation));
  update(values, at);
}

}  // namespace calor
