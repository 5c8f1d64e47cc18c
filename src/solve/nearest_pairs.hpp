#pragma once
// A thin matrix in the place of that of many neighbours, for a preconditioner.
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/petsc.hpp"
#include "cloud/cloud.hpp"
#include "conduction/heat_term.hpp"

namespace calor {

/// The entries of a matrix between points next to each other, times what makes linear temperatures flow as much as by
/// all entries; the sums of rows stay, and so does the diagonal of rows whose next points give them nothing. The rows
/// are those of the points.
class NearestPairs final : public JacobianEntries {
 public:
  explicit NearestPairs(const Cloud& cloud);

  /// Makes or renews the thin matrix. False where it would be no thinner, or leave a row without a neighbour. `matrix`
  /// has the same pattern every time. Collective.
  bool set(Mat matrix);

  /// The same without the whole matrix: add() is given all entries, by local points, those of a row at once or bit by
  /// bit, and finish() makes the thin matrix of them. Every time the same pattern. finish() is collective.
  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override;
  void finish();

  Mat matrix() const { return thin_; }

 private:
  struct Row {
    double sum = 0, diagonal = 0;
    double moment = 0, near_moment = 0;  ///< sum a_ij r_ij^2, r in spacings
    bool is_alone() const { return moment != 0 && near_moment == 0; }
  };
  struct Entry {
    std::int32_t row, column;
    double value;
  };

  void begin();
  void clear();
  void set_pattern();

  const Cloud& cloud_;
  std::vector<std::pair<std::int64_t, std::int32_t>> ghosts_;  ///< global and local numbers, sorted
  petsc::Matrix thin_;
  bool has_pattern_ = false;
  // Until the thin matrix has them:
  std::vector<Row> rows_;
  std::vector<Entry> near_;
  std::int64_t given_ = 0;  ///< entries off the diagonal
};

}  // namespace calor
