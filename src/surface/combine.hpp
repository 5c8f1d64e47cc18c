#pragma once
// Several closed surfaces as one body: what is left of one without another, what two have in common, and where solids
// that touch meet. Facets are cut where they cross others, so that all results are closed and made of flat facets that
// lie where those given do.
#include <vector>

#include "surface/surface.hpp"

namespace calor {

/// The body a without b; the walls of the cut have the faces of b. Both surfaces are closed, facets outward; so is the
/// result, which has no facets where nothing is left.
Surface difference(const Surface& a, const Surface& b);

/// What a and b have in common.
Surface intersection(const Surface& a, const Surface& b);

/// Solids that touch, as one body.
struct Assembly {
  Surface surface;  ///< its walls, a closed surface, then the interfaces, where two solids meet
  int walls = 0;    ///< so many facets are walls
};

/// Of solids that do not overlap. Interfaces are facets of the later one of the two solids. Facets share edges as a
/// whole: those of walls with those of interfaces, too.
Assembly assemble(const std::vector<Surface>& solids);

}  // namespace calor
