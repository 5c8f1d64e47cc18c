#pragma once
// Cracks and interfaces: surfaces inside the body that heat does not cross, or only against a contact resistance.
#include <limits>
#include <optional>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

/// A crack as it is asked for.
struct Crack {
  std::vector<Vec3> vertices;  ///< m; of a polyline in 2D, of a plane polygon in 3D
  double contact = 0;          ///< conductance of the contact, W/(m^2 K); 0: no heat crosses
  double opens = 0;            ///< s; the bonds across it fail then. 0: open from the start
  bool fails() const { return opens > 0; }
};

/// A plane piece of a crack: a segment of a polyline, or a polygon.
struct CrackPiece {
  std::vector<Vec3> corners;   ///< as given
  std::vector<Vec3> extended;  ///< the same, moved out of the body where they lie on its surface
  Vec3 normal;                 ///< unit; its upper side is where it points
  /// Edges where the crack ends inside the body, by their lines; ends of a segment in 2D.
  struct Tip {
    Vec3 a, b;  ///< a == b in 2D
  };
  std::vector<Tip> tips;

  /// Signed distance of x from the plane, m.
  double side(const Vec3& x) const { return dot(x - corners[0], normal); }
};

/// A pair that crosses a crack, as seen from the point in whose row it is.
struct Crossing {
  std::int64_t entry;  ///< in the neighbour lists
  int point;           ///< owned point in whose row it is
  int crack;
  double fraction;  ///< of the pair's weight that the crack cuts; below 1 beside a tip only, and 0 where only
  double sliver;    ///< a share of what lies between the crack and the middle of the pair is beside the crack
  double length;    ///< |x_ji . n|, m
  /// Of the piece of the crack that the point faces, the first on the way to its neighbour:
  Vec3 normal;  ///< away from the point
  double at;    ///< part of the way that lies before it, 0 to 1
  bool upper;   ///< the point is on its upper side
};

class Cracks {
 public:
  /// Finds tips, ends on the surface and points on cracks. Corners on the surface (nearer than a tenth of a spacing)
  /// or beyond it are taken to reach out of the body. Collective.
  Cracks(const Cloud& cloud, std::vector<Crack> cracks);

  const std::vector<Crack>& all() const { return cracks_; }
  const std::vector<CrackPiece>& segments(int crack) const { return segments_[crack]; }
  /// Does the crack cut right through, without a tip in the body?
  bool is_full_cut(int crack) const;
  /// Position of a local point for all questions about sides: points on a crack are moved 1e-3 spacings to its
  /// upper side.
  const Vec3& location(int i) const { return location_[i]; }
  /// Does a crack lie between two places? Tips count as where the crack ends.
  bool separate(const Vec3& a, const Vec3& b) const;
  std::int64_t moved() const { return moved_; }  ///< points on cracks, of all ranks

  /// Sorted by entry, then by crack; the same fraction and length for (i, j) and (j, i).
  std::vector<Crossing> crossings(const Neighbours& neighbours) const;

 private:
  struct Surface;
  Surface surface_at(const Vec3& place) const;
  bool runs_inside(const Vec3& a, const Vec3& b) const;  ///< of an edge, any part
  bool holds(const CrackPiece& piece, const Vec3& x) const;
  /// Crossing::fraction and Crossing::sliver of the pair of a and b.
  struct Cut {
    double fraction = 0, sliver = 0;
  };
  Cut cut(const CrackPiece& piece, const Vec3& a, const Vec3& b, const Vec3& metric) const;
  void find_tips();
  void reach_out_of_the_body();
  void move_points();

  const Cloud& cloud_;
  std::vector<Crack> cracks_;
  std::vector<std::vector<CrackPiece>> segments_;
  std::vector<Vec3> location_;
  std::int64_t moved_ = 0;
};

/// Gives the points beside cracks the cells and facets that are nearer to them than to other points on their side of
/// the cracks. Collective.
void end_cells_at_cracks(Cloud& cloud, const Cracks& cracks);
/// Within which points are asked whether a crack lies between them: two spacings, or as far as the ghosts reach.
Support nearest_of(const Cloud& cloud);
/// What a user should know of the [[crack]] entries of a case that do nothing. Refuses cracks outside the body.
/// Collective; throws Error.
std::vector<std::string> notes_on_cracks(const Case& c, const Cloud& cloud);
/// The cloud of the body before cracks ended its cells: `cloud` itself where none did, or else `copy`.
const Cloud& without_cracks(const Cloud& cloud, std::optional<Cloud>& copy);

/// The [[crack]] entries of a case. Throws Error(bad_case) for cracks that do not suit the cloud.
std::vector<Crack> read_cracks(const Case& c, const Cloud& cloud);
bool has_cracks(const Case& c);

void declare_cracks(Schema& schema);

}  // namespace calor
