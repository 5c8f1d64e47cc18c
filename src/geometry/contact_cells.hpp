#pragma once
// Cells end at the contacts between parts.
#include <memory>
#include <vector>

#include "case/case.hpp"
#include "cloud/cloud.hpp"
#include "geometry/parts.hpp"

namespace calor {

/// Gives the points beside contacts the cells, faces and facets up to them: what lies beyond a contact belongs to the
/// points there. In a lattice of layers these stay boxes. Elsewhere the cloud is no lattice any more, and it knows the
/// sides of its contacts (Solids::sides). Not where a layer between two contacts holds no points, on lattices whose
/// spacings differ, in axisymmetric bodies that are no lattice of layers, and with cracks. Collective; throws
/// Error(bad_case).
void end_cells_at_contacts(const Case& c, Cloud& cloud);

/// The part of it that does not keep boxes. `separated`: see Sides. Collective; throws Error(bad_case).
void end_cells_between_points(std::shared_ptr<const Parts> parts, std::vector<std::vector<char>> separated,
                              Cloud& cloud);

}  // namespace calor
