#pragma once
// How far it is from the faces of a body: for finer points near them, and as lengths that formulas know by name.
#include <optional>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "surface/surface.hpp"
#include "surface/surface_tree.hpp"

namespace calor {

/// Some faces of a body. Copying would leave the tree without its surface.
class FaceDistance {
 public:
  /// Key `key` of `table` names the faces; refuses what is none of the body.
  FaceDistance(const Surface& body, const Table& table, const std::string& key);
  FaceDistance(const FaceDistance&) = delete;
  FaceDistance& operator=(const FaceDistance&) = delete;

  /// Distance from the facets, m, if it is below `bound`.
  std::optional<double> within(const Vec3& x, double bound) const;

 private:
  Surface faces_;
  SurfaceTree tree_;
};

/// Gives the lengths that [cloud.distance] names their values: distances to faces of this body.
void set_distances(const Table& cloud, const Surface& body);

/// The keys of [cloud.distance].
void declare_distances(Schema& schema);

}  // namespace calor
