#include "output/facet_fields.hpp"

#include <algorithm>

namespace calor {

Label part_of_points(const HeatSystem& system) {
  const Parts& parts = system.material().parts();
  const int owned = system.cloud().owned;
  Label label{"part", {}, std::vector<std::int64_t>(owned)};
  std::vector<double> most(owned);
  const std::vector<PlacesOfPart>& shares = system.material().cell_shares();
  for (int part = 0; part < parts.count(); ++part) {
    label.called.push_back(parts[part].material);
    const auto& [place, share] = shares[part];
    for (std::size_t n = 0; n < place.size(); ++n)
      if (place[n] < owned && share[n] > most[place[n]]) most[place[n]] = share[n], label.values[place[n]] = part;
  }
  return label;
}

Label condition_of_facets(const HeatSystem& system) {
  const Cloud& cloud = system.cloud();
  const Conditions& conditions = system.conditions();
  Label label{"condition", conditions.accounts, std::vector<std::int64_t>(cloud.facets.size(), -1)};
  std::vector<double> most(cloud.facets.size());
  for (const SurfaceTerm& term : conditions.fluxes) {
    if (term.is_plate) continue;
    std::vector<double> covered(cloud.facets.size());
    for (std::size_t n = 0; n < term.facet.size(); ++n) covered[term.facet[n]] += term.area[n];
    for (std::size_t n = 0; n < covered.size(); ++n)
      if (covered[n] > most[n]) most[n] = covered[n], label.values[n] = term.account;
  }
  for (std::size_t face = 0; face < cloud.faces.size(); ++face) {
    std::vector<std::size_t> facets;
    std::vector<Vec3> x;
    for (std::size_t n = 0; n < cloud.facets.size(); ++n) {
      const Facet& facet = cloud.facets[n];
      if (facet.face != static_cast<int>(face)) continue;
      facets.push_back(n);
      x.push_back(place_on_wall(cloud, facet));
    }
    const std::vector<int> held = conditions_at(conditions, static_cast<int>(face), x);
    for (std::size_t n = 0; n < facets.size(); ++n)
      if (held[n] >= 0) label.values[facets[n]] = conditions.temperatures[held[n]].account;
  }
  return label;
}

std::vector<double> heat_flux_of_facets(const HeatSystem& system, double t, const Label& condition,
                                        std::span<const double> T, std::span<const Vec3> q) {
  const Cloud& cloud = system.cloud();
  std::vector<double> flux(cloud.facets.size());
  for (const SurfaceTerm& term : system.conditions().fluxes) {
    if (term.is_plate) continue;
    std::vector<double> at(term.x.size()), given(term.x.size());
    for (std::size_t n = 0; n < at.size(); ++n) at[n] = T[term.facet[n]];
    term.flux->evaluate({.x = term.x, .t = t, .T = at}, given, {});
    for (std::size_t n = 0; n < at.size(); ++n)
      flux[term.facet[n]] += given[n] * term.area[n] / cloud.facets[term.facet[n]].area;
  }
  std::vector<char> is_prescribed(system.accounts().size());
  for (const PrescribedTerm& term : system.conditions().temperatures) is_prescribed[term.account] = 1;
  for (std::size_t n = 0; n < flux.size(); ++n)
    if (const std::int64_t account = condition.values[n]; account >= 0 && is_prescribed[account])
      flux[n] = -dot(q[cloud.facets[n].point], cloud.facets[n].normal);
  return flux;
}

}  // namespace calor
