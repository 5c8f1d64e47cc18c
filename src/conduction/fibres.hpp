#pragma once
// Pairs of a lattice whose cells hold several parts. The heat of such a pair does not run along the line between its
// points alone: it runs through the face that their cells share, each part of it in the way of its own.
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "cloud/cloud.hpp"
#include "geometry/parts.hpp"

namespace calor {

/// A share of the face of a pair, whose heat runs parallel to the line between the points.
struct Fibre {
  Parts::Segment segment;
  std::vector<SegmentPiece> run;  ///< what it runs through
  double share;
};

/// Does the cell of a local point hold one part alone, as far as its corners tell? Throws Error(bad_case).
std::vector<char> hold_one_part(const Cloud& cloud, const Parts& parts);

/// The fibres of pairs (a, b) of local points of a lattice. Their face is what the cells of a and b have in common
/// along the axes on which the points do not differ; it is cut into rectangles where parts meet, exactly where
/// interfaces are parallel to the axes. Fibres through the same parts are one. Beyond a contact the points'
/// temperatures say nothing: what lies there is left to the points on that side. Shares add up to 1. The same bits on
/// all ranks that know the pair. Throws Error(bad_case).
std::vector<std::vector<Fibre>> fibres(const Cloud& cloud, const Parts& parts,
                                       std::span<const std::pair<std::int32_t, std::int32_t>> pairs);

/// Those between the points of a lattice in the middle of cells and the facets of Cloud::facets before them.
std::vector<std::vector<Fibre>> fibres_to_walls(const Cloud& cloud, const Parts& parts);

}  // namespace calor
