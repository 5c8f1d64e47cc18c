#pragma once
// The groups of elements of a mesh as solids: what tells which of them holds a place.
#include <memory>
#include <vector>

#include "cloud/simplices.hpp"
#include "surface/solids.hpp"

namespace calor {

/// One solid for every tag of the simplices; null where all have the same.
std::shared_ptr<const Solids> solids_of_groups(const Simplices& body, const std::vector<int>& tag_of_simplex);

}  // namespace calor
