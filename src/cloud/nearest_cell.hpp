#pragma once
// The cell of a point of a cloud that is no lattice: what is nearer to it than to the points that it sees.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cloud/cloud.hpp"

namespace calor {

/// A point that may be nearer to a place.
struct Rival {
  Vec3 x;
  double square;  ///< squared distance to the point whose cell it is
  std::int64_t id;
  Vec3 area;
  std::uint32_t on_faces;
};

/// Samples by the small cubes that they lie in: those of cube k are begin[k] .. begin[k+1].
struct SampleCubes {
  std::vector<std::array<int, 3>> index;
  std::vector<std::int32_t> begin;
};

/// A plane of the surface near a point.
struct Plane {
  Vec3 through, normal;
  bool has_outside(const Vec3& x, double margin = 0) const { return dot(x - through, normal) > margin; }
};

class NearestCell {
 public:
  /// Of owned point i with these facets, among rivals that are sorted, nearest first. `farthest`: no part of the cell
  /// is farther from the point than this many spacings. The rivals must outlive it.
  NearestCell(const Cloud& cloud, int i, std::span<const Facet> facets, std::span<const Rival> rivals, double farthest);

  /// Sets `out` to one random place in each of n sub-cells a spacing that lies in the cell. Places of `per_cube`
  /// sub-cells along every axis follow each other: what holds of these cubes as a whole is not asked of every place.
  void sample(int level, int n, int per_cube, std::vector<Vec3>& out, SampleCubes& cubes);

 private:
  /// The surface at one of its points. Where the body reaches beyond a plane, as at re-entrant edges, only what lies
  /// beyond all such planes is outside.
  struct Walls {
    std::vector<Plane> planes, reentrant;
    bool has_outside(const Vec3& x) const;
  };
  struct Cube {
    Vec3 centre, half;
  };

  bool may_hold(const Cube& cube);
  bool is_in_cell(const Vec3& p) const;
  bool is_outside(const Vec3& p) const;
  bool is_beyond_near_wall(const Vec3& p) const;

  const Cloud& cloud_;
  int i_;
  Vec3 x_;
  double d_, farthest_;
  std::span<const Rival> rivals_;
  Walls walls_;
  bool near_wall_ = false;
  // Of the cube at hand:
  std::vector<const Rival*> active_;  ///< between which and the point its places have to choose
  bool sees_all_ = false;             ///< no wall hides any of its places
};

}  // namespace calor
