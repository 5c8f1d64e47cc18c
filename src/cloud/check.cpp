#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "cloud/cells.hpp"
#include "cloud/cloud.hpp"
#include "cloud/points.hpp"

namespace calor {

Bounds bounds_of_all(const Cloud& cloud) {
  Bounds box = bounds_of(cloud.owned_points());
  for (int a = 0; a < 3; ++a) box.low[a] = min(cloud.comm, box.low[a]), box.high[a] = max(cloud.comm, box.high[a]);
  return box;
}

CloudCheck check(const Cloud& cloud) {
  const Bounds box = bounds_of_all(cloud);
  const Vec3 middle = 0.5 * (box.low + box.high);
  const double size = norm(box.high - box.low);

  constexpr int columns = 8;  // V, |A|, A, x cross A
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(columns) * cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3 A = cloud.plane_area(i);
    const Vec3 moment = cross(cloud.x[i] - middle, A);
    values.insert(values.end(), {cloud.volume[i], norm(A), A.x, A.y, A.z, moment.x, moment.y, moment.z});
  }
  const std::vector<double> s = sums(cloud.comm, values, columns);
  const double area = s[1] > 0 ? s[1] : 1;
  return {.volume = s[0],
          .volume_error = cloud.exact.volume > 0 ? std::abs(s[0] - cloud.exact.volume) / cloud.exact.volume : 0,
          .area_sum = norm({s[2], s[3], s[4]}) / area,
          .moment_sum = size > 0 ? norm({s[5], s[6], s[7]}) / (area * size) : 0};
}

std::vector<std::string> remarks_on_surface(const Cloud& cloud) {
  if (!cloud.has_areas) return {};
  const Bounds box = bounds_of_all(cloud);
  const Vec3 middle = 0.5 * (box.low + box.high);
  constexpr int columns = 7;  // D V, x.A at the points, y |A| beyond them, |A|, A
  std::vector<double> rows(columns * static_cast<std::size_t>(cloud.owned));
  for (int i = 0; i < cloud.owned; ++i) {
    double* row = rows.data() + columns * static_cast<std::size_t>(i);
    const Vec3 A = cloud.whole ? cloud.whole->area[i] : cloud.plane_area(i);
    row[0] = cloud.dimension * cloud.volume[i];
    row[1] = dot(cloud.x[i] - middle, A);
    row[4] = A.x, row[5] = A.y, row[6] = A.z;
  }
  for (const Facet& facet : cloud.facets) {
    double* row = rows.data() + columns * static_cast<std::size_t>(facet.point);
    row[2] += facet.area * wall_distance(cloud, facet);
    row[3] += facet.area;
  }
  const std::vector<double> s = sums(cloud.comm, rows, columns);
  const std::int64_t pieces = total(cloud.comm, static_cast<std::int64_t>(cloud.facets.size()));
  const std::string by_D = cloud.dimension == 1 ? "" : fmt::format(" / {}", cloud.dimension);
  const double inside = s[0] / cloud.dimension, enclosed = (s[1] + s[2]) / cloud.dimension;
  if (s[1] < 0)
    throw Error(
        Fault::bad_case,
        fmt::format("the boundary areas point inwards: the sum of x.A{} is {:.6g} m^3, the volumes sum up to {:.6g} "
                    "m^3",
                    by_D, s[1] / cloud.dimension, inside),
        "area vectors point out of the body: change their signs");
  std::vector<std::string> notes;
  if (const auto found = std::ranges::find(cloud.faces, undescribed_face); found != cloud.faces.end()) {
    const auto lacking = std::ranges::count(cloud.facets, found - cloud.faces.begin(), &Facet::face);
    return {
        fmt::format("{} points lie at walls without a piece of surface, which count as the face '{}', insulated, with "
                    "areas by estimate: every wall needs its areas, insulated ones too",
                    total(cloud.comm, static_cast<std::int64_t>(lacking)), undescribed_face)};
  }
  const double open = norm({s[4], s[5], s[6]});
  if (open > 1e-3 * s[3] || open > 0.25 * s[3] / static_cast<double>(pieces))
    notes.push_back(
        fmt::format("the surface does not close: its area vectors sum up to ({:.3g}, {:.3g}, {:.3g}) m^2, "
                    "which is {:.2g} of all area and {:.2g} of a mean piece, and should vanish: is a piece of "
                    "surface missing?",
                    s[4], s[5], s[6], open / s[3], open / s[3] * static_cast<double>(pieces)));
  constexpr double as_surfaces_of_chords = 0.01;
  if (std::abs(enclosed - inside) > as_surfaces_of_chords * inside)
    notes.push_back(
        fmt::format("the volumes of the points sum up to {:.6g} m^3, but their surface encloses {:.6g} m^3 (sum of "
                    "x.A{}{}): {:.2g} % "
                    "off. {}",
                    inside, enclosed, by_D, cloud.points_on_walls ? "" : ", and half a cell to the walls",
                    100 * (inside / enclosed - 1),
                    cloud.points_on_walls ? "Points on walls have half cells, those on edges quarters"
                                          : "No points lie on the walls: those beside them have whole cells"));
  return notes;
}

}  // namespace calor
