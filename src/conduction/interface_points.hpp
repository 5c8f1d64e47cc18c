#pragma once
// Which points of a cloud are near an interface: whose pairs may run through more than one part of the body.
#include <cstdint>
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "geometry/parts.hpp"

namespace calor {

/// How many spacings lie between two local points, rounded up: by steps from point to point along the axes on a
/// lattice, by the metric elsewhere.
int spacings_between(const Cloud& cloud, int a, int b);

class InterfacePoints {
 public:
  /// Cloud and parts must outlive this. Collective; throws Error where a formula of a region fails.
  InterfacePoints(const Cloud& cloud, const Parts& parts, const Neighbours& neighbours);

  /// The parts that meet at a local point.
  int count_of_parts(int i) const { return parts_here_[i]; }
  /// Do the cells of two points hold one part alone, the same?
  bool are_of_one_part(int i, int j) const { return own_[i] == own_[j] && !is_divided(i) && !is_divided(j); }
  /// Is it known that between two points of one part there is no other?
  bool have_nothing_between(int i, int j) const;

 private:
  void find_parts();
  void find_thin_regions(const Neighbours& neighbours);
  void mark_near(const Neighbours& neighbours);
  /// Does the cell of a local point hold several parts?
  bool is_divided(int i) const { return parts_here_[i] > 1 || (!one_part_.empty() && !one_part_[i]); }

  const Cloud& cloud_;
  const Parts& parts_;
  // Of the local points.
  std::vector<int> own_, parts_here_;  // its part, and how many meet there
  std::vector<char> one_part_;         // on a lattice: does its cell hold one alone?
  std::vector<char> beside_thin_;      // does a short pair of it run through another part?
  std::vector<double> near_;           // 1 or 0
};

}  // namespace calor
