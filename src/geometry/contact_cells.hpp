#pragma once
// The cells of lattices end at contacts between layers.
#include "case/case.hpp"
#include "cloud/cloud.hpp"

namespace calor {

/// In a lattice of layers, gives the points beside the contacts the cells, faces and facets up to them in place of
/// those up to the middle between two points: what lies beyond a contact belongs to the points there. Not where a layer
/// between two contacts holds no points, and in bodies that have regions too. Collective; throws Error(bad_case).
void end_cells_at_contacts(const Case& c, Cloud& cloud);

}  // namespace calor
