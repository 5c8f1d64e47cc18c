#include "cloud/components.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <span>

#include "base/parallel.hpp"

namespace calor {

Components components(const Cloud& cloud, const Neighbours& neighbours) {
  std::vector<int> parent(cloud.local());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (int i = 0; i < cloud.owned; ++i) {
    int own = root(i);
    for (const int j : neighbours.of(i))
      if (const int other = root(j); other != own) own = parent[own] = other;
  }

  // The least id of every component, carried from rank to rank by the ghosts.
  std::vector<double> first(cloud.id.begin(), cloud.id.end());
  for (bool changes = true; changes;) {
    std::vector<double> least = first;
    for (int i = 0; i < cloud.local(); ++i) least[root(i)] = std::min(least[root(i)], first[i]);
    changes = false;
    for (int i = 0; i < cloud.local(); ++i) {
      changes = changes || least[root(i)] < first[i];
      first[i] = least[root(i)];
    }
    cloud.halo.update(std::span<double>(first));
    changes = any(cloud.comm, changes);
  }
  const std::set<double> mine(first.begin(), first.begin() + cloud.owned);
  std::vector<double> all = gather(cloud.comm, std::vector<double>(mine.begin(), mine.end()));
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  Components out{.of = std::vector<int>(cloud.owned), .count = static_cast<int>(all.size())};
  for (int i = 0; i < cloud.owned; ++i)
    out.of[i] = static_cast<int>(std::ranges::lower_bound(all, first[i]) - all.begin());
  return out;
}

}  // namespace calor
