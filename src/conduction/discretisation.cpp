#include "conduction/discretisation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/parallel.hpp"
#include "conduction/constraint.hpp"
#include "conduction/wall_terms.hpp"

namespace calor {

Discretisation nodal_discretisation(const Cloud& cloud, const Conditions& conditions,
                                    std::unique_ptr<Conduction> conduction,
                                    std::vector<std::unique_ptr<HeatTerm>> walls, std::unique_ptr<Constraint> massless,
                                    std::unique_ptr<WallLayers> layers) {
  std::vector<double> volume(cloud.volume.begin(), cloud.volume.begin() + cloud.owned);
  if (massless)
    for (const int i : massless->points()) volume[i] = 0;
  Discretisation d;
  if (conduction->ends()) d.locations.push_back(conduction->ends());
  if (layers) {
    d.locations.push_back(&layers->ends());
    layers->location = static_cast<Location>(d.locations.size());
  }
  d.wall_layers = std::move(layers);
  d.conduction = std::move(conduction), d.walls = std::move(walls);
  if (!cloud.points_on_walls && d.walls.empty() && !conditions.temperatures.empty())  // no images hold them
    d.walls.push_back(std::make_unique<SeriesWalls>(cloud, conditions.temperatures, d.wall_layers.get()));
  d.dofs = std::make_unique<Dofs>(cloud);
  d.capacity = std::make_unique<LumpedCapacity>(std::move(volume));
  if (auto prescribed = prescribed_points(cloud, conditions.temperatures, *d.dofs, *d.capacity))
    d.constraints.push_back(std::move(prescribed));
  if (massless) d.constraints.push_back(std::move(massless));
  return d;
}

std::optional<std::string> note_of_jumps(const Cloud& cloud, const Conduction& conduction,
                                         const MaterialField& material, std::span<const double> T) {
  constexpr double smooth = 3;
  std::vector<double> T_local(T.begin(), T.end()), k(cloud.local());
  T_local.resize(cloud.local());
  cloud.halo.update(T_local);
  std::vector<int> part;
  std::vector<PlacesOfPart> shares;
  collective_try(cloud.comm, [&] {
    material.conductivity(0, T_local, k, {});
    part = material.parts().at(cloud.x, cloud.tag);
    shares = material.parts().shares(cloud.x, cloud.tag, cloud.spacing);
  });
  std::vector<char> meet(cloud.local(), 0);  // parts
  for (const PlacesOfPart& p : shares)
    for (std::size_t n = 0; n < p.place.size(); ++n) meet[p.place[n]] |= p.share[n] < 1;
  int where = -1;
  double largest = 1;
  std::vector<std::int32_t> buffer;
  for (int i = 0; i < cloud.owned; ++i) {
    for (const std::int32_t j : conduction.coupled(i, buffer)) {
      const Vec3 r = cloud.x[j] - cloud.x[i];
      if (part[i] != part[j] || meet[i] || meet[j] || !(norm(r) < 1.5 * std::min(cloud.spacing[i], cloud.spacing[j])))
        continue;
      if (const double jump = std::max(k[i], k[j]) / std::min(k[i], k[j]); jump > largest) largest = jump, where = i;
    }
  }
  const double everywhere = max(cloud.comm, largest);
  if (!(everywhere > smooth)) return std::nullopt;
  std::vector<Vec3> found;
  if (where >= 0 && largest == everywhere) found.push_back(cloud.x[where]);
  found = gather(cloud.comm, found);
  return fmt::format(
      "the conductivity of one part changes by a factor of {:.3g} between neighbours at ({:.6g}, {:.6g}, {:.6g}) m: "
      "where it jumps, say so by [[body.region]] or [[body.layer]], so that the interface lies where it is; where it "
      "is steep, take more points",
      everywhere, found[0].x, found[0].y, found[0].z);
}

}  // namespace calor
