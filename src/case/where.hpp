#pragma once
// Selections of points by formula: where = "x > 0.5 && r < 1", with length = "mm" beside it.
#include <span>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"

namespace calor {

/// 1 for every point at which the formula of `table`'s key `where` is true. Throws Error(bad_case) at the key for a
/// formula that is wrong, is not finite at a point, or depends on more than place.
std::vector<char> where(const Case& c, const Table& table, std::span<const Vec3> x);

/// The keys `where` and `length`, to be declared with the others of a section.
std::vector<Key> where_keys(const std::string& sentence);

}  // namespace calor
