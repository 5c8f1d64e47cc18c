#pragma once
// Reference files of [[expect]]: a CSV with a column of expected values, perhaps one of times, and none, one or more of
// coordinates (x, y, z, r).
#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// The rows that an [[expect]] asks for by `reference`, `column`, `filter` and its times.
class ReferenceFile {
 public:
  /// Checks the columns; values come in `unit`, SI. Throws Error.
  ReferenceFile(const Table& expect, const std::string& unit);

  bool has_time() const { return has_time_; }
  /// Coordinate columns that are not filtered by.
  const std::vector<std::string>& axes() const { return axes_; }

  /// Calls row(k, coordinates, T) for every row at time times[k] (all rows for each k in a file without times), reading
  /// from the file row by row. Refuses when a time has no row.
  using Row = std::function<void(int, const std::array<double, 3>&, double)>;
  void read(std::span<const double> times, const Row& row) const;

 private:
  Table expect_;
  std::string path_, unit_;
  bool has_time_ = false;
  std::string time_;
  std::vector<std::string> axes_;
};

/// The one row of every time, in `unit`. Throws Error.
std::vector<double> reference_values(const Table& expect, const std::string& unit, std::span<const double> times);

/// Reference values at points of the cloud. One coordinate: the rows are interpolated by cubics through the four
/// nearest. More: rows are matched to the points that lie there (within 1e-6 of the spacing); others are skipped.
class PointReference {
 public:
  struct Values {
    std::vector<int> point;  ///< owned points, ascending
    std::vector<double> value;
  };

  /// Refuses points outside the rows of one coordinate, rows of which none matches, and two rows for one place.
  /// `selected`: owned points, ascending. Collective; throws Error on all ranks.
  PointReference(const Table& expect, const std::string& unit, const Cloud& cloud, std::span<const int> selected,
                 std::span<const double> times);

  /// For times[k], at the selected points (those matched).
  Values at(int k, const Cloud& cloud, std::span<const int> selected) const;

 private:
  struct Knot {
    double x, value;
  };
  std::string axis_;                       // of one coordinate
  std::vector<std::vector<Knot>> curves_;  // one a time, ascending; empty with more coordinates
  std::vector<Values> matched_;            // one a time
};

}  // namespace calor
