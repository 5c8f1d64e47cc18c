// Cracks that do nothing: beside the body, shorter than the distance of its points, or after the end of the run.
#include <fmt/format.h>

#include <algorithm>

#include "base/parallel.hpp"
#include "cloud/cracks.hpp"
#include "cloud/neighbours.hpp"
#include "cloud/points.hpp"

namespace calor {
namespace {

/// Refuses a crack that is farther than `margin` from the box around the points.
void require_within(const Table& table, const Crack& crack, const Bounds& body, double margin, int dimension) {
  for (int axis = 0; axis < dimension; ++axis) {
    const auto [low, high] = std::ranges::minmax(crack.vertices, {}, [axis](const Vec3& v) { return v[axis]; });
    if (high[axis] >= body.low[axis] - margin && low[axis] <= body.high[axis] + margin) continue;
    table.refuse(std::string(1, "xyz"[axis]),
                 fmt::format("the crack lies outside the body, which reaches from {0} = {1:.6g} m to {0} = {2:.6g} m",
                             "xyz"[axis], body.low[axis], body.high[axis]),
                 "move the crack, or leave it out");
  }
}

}  // namespace

std::vector<std::string> notes_on_cracks(const Case& c, const Cloud& cloud) {
  const std::vector<Table> tables = c.root().list("crack");
  const std::vector<Crack> asked = read_cracks(c, cloud);
  const Bounds body = bounds_of_all(cloud);
  double spacing = 0;
  for (int i = 0; i < cloud.owned; ++i) spacing = std::max(spacing, cloud.spacing[i]);
  spacing = max(cloud.comm, spacing);
  for (std::size_t n = 0; n < asked.size(); ++n) require_within(tables[n], asked[n], body, spacing, cloud.dimension);

  std::vector<std::int64_t> cut(asked.size());
  const Cracks cracks(cloud, asked);
  for (const Crossing& x : cracks.crossings(find_neighbours(cloud, nearest_of(cloud)))) cut[x.crack] += x.fraction > 0;
  add_up(cloud.comm, cut);
  std::vector<std::string> notes;
  for (std::size_t n = 0; n < asked.size(); ++n) {
    const std::string place = tables[n].location().text();
    if (cut[n] == 0)
      notes.push_back(fmt::format(
          "{}: the crack does nothing: it runs between no two neighbouring points of the body; it lies beside the "
          "body or along its surface, or is shorter than the spacing of {:.3g} mm",
          place, 1e3 * spacing));
    if (asked[n].fails() && asked[n].opens >= c.section("time").number("end"))
      notes.push_back(fmt::format("{}: the crack opens at {:g} s, after the end of the run: the body stays whole",
                                  place, asked[n].opens));
  }
  return notes;
}

}  // namespace calor
