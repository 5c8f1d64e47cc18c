#pragma once
// Nodes of a mesh far closer to one another than the rest, as at small features of a part: as points they would see far
// more neighbours on one side than on the other, and no weights exist for them.
#include <cstdint>
#include <span>
#include <vector>

#include "cloud/simplices.hpp"

namespace calor {

/// Draws together the ends of edges shorter than 0.4 of the spacing there, where that neither turns a simplex inside
/// out nor the surface by more than 30 degrees: inner nodes go before those on the surface, these before those on its
/// edges; corners stay. The simplices that vanish are removed; what is left fills the body as before. Returns of every
/// node the one that stands for it, itself where it stays. `surface`: the facets of simplices that have no neighbour.
std::vector<std::int32_t> collapse_short_edges(Simplices& body, std::span<const BoundaryFacet> surface);

}  // namespace calor
