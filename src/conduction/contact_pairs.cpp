#include "conduction/contact_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/parallel.hpp"
#include "conduction/cut_weights.hpp"
#include "surface/solids.hpp"

namespace calor {
namespace {

/// A pair that crosses contacts, as its point sees it.
struct ContactCrossing {
  Crossing crossing;
  bool once;        ///< its points lie on different sides
  double conducts;  ///< see SurfaceCuts
  /// The first contact from the point of the lower id, the same for both: Crossing::crack, and the curved piece of it
  /// (Parts::curved_areas) or -1.
  int contact, piece;
};

/// Where a way crosses a contact: between which parts, p + n q for p < q of n, and whether from q to p.
struct ContactOnWay {
  int contact;
  bool down;
  double at;  ///< part of the way
  Parts::Interface face;
};

/// The first or the last contact on a way.
std::optional<ContactOnWay> contact_on(const Parts& parts, const Parts::Segment& way, std::span<const SegmentPiece> run,
                                       double size, bool first) {
  const int changes = static_cast<int>(run.size()) - 1;
  for (int k = 0; k < changes; ++k) {
    const int n = first ? k : changes - 1 - k;
    const int part = run[n].part, other = run[n + 1].part;
    if (!parts.contact(part, other)) continue;
    const Vec3 along = way.b - way.a;
    return ContactOnWay{.contact = std::min(part, other) + parts.count() * std::max(part, other),
                        .down = part > other,
                        .at = run[n].end,
                        .face = parts.interface_at(way.a + run[n].end * along, along, way.tag_a, part, other, size)};
  }
  return std::nullopt;
}

/// Resistance of all contacts on a way, m K/W.
double resistance_of(const Parts& parts, const Parts::Segment& way, std::span<const SegmentPiece> run, double size,
                     double T) {
  double sum = 0;
  for (std::size_t n = 0; n + 1 < run.size(); ++n) {
    const Function* h = parts.contact(run[n].part, run[n + 1].part);
    if (!h) continue;
    const Vec3 along = way.b - way.a, x = way.a + run[n].end * along;
    const Vec3 normal = parts.interface_at(x, along, way.tag_a, run[n].part, run[n + 1].part, size).normal;
    sum += 1 / ((*h)(x, 0, T) * std::abs(dot(along, normal)));
  }
  return sum;
}

/// The pairs that cross contacts, each with the one that its point meets first, sorted by entry. k: of the local
/// points, W/(m K).
std::vector<ContactCrossing> crossings_of_contacts(const Cloud& cloud, const Parts& parts, std::span<const double> k,
                                                   double T, const Neighbours& neighbours) {
  struct Pair {
    int i;
    std::int64_t entry;
  };
  std::vector<Parts::Segment> ways;  // from the lower id to the higher
  std::vector<Pair> pairs;
  const Sides& sides = *cloud.solids->sides();
  const auto is_up = [&](int i, int j) { return cloud.id[i] < cloud.id[j]; };
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const int j = neighbours.column[n];
      if (!sides.is_beside[i] && !sides.separate(i, j)) continue;
      const auto [a, b] = is_up(i, j) ? std::pair(i, j) : std::pair(j, i);
      ways.push_back({cloud.x[a], cloud.x[b], cloud.tag[a], cloud.tag[b]});
      pairs.push_back({i, n});
    }
  }
  const Parts::Pieces pieces = parts.along(ways);
  std::vector<ContactCrossing> crossings;
  for (std::size_t s = 0; s < ways.size(); ++s) {
    const auto [i, entry] = pairs[s];
    const int j = neighbours.column[entry];
    const double size = 0.5 * (cloud.spacing[i] + cloud.spacing[j]);
    const auto first = contact_on(parts, ways[s], pieces.of(s), size, true);
    if (!first) continue;
    const bool up = is_up(i, j);
    const auto faced = up ? first : contact_on(parts, ways[s], pieces.of(s), size, false);
    const double length = dot(cloud.x[j] - cloud.x[i], faced->face.normal);
    const double K = 2 * (k[i] * k[j]) / (k[i] + k[j]);
    const double h_length = 1 / resistance_of(parts, ways[s], pieces.of(s), size, T);
    crossings.push_back({.crossing = {.entry = entry,
                                      .point = i,
                                      .crack = faced->contact,
                                      .fraction = 1,
                                      .sliver = 1,
                                      .length = std::abs(length),
                                      .normal = (length < 0 ? -1.0 : 1.0) * faced->face.normal,
                                      .at = up ? faced->at : 1 - faced->at,
                                      .upper = faced->down == up},
                         .once = sides.separate(i, j),
                         .conducts = conducted_by_contact(K, h_length),
                         .contact = first->contact,
                         .piece = first->face.piece});
  }
  return crossings;
}

/// Numbers the contacts anew, those that some pair of some rank crosses; returns how many these are. Collective.
int number_contacts(MPI_Comm comm, std::vector<ContactCrossing>& crossings) {
  const auto unique = [](std::vector<int>& numbers) {
    std::ranges::sort(numbers);
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  };
  std::vector<int> numbers;
  for (const ContactCrossing& c : crossings) numbers.push_back(c.contact), numbers.push_back(c.crossing.crack);
  unique(numbers);
  numbers = gather(comm, numbers);
  unique(numbers);
  const auto anew = [&](int& contact) {
    contact = static_cast<int>(std::ranges::lower_bound(numbers, contact) - numbers.begin());
  };
  for (ContactCrossing& c : crossings) anew(c.contact), anew(c.crossing.crack);
  return static_cast<int>(numbers.size());
}

/// Pairs that cross a contact twice stay whole: they go around. Collective.
SurfaceCuts cuts_of_contacts(const Cloud& cloud, const Parts& parts, std::vector<ContactCrossing> crossings,
                             std::span<const double> G) {
  const int contacts = number_contacts(cloud.comm, crossings);
  SurfaceCuts cuts{.surfaces = {}, .crossings = {}, .area_over_pair = {}, .conducts = {}};
  cuts.surfaces.assign(contacts, {.is_full = true, .heat_crosses = true});
  // Of every contact, then of every curved piece of known area, as both points of a pair see it.
  const std::span<const double> known = parts.curved_areas();
  std::vector<std::vector<double>> all(contacts + known.size()), once(all.size());
  const auto surface = [&](const ContactCrossing& c) {
    return c.piece >= 0 && known[c.piece] > 0 ? contacts + c.piece : c.contact;
  };
  for (const ContactCrossing& c : crossings) {
    const double area = G[c.crossing.entry] * c.crossing.length;
    all[surface(c)].push_back(area);
    if (c.once) once[surface(c)].push_back(area);
  }
  std::vector<double> factor;
  for (std::size_t n = 0; n < all.size(); ++n) {
    const double across = sum(cloud.comm, once[n]), whole = sum(cloud.comm, all[n]);
    const bool is_known = n >= static_cast<std::size_t>(contacts);
    const double area = is_known ? 2 * cloud.cross_section * known[n - contacts] : whole;
    factor.push_back(across > 0 ? area / across : 1);
  }
  for (const ContactCrossing& c : crossings) {
    if (!c.once) continue;
    cuts.crossings.push_back(c.crossing);
    cuts.area_over_pair.push_back(factor[surface(c)]);
    cuts.conducts.push_back(c.conducts);
  }
  return cuts;
}

}  // namespace

bool contacts_end_cells(const Cloud& cloud) { return cloud.solids && cloud.solids->sides(); }

std::optional<std::string> cut_at_contacts(const Cloud& cloud, const MaterialField& material, double T,
                                           const Neighbours& neighbours, std::vector<double>& G,
                                           CorrectionReport& report) {
  const Parts& parts = material.parts();
  std::vector<ContactCrossing> crossings;
  collective_try(cloud.comm, [&] {
    std::vector<double> k(cloud.local());
    material.conductivity(0, std::vector<double>(k.size(), T), k, {});
    crossings = crossings_of_contacts(cloud, parts, k, T, neighbours);
  });
  const SurfaceCuts cuts = cuts_of_contacts(cloud, parts, std::move(crossings), G);
  CutWeights kept;
  try {
    kept = cut_weights(cloud, cuts, neighbours, G, report);
  } catch (const Error& e) {  // on all ranks
    if (e.fault() != Fault::numbers) throw;
    return "what lies between contacts is too thin for its points: heat across is right, along it there are errors of "
           "first order; take points closer, two spacings between contacts or more";
  }
  for (std::size_t n = 0; n < cuts.crossings.size(); ++n) G[cuts.crossings[n].entry] *= cuts.area_over_pair[n];
  for (int i = 0; i < cloud.owned; ++i) {
    auto k = kept.neighbours.row[i];
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
      if (k < kept.neighbours.row[i + 1] && kept.neighbours.column[k] == neighbours.column[n]) G[n] = kept.G[k++];
  }
  return std::nullopt;
}

}  // namespace calor
