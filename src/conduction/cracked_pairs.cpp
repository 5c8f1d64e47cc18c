#include "conduction/cracked_pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/parallel.hpp"
#include "conduction/contact_pairs.hpp"
#include "conduction/cut_weights.hpp"

namespace calor {
namespace {

bool is_surface(const Crack& crack) { return !crack.fails() && crack.contact == 0; }

}  // namespace

PairConduction cracked_pairs(const Cloud& cloud, const Parts& parts, const Cracks& cracks, Neighbours neighbours,
                             std::vector<double> G, CorrectionReport& report) {
  if (std::ranges::any_of(cracks.all(), is_surface)) {
    SurfaceCuts cuts{.crossings = cracks.crossings(neighbours), .is_full = {}, .area_over_pair = {}};
    std::erase_if(cuts.crossings, [&](const Crossing& x) { return !is_surface(cracks.all()[x.crack]); });
    for (std::size_t crack = 0; crack < cracks.all().size(); ++crack)
      cuts.is_full.push_back(cracks.is_full_cut(static_cast<int>(crack)));
    cuts.area_over_pair.assign(cuts.crossings.size(), 1);
    CutWeights kept = cut_weights(cloud, cuts, neighbours, std::move(G), report);
    neighbours = std::move(kept.neighbours), G = std::move(kept.G);
  }

  CrackBonds bonds;
  for (const Crack& crack : cracks.all())
    if (crack.fails()) bonds.openings.push_back(crack.opens);
  for (const Crossing& x : cracks.crossings(neighbours)) {
    const Crack& crack = cracks.all()[x.crack];
    if (!is_surface(crack) && x.fraction > 0)
      bonds.bonds.push_back({.entry = x.entry,
                             .point = x.point,
                             .fraction = x.fraction,
                             .contact = crack.contact * x.length,
                             .opens = crack.opens});
  }
  return PairConduction(cloud, parts, std::move(neighbours), std::move(G), std::move(bonds));
}

bool has_images(const Case& c, const Cloud& cloud, const Parts& parts) {
  return !cloud.points_on_walls && !cloud.walls.empty() && !cloud.axisymmetric && !has_cracks(c) &&
         !contacts_end_cells(cloud) && (!cloud.lattice || parts.count() == 1);
}

MirroredNeighbours neighbours_of_body(const Case& c, const Cloud& cloud, const Parts& parts, const Support& support,
                                      const Conditions& conditions, bool insulated_too) {
  if (!has_images(c, cloud, parts)) return {find_neighbours(cloud, support)};
  return find_mirrored_neighbours(cloud, support, conditions, insulated_too);
}

Discretisation with_cracks(const Case& c, const Cloud& cloud, const Parts& parts, const Conditions& conditions,
                           MirroredNeighbours mirrored, std::vector<double> G, Layers layers, CorrectionReport& done,
                           MethodReport& report, const PairDirections& directions) {
  if (contacts_end_cells(cloud)) cut_at_contacts(cloud, parts, mirrored.neighbours, G, done);
  if (!has_cracks(c))
    return pair_discretisation(cloud, parts, conditions, std::move(mirrored), std::move(G), layers, directions);
  Neighbours& neighbours = mirrored.neighbours;  // without images
  const Cracks cracks(cloud, read_cracks(c, cloud));
  const std::size_t before = neighbours.column.size();
  auto pairs =
      std::make_unique<PairConduction>(cracked_pairs(cloud, parts, cracks, std::move(neighbours), std::move(G), done));
  const auto cut = total(cloud.comm, static_cast<std::int64_t>(before) - pairs->rows().entries());
  report["cut_pairs"] = 0.5 * static_cast<double>(cut);
  report["points_on_cracks"] = static_cast<double>(cracks.moved());
  Discretisation discretisation = nodal_discretisation(cloud, conditions, std::move(pairs), {}, nullptr,
                                                       layers_before_walls(cloud, parts, directions.of_parts));
  if (cracks.moved() > 0)
    discretisation.notes.push_back(fmt::format(
        "{} point{} on a crack taken to lie beside it, 1e-3 spacings to the left of its direction (in 3D: where "
        "its corners run counter-clockwise)",
        cracks.moved(), cracks.moved() == 1 ? " is" : "s are"));
  return discretisation;
}

}  // namespace calor
