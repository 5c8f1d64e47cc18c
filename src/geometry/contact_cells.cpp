#include "geometry/contact_cells.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/cracks.hpp"
#include "cloud/lattice.hpp"

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

void end_cells_at_planes(const Parts& parts, const std::string& along, Cloud& cloud) {
  const int axis = along == "x" ? 0 : along == "y" ? 1 : 2;
  const bool is_radius = cloud.axisymmetric && axis == 0;  // the thickness of the cells is 2 pi of their middles
  const std::shared_ptr<const Lattice> before = cloud.lattice;
  auto lattice = std::make_shared<Lattice>(*before);
  lattice->end_cells_at(axis, contact_planes(cloud, parts, axis));
  const auto middle = [](const Lattice& of, int a, std::int64_t at) {
    const auto [low, high] = of.cell(a, at);
    return 0.5 * (low + high);
  };
  const auto wider = [&](int i) {
    const std::int64_t at = before->index(cloud.id[i])[axis];
    return lattice->width(axis, at) / before->width(axis, at);
  };
  const auto larger = [&](int i) {  // with the thickness
    const std::int64_t at = before->index(cloud.id[i])[axis];
    return wider(i) * (is_radius ? middle(*lattice, axis, at) / middle(*before, axis, at) : 1);
  };
  for (int i = 0; i < cloud.local(); ++i) {
    cloud.volume[i] *= larger(i), cloud.full_volume[i] *= larger(i);
    for (int a = 0; a < 3; ++a)
      if (a != axis) cloud.area[i][a] *= larger(i);
    if (!cloud.axisymmetric) continue;
    cloud.hoop[i] *= wider(i);
    const LatticeIndex at = before->index(cloud.id[i]);
    for (int a = 0; a < cloud.dimension; ++a)
      cloud.moment[i][a] = cloud.hoop[i] * (middle(*lattice, a, at[a]) - cloud.x[i][a]);
  }
  for (Facet& facet : cloud.facets)
    if (facet.face / 2 != axis) facet.area *= larger(facet.point);
  cloud.lattice = std::move(lattice);
  cloud.box_lattice = false;  // its cells are not alike any more
}

/// Of two parts: does a contact lie between them, where they meet or where layers between them do?
std::vector<std::vector<char>> separated_parts(const Parts& parts, int layers) {
  std::vector<std::vector<char>> separated(parts.count(), std::vector<char>(parts.count()));
  for (int p = 0; p < parts.count(); ++p)
    for (int q = p + 1; q < parts.count(); ++q) {
      bool found = parts.contact(p, q);
      for (int layer = p; layer < q && q < layers; ++layer) found = found || parts.contact(layer, layer + 1);
      separated[p][q] = separated[q][p] = found;
    }
  return separated;
}

/// Does a contact run through a cell, not between two of them?
bool contacts_cut_cells(const Parts& parts, const std::vector<std::vector<char>>& separated, const Cloud& cloud) {
  constexpr double cut = 1e-6;  // of the cell: below, round-off
  const std::vector<PlacesOfPart> shares = parts.cell_shares();
  const std::vector<int> own = parts.at(cloud.x, cloud.tag);
  bool found = false;
  for (int p = 0; p < parts.count(); ++p)
    for (std::size_t n = 0; n < shares[p].place.size(); ++n)
      found = found || (shares[p].share[n] > cut && separated[p][own[shares[p].place[n]]]);
  return any(cloud.comm, found);
}

}  // namespace

void end_cells_at_contacts(const Case& c, Cloud& cloud) {
  const Table body = c.section("body");
  const bool has_contact =
      !body.list("contact").empty() || std::ranges::any_of(std::array{"layer", "region"}, [&](const char* kind) {
        return std::ranges::any_of(body.list(kind), [](const Table& part) { return part.has("contact"); });
      });
  if (!has_contact) return;
  const auto parts = std::make_shared<const Parts>(c, cloud, "");
  if (cloud.lattice && body.has("along") && body.list("region").empty()) {
    end_cells_at_planes(*parts, body.text("along"), cloud);
    return;
  }
  std::vector<std::vector<char>> separated = separated_parts(*parts, static_cast<int>(body.list("layer").size()));
  const bool are_served =
      !cloud.axisymmetric && !has_cracks(c) && cloud.has_areas && (!cloud.lattice || cloud.box_lattice);
  if (are_served && !cloud.lattice) return end_cells_between_points(parts, std::move(separated), cloud);
  if (!contacts_cut_cells(*parts, separated, cloud)) return;
  if (are_served) return end_cells_between_points(parts, std::move(separated), cloud);
  cloud.notes.push_back(
      "a contact runs through the cells of points, which is of first order with cracks, in axisymmetric bodies but "
      "between layers of a box, and with regions on points of unequal spacings: put it midway between points where you "
      "can");
}

}  // namespace calor
