#include "solve/aggregation_multigrid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/petsc.hpp"
#include "solve/nearest_pairs.hpp"

namespace calor {
namespace {

using petsc::check;

/// Temperatures equal within aggregates make a body too stiff, on a lattice of bins twice as wide by 2 where they
/// change linearly. Less than that is safe where they do not.
constexpr double over_correction = 1.8;
constexpr std::int64_t coarsest = 1'000;  ///< rows that are solved directly
constexpr double least_coarsening = 0.7;  ///< rows of a level over those of the finer one that are still worth it
constexpr double weak = 0.25;             ///< coupling along an axis, over the strongest, that is no reason to coarsen

/// The bin of a row. Points of different spacing are in bins of different width, in powers of two: their class.
struct Bin {
  std::array<int, 3> width = {};  ///< class along every axis
  std::array<std::int64_t, 3> place = {};
  auto operator<=>(const Bin&) const = default;  // NOLINT(modernize-use-nullptr): of what the compiler writes
};

/// Bins of the points themselves, about one each. Collective.
std::vector<Bin> bins_of(const Cloud& cloud) {
  std::vector<Bin> bins(cloud.owned);
  for (std::size_t d = 0; d < 3; ++d) {
    double low = std::numeric_limits<double>::infinity(), least = low;
    for (int i = 0; i < cloud.owned; ++i) {
      low = std::min(low, cloud.x[i][d]);
      least = std::min(least, cloud.metric[i][d]);
    }
    low = min(cloud.comm, low), least = min(cloud.comm, least);
    for (int i = 0; i < cloud.owned; ++i) {
      const int width = static_cast<int>(std::lround(std::log2(cloud.metric[i][d] / least)));
      bins[i].width[d] = width;
      // Lattices start at `low`: a quarter of a bin keeps their points clear of the limits of bins.
      bins[i].place[d] = static_cast<std::int64_t>(std::floor((cloud.x[i][d] - low) / std::ldexp(least, width) + 0.25));
    }
  }
  return bins;
}

/// The rows of a matrix that this rank holds.
class Rows {
 public:
  explicit Rows(Mat matrix) : matrix_(matrix) { check(MatGetOwnershipRange(matrix, &first_, &end_)); }
  int count() const { return end_ - first_; }
  /// Calls visit(j, a_ij) with the columns of row i that this rank owns, numbered as the rows; returns whether there
  /// is any entry off the diagonal at all.
  template <class Visit>
  bool visit(int i, const Visit& visit) const {
    PetscInt count = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(matrix_, first_ + i, &count, &columns, &values));
    bool is_coupled = false;
    for (PetscInt n = 0; n < count; ++n) {
      if (columns[n] == first_ + i || values[n] == 0) continue;
      is_coupled = true;
      if (columns[n] >= first_ && columns[n] < end_) visit(columns[n] - first_, values[n]);
    }
    check(MatRestoreRow(matrix_, first_ + i, &count, &columns, &values));
    return is_coupled;
  }

 private:
  Mat matrix_;
  PetscInt first_ = 0, end_ = 0;
};

/// How strongly rows couple along every axis, over the strongest: sum |a_ij| (distance in bins)^2. Collective.
Vec3 coupling(MPI_Comm comm, const Rows& rows, std::span<const Bin> bins) {
  Vec3 sum;
  for (int i = 0; i < rows.count(); ++i)
    rows.visit(i, [&](int j, double a) {
      for (std::size_t d = 0; d < 3; ++d)
        if (bins[i].width[d] == bins[j].width[d]) {
          const auto distance = static_cast<double>(bins[j].place[d] - bins[i].place[d]);
          sum[d] += std::abs(a) * distance * distance;
        }
    });
  const std::array<double, 3> values = {sum.x, sum.y, sum.z};
  const std::vector<double> all = sums(comm, values, 3);
  const double largest = std::max({all[0], all[1], all[2]});
  return largest > 0 ? 1 / largest * Vec3{all[0], all[1], all[2]} : Vec3{};
}

/// The interpolation from aggregates, and their bins. Rows that couple to nothing belong to none: a sweep solves them.
/// Collective.
petsc::Matrix aggregate(MPI_Comm comm, const Rows& rows, std::vector<Bin>& bins) {
  const Vec3 strength = coupling(comm, rows, bins);
  // Aggregates as their rows come, then in the order of their bins.
  std::map<Bin, PetscInt> known;
  std::vector<PetscInt> aggregate_of(rows.count(), -1);
  for (int i = 0, last = -1; i < rows.count(); ++i) {
    for (std::size_t d = 0; d < 3; ++d)
      if (strength[d] > weak) bins[i].place[d] >>= 1;
    if (!rows.visit(i, [](int, double) {})) continue;
    aggregate_of[i] = last >= 0 && bins[i] == bins[last]
                          ? aggregate_of[last]
                          : known.try_emplace(bins[i], static_cast<PetscInt>(known.size())).first->second;
    last = i;
  }
  std::vector<Bin> aggregates;
  std::vector<PetscInt> place(known.size());
  for (const auto& [bin, aggregate] : known) {
    place[aggregate] = static_cast<PetscInt>(aggregates.size());
    aggregates.push_back(bin);
  }
  for (PetscInt& aggregate : aggregate_of)
    if (aggregate >= 0) aggregate = place[aggregate];
  petsc::Matrix interpolation;
  check(MatCreateAIJ(comm, rows.count(), static_cast<PetscInt>(aggregates.size()), PETSC_DETERMINE, PETSC_DETERMINE, 1,
                     nullptr, 0, nullptr, interpolation.out()));
  PetscInt first_row = 0, first_column = 0;
  check(MatGetOwnershipRange(interpolation, &first_row, nullptr));
  check(MatGetOwnershipRangeColumn(interpolation, &first_column, nullptr));
  for (int i = 0; i < rows.count(); ++i)
    if (aggregate_of[i] >= 0)
      check(MatSetValue(interpolation, first_row + i, first_column + aggregate_of[i], 1, INSERT_VALUES));
  petsc::assemble(interpolation);
  bins = std::move(aggregates);
  return interpolation;
}

std::int64_t rows_of(Mat matrix) {
  PetscInt rows = 0;
  check(MatGetSize(matrix, &rows, nullptr));
  return rows;
}

class Multigrid {
 public:
  Multigrid(const Cloud& cloud, bool is_thin) : cloud_(cloud), is_thin_already_(is_thin), near_(cloud) {}

  /// Collective.
  void set_up(Mat matrix) {
    const bool is_thin = !is_thin_already_ && near_.set(matrix);
    Mat finest = is_thin ? near_.matrix() : matrix;
    if (std::exchange(is_thin_, is_thin) == is_thin && cycle_)
      renew(finest);
    else
      build(finest);
    check(PCSetOperators(cycle_, finest, finest));
    check(PCSetUp(cycle_));
  }
  void apply(Vec x, Vec y) const { check(PCApply(cycle_, x, y)); }

 private:
  /// A coarser matrix and how values on it become those of the finer one.
  struct Coarser {
    petsc::Matrix interpolation, matrix;
  };

  void build(Mat finest) {
    levels_.clear(), cycle_ = {};
    std::vector<Bin> bins = bins_of(cloud_);
    Mat fine = finest;
    while (rows_of(fine) > coarsest) {
      Coarser next;
      next.interpolation = aggregate(cloud_.comm, Rows(fine), bins);
      check(MatPtAP(fine, next.interpolation, MAT_INITIAL_MATRIX, PETSC_DEFAULT, next.matrix.out()));
      check(MatScale(next.matrix, 1 / over_correction));
      const bool is_worth_it = rows_of(next.matrix) < least_coarsening * static_cast<double>(rows_of(fine));
      if (!is_worth_it) break;
      levels_.push_back(std::move(next));
      fine = levels_.back().matrix;
    }
    make_cycle(finest);
  }

  /// The same aggregates with the values of another matrix.
  void renew(Mat finest) {
    Mat fine = finest;
    for (Coarser& level : levels_) {
      check(MatPtAP(fine, level.interpolation, MAT_REUSE_MATRIX, PETSC_DEFAULT, level.matrix.out()));
      check(MatScale(level.matrix, 1 / over_correction));
      fine = level.matrix;
    }
  }

  void make_cycle(Mat finest) {
    check(PCCreate(cloud_.comm, cycle_.out()));
    check(PCSetType(cycle_, PCMG));
    const auto count = static_cast<PetscInt>(levels_.size()) + 1;
    check(PCMGSetLevels(cycle_, count, nullptr));
    check(PCMGSetCycleType(cycle_, PC_MG_CYCLE_W));
    check(PCMGSetDistinctSmoothUp(cycle_));
    for (PetscInt n = 0; n < count - 1; ++n) {  // n = 0: the finest; PETSc counts from the coarsest
      const PetscInt level = count - 1 - n;
      Mat matrix = n == 0 ? finest : static_cast<Mat>(levels_[n - 1].matrix);
      check(PCMGSetInterpolation(cycle_, level, levels_[n].interpolation));
      KSP before = nullptr, after = nullptr;
      check(PCMGGetSmootherDown(cycle_, level, &before));
      check(PCMGGetSmootherUp(cycle_, level, &after));
      one_sweep(before, matrix, SOR_LOCAL_FORWARD_SWEEP);
      one_sweep(after, matrix, SOR_LOCAL_BACKWARD_SWEEP);
    }
    KSP solver = nullptr;
    check(PCMGGetCoarseSolve(cycle_, &solver));
    Mat last = levels_.empty() ? finest : static_cast<Mat>(levels_.back().matrix);
    check(KSPSetOperators(solver, last, last));
    if (rows_of(last) <= 2 * coarsest) {
      petsc::factorise(solver, rows_of(last), false);
    } else {
      one_sweep(solver, last, SOR_LOCAL_SYMMETRIC_SWEEP);
    }
  }

  static void one_sweep(KSP smoother, Mat matrix, MatSORType type) {
    check(KSPSetOperators(smoother, matrix, matrix));
    check(KSPSetType(smoother, KSPRICHARDSON));
    check(KSPSetTolerances(smoother, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 1));
    check(KSPSetNormType(smoother, KSP_NORM_NONE));
    PC sweep = nullptr;
    check(KSPGetPC(smoother, &sweep));
    check(PCSetType(sweep, PCSOR));
    check(PCSORSetSymmetric(sweep, type));
  }

  const Cloud& cloud_;
  bool is_thin_already_;
  NearestPairs near_;
  bool is_thin_ = false;         ///< the finest level is that of the nearest pairs
  std::vector<Coarser> levels_;  ///< from fine to coarse
  petsc::Handle<PC, PCDestroy> cycle_;
};

Multigrid& multigrid_of(PC preconditioner) {
  Multigrid* multigrid = nullptr;
  check(PCShellGetContext(preconditioner, &multigrid));
  return *multigrid;
}

PetscErrorCode set_up(PC preconditioner) {
  return petsc::callback([&] {
    Mat matrix = nullptr;
    check(PCGetOperators(preconditioner, nullptr, &matrix));
    multigrid_of(preconditioner).set_up(matrix);
  });
}

PetscErrorCode apply(PC preconditioner, Vec x, Vec y) {
  return petsc::callback([&] { multigrid_of(preconditioner).apply(x, y); });
}

PetscErrorCode destroy(PC preconditioner) {
  return petsc::callback([&] { delete &multigrid_of(preconditioner); });
}

}  // namespace

void use_aggregation_multigrid(PC preconditioner, const Cloud& cloud, bool is_thin) {
  check(PCSetType(preconditioner, PCSHELL));
  check(PCShellSetName(preconditioner, "multigrid by aggregation"));
  check(PCShellSetContext(preconditioner, new Multigrid(cloud, is_thin)));  // PETSc calls destroy
  check(PCShellSetSetUp(preconditioner, set_up));
  check(PCShellSetApply(preconditioner, apply));
  check(PCShellSetDestroy(preconditioner, destroy));
}

}  // namespace calor
