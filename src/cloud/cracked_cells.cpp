// The cells of points beside cracks end there.
#include <algorithm>

#include "base/parallel.hpp"
#include "cloud/cell_samples.hpp"
#include "cloud/convex_cell.hpp"
#include "cloud/cracks.hpp"
#include "cloud/neighbours.hpp"

namespace calor {
namespace {

/// Cells of an unbroken body and of the one with cracks, around the points one after the other.
class CellsBesideCracks {
 public:
  CellsBesideCracks(const Cloud& cloud, const Cracks& cracks, const Neighbours& neighbours)
      : cloud_(cloud), cracks_(cracks), neighbours_(neighbours) {}

  /// Does a crack lie between the point and one of its neighbours?
  bool are_cut(int i) const {
    return std::ranges::any_of(neighbours_.of(i), [&](int j) { return cracks_.separate(place(i), place(j)); });
  }
  /// What the crack leaves of the cell of point i; with a face, of the layer of the cell along that plane.
  double share(int i, std::span<const Facet> facets, const Facet* face = nullptr) {
    const double whole = volume(i, facets, face, false);
    return whole > 0 ? volume(i, facets, face, true) / whole : 1;
  }

 private:
  const Vec3& place(int i) const { return cracks_.location(i); }

  double volume(int i, std::span<const Facet> facets, const Facet* face, bool is_cracked) {
    constexpr double reach = 1.5, layer = 1e-3;  // in spacings
    const Vec3 &x = cloud_.x[i], &d = cloud_.metric[i];
    cell_.set(-reach * d, reach * d, cloud_.dimension);
    for (const Facet& f : facets) cell_.cut(f.normal, wall_distance(cloud_, f));
    for (const int j : neighbours_.of(i)) {
      if (is_cracked && cracks_.separate(place(i), place(j))) continue;
      const Vec3 r = cloud_.x[j] - x, n = quotient(quotient(r, d), d);  // nearest in the metric
      cell_.cut(n, 0.5 * dot(r, n));
    }
    for (std::size_t c = 0; c < cracks_.all().size() && is_cracked; ++c) {
      for (const CrackPiece& piece : cracks_.segments(static_cast<int>(c))) {
        const double side = piece.side(place(i));
        const Vec3 beyond = place(i) - 2 * side * piece.normal;
        if (side != 0 && cracks_.separate(place(i), beyond))
          cell_.cut((side > 0 ? -1.0 : 1.0) * piece.normal, std::max(0.0, (side > 0 ? 1 : -1) * piece.side(x)));
      }
    }
    if (face) cell_.cut(-face->normal, layer * std::min({d.x, d.y, d.z}) - wall_distance(cloud_, *face));
    return cell_.volume();
  }

  const Cloud& cloud_;
  const Cracks& cracks_;
  const Neighbours& neighbours_;
  ConvexCell cell_;
};

}  // namespace

Support nearest_of(const Cloud& cloud) {
  const Support& support = cloud.halo_support;
  return support.length == 0 ? std::min(2.0, support.over_spacing * (1 - 1e-9)) : 2.0;
}

void end_cells_at_cracks(Cloud& cloud, const Cracks& cracks) {
  const Neighbours neighbours = find_neighbours(cloud, nearest_of(cloud));
  CellsBesideCracks cells(cloud, cracks, neighbours);
  auto whole = std::make_shared<Cloud::Measures>(Cloud::Measures{cloud.volume, cloud.area});
  std::vector<double> before, after;  // of the points beside cracks
  std::vector<int> beside;
  auto facet = cloud.facets.begin();
  for (int i = 0; i < cloud.owned; ++i) {
    const auto first = facet;
    while (facet != cloud.facets.end() && facet->point == i) ++facet;
    if (!cells.are_cut(i)) continue;
    const std::vector<Facet> facets(first, facet);
    beside.push_back(i);
    before.push_back(cloud.volume[i]);
    cloud.volume[i] *= cells.share(i, facets);
    after.push_back(cloud.volume[i]);
    for (std::size_t n = 0; n < facets.size(); ++n) {
      const double share = cells.share(i, facets, &facets[n]);
      cloud.area[i] -= (1 - share) * facets[n].area * facets[n].normal;
      first[static_cast<std::ptrdiff_t>(n)].area *= share;
    }
  }
  // Around tips the cells do not fill the body to the last.
  const double old_sum = sum(cloud.comm, before), new_sum = sum(cloud.comm, after);
  for (const int i : beside) cloud.volume[i] *= old_sum / new_sum;
  cloud.halo.update(std::span<double>(cloud.volume));
  cloud.halo.update(std::span<Vec3>(cloud.area));
  if (any(cloud.comm, !beside.empty())) cloud.whole = std::move(whole);
}

const Cloud& without_cracks(const Cloud& cloud, std::optional<Cloud>& copy) {
  if (!cloud.whole) return cloud;
  copy = cloud;
  copy->volume = cloud.whole->volume, copy->area = cloud.whole->area;
  return *copy;
}

}  // namespace calor
