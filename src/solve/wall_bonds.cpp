#include "solve/wall_bonds.hpp"

#include <algorithm>
#include <cmath>

#include "conduction/pair_flux.hpp"

namespace calor {

ImageHeat::ImageHeat(const WallBonds& bonds, const std::vector<PrescribedTerm>& temperatures,
                     const MaterialField& material)
    : bonds_(bonds), temperatures_(temperatures), material_(material), places_(temperatures.size()) {
  for (std::size_t n = 0; n < bonds.values.size(); ++n) {
    OnWall& places = places_[bonds.values[n].term];
    places.value.push_back(n);
    places.x.push_back(bonds.values[n].x);
  }
  for (std::size_t m = 0; m < temperatures.size(); ++m)
    is_constant_ = is_constant_ && (places_[m].x.empty() || !temperatures[m].temperature.depends_on_time());
  image_.resize(bonds.images.size());
  image_power_.resize(bonds.images.size());
}

std::span<const double> ImageHeat::wall_part(double t, bool of_theta) {
  std::vector<double>& part = wall_part_[of_theta];
  if (is_known_[of_theta]) return part;
  part.assign(bonds_.images.size(), 0);
  for (std::size_t m = 0; m < places_.size(); ++m) {
    const OnWall& places = places_[m];
    T_wall_.resize(places.x.size());
    temperatures_[m].temperature.evaluate({.x = places.x, .t = t}, T_wall_);
    if (of_theta) material_.theta(std::vector<double>(T_wall_), T_wall_);
    for (std::size_t n = 0; n < T_wall_.size(); ++n) {
      const WallBonds::Value& value = bonds_.values[places.value[n]];
      part[value.image] += value.factor * T_wall_[n];
    }
  }
  is_known_[of_theta] = is_constant_;
  return part;
}

void ImageHeat::add_rate(double t, const Conductivity& k, std::span<const double> T, std::span<double> F,
                         std::span<double> power) {
  const bool of_theta = k.mean == Mean::integral;
  const std::span<const double> potential = of_theta ? k.theta : T, wall = wall_part(t, of_theta);
  for (std::size_t n = 0; n < image_.size(); ++n) {
    const WallBonds::Image& image = bonds_.images[n];
    image_[n] = image.sign * potential[image.point] + wall[n];
    image_power_[n] = 0;
  }
  for (std::size_t b = 0; b < bonds_.G.size(); ++b) {
    const std::int32_t i = bonds_.point[b], n = bonds_.image[b];
    double heat = bonds_.G[b] * (image_[n] - potential[i]);
    if (!of_theta) heat *= mean_conductivity(k.mean, k.k[i], k.k[bonds_.images[n].point]).value;
    F[i] += heat;
    image_power_[n] += heat;
  }
  for (std::size_t n = 0; n < image_.size(); ++n) {
    const auto& walls = bonds_.images[n].term;
    const auto count = static_cast<double>(std::ranges::count_if(walls, [](int term) { return term >= 0; }));
    for (const int term : walls)
      if (term >= 0) power[temperatures_[term].account] += image_power_[n] / count;
  }
}

void ImageHeat::add_jacobian(double t, const Conductivity& k, std::span<const double> T, JacobianEntries& J) {
  const std::span<const double> wall = wall_part(t, false);
  for (std::size_t b = 0; b < bonds_.G.size(); ++b) {
    const WallBonds::Image& image = bonds_.images[bonds_.image[b]];
    const std::int32_t i = bonds_.point[b], columns[] = {i, image.point};
    const double jump = image.sign * T[image.point] + wall[bonds_.image[b]] - T[i];
    const auto d = flux_derivatives(k, jump, i, image.point, image.sign);
    J.add(i, columns, std::array{bonds_.G[b] * d.by_i, bonds_.G[b] * d.by_j});
  }
}

void ImageHeat::add_row_bound(const Conductivity& k, std::span<double> bound) const {
  const Conductivity frozen{.mean = k.mean, .k = k.k, .dk_dT = {}, .theta = {}};
  for (std::size_t b = 0; b < bonds_.G.size(); ++b) {
    const WallBonds::Image& image = bonds_.images[bonds_.image[b]];
    const auto d = flux_derivatives(frozen, 0, bonds_.point[b], image.point, image.sign);
    bound[bonds_.point[b]] += std::abs(bonds_.G[b]) * (std::abs(d.by_i) + std::abs(d.by_j));
  }
}

}  // namespace calor
