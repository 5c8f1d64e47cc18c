#include "cloud/bisection.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "base/parallel.hpp"

namespace calor {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr int bins = 64;

/// A set of points that goes to ranks first .. first + ranks, and the search for the points of its lower half: among
/// the `open` points that are still undecided, `wanted` go below.
struct Group {
  int first = 0, ranks = 1;
  std::array<int, 4> keys = {2, 1, 0, 3};  ///< axes, longest first; 3 is the id
  int key = 0;                             ///< place in keys
  std::int64_t wanted = 0, open = 0;
  double low = 0, high = 0;  ///< of the key over the open points

  bool decided() const { return wanted == 0 || wanted == open; }
};

double key_of(const Point& p, int key) { return key == 3 ? static_cast<double>(p.id) : p.x[key]; }

/// Lowest and highest value of key(point) over the listed points of each group, over all ranks: {low, -high}.
template <class Key>
std::vector<double> extents(MPI_Comm comm, std::size_t groups, std::span<const int> group,
                            std::span<const std::int32_t> listed, const Key& key) {
  std::vector<double> e(2 * groups, inf);
  for (std::int32_t i : listed) {
    const double v = key(i);
    double* out = &e[2 * group[i]];
    out[0] = std::min(out[0], v);
    out[1] = std::min(out[1], -v);
  }
  lowest(comm, e);
  return e;
}

void choose_axes(MPI_Comm comm, std::span<const Point> points, std::span<const int> group,
                 std::span<const std::int32_t> all, std::vector<Group>& groups) {
  std::array<std::vector<double>, 3> e;
  for (int a = 0; a < 3; ++a)
    e[a] = extents(comm, groups.size(), group, all, [&](std::int32_t i) { return points[i].x[a]; });
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const auto length = [&](int a) { return -e[a][2 * g + 1] - e[a][2 * g]; };
    // Of sides that are equal but for rounding the last: its slabs are whole stretches of the order.
    std::ranges::stable_sort(groups[g].keys.begin(), groups[g].keys.begin() + 3,
                             [&](int a, int b) { return length(a) > length(b) * (1 + 1e-9); });
  }
}

/// Halves every group that has more than one rank; group[i] follows.
void halve(MPI_Comm comm, std::span<const Point> points, std::vector<int>& group, std::vector<Group>& groups) {
  std::vector<std::int32_t> open(points.size());
  std::iota(open.begin(), open.end(), 0);
  choose_axes(comm, points, group, open, groups);
  std::vector<char> upper(points.size(), 0);
  const auto settle = [&] {
    std::erase_if(open, [&](std::int32_t i) {
      const Group& g = groups[group[i]];
      if (g.decided()) upper[i] = g.wanted == 0;
      return g.decided();
    });
  };
  settle();
  while (std::ranges::any_of(groups, [](const Group& g) { return !g.decided(); })) {
    const auto key = [&](std::int32_t i) {
      const Group& g = groups[group[i]];
      return key_of(points[i], g.keys[g.key]);
    };
    const std::vector<double> e = extents(comm, groups.size(), group, open, key);
    for (std::size_t g = 0; g < groups.size(); ++g) groups[g].low = e[2 * g], groups[g].high = -e[2 * g + 1];
    const auto bin = [&](std::int32_t i) {
      const Group& g = groups[group[i]];
      if (!(g.high > g.low)) return 0;
      return std::min(bins - 1, static_cast<int>((key(i) - g.low) / (g.high - g.low) * bins));
    };
    std::vector<std::int64_t> count(bins * groups.size(), 0);
    for (std::int32_t i : open) ++count[bins * group[i] + bin(i)];
    add_up(comm, count);

    std::vector<int> cut(groups.size(), 0);  // the bin that holds the last point that goes below
    std::vector<char> next_key(groups.size(), 0);
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (groups[g].decided()) continue;
      if (!(groups[g].high > groups[g].low)) {
        next_key[g] = 1;
        continue;
      }
      const std::int64_t* n = &count[bins * g];
      for (; n[cut[g]] < groups[g].wanted; ++cut[g]) groups[g].wanted -= n[cut[g]];
      groups[g].open = n[cut[g]];
    }
    std::erase_if(open, [&](std::int32_t i) {
      if (next_key[group[i]]) return false;
      const int b = bin(i), c = cut[group[i]];
      upper[i] = b > c;
      return b != c;
    });
    for (std::size_t g = 0; g < groups.size(); ++g) groups[g].key += next_key[g];
    settle();
  }

  std::vector<Group> halves;
  std::vector<int> lower_half(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const Group& whole = groups[g];
    lower_half[g] = static_cast<int>(halves.size());
    const int below = whole.ranks / 2;
    if (below == 0) {
      halves.push_back({.first = whole.first});
    } else {
      halves.push_back({.first = whole.first, .ranks = below});
      halves.push_back({.first = whole.first + below, .ranks = whole.ranks - below});
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) group[i] = lower_half[group[i]] + upper[i];
  groups = std::move(halves);
}

}  // namespace

std::vector<int> bisect(MPI_Comm comm, std::span<const Point> points) {
  const std::int64_t count = total(comm, static_cast<std::int64_t>(points.size()));
  const std::int64_t ranks = size_of(comm);
  const auto share = [&](std::int64_t r) { return count / ranks * r + count % ranks * r / ranks; };
  std::vector<Group> groups = {{.first = 0, .ranks = static_cast<int>(ranks)}};
  std::vector<int> group(points.size(), 0);
  while (std::ranges::any_of(groups, [](const Group& g) { return g.ranks > 1; })) {
    for (Group& g : groups) {
      g.open = share(g.first + g.ranks) - share(g.first);
      g.wanted = g.ranks > 1 ? share(g.first + g.ranks / 2) - share(g.first) : g.open;
    }
    halve(comm, points, group, groups);
  }
  for (int& g : group) g = groups[g].first;
  return group;
}

}  // namespace calor
