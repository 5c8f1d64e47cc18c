#include "material/regions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"

namespace calor {
namespace {

// At most two materials meet in a point; -1 is none.
using Pair = std::array<int, 2>;

struct Map {
  std::vector<BodyRegion> regions;
  std::vector<Pair> of_point;

  int region(const std::string& material, const SourceLocation& location) {
    for (std::size_t m = 0; m < regions.size(); ++m)
      if (regions[m].material == material) return static_cast<int>(m);
    regions.push_back({.material = material, .location = location});
    return static_cast<int>(regions.size()) - 1;
  }
};

void fill_layers(const Table& body, const std::vector<Table>& layers, const Cloud& cloud, const MaterialPoints& places,
                 Map& map) {
  if (!body.has("along"))
    body.refuse("", "[body] has layers, but not the axis across them", "add along = \"x\", \"y\" or \"z\"");
  const std::string along = body.text("along");
  const int axis = along[0] - 'x';
  if (axis >= cloud.dimension)
    body.refuse("along", fmt::format("the body has no axis {}: it is {}D", along, cloud.dimension),
                cloud.dimension == 1 ? "write along = \"x\"" : "write along = \"x\" or \"y\"");

  std::vector<double> top;  // upper sides of the layers above the start
  std::vector<int> region;
  for (const Table& layer : layers) {
    const double d = layer.number("thickness");
    if (!(d > 0)) layer.refuse("thickness", fmt::format("the thickness is {:.6g} m", d), "it must be positive");
    top.push_back((top.empty() ? 0 : top.back()) + d);
    region.push_back(map.region(layer.text("material"), layer.location("material")));
  }

  double low = std::numeric_limits<double>::max(), high = -low;
  for (int i = 0; i < cloud.owned; ++i) {
    // Points in the middle of their cells stand half a spacing off the wall.
    const double wall = cloud.points_on_walls ? 0 : cloud.spacing[i] / 2;
    low = std::min(low, cloud.x[i][axis] - wall);
    high = std::max(high, cloud.x[i][axis] + wall);
  }
  low = min(cloud.comm, low), high = max(cloud.comm, high);
  const double start = body.has("start") ? body.number("start") : low, total = top.back();
  // Jittered cell centres know their wall only roughly.
  const double slack = (cloud.points_on_walls ? 1e-6 : 1e-2) * (high - low);
  const bool short_of = start > low + slack || start + total < high - slack;
  if (short_of || (!body.has("start") && start + total > high + slack))
    body.refuse(
        "layer",
        fmt::format("the layers are {:.6g} m thick together, from {} = {:.6g} m, the body reaches from {:.6g} m "
                    "to {:.6g} m ({:.6g} m)",
                    total, along, start, low, high, high - low),
        short_of ? "make them as thick as the body" : "make them as thick as the body, or say where they start");

  const double near = 1e-9 * total;
  for (std::size_t i = 0; i < places.x.size(); ++i) {
    const double s = places.x[i][axis] - start;
    const std::size_t layer =
        std::min<std::size_t>(std::ranges::lower_bound(top, s - near) - top.begin(), top.size() - 1);
    const bool interface = std::abs(s - top[layer]) <= near && layer + 1 < top.size();
    const int upper = interface && region[layer + 1] != region[layer] ? region[layer + 1] : -1;
    map.of_point[i] = {region[layer], upper};
  }
}

void fill_region(const Case& c, const Table& table, const Cloud& cloud, const MaterialPoints& places, Map& map) {
  if (table.has("where") == table.has("tag"))
    table.refuse("", table.has("tag") ? "the region has 'where' and 'tag'" : "the region says nothing of its points",
                 "give where = \"...\" or tag = \"...\"");
  std::vector<char> in(places.x.size());
  if (table.has("where")) {
    collective_try(cloud.comm, [&] { in = where(c, table, places.x); });
  } else {
    const auto tag = std::ranges::find(cloud.tags, table.text("tag"));
    if (tag == cloud.tags.end())
      table.refuse("tag", fmt::format("no point has the tag '{}'", table.text("tag")),
                   fmt::format("the tags of the cloud are '{}'", fmt::join(cloud.tags, "', '")));
    for (std::size_t i = 0; i < in.size(); ++i) in[i] = places.tag[i] == tag - cloud.tags.begin();
  }
  if (!any(cloud.comm, std::ranges::count(in, 1) > 0))
    table.refuse(table.has("where") ? "where" : "tag", "the region holds no point",
                 "change the selection, or leave the region out");
  const int m = map.region(table.text("material"), table.location("material"));
  for (std::size_t i = 0; i < in.size(); ++i)
    if (in[i]) map.of_point[i] = {m, -1};
}

}  // namespace

std::vector<BodyRegion> body_regions(const Case& c, const Cloud& cloud, const MaterialPoints& places,
                                     const std::string& only_material) {
  const Table body = c.section("body");
  const auto layers = body.list("layer"), regions = body.list("region");
  Map map;
  if (layers.empty() && regions.empty()) {
    map.region(body.has("material") ? body.text("material") : only_material, body.location("material"));
    map.regions[0].whole = true;
    return map.regions;
  }
  if (!layers.empty() && body.has("material"))
    body.refuse("material", "[body] has a material for the rest of the body, but its layers leave no rest",
                "leave it out");

  map.of_point.assign(places.x.size(), {-1, -1});
  if (!layers.empty()) fill_layers(body, layers, cloud, places, map);
  if (body.has("material")) {
    const int m = map.region(body.text("material"), body.location("material"));
    std::ranges::fill(map.of_point, Pair{m, -1});
  }
  for (const Table& region : regions) fill_region(c, region, cloud, places, map);

  collective_try(cloud.comm, [&] {
    for (std::size_t i = 0; i < places.x.size(); ++i)
      if (map.of_point[i][0] < 0)
        body.refuse("region",
                    fmt::format("no region holds the point at ({:.6g}, {:.6g}, {:.6g}) m", places.x[i].x, places.x[i].y,
                                places.x[i].z),
                    "give [body] a material for the points that no region takes");
  });
  for (std::size_t i = 0; i < places.x.size(); ++i) {
    const auto [m, upper] = map.of_point[i];
    for (const int r : {m, upper}) {
      if (r < 0) continue;
      map.regions[r].point.push_back(static_cast<int>(i));
      map.regions[r].weight.push_back(upper < 0 ? 1 : 0.5);
    }
  }
  if (map.regions.size() == 1) map.regions[0] = {map.regions[0].material, map.regions[0].location, true, {}, {}};
  return map.regions;
}

}  // namespace calor
