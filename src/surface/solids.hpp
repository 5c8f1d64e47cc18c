#pragma once
// The solids that a body is made of: which of them holds a place. And the contacts that separate its parts, solids or
// not.
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "surface/sides.hpp"
#include "surface/surface.hpp"
#include "surface/surface_tree.hpp"

namespace calor {

class Solids {
 public:
  /// None: the points alone know.
  Solids() = default;
  /// Closed surfaces, facets outward, that do not overlap, the tag of each, and the facets where two of them meet.
  Solids(std::vector<Surface> surfaces, std::vector<int> tags, Surface interfaces);

  bool exist() const { return !solids_.empty(); }
  /// The contacts that end cells; null: there are none.
  const Sides* sides() const { return sides_.get(); }
  void set_sides(Sides sides) { sides_ = std::make_shared<const Sides>(std::move(sides)); }

  /// Tag of the solid that holds the place; of those that meet there the first one. -1: it lies outside.
  int tag_at(const Vec3& x) const;
  /// What is known from the places asked for before: of every solid one inside, and how far it is from the surface.
  struct Known {
    Vec3 x;
    double clearance = -1;  ///< m; < 0: nothing is known
  };
  /// The same for many places. Fast where each lies near one before.
  void tags_at(std::span<const Vec3> x, std::span<int> tags, std::vector<Known>& known) const;
  /// A smooth piece of the interfaces between two solids, and its unit normal next to a place.
  struct Interface {
    int piece;
    Vec3 normal;
  };
  /// Next to the place, none where it is farther than `bound` (m).
  std::optional<Interface> interface_at(const Vec3& x, double bound) const;
  /// The parts of the way from a to b at which it crosses interfaces, in any order.
  std::vector<double> crossings(const Vec3& a, const Vec3& b) const {
    return interfaces_ ? interfaces_->tree.crossings(a, b) : std::vector<double>();
  }
  /// Areas of the pieces that are curved, 0 for the plane ones, m^(dimension - 1).
  std::span<const double> curved_areas() const {
    return interfaces_ ? std::span<const double>(interfaces_->curved_areas) : std::span<const double>();
  }

 private:
  struct Solid {
    Surface surface;
    SurfaceTree tree;
    Vec3 low, high;  // of a box around it, a little larger
    double on;       // places nearer to the surface than this lie on it, m
    int tag;

    Solid(Surface s, int tag);
  };
  /// The solid, and whether the place surely lies inside, not on its surface.
  struct Found {
    int solid;
    bool is_inside;
  };
  struct Interfaces {
    Surface surface;
    SurfaceTree tree;
    std::vector<int> piece;  // of every facet
    std::vector<double> curved_areas;

    explicit Interfaces(Surface s);
  };
  Found find(const Vec3& x) const;
  int find_from(const Vec3& x, std::vector<Known>& known) const;
  void find_pieces(Interfaces& interfaces) const;

  std::vector<std::shared_ptr<const Solid>> solids_;
  std::shared_ptr<const Interfaces> interfaces_;
  std::shared_ptr<const Sides> sides_;
};

}  // namespace calor
