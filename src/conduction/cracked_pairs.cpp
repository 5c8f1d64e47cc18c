#include "conduction/cracked_pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "conduction/contact_pairs.hpp"
#include "conduction/cut_weights.hpp"

namespace calor {
namespace {

bool fails(const Crack& crack) { return crack.fails(); }

/// A temperature among those of the conditions, K.
double typical_temperature(const Cloud& cloud, const Conditions& conditions) {
  std::vector<double> T;
  collective_try(cloud.comm, [&] {
    for (const PrescribedTerm& term : conditions.temperatures)
      for (const Vec3& x : term.x) T.push_back(term.temperature(x));
    for (const SurfaceTerm& term : conditions.fluxes)
      for (const double ambient : term.flux->ambient(term.x, 0)) T.push_back(ambient);
  });
  const auto count = total(cloud.comm, static_cast<std::int64_t>(T.size()));
  constexpr double room = 293.15;
  return count > 0 ? sum(cloud.comm, T) / static_cast<double>(count) : room;
}

/// Pairs of a cracked body, and of every one the share of its weight that conducts through contacts.
struct CutBody {
  Neighbours neighbours;
  std::vector<double> G, by_contact;
};

/// Cuts the pairs across cracks that are open from the start. What contacts hold of them is kept beside the rest.
CutBody cut_body(const Cloud& cloud, const Cracks& cracks, const Neighbours& neighbours, const std::vector<double>& G,
                 std::span<const double> k, CorrectionReport& report) {
  SurfaceCuts cuts{.surfaces = {}, .crossings = cracks.crossings(neighbours), .area_over_pair = {}, .conducts = {}};
  std::erase_if(cuts.crossings, [&](const Crossing& x) { return fails(cracks.all()[x.crack]); });
  for (std::size_t crack = 0; crack < cracks.all().size(); ++crack)
    cuts.surfaces.push_back(
        {.is_full = cracks.is_full_cut(static_cast<int>(crack)), .heat_crosses = cracks.all()[crack].contact > 0});
  cuts.area_over_pair.assign(cuts.crossings.size(), 1);
  std::vector<double> by_cracks(G.size(), 1), by_all(G.size(), 1);  // what remains of every pair
  for (const Crossing& x : cuts.crossings) {
    const double h = cracks.all()[x.crack].contact;
    const double k_i = k[x.point], k_j = k[neighbours.column[x.entry]];
    cuts.conducts.push_back(conducted_by_contact(2 * (k_i * k_j) / (k_i + k_j), h * x.length));
    by_all[x.entry] *= 1 - x.fraction;
    if (h == 0) by_cracks[x.entry] *= 1 - x.fraction;
  }
  const CutWeights kept = cut_weights(cloud, cuts, neighbours, G, report);
  CutBody out{.neighbours = {.row = {0}, .column = {}}, .G = {}, .by_contact = {}};
  for (int i = 0; i < cloud.owned; ++i) {
    auto m = kept.neighbours.row[i];
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const bool is_kept = m < kept.neighbours.row[i + 1] && kept.neighbours.column[m] == neighbours.column[n];
      const double beside = is_kept ? kept.G[m++] : 0, across = G[n] * (by_cracks[n] - by_all[n]);
      if (!is_kept && across == 0) continue;
      out.neighbours.column.push_back(neighbours.column[n]);
      out.G.push_back(beside + across);
      out.by_contact.push_back(across == 0 ? 0 : across / (beside + across));
    }
    out.neighbours.row.push_back(static_cast<std::int64_t>(out.neighbours.column.size()));
  }
  return out;
}

}  // namespace

PairConduction cracked_pairs(const Cloud& cloud, const Parts& parts, const Cracks& cracks, Neighbours neighbours,
                             std::vector<double> G, std::span<const double> k, CorrectionReport& report) {
  CutBody body{.neighbours = std::move(neighbours), .G = std::move(G), .by_contact = {}};
  if (!std::ranges::all_of(cracks.all(), fails)) body = cut_body(cloud, cracks, body.neighbours, body.G, k, report);

  CrackBonds bonds;
  for (const Crack& crack : cracks.all())
    if (crack.fails()) bonds.openings.push_back(crack.opens);
  const std::vector<Crossing> crossings = cracks.crossings(body.neighbours);
  const auto is_contact = [&](const Crossing& x) {
    return !fails(cracks.all()[x.crack]) && cracks.all()[x.crack].contact > 0;
  };
  std::vector<int> contacts(body.G.size());  // that a pair crosses
  for (const Crossing& x : crossings) contacts[x.entry] += is_contact(x) && x.fraction > 0;
  for (const Crossing& x : crossings) {
    const Crack& crack = cracks.all()[x.crack];
    if (x.fraction == 0 || (!crack.fails() && !is_contact(x))) continue;
    // What several contacts leave of a pair multiplies.
    const double fraction =
        crack.fails() ? x.fraction : 1 - std::pow(1 - body.by_contact[x.entry], 1.0 / contacts[x.entry]);
    bonds.bonds.push_back({.entry = x.entry,
                           .point = x.point,
                           .fraction = fraction,
                           .contact = crack.contact * x.length,
                           .opens = crack.opens});
  }
  return PairConduction(cloud, parts, std::move(body.neighbours), std::move(body.G), std::move(bonds));
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

Discretisation with_cracks(const Case& c, const Cloud& cloud, const MaterialField& material,
                           const Conditions& conditions, MirroredNeighbours mirrored, std::vector<double> G,
                           Layers layers, CorrectionReport& done, MethodReport& report,
                           const PairDirections& directions) {
  const Parts& parts = material.parts();
  const double T = typical_temperature(cloud, conditions);
  if (!has_cracks(c)) {
    std::optional<std::string> note;
    if (contacts_end_cells(cloud)) note = cut_at_contacts(cloud, material, T, mirrored.neighbours, G, done);
    Discretisation discretisation =
        pair_discretisation(cloud, parts, conditions, std::move(mirrored), std::move(G), layers, directions);
    if (note) discretisation.notes.push_back(*note);
    return discretisation;
  }
  Neighbours& neighbours = mirrored.neighbours;  // without images
  const Cracks cracks(cloud, read_cracks(c, cloud));
  const std::size_t before = neighbours.column.size();
  std::vector<double> k(cloud.local());
  collective_try(cloud.comm, [&] { material.conductivity(0, std::vector<double>(k.size(), T), k, {}); });
  auto pairs = std::make_unique<PairConduction>(
      cracked_pairs(cloud, parts, cracks, std::move(neighbours), std::move(G), k, done));
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
