#pragma once
// Points within the support of a place, by lists of search cells.
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cloud/cells.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// Finds the local points of a cloud that are within the ellipsoid support.radius((s + s_j) / 2) (1 - 1e-9) around a
/// place of metric s. Points are kept in classes of the metric, a factor of 2 wide along every axis, each in cells of
/// its own sizes, so that a search costs what it finds on graded clouds and between flat points too.
class Search {
 public:
  Search(const Cloud& cloud, const Support& support);

  /// Positions of all points within reach, the place's own point included, by ascending id: see local(). `coincident`
  /// counts those at (almost) no distance. What is returned lies in `buffer`.
  std::span<std::int32_t> find(const Vec3& p, const Vec3& metric, std::vector<std::int32_t>& buffer,
                               int& coincident) const;
  /// Local index of the point at a position.
  std::int32_t local(std::int32_t position) const { return local_[position]; }
  /// Of the points with the largest spacing along each axis, m.
  Vec3 largest_reach() const { return reach(largest_, largest_); }

 private:
  /// Extent in y and z of a row of cells along x: most rows of a lattice are ruled out by it at once.
  struct RowExtent {
    double y_low = std::numeric_limits<double>::infinity(), y_high = -y_low, z_low = y_low, z_high = -y_low;
  };
  struct Hits {
    int count = 0, coincident = 0;
  };
  struct Class {
    Vec3 largest;  ///< spacing along every axis
    Cells cells;
    std::vector<std::int32_t> start;  ///< position of the first point of every cell, and the end
    std::vector<RowExtent> rows;
  };

  void add_class(const Cloud& cloud, std::span<const std::int32_t> members);
  Vec3 reach(const Vec3& s_i, const Vec3& s_j) const {
    const Vec3 sum = s_i + s_j;
    return {half_reach_ * sum.x + length_, half_reach_ * sum.y + length_, half_reach_ * sum.z + length_};
  }
  void search(const Class& c, const Vec3& p, const Vec3& metric, std::vector<std::int32_t>& buffer, Hits& hits) const;
  /// Calls scan(begin, end, out) for the positions in the cells of every row within reach; it appends to out.
  template <class Scan>
  void for_each_row(const Class& c, const Vec3& p, const Vec3& metric, std::vector<std::int32_t>& buffer,
                    const Hits& hits, const Scan& scan) const;
  void scan_metric(std::int32_t begin, std::int32_t end, const Vec3& p, const Vec3& metric, std::int32_t* out,
                   Hits& hits) const;

  void sort_by_counting(std::span<const std::int32_t> found, std::span<std::int32_t> sorted) const;

  static constexpr std::size_t most_counted = 256;  // beyond, n^2 is too much
  static constexpr int widest = 8;                  // of the vectors: the arrays that they read end in so many more
  double half_reach_, length_;
  Vec3 largest_;
  bool isotropic_;
  std::vector<Class> classes_;
  // Class by class in the order of the cells, coordinates apart, so that the search reads memory in sequence.
  std::vector<double> x_, y_, z_, d_;  // d_: spacing of isotropic clouds
  std::vector<Vec3> metric_;           // of the others
  std::vector<std::int64_t> id_;
  std::vector<std::int32_t> short_id_;  // less the lowest one; empty where that is too much
  std::vector<std::int32_t> local_;
};

}  // namespace calor
