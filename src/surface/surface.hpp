#pragma once
// The closed surface of a body: flat facets, triangles in space and segments in the plane. What a file or a shape
// gives is such a surface; points, cells and facets of a cloud are made from it.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vec3.hpp"

namespace calor {

struct SourceLocation;

struct Surface {
  /// Seen from outside, the vertices of a triangle run counter-clockwise; a segment has the body on its left, and -1
  /// as its third vertex.
  struct Triangle {
    std::array<std::int32_t, 3> vertex = {-1, -1, -1};
    std::int32_t face = 0;  ///< index into faces
  };

  int dimension = 3;           ///< 3: triangles; 2: segments, z = 0
  std::vector<Vec3> vertices;  ///< m
  std::vector<Triangle> facets;
  std::vector<std::string> faces;  ///< names of the faces of the body

  /// Outward area vector of a facet, m^2 (m in the plane).
  Vec3 area(int facet) const {
    const Vec3& a = vertices[facets[facet].vertex[0]];
    const Vec3 ab = vertices[facets[facet].vertex[1]] - a;
    if (dimension == 2) return {ab.y, -ab.x, 0};
    return 0.5 * cross(ab, vertices[facets[facet].vertex[2]] - a);
  }
  /// Mean of the vertices of a facet, m.
  Vec3 centroid(int facet) const {
    Vec3 sum;
    for (int n = 0; n < dimension; ++n) sum += vertices[facets[facet].vertex[n]];
    return (1.0 / dimension) * sum;
  }
};

/// Volume inside a closed surface, m^3 (m^2 in the plane); negative where facets point inwards.
double enclosed_volume(const Surface& surface);

/// Makes vertices nearer to each other than `tolerance` (m) one, and leaves out facets that lose their area by it, and
/// vertices without a facet. Returns the number of vertices that went.
int weld(Surface& surface, double tolerance);

/// Throws Error(bad_case) at `where` unless every edge (vertex in the plane) has just two facets that run against each
/// other: open, doubled and over-shared edges are told by number and place.
void require_closed(const Surface& surface, const SourceLocation& where);

/// Turns facets outwards shell by shell: a shell (facets that hang together by edges) inside an odd number of others is
/// a cavity, its facets point into it. Facets that run with a neighbour instead of against it are turned, too. Returns
/// the number of shells in which facets were turned.
int orient(Surface& surface);

/// Unit outward normal of every facet. Facets too thin to have one take that of a neighbour.
std::vector<Vec3> facet_normals(const Surface& surface);

/// The smooth patch of every facet: facets whose normals turn by less than `angle` (rad) across the edge between them
/// belong together. Patches are numbered in the order of their first facets.
std::vector<int> smooth_patches(const Surface& surface, double angle);

/// Names faces anew, by smooth patches: face1 is the largest, then face2, ...
void name_faces_by_angle(Surface& surface, double angle);

}  // namespace calor
