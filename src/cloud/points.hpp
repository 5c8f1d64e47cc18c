#pragma once
// What a generator or a reader of clouds makes: this rank's share of the points, in any distribution; `distribute` then
// sends every point to its block, orders it and adds the ghosts.
#include <mpi.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/vec3.hpp"
#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/cells.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

/// One point as it travels between ranks.
struct Point {
  std::int64_t id = 0;
  Vec3 x;                                           ///< m
  double volume = 0, full_volume = 0, spacing = 0;  ///< m^3, m^3, m
  Vec3 area = {};                                   ///< outward boundary area vector A_i, m^2
  Vec3 metric = {};                                 ///< spacing along every axis, m; zeros: `spacing`
  std::uint32_t on_faces = 0;                       ///< bit f: carries a facet of faces[f]
  int tag = 0;
  int facets = 0;  ///< how many of Points::facets are this point's
};

/// A piece of the surface that belongs to one point and one face. On a curved face `area` is the measure of the
/// surface (it exchanges heat), while the point's area vector is the integral of the normal over it.
struct SurfacePiece {
  int face = 0;
  double area = 0;  ///< m^2
  Vec3 normal;      ///< outward unit normal
};

/// The points of one rank; ids over all ranks are 0 .. count-1 without gaps. Volumes and areas are those of the real
/// body: thickness and section included.
struct Points {
  int dimension = 3;
  double section = 1;
  std::vector<Point> points;
  std::vector<SurfacePiece> facets;  ///< of points[0], then of points[1], ...
  std::vector<std::string> faces, tags = {""};
  std::shared_ptr<const Lattice> lattice;          ///< see Cloud
  std::shared_ptr<const RingLattice> rings;        ///< see Cloud
  std::vector<double> walls;                       ///< of a box, see Cloud
  std::shared_ptr<const Body> body = nullptr;      ///< see Cloud
  std::shared_ptr<const Solids> solids = nullptr;  ///< see Cloud
  /// Of points of a jittered lattice whose volumes are still to be set.
  std::shared_ptr<const Lattice> jittered = nullptr;
  bool box_lattice = false, nearest_volumes = true, points_on_walls = true, has_areas = true;
  /// Spacings are estimates, which settle_spacings improves; without `knows_walls` it is not known either whether the
  /// points lie on the walls, nor whether all walls are there.
  bool estimated_spacings = false, knows_walls = true;
  std::vector<std::string> notes;  ///< what a user should know, the same on all ranks
  ExactBody exact;

  /// Adds a piece of a plane face to the last point.
  void add_patch(int face, double area, const Vec3& normal) { add_patch(face, area, normal, area * normal); }
  /// The same for a curved face, whose area vector is not area * normal.
  void add_patch(int face, double area, const Vec3& normal, const Vec3& area_vector);
};

/// The slice of 0 .. count-1 that a rank generates.
struct Slice {
  std::int64_t begin, end;
};
/// Throws Error(bad_case) where the ranks could not hold so many points, before any of them is made. They are counted
/// in a double, in which no product of counts is too large.
void refuse_too_many(MPI_Comm comm, double count);
/// Throws Error(bad_case) when a rank would hold more points than local indices can count.
Slice slice(MPI_Comm comm, std::int64_t count);

/// Sends points to compact blocks (recursive bisection), orders them in cells of one spacing, x running fastest, and
/// adds the points of other ranks within `support` of the block as ghosts. Refuses volumes that are not positive
/// (coincident points: see find_neighbours). Collective; throws Error.
Cloud distribute(MPI_Comm comm, Points points, double support);
/// The same with the ghosts j for which an owned point i lies within the ellipsoid support.radius((s_i + s_j) / 2): on
/// graded clouds far fewer than within the largest support.
Cloud distribute(MPI_Comm comm, Points points, const Support& support);
/// The owned points of a cloud, to be distributed anew.
Points owned_points(const Cloud& cloud);

/// The face of walls that a cloud from elsewhere does not describe.
constexpr const char* undescribed_face = "undescribed";

/// Finds out whether the points of a cloud from elsewhere lie on its walls. Where its surface encloses far less than
/// its volumes, walls that no piece describes get pieces of `undescribed_face`. Collective.
void settle_walls(Cloud& cloud);

/// Spacings by the distances between the points, for those of a cloud from elsewhere that have estimates only: exactly
/// that of a lattice, at its walls and corners too. Sets full cells of the points at the surface as well; settle_walls
/// where the walls are not known. The points change ranks. Collective; throws Error.
Points settle_spacings(MPI_Comm comm, Points points);

/// Makes a cloud of two dimensions and thickness 1 an axisymmetric body: volumes and areas take the thickness 2 pi x,
/// pieces of surface on the axis vanish. S_i is such that the surface closes to round-off. `volumes_of_cells`: the
/// volumes are those of the nearest point; otherwise weights of a quadrature at the points, whose m_i vanish inside.
/// Collective.
void revolve(Cloud& cloud, bool volumes_of_cells);

/// The smallest box around the points of all ranks. Collective.
Bounds bounds_of_all(const Cloud& cloud);

/// What a user should know of the volumes and areas of a cloud from elsewhere: a surface that does not close, volumes
/// that are not those the surface encloses. Refuses areas that point inwards. Collective; throws Error.
std::vector<std::string> remarks_on_surface(const Cloud& cloud);

/// The cloud that [cloud] asks for, with the ghosts that the support of the method needs. Collective; throws Error.
Cloud make_cloud(MPI_Comm comm, const Case& c, const Support& support);

void declare_cloud(Schema& schema);

}  // namespace calor
