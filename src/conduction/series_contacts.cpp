// Contacts of pairs: how much of an interface each pair stands for, and its resistance.
#include <fmt/format.h>

#include "base/parallel.hpp"
#include "conduction/series_pairs.hpp"

namespace calor {

/// On a plane the weights across it add up to its area, sum G |x_ba . n| = A. On a curved interface they miss it by the
/// ratio of the spacing to the radius, as the pairs lie on one side of it: lengths are scaled, piece by piece.
/// Collective.
void SeriesPairs::fit_contacts_to_areas(const Parts& parts) {
  const std::span<const double> area = parts.curved_areas();
  std::vector<std::vector<double>> terms(area.size());
  for (const Law& law : laws_)
    for (std::size_t n = 0; n < law.pair.size(); ++n) {
      const Pair& p = pairs_[law.pair[n]];
      const int owned = (p.a < cloud_->owned) + (p.b < cloud_->owned);  // the other rank has the pair, too
      if (law.piece[n] >= 0) terms[law.piece[n]].push_back(0.5 * owned * p.G * law.length[n]);
    }
  std::vector<double> scale(area.size(), 1);
  for (std::size_t q = 0; q < area.size(); ++q) {
    const double counted = sum(cloud_->comm, terms[q]);
    if (area[q] > 0 && counted > 0) scale[q] = cloud_->cross_section * area[q] / counted;
  }
  for (Law& law : laws_)
    for (std::size_t n = 0; n < law.pair.size(); ++n)
      if (law.piece[n] >= 0) law.length[n] *= scale[law.piece[n]];
}

/// Gives the pairs the resistances of contacts that do not depend on temperature, whose laws are done with.
void SeriesPairs::add_constant_contacts() {
  for (const Law& law : laws_) {
    if (law.h->depends_on_temperature()) continue;
    std::vector<double> h(law.x.size());
    law.h->evaluate({.x = law.x}, h);
    for (std::size_t n = 0; n < h.size(); ++n) {
      if (!(h[n] >= 0))
        throw Error(Fault::bad_case, law.h->location(), fmt::format("a contact of {:.6g} W/(m^2 K) is negative", h[n]),
                    "give 0 (no heat crosses) or more");
      pairs_[law.pair[n]].contacts += resistance_of(h[n], law.length[n]);
    }
  }
  std::erase_if(laws_, [](const Law& law) { return !law.h->depends_on_temperature(); });
}

}  // namespace calor
