#pragma once
// What follows from a cloud and its pairs can be kept: Cache.
#include "base/cache.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

/// Of points, volumes, areas and pairs of this rank.
Fingerprint fingerprint(const Cloud& cloud, const Neighbours& neighbours);

}  // namespace calor
