#pragma once
// Points for a body of any shape: on its corners, along its edges, on its faces, and inside.
#include <cstdint>
#include <functional>
#include <vector>

#include "cloud/point_grid.hpp"
#include "surface/body.hpp"

namespace calor {

/// Wanted distance of neighbouring points, m.
struct SpacingField {
  std::function<double(const Vec3& x)> at;
  bool is_uniform = true;
};

/// A cube (square in the plane) of the tree that covers the body: no edge is longer than the spacing in its middle.
struct Box {
  Vec3 low;
  double size;
  bool is_cut;  ///< the surface may run through it; if not, it lies in the body as a whole
};
/// The boxes that hold a part of the body. With a uniform spacing they are the cells of a lattice, in the middle of the
/// box around the body.
std::vector<Box> cover(const Body& body, const SpacingField& spacing);

struct BodyPoints {
  /// A patch that a point lies on, and the outward normal there.
  struct OnPatch {
    int patch;
    Vec3 normal;
  };
  PointGrid grid;
  std::vector<std::vector<OnPatch>> on;  ///< of the points on the surface, which come first
  std::vector<char> is_lattice;          ///< of every point: inside the body, on the lattice of the boxes

  int on_surface() const { return static_cast<int>(on.size()); }
};

/// Points no nearer to each other than 0.4 spacings. On lines they stand in equal steps, on patches and (where the
/// spacing varies) inside they are thrown at random as long as they find room (Poisson discs); with a uniform spacing
/// the lattice of the boxes comes first. The same points for the same seed, whatever else.
BodyPoints make_points(const Body& body, const SpacingField& spacing, const std::vector<Box>& boxes,
                       std::uint64_t seed);

}  // namespace calor
