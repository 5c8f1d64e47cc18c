#pragma once
// The parts of a body: its layers and regions, each of one material, and where they meet. An interface is geometry, not
// a set of points: the plane between two layers, or the surface on which a region's formula changes.
#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/function.hpp"
#include "case/case.hpp"
#include "cloud/cloud.hpp"
#include "surface/solids.hpp"

namespace calor {

class PointTags;
struct TagPiece;

struct Part {
  std::string material, tag;  ///< the tag of its points, if it is a region by tag
  SourceLocation location;    ///< where the case names it
};

/// A share of some places, in ascending order.
struct PlacesOfPart {
  std::vector<int> place;
  std::vector<double> share;
};

/// A piece of a segment from a to b: it lies in one part and ends at `end`, a fraction of the way.
struct SegmentPiece {
  int part;
  double end;
};

class Parts {
 public:
  /// The parts of [body], or one of `only_material` if it names none. Refuses layers that do not cover the body and
  /// regions that hold no point. Collective; throws Error(bad_case).
  Parts(const Case& c, const Cloud& cloud, const std::string& only_material);
  /// One part.
  explicit Parts(const Cloud& cloud) : cloud_(cloud), parts_(1), rest_(0), contacts_(1) {}

  int count() const { return static_cast<int>(parts_.size()); }
  const Part& operator[](int part) const { return parts_[part]; }
  /// Conductance of the contact between two parts that meet, W/(m^2 K); null: they touch.
  const Function* contact(int part, int other) const;
  bool has_contacts() const { return has_contacts_; }
  /// Are there regions of which more is known than which points they hold? They may be thinner than a spacing.
  bool may_be_thin() const {
    return std::ranges::any_of(regions_, [&](const Region& r) { return r.where || !point_tags_; });
  }

  /// The part of every place; on an interface one of those that meet there. `tag`: of the point that the place belongs
  /// to. Throws Error(bad_case), maybe on one rank alone, for a place that no part holds.
  std::vector<int> at(std::span<const Vec3> x, std::span<const int> tag) const;
  /// For every part which places it has, and how much of them: all, or on an interface the part of the surroundings
  /// inside the body that it fills. `size`: of what is around every place, m. Places at contacts belong to one side.
  std::vector<PlacesOfPart> shares(std::span<const Vec3> x, std::span<const int> tag,
                                   std::span<const double> size) const;
  /// The share of every part in the cells of all local points of the cloud. Takes long: see
  /// MaterialField::cell_shares.
  std::vector<PlacesOfPart> cell_shares() const;

  /// Segments between places a and b, b - a of each and the points' tags.
  struct Segment {
    Vec3 a, b;
    int tag_a = 0, tag_b = 0;
    int spacings = 1;  ///< that it is long, rounded up
  };
  /// What every segment runs through, in order; each begins in the part of its place a and ends in that of b. Rows of
  /// pieces: those of segment s are piece[row[s]] .. piece[row[s+1]].
  struct Pieces {
    std::vector<std::int64_t> row = {0};
    std::vector<SegmentPiece> piece;

    std::span<const SegmentPiece> of(std::size_t segment) const {
      return {piece.data() + row[segment], static_cast<std::size_t>(row[segment + 1] - row[segment])};
    }
  };
  Pieces along(std::span<const Segment> segments) const;
  /// Does the place lie in the body? True where its walls are not known.
  bool is_inside(const Vec3& x) const;
  /// Does one part alone, surely, lie within `radius` (m) of a place? Not known of regions by formulas or points.
  bool is_one_around(const Vec3& x, double radius) const;
  /// Does a plane between layers lie between two places, or in one of them?
  bool has_plane_between(const Vec3& a, const Vec3& b) const;
  /// The surface between two parts next to a place on it.
  struct Interface {
    Vec3 normal;     ///< of length 1
    int piece = -1;  ///< index into curved_areas(), if it is one of those
  };
  /// At x; `along`: a direction that crosses it, `size`: of what is around, m.
  Interface interface_at(const Vec3& x, const Vec3& along, int tag, int part, int other, double size) const;
  /// Areas of the curved pieces of interfaces, m^(dimension - 1), as far as they are known; 0 for plane ones.
  std::span<const double> curved_areas() const;

 private:
  struct Layers {
    int axis = -1;  ///< -1: there are none
    double start = 0;
    std::vector<double> top;  ///< above the start, ascending, m
  };
  struct Region {
    int part;
    int tag = -1;  ///< of the points that belong to it; or
    std::optional<Function> where = {};
  };

  /// Is it known where every tag begins and ends?
  bool knows_solids() const;
  bool has_wall_within(const Vec3& x, double distance) const;
  /// Is every interface a plane of layers or a surface between solids?
  bool knows_interfaces() const;
  void read_layers(const Table& body);
  Vec3 normal_of_region(const Vec3& x, const Vec3& along, int tag, double size) const;
  void read_region(const Case& c, const Table& table);
  void read_contact(const Table& table);
  std::vector<int> parts_called(const std::string& name, const Table& contact) const;
  int add(const Table& table);
  bool has_formulas() const;
  /// Where formulas are asked for what the body has at these places: one that ends at a wall may be false on it.
  std::vector<Vec3> off_walls(std::span<const Vec3> x) const;
  /// `inside`: where formulas are asked. -1: none.
  void find(std::span<const Vec3> x, std::span<const Vec3> inside, std::span<const int> tag, std::span<int> part) const;
  void find(std::span<const Vec3> x, std::span<const Vec3> inside, std::span<const int> tag, std::span<int> part,
            std::vector<Solids::Known>& known) const;
  /// Of every segment, where formulas ask: does it touch a wall? True where that is not known.
  std::vector<char> lie_on_walls(std::span<const Segment> segments) const;
  std::vector<TagPiece> tags_along(const Segment& segment) const;
  std::vector<double> crossings(const Segment& segment) const;
  std::optional<double> only_crossing(const Segment& segment, std::span<const double> crossings, double low,
                                      double high) const;
  std::vector<double> samples(const Segment& segment, std::span<const TagPiece> tags,
                              std::span<const double> crossings) const;
  // Of every part, in the cells of the owned points.
  std::vector<std::vector<double>> shares_of_lattice_cells() const;
  std::vector<std::vector<double>> shares_of_cells() const;

  const Cloud& cloud_;
  std::vector<Part> parts_;
  SourceLocation body_;
  int rest_ = -1;  ///< the part of what no region takes
  Layers layers_;
  std::vector<Region> regions_;
  std::shared_ptr<const PointTags> point_tags_;      ///< if there are regions of which the points alone know
  std::vector<std::unique_ptr<Function>> contacts_;  ///< of every part, with the part before it or all around it
  std::map<std::pair<int, int>, Function> between_;  ///< of two parts, the lower first; they come before
  bool has_contacts_ = false;
  double skin_ = 0;  ///< places nearer to a wall lie on it, m
};

void declare_parts(Schema& schema);

}  // namespace calor
