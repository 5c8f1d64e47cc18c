#include "geometry/contact_cells.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include "cloud/lattice.hpp"
#include "geometry/parts.hpp"

namespace calor {
namespace {

/// Where layers with a contact between them meet, by a line across all of them.
std::vector<double> contact_planes(const Cloud& cloud, const Parts& parts, int axis) {
  Parts::Segment line{.a = {}, .b = {}};
  line.a[axis] = cloud.walls[2 * axis], line.b[axis] = cloud.walls[2 * axis + 1];
  const Parts::Pieces pieces = parts.along({&line, 1});
  const auto run = pieces.of(0);
  std::vector<double> planes;
  for (std::size_t n = 0; n + 1 < run.size(); ++n)
    if (parts.contact(run[n].part, run[n + 1].part))
      planes.push_back(line.a[axis] + run[n].end * (line.b[axis] - line.a[axis]));
  return planes;
}

}  // namespace

void end_cells_at_contacts(const Case& c, Cloud& cloud) {
  const Table body = c.section("body");
  if (!cloud.lattice || cloud.axisymmetric || !body.has("along") || !body.list("region").empty()) return;
  const Parts parts(c, cloud, "");
  if (!parts.has_contacts()) return;
  const std::string along = body.text("along");
  const int axis = along == "x" ? 0 : along == "y" ? 1 : 2;
  auto lattice = std::make_shared<Lattice>(*cloud.lattice);
  lattice->end_cells_at(axis, contact_planes(cloud, parts, axis));
  const auto change = [&](int i) {
    const std::int64_t at = lattice->index(cloud.id[i])[axis];
    return lattice->width(axis, at) / cloud.lattice->width(axis, at);
  };
  for (int i = 0; i < cloud.local(); ++i) {
    cloud.volume[i] *= change(i), cloud.full_volume[i] *= change(i);
    for (int a = 0; a < 3; ++a)
      if (a != axis) cloud.area[i][a] *= change(i);
  }
  for (Facet& facet : cloud.facets)
    if (facet.face / 2 != axis) facet.area *= change(facet.point);
  cloud.lattice = std::move(lattice);
  cloud.box_lattice = false;  // its cells are not alike any more
}

}  // namespace calor
