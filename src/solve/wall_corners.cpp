#include "solve/wall_corners.hpp"

#include "base/parallel.hpp"

namespace calor {

WallCorners::WallCorners(const Cloud& cloud, std::span<const PrescribedTerm> temperatures) {
  std::vector<int> number(cloud.owned, -1);
  for (const PrescribedTerm& term : temperatures)
    for (std::size_t n = 0; n < term.point.size(); ++n) {
      if (term.share[n] == 1) continue;
      int& point = number[term.point[n]];
      if (point < 0) point = static_cast<int>(points_.size()), points_.push_back(term.point[n]);
      walls_.push_back({point, term.account, term.share[n], term.area[n]});
    }
  exist_ = any(cloud.comm, !points_.empty());
}

void WallCorners::shift(std::span<const Vec3> q, std::span<double> power) const {
  std::vector<double> through_all(points_.size());
  for (const Wall& wall : walls_) through_all[wall.point] -= dot(q[wall.point], wall.area);
  for (const Wall& wall : walls_)
    power[wall.account] += -dot(q[wall.point], wall.area) - wall.share * through_all[wall.point];
}

}  // namespace calor
