#include "solve/aggregation_multigrid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/petsc.hpp"
#include "solve/aggregates.hpp"
#include "solve/nearest_pairs.hpp"

namespace calor {
namespace {

using petsc::check;

/// Temperatures equal within aggregates make a body too stiff, on a lattice of bins twice as wide by 2 where they
/// change linearly. Less than that is safe where they do not.
constexpr double over_correction = 1.8;
constexpr std::int64_t coarsest = 1'000;  ///< rows that are solved directly
constexpr double least_coarsening = 0.7;  ///< rows of a level over those of the finer one that are still worth it

/// A level of the hierarchy: b and x with A x ~ b, of the owned rows.
template <class Value>
class Level {
 public:
  /// Takes the values of the rows; what is left of them serves for messages between ranks.
  Level(MatrixRows rows, std::vector<std::int32_t> aggregate_of)
      : count_(rows.count()), aggregate_of_(std::move(aggregate_of)), inverse_(count_), b_(count_), x_(rows.columns()) {
    first_.reserve(count_ + 1), right_.reserve(count_);
    column_.reserve(rows.entries()), value_.reserve(rows.entries());
    first_.push_back(0);
    for (std::int32_t i = 0; i < count_; ++i) {
      double diagonal = 0;
      PetscInt left = 0;
      rows.for_each_entry(i, [&](std::int32_t j, double a) {
        left += j < i;
        if (j == i) return void(diagonal = a);
        column_.push_back(j), value_.push_back(static_cast<Value>(a));
      });
      right_.push_back(first_.back() + left);
      first_.push_back(static_cast<PetscInt>(column_.size()));
      inverse_[i] = static_cast<Value>(diagonal != 0 ? 1 / diagonal : 0);
    }
    rows.drop_entries();
    rows_.emplace(std::move(rows));
  }

  std::vector<Value>& b() { return b_; }
  std::span<Value> x() { return std::span(x_).first(count_); }

  /// Gauss-Seidel forwards from x = 0, within the rank.
  void sweep_from_zero() {
    for (std::int32_t i = 0; i < count_; ++i) x_[i] = (b_[i] - sum(first_[i], right_[i])) * inverse_[i];
    update();
  }
  /// Backwards.
  void sweep_back() {
    update();
    for (std::int32_t i = count_ - 1; i >= 0; --i)
      x_[i] = (b_[i] - sum(right_[i], first_[i + 1]) - sum(first_[i], right_[i])) * inverse_[i];
  }
  /// b of the coarser level: b - A x added up, after sweep_from_zero, which has left nothing of the left part.
  void restrict_to(Level& coarser) const {
    std::ranges::fill(coarser.b_, Value(0));
    for (std::int32_t i = 0; i < count_; ++i)
      if (aggregate_of_[i] >= 0) coarser.b_[aggregate_of_[i]] -= sum(right_[i], first_[i + 1]);
  }
  void prolong_from(const Level& coarser) {
    for (std::int32_t i = 0; i < count_; ++i)
      if (aggregate_of_[i] >= 0) x_[i] += coarser.x_[aggregate_of_[i]];
  }
  /// b -= A x.
  void take_residual() {
    update();
    for (std::int32_t i = 0; i < count_; ++i)
      if (inverse_[i] != 0) b_[i] -= sum(first_[i], first_[i + 1]) + x_[i] / inverse_[i];
  }

 private:
  Value sum(PetscInt begin, PetscInt end) const {
    Value sum = 0;
    for (PetscInt n = begin; n < end; ++n) sum += value_[n] * x_[column_[n]];
    return sum;
  }
  void update() { rows_->update(std::is_same_v<Value, float> ? MPI_FLOAT : MPI_DOUBLE, x_); }

  std::int32_t count_;
  std::vector<std::int32_t> aggregate_of_;  ///< row of the coarser level, or -1
  std::vector<PetscInt> first_, right_;     ///< where rows begin, and their entries right of the diagonal
  std::vector<std::int32_t> column_;
  std::vector<Value> value_;    ///< off the diagonal
  std::vector<Value> inverse_;  ///< of the diagonal
  std::vector<Value> b_, x_;    ///< x with the columns of other ranks
  std::optional<MatrixRows> rows_;
};

/// W-cycles over all levels, x ~ A^-1 b. Single precision is enough for what only has to come near, as the iteration
/// around it takes residuals in double precision; but not where next to nothing holds the level of the temperatures.
template <class Value>
class Hierarchy {
 public:
  Hierarchy(const Cloud& cloud, Mat matrix) {
    std::vector<Bin> bins = bins_of(cloud);
    MatrixRows rows(matrix);
    weight_ = rows.diagonal();
    while (rows.global_count() > coarsest) {
      std::vector<Bin> coarser_bins = bins;
      std::vector<std::int32_t> aggregate_of = aggregate(rows, coarser_bins);
      MatrixRows coarser(rows, aggregate_of, static_cast<std::int32_t>(coarser_bins.size()), 1 / over_correction);
      if (!(static_cast<double>(coarser.global_count()) < least_coarsening * static_cast<double>(rows.global_count())))
        break;
      add_weights(aggregate_of, coarser.count());
      levels_.emplace_back(std::move(rows), std::move(aggregate_of));
      rows = std::move(coarser), bins = std::move(coarser_bins);
    }
    is_direct_ = rows.global_count() <= 2 * coarsest;
    if (is_direct_) factorise(rows);
    levels_.emplace_back(std::move(rows), std::vector<std::int32_t>());
  }

  void apply(Vec x, Vec y) {
    const petsc::View<const double> from(x);
    std::ranges::copy(from.values(), levels_.front().b().begin());
    cycle(0);
    const petsc::View<double> to(y);
    std::ranges::copy(levels_.front().x(), to.values().begin());
  }

  /// The least of x A x over x D x, D the diagonal of the finest level, or more: by inverse iteration on the coarsest,
  /// where temperatures whose level hardly anything holds are at home. 0 where that is not solved directly. Collective.
  double least_eigenvalue() const {
    if (!is_direct_) return 0;
    MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(static_cast<KSP>(solver_)));
    const std::size_t count = weight_.size();
    std::vector<double> x(count), b(count), products(2 * count);
    for (std::size_t i = 0; i < count; ++i) x[i] = 1 + 0.5 * std::sin(12.9898 * static_cast<double>(i + 1));
    double least = 0;
    for (int n = 0; n < 5; ++n) {
      for (std::size_t i = 0; i < count; ++i) b[i] = weight_[i] * x[i];
      petsc::copy(b, solution_);
      petsc::solve(solver_, solution_, solution_);
      petsc::copy(solution_, x);
      for (std::size_t i = 0; i < count; ++i)
        products[2 * i] = b[i] * x[i], products[2 * i + 1] = weight_[i] * x[i] * x[i];
      const std::vector<double> sum = sums(comm, products, 2);
      least = sum[1] > 0 ? std::abs(sum[0] / sum[1]) : 0;
      const double size = std::sqrt(sum[1]);
      for (double& value : x) value /= size > 0 ? size : 1;
    }
    return std::isfinite(least) ? least : 0;
  }

 private:
  void add_weights(std::span<const std::int32_t> aggregate_of, std::int32_t aggregates) {
    std::vector<double> sum(aggregates);
    for (std::size_t i = 0; i < aggregate_of.size(); ++i)
      if (aggregate_of[i] >= 0) sum[aggregate_of[i]] += weight_[i];
    weight_ = std::move(sum);
  }

  void factorise(const MatrixRows& rows) {
    last_ = rows.assembled();
    solution_ = petsc::create_vector(last_);
    check(KSPCreate(rows.comm(), solver_.out()));
    check(KSPSetOperators(solver_, last_, last_));
    petsc::factorise(solver_, rows.global_count(), false);
  }

  void cycle(std::size_t n) {
    Level<Value>& level = levels_[n];
    if (n + 1 == levels_.size()) return solve(level);
    Level<Value>& coarser = levels_[n + 1];
    level.sweep_from_zero();
    level.restrict_to(coarser);
    cycle(n + 1);
    if (n + 2 < levels_.size()) {  // twice: a W-cycle
      const std::vector<Value> first(coarser.x().begin(), coarser.x().end());
      coarser.take_residual();
      cycle(n + 1);
      for (std::size_t i = 0; i < first.size(); ++i) coarser.x()[i] += first[i];
    }
    level.prolong_from(coarser);
    level.sweep_back();
  }

  void solve(Level<Value>& level) {
    if (!is_direct_) {
      level.sweep_from_zero();
      level.sweep_back();
      return;
    }
    {
      const petsc::View<double> right(solution_);
      std::ranges::copy(level.b(), right.values().begin());
    }
    petsc::solve(solver_, solution_, solution_);
    const petsc::View<double> found(solution_);
    std::ranges::copy(found.values(), level.x().begin());
  }

  std::vector<Level<Value>> levels_;  ///< from fine to coarse
  std::vector<double> weight_;        ///< of the rows of the coarsest: sums of the diagonal of the finest
  bool is_direct_ = false;            ///< the coarsest, by
  petsc::Matrix last_;
  petsc::Vector solution_;
  petsc::LinearSolver solver_;
};

class Multigrid {
 public:
  Multigrid(const Cloud& cloud, bool is_thin) : cloud_(cloud), is_thin_already_(is_thin), near_(cloud) {}

  /// Collective.
  void set_up(Mat matrix) {
    constexpr double safe = 1e-6;  // some twenty times the rounding of single precision
    single_.reset(), double_.reset();
    const bool is_thin = !is_thin_already_ && near_.set(matrix);
    Mat finest = is_thin ? near_.matrix() : matrix;
    single_.emplace(cloud_, finest);
    if (single_->least_eigenvalue() > safe) return;
    single_.reset();
    double_.emplace(cloud_, finest);
  }
  void apply(Vec x, Vec y) { single_ ? single_->apply(x, y) : double_->apply(x, y); }

 private:
  const Cloud& cloud_;
  bool is_thin_already_;
  NearestPairs near_;
  std::optional<Hierarchy<float>> single_;
  std::optional<Hierarchy<double>> double_;  ///< the one or the other
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
