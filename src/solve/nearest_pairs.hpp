#pragma once
// A thin matrix in the place of that of many neighbours, for a preconditioner.
#include <cstdint>
#include <utility>
#include <vector>

#include "base/petsc.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// The entries of a matrix between points next to each other, times what makes linear temperatures flow as much as by
/// all entries; the sums of rows stay. The rows are those of the points.
class NearestPairs {
 public:
  explicit NearestPairs(const Cloud& cloud);

  /// Makes or renews the thin matrix. False where it would be no thinner, or leave a row without a neighbour. `matrix`
  /// has the same pattern every time. Collective.
  bool set(Mat matrix);
  Mat matrix() const { return thin_; }

 private:
  /// Square of the distance of an owned point to the one of a column, in spacings.
  double square(int i, PetscInt column) const;

  const Cloud& cloud_;
  std::vector<std::pair<std::int64_t, std::int32_t>> ghosts_;  ///< global and local numbers, sorted
  petsc::Matrix thin_;
};

}  // namespace calor
