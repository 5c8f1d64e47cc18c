#pragma once
// The cloud of points that stands for the body, distributed over the ranks in compact blocks. Every rank holds its
// owned points first (0 .. owned), in lexicographic order of the search cells, then copies ("ghosts") of the points of
// other ranks that lie within the support radius of its block.
#include <mpi.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "base/vec3.hpp"

struct _p_PetscSF;  // NOLINT(bugprone-reserved-identifier): PETSc's name

namespace calor {

class Cache;
class Lattice;
class RingLattice;
class Body;
class Solids;

/// Copies values of owned points to the ghosts on other ranks (PetscSF).
class Halo {
 public:
  Halo() = default;  ///< no ghosts
  /// `ghost_global`: global numbers of the ghosts, in the order of the local arrays.
  Halo(MPI_Comm comm, int owned, std::span<const std::int64_t> ghost_global);

  /// values.size() == owned + ghosts; overwrites the ghosts. Collective.
  void update(std::span<double> values, CallSite at = CallSite::current()) const;
  void update(std::span<Vec3> values, CallSite at = CallSite::current()) const;
  /// Sets every point and its ghosts to the largest value that any rank has for it. Collective.
  void raise(std::span<double> values, CallSite at = CallSite::current()) const;
  /// Sets every point and its ghosts to the sum of the values that all ranks have for it. Collective.
  void add_up(std::span<double> values, CallSite at = CallSite::current()) const;

 private:
  void reduce(std::span<double> values, MPI_Op operation, CallSite at) const;

  int owned_ = 0;
  std::shared_ptr<_p_PetscSF> forest_;  // null on one rank
};

/// Of a metric, in a direction of length 1, m.
inline double spacing_along(const Vec3& metric, const Vec3& direction) { return 1 / norm(quotient(direction, metric)); }

/// How far a point sees, in spacings and in metres: the sum of both. As the spacing has a value along every axis, so
/// has the radius: the support is an ellipsoid with the axes of the cloud.
struct Support {
  double over_spacing = 0, length = 0;

  Support() = default;
  Support(double over_spacing, double length = 0) : over_spacing(over_spacing), length(length) {}
  double radius(double spacing) const { return over_spacing * spacing + length; }
  Vec3 radius(const Vec3& metric) const { return {radius(metric.x), radius(metric.y), radius(metric.z)}; }
};

/// A piece of the surface that belongs to one owned point and one face.
struct Facet {
  int point;    ///< local index of the owned point
  int face;     ///< index into Cloud::faces
  double area;  ///< scalar area, m^2 of the real body (thickness and section included)
  Vec3 normal;  ///< outward unit normal
};

/// What is known exactly about the body, to check the cloud against.
struct ExactBody {
  double volume = 0;  ///< m^3; 0 = unknown
};

struct Cloud {
  MPI_Comm comm = MPI_COMM_SELF;
  int dimension = 3;
  double cross_section = 1;  ///< thickness (2D, m) or cross-section (1D, m^2) that volumes and areas include; 1 in 3D
  /// A body of two dimensions revolved about the y axis: x is the distance from it, and the thickness is cross_section
  /// x with cross_section = 2 pi.
  bool axisymmetric = false;

  int owned = 0;                      ///< owned points on this rank
  std::int64_t first = 0, count = 0;  ///< global number of the first owned point; points on all ranks

  // One entry per local point, ghosts included.
  std::vector<std::int64_t> id;      ///< place in the input order, from 0
  std::vector<std::int64_t> global;  ///< number in the distributed order
  std::vector<Vec3> x;               ///< m
  std::vector<double> volume;        ///< true volume inside the body, m^3
  std::vector<double> full_volume;   ///< volume of the uncut cell, m^3
  /// Local spacing s_i along every axis, m; along axes that the body does not have, the largest of the others. Lengths
  /// around a point are measured in it, so that points much flatter than wide have neighbours as cubes have.
  std::vector<Vec3> metric;
  std::vector<double> spacing;  ///< the largest component of the metric, d_i, m
  std::vector<Vec3> area;       ///< outward boundary area vector A_i, m^2; 0 inside
  // Of axisymmetric bodies, otherwise empty.
  std::vector<double> hoop;             ///< S_i, integral of dV / x over the cell, m^2
  std::vector<Vec3> moment;             ///< m_i, integral of (x - x_i) dV / x over the cell, m^3
  std::vector<std::uint32_t> on_faces;  ///< bit f: the point lies on faces[f]
  std::vector<int> tag;                 ///< index into tags

  std::vector<std::string> faces;  ///< "xmin", "top", "side", ...; at most 32
  std::vector<std::string> tags;   ///< at least one, "" for untagged
  std::vector<Facet> facets;       ///< of the owned points, sorted by point
  std::vector<double> walls;  ///< of a box: coordinate of the plane of faces[f], m; faces[f] is normal to axis f / 2

  std::shared_ptr<const Lattice> lattice;  ///< of points that are those of an unjittered lattice, by their id; or null
  std::shared_ptr<const RingLattice> rings;  ///< of points that are those of concentric rings, by their id; or null
  std::shared_ptr<const RingLattice> disc;   ///< the same for its walls, whatever becomes of the cells
  std::shared_ptr<const Body> body;          ///< the surface that the points were made for; null: not known
  std::shared_ptr<const Solids> solids;      ///< where every tag begins and ends; null: the points alone know
  bool box_lattice = false;                  ///< unjittered box lattice with equal spacing along every axis
  bool isotropic = true;                     ///< the metric of every point has one value
  bool nearest_volumes =
      true;  ///< volumes are those of the nearest point; false: sectors of rings, which only resemble them
  bool points_on_walls = true;  ///< false: cell-centred
  bool has_areas = true;        ///< false: a bare CSV without boundary areas
  ExactBody exact;
  std::vector<std::string> notes;  ///< what a user should know of the cloud, the same on all ranks
  std::shared_ptr<Cache> cache;    ///< where what is made of the cloud at length is kept; null: it is not
  /// Volumes and area vectors of the body before cracks, which end cells: weights are made for the whole body first and
  /// cut then. Null: there are no such cracks.
  struct Measures {
    std::vector<double> volume;
    std::vector<Vec3> area;
  };
  std::shared_ptr<const Measures> whole;
  Halo halo;
  /// Every point j within halo_width (m) and the ellipsoid halo_support.radius((s_i + s_j) / 2) around an owned point i
  /// is local.
  double halo_width = 0;
  Support halo_support;

  // Of a body by its surface, one entry per local point; else empty.
  std::vector<Vec3> inside;       ///< where it looks from and is looked at: a little away from walls, m
  std::vector<double> clearance;  ///< distance to the surface, as far as points see, m
  /// Sets `inside` and `clearance`.
  void open_eyes();
  /// Does the straight way between two local points run through the body alone? True where the surface is not known.
  /// The same for (i, j) and (j, i).
  bool sees(int i, int j) const;
  /// The same for a place and local point j; the place must not lie on a wall: see eye_at.
  bool is_seen_from(const Vec3& eye, int j) const;
  /// The place itself, a little away from walls. `d`: spacing there, m.
  Vec3 eye_at(const Vec3& place, double d) const;
  /// The place, or if it lies nearer than `depth` (m) to a wall that is known, one as deep inside the body.
  Vec3 off_walls(const Vec3& place, double depth) const;

  int local() const { return static_cast<int>(x.size()); }
  std::span<const Vec3> owned_points() const { return {x.data(), static_cast<std::size_t>(owned)}; }
  /// The metric of a pair: the same bits for (i, j) and (j, i).
  Vec3 mean_metric(int i, int j) const { return 0.5 * (metric[i] + metric[j]); }
  /// Square of the distance of a pair, in spacings.
  double square_in_spacings(int i, int j) const {
    const Vec3 way = x[j] - x[i];
    if (isotropic) {
      const double mean = 0.5 * (spacing[i] + spacing[j]);
      return dot(way, way) / (mean * mean);
    }
    const Vec3 r = quotient(way, mean_metric(i, j));
    return dot(r, r);
  }
  /// A_i, of axisymmetric bodies A_i - S_i e_x: what remains of the boundary area in the plane, where it and its moment
  /// add up to 0 over the body.
  Vec3 plane_area(int i) const { return axisymmetric ? area[i] - Vec3{hoop[i], 0, 0} : area[i]; }
  /// Thickness or cross-section of a cell, at the mean distance from the axis.
  double section(int i) const { return axisymmetric ? cross_section * volume[i] / hoop[i] : cross_section; }
  /// Of a pair, such that V_i V_j / section is the product of their measures in the plane times the mean thickness; the
  /// same bits for (i, j) and (j, i).
  double section(int i, int j) const {
    if (!axisymmetric) return cross_section;
    const double a = section(i), b = section(j);
    return 2 * (a * b) / (a + b);
  }
};

/// sum V against the exact volume, sum A = 0 and sum x cross A = 0. Collective.
struct CloudCheck {
  double volume, volume_error;  ///< m^3; relative error against the exact volume (0 if unknown)
  double area_sum, moment_sum;  ///< |sum A| / sum |A| and |sum x cross A| / (sum |A| * size of the body)
};
CloudCheck check(const Cloud& cloud);

}  // namespace calor
