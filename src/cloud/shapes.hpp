#pragma once
// The shapes of clouds that calor makes or reads, as plain functions and as sections of a case.
#include <mpi.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "case/registry.hpp"
#include "cloud/body_points.hpp"
#include "cloud/points.hpp"

namespace calor {

class Cache;
struct Mesh;

/// A box filled with a lattice, faces "xmin", "xmax", "ymin", ... Ids run along x first, then y, then z.
struct BoxLattice {
  int dimension = 3;
  std::array<double, 3> size = {1, 1, 1};          ///< m, one per axis of the dimension
  std::array<std::int64_t, 3> points = {2, 2, 2};  ///< per axis; at least 2 on walls, 1 in cells
  Vec3 origin = {};                                ///< lowest corner, m
  /// Of a graded axis: coordinates of its points (on walls) or of the ends of its cells, ascending, m; they take the
  /// place of size, points and origin along it. Without jitter.
  std::array<std::vector<double>, 3> coordinates = {};
  bool on_walls = true;  ///< outermost points on the walls; otherwise at cell centres
  /// Points move by up to this fraction of the spacing: inner ones along every axis, those on a wall (on walls) within
  /// it, corners not at all; those of the outermost cells (in cells) not at all. Below 0.5.
  double jitter = 0;
  std::uint64_t seed = 1;
  double section = 1;  ///< thickness (2D, m) or cross-section (1D, m^2)
};
/// Points of a jittered lattice have the volumes of those that are nearest to them. Collective.
Points make_box(MPI_Comm comm, const BoxLattice& box);
/// The same, but volumes of a jittered lattice are still to be set (Points::jittered). Collective.
Points lattice_points(MPI_Comm comm, const BoxLattice& box);
/// Those of this rank's points of a jittered lattice, m^dimension.
void set_volumes(Points& points, std::span<const double> volume);

enum class Sector { full, half, quarter };

/// A disc (2D, levels = 0) or cylinder (3D, axis z from z = 0) of concentric rings: a centre and points 6 m on ring m;
/// a half 3 m intervals, a quarter round(1.5 m) but at least 2, with points on the cuts. Faces "side", then "bottom"
/// and "top", then "cut1" (y = 0) and, of a quarter, "cut2" (x = 0).
struct Rings {
  double radius = 1;  ///< m
  int rings = 1;      ///< outermost ring on the side
  double height = 0;  ///< m; 3D only
  int levels = 0;     ///< layers of points over the height, bottom and top included; 0: a disc
  Sector sector = Sector::full;
  double thickness = 1;  ///< m; 2D only
};
/// Collective.
Points make_rings(MPI_Comm comm, const Rings& rings);

/// A rectangle from x = 0 filled with rows of points along x, each with its own number of them; ids run along the rows.
/// Faces "xmin", "xmax", "ymin", "ymax". Volumes are those of the nearest point, exactly.
struct Rows {
  double length = 1;                 ///< m
  std::vector<double> y;             ///< of every row, ascending, m; the first and the last lie on walls
  std::vector<std::int64_t> points;  ///< of every row, at least 2: the ends lie on walls
  double thickness = 1;              ///< m
};
/// Collective.
Points make_rows(MPI_Comm comm, const Rows& rows);

/// A body of any shape by its closed surface. Collective.
Points make_body(MPI_Comm comm, Assembly assembly, const SpacingField& spacing, std::uint64_t seed, double section);

/// A cloud in a CSV file; see csv.cpp for its columns. Every rank reads a part. `section` gives the thickness or
/// cross-section for the dimension that the file turns out to have; `named` is where the case names the file.
/// Collective; throws Error.
Points read_points(MPI_Comm comm, const std::string& file, const std::function<double(int dimension)>& section,
                   const SourceLocation& named = {});

/// The nodes of a mesh; see mesh.cpp. Every rank holds the whole mesh and keeps a slice of the points. `unit`: length
/// of one unit of the mesh, m; `section`: as of read_points; `file`: of the mesh, for messages. Throws Error.
Points mesh_points(MPI_Comm comm, const Mesh& mesh, double unit, const std::function<double(int dimension)>& section,
                   const SourceLocation& file = {});

/// A value of [cloud] shape. A new one is a new file and its name in shapes.cpp.
struct CloudShape {
  std::string name, sentence;
  std::vector<Key> keys;  ///< in [cloud]
  Points (*make)(MPI_Comm comm, const Table& cloud);
};
Registry<CloudShape>& cloud_shapes();

/// Where what this cloud is made of at length is kept; null where the case does not ask for it.
std::shared_ptr<Cache> cache_of(const Table& cloud);
/// Where the case says what its points are: whoever finds fault with them points there.
SourceLocation location_of_points(const Table& cloud);
/// Thickness (2D) or cross-section (1D) of the table, 1 in 3D; refuses a key that the dimension does not have.
double section_of(const Table& cloud, int dimension);
/// How often `spacing` goes into `length`; refuses one that does not divide it and names the nearest that do.
std::int64_t intervals(const Table& cloud, double length, double spacing);

}  // namespace calor
