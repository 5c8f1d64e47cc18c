#include "cloud/neighbours.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "cloud/search.hpp"
#include "surface/solids.hpp"

namespace calor {
namespace {

std::string point_text(const Cloud& cloud, int i) {
  return fmt::format("{} at ({:.6g}, {:.6g}, {:.6g}) m", cloud.id[i], cloud.x[i].x, cloud.x[i].y, cloud.x[i].z);
}

[[noreturn]] void refuse_coincident(const Cloud& cloud, int i, std::span<const std::int32_t> near) {
  const auto distance = [&](int j) {
    return j == i ? std::numeric_limits<double>::infinity() : norm(cloud.x[j] - cloud.x[i]);
  };
  const int j = *std::ranges::min_element(near, {}, distance);
  const auto [first, second] = std::minmax(cloud.id[i], cloud.id[j]);
  const Vec3& x = cloud.x[i];
  throw Error(
      Fault::bad_case,
      fmt::format("points {} and {} (from 0) coincide at ({:.6g}, {:.6g}, {:.6g}) m", first, second, x.x, x.y, x.z),
      "remove one of them");
}

/// Do the ghosts reach as far as the support?
bool covers(const Cloud& cloud, const Search& search, const Support& support) {
  if (cloud.spacing.empty()) return true;
  const Vec3 reach = search.largest_reach();
  if (std::max({reach.x, reach.y, reach.z}) > cloud.halo_width) return false;
  const auto [least, most] = std::ranges::minmax(cloud.spacing);
  const auto within = [&](double d) { return support.radius(d) <= cloud.halo_support.radius(d) * (1 + 1e-9); };
  return within(least) && within(most);
}

/// Images across both of two opposite walls must not be within reach of a point.
void refuse_images_of_images(const Cloud& cloud, const Vec3& reach_here, std::uint32_t mirrored_faces) {
  for (std::size_t f = 0; f < cloud.walls.size(); f += 2) {
    if ((mirrored_faces >> f & 3) != 3) continue;
    const double thickness = cloud.walls[f + 1] - cloud.walls[f];
    double gap = std::numeric_limits<double>::max();  // between a wall and the points next to it
    for (int i = 0; i < cloud.owned; ++i) {
      const double x = cloud.x[i][static_cast<int>(f / 2)];
      gap = std::min({gap, x - cloud.walls[f], cloud.walls[f + 1] - x});
    }
    const double reach = max(cloud.comm, reach_here[static_cast<int>(f / 2)]);
    if (thickness + 2 * min(cloud.comm, gap) >= reach) continue;
    throw Error(Fault::bad_case,
                fmt::format("the body is {:.6g} m thick between {} and {}, less than the {:.6g} m that a point sees",
                            thickness, cloud.faces[f], cloud.faces[f + 1], reach),
                "give it more points along that axis, or a smaller horizon (or smoothing)");
  }
}

/// Adds the images within reach of point i: those of the points within reach of its own images.
void add_images(const Cloud& cloud, const Search& search, const Bounds& body, std::span<const std::uint32_t> sets,
                int i, std::vector<std::int32_t>& buffer, Neighbours& out) {
  const Vec3 reach = search.largest_reach();
  for (const std::uint32_t set : sets) {
    const Vec3 x = out.mirrors[set].point(cloud.x[i]);
    bool far = false;
    for (int a = 0; a < 3; ++a) far = far || x[a] < body.low[a] - reach[a] || x[a] > body.high[a] + reach[a];
    if (far) continue;
    int coincident = 0;
    for (const std::int32_t k : search.find(x, cloud.metric[i], buffer, coincident)) {
      out.column.push_back(search.local(k));
      out.image.push_back(static_cast<std::uint8_t>(set));
    }
  }
}

/// The sets of faces that have an image of their own, in ascending order.
std::vector<std::uint32_t> image_sets(std::uint32_t mirrored_faces) {
  std::vector<std::uint32_t> sets;
  for (std::uint32_t set = 1; set <= mirrored_faces; ++set)
    if ((set & ~mirrored_faces) == 0 && !has_opposite_walls(set)) sets.push_back(set);
  return sets;
}

/// Points that lie on a contact belong to one side of it: a thin part on the other side keeps those within it alone.
std::string cure_of_few_neighbours(const Cloud& cloud, int i) {
  if (!cloud.solids || !cloud.solids->sides())
    return "give it neighbours: more points, a larger support, or volumes that fit the distances";
  const std::string& part = cloud.tags[cloud.tag[i]];
  return fmt::format("{} is too thin there for its points: take a smaller spacing, or finer points there",
                     part.empty() ? "the body" : fmt::format("part '{}'", part));
}

}  // namespace

Neighbours find_neighbours(const Cloud& cloud, const Support& support, std::uint32_t mirrored_faces) {
  const Search search(cloud, support);
  refuse_images_of_images(cloud, search.largest_reach(), mirrored_faces);
  const std::vector<std::uint32_t> sets = image_sets(mirrored_faces);
  const Bounds body = bounds_of(cloud.x);
  Neighbours out;
  if (!sets.empty()) {
    out.mirrors = mirrors_of(cloud.walls);
    for (const Facet& facet : cloud.facets) out.mirrored.push_back(mirrored_faces >> facet.face & 1);
  }
  out.row.reserve(cloud.owned + 1);
  out.row.push_back(0);
  collective_try(cloud.comm, [&] {
    if (size_of(cloud.comm) > 1 && !covers(cloud, search, support))
      throw Error(Fault::numbers, "the ghosts do not reach as far as the neighbours",
                  "distribute the cloud with a larger support");
    std::vector<std::int32_t> buffer;
    for (int i = 0; i < cloud.owned; ++i) {
      int coincident = 0;
      auto found = search.find(cloud.x[i], cloud.metric[i], buffer, coincident);
      for (std::int32_t& k : found) k = search.local(k);
      if (coincident > 1) refuse_coincident(cloud, i, found);
      if (cloud.body) {
        const auto seen =
            std::remove_if(found.begin(), found.end(), [&](int j) { return j != i && !cloud.sees(i, j); });
        found = found.first(seen - found.begin());
      }
      const std::size_t size = out.column.size(), needed = size + found.size();
      if (out.column.capacity() < needed) {
        // From what the rows so far took, so that large lists are moved once or twice only, and are packed where they
        // are (pair_rows.hpp): for twice as much, as the first rows may be those of a wall, which are short. Room that
        // is never used costs no memory.
        const double rows = i < 1000 ? 1 : static_cast<double>(cloud.owned) / (i + 1.0);
        out.column.reserve(static_cast<std::size_t>(2 * rows * static_cast<double>(needed)));
      }
      const auto self = std::ranges::find(found, i);
      out.column.insert(out.column.end(), found.begin(), self);
      out.column.insert(out.column.end(), self + 1, found.end());
      if (!sets.empty()) {
        out.image.resize(out.column.size(), 0);
        add_images(cloud, search, body, sets, i, buffer, out);
      }
      out.row.push_back(static_cast<std::int64_t>(out.column.size()));
    }
  });
  return out;
}

void require_neighbours(const Cloud& cloud, const Neighbours& neighbours) {
  collective_try(cloud.comm, [&] {
    for (int i = 0; i < cloud.owned; ++i) {
      const int n = static_cast<int>(neighbours.of(i).size()), least = cloud.dimension;
      if (n < least)
        throw Error(Fault::bad_case,
                    fmt::format("point {} has {} neighbour{}, fewer than {}", point_text(cloud, i), n,
                                n == 1 ? "" : "s", least),
                    cure_of_few_neighbours(cloud, i));
    }
  });
}

std::vector<Mirror> mirrors_of(const std::vector<double>& walls) {
  std::vector<Mirror> mirrors(std::size_t{1} << walls.size());
  for (std::uint32_t set = 0; set < mirrors.size(); ++set) {
    if (has_opposite_walls(set)) continue;
    for (std::size_t f = 0; f < walls.size(); ++f) {
      if (!(set >> f & 1)) continue;
      const int axis = static_cast<int>(f / 2);
      mirrors[set].sign[axis] = -1;
      mirrors[set].shift[axis] = 2 * walls[f];
    }
  }
  return mirrors;
}

}  // namespace calor
