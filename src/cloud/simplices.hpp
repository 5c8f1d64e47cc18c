#pragma once
// A mesh cut into simplices: triangles of a plane body, tetrahedra of a body in space; and the facets of its surface.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/vec3.hpp"
#include "mesh/mesh.hpp"

namespace calor {

struct Simplex {
  std::array<std::int32_t, 4> node;
  int name = 0;  ///< index into Mesh::names, of the element
  int sign = 1;  ///< -1: of an element that is inside out
};

/// A facet of one simplex alone.
struct BoundaryFacet {
  std::array<std::int32_t, 3> node;
  int name = 0;  ///< index into Mesh::names, 0 for none
  Vec3 area;     ///< outward, m^2; in the plane m
};

struct Simplices {
  int dimension = 3;
  std::vector<Vec3> x;              ///< m; in the plane z = 0. Of nodes that elements use, in the order of the file
  std::vector<std::int64_t> label;  ///< number of every node in the file
  std::vector<Simplex> simplices;
  std::vector<BoundaryFacet> surface;
  std::vector<std::string> notes;

  /// m^3 (m^2); negative where an element is folded.
  double volume(const Simplex& s) const;
};

/// Cuts the elements of the highest dimension; quadrilaterals, also those between elements, from their node that comes
/// first, so that neighbours agree (Dompierre et al., "How to subdivide pyramids, prisms and hexahedra into
/// tetrahedra", 1999). Nodes that coincide become one. Elements inside out are turned. Facets of the surface are named
/// by elements of the surface, then by sets of nodes. `unit`: m; `file`: of the mesh. Throws Error(bad_case).
Simplices make_simplices(const Mesh& mesh, double unit, const SourceLocation& file);

}  // namespace calor
