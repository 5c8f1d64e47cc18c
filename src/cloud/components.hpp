#pragma once
// The bodies that a cloud consists of: points that hang together by pairs.
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

struct Components {
  std::vector<int> of;  ///< of every owned point, from 0, in the order of their first points
  int count = 1;
};

/// The same on any number of ranks. Collective.
Components components(const Cloud& cloud, const Neighbours& neighbours);

}  // namespace calor
