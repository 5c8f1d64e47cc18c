#pragma once
// What all parts of a body have in common, whatever their shape: lengths, the place where they stand, copies.
#include <string>
#include <vector>

#include "case/case.hpp"
#include "surface/surface.hpp"

namespace calor {

/// Lengths of the table, m, one for every axis; refuses another number of them, and ones that are not positive.
Vec3 positive_lengths(const Table& part, const std::string& key, int dimension);

/// Inner and outer radius of the table, m; refuses 0 >= inner and inner >= outer.
struct Radii {
  double inner, outer;
};
Radii inner_and_outer(const Table& part);

/// The keys at, turn, count and step of [[cloud.part]], which every shape takes.
std::vector<Key> placing_keys();

/// The surface turned around the origin, moved to its place and repeated as the keys say. Copies are one surface with
/// the faces of the first. Throws Error(bad_case).
Surface place(Surface surface, const Table& part);

}  // namespace calor
