#include "conduction/wall_terms.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cloud/cell_samples.hpp"
#include "conduction/pair_flux.hpp"

namespace calor {

ImageConduction::ImageConduction(ImageBonds bonds, std::span<const PrescribedTerm> temperatures)
    : bonds_(std::move(bonds)), temperatures_(temperatures), walls_(temperatures.size()) {
  for (std::size_t n = 0; n < bonds_.values.size(); ++n) {
    OnWall& wall = walls_[bonds_.values[n].term];
    wall.value.push_back(n);
    wall.x.push_back(bonds_.values[n].x);
  }
  for (std::size_t m = 0; m < temperatures.size(); ++m)
    is_constant_ = is_constant_ && (walls_[m].x.empty() || !temperatures[m].temperature.depends_on_time());
  image_.resize(bonds_.images.size());
  image_power_.resize(bonds_.images.size());
}

std::span<const double> ImageConduction::wall_part(Evaluation& at, bool of_theta) {
  std::vector<double>& part = wall_part_[of_theta];
  if (is_known_[of_theta]) return part;
  part.assign(bonds_.images.size(), 0);
  for (std::size_t m = 0; m < walls_.size(); ++m) {
    const OnWall& wall = walls_[m];
    T_wall_.resize(wall.x.size());
    temperatures_[m].temperature.evaluate({.x = wall.x, .t = at.t()}, T_wall_);
    if (of_theta) at.at(Evaluation::nodes).material().theta(std::vector<double>(T_wall_), T_wall_);
    for (std::size_t n = 0; n < T_wall_.size(); ++n) {
      const ImageBonds::Value& value = bonds_.values[wall.value[n]];
      part[value.image] += value.factor * T_wall_[n];
    }
  }
  is_known_[of_theta] = is_constant_;
  return part;
}

void ImageConduction::add_rate(Evaluation& at, std::span<double> F, std::span<double> power) {
  const Conductivity k = at.at(Evaluation::nodes).conductivity(Purpose::rate);
  const bool of_theta = k.mean == Mean::integral;
  const std::span<const double> potential = of_theta ? k.theta : at.u(), wall = wall_part(at, of_theta);
  for (std::size_t n = 0; n < image_.size(); ++n) {
    const ImageBonds::Image& image = bonds_.images[n];
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

void ImageConduction::add_jacobian(Evaluation& at, JacobianEntries& J) {
  const Conductivity k = at.at(Evaluation::nodes).conductivity(Purpose::jacobian);
  const std::span<const double> T = at.u(), wall = wall_part(at, false);
  for (std::size_t b = 0; b < bonds_.G.size(); ++b) {
    const ImageBonds::Image& image = bonds_.images[bonds_.image[b]];
    const std::int32_t i = bonds_.point[b], columns[] = {i, image.point};
    const double jump = image.sign * T[image.point] + wall[bonds_.image[b]] - T[i];
    const auto d = flux_derivatives(k, jump, i, image.point, image.sign);
    J.add(i, columns, std::array{bonds_.G[b] * d.by_i, bonds_.G[b] * d.by_j});
  }
}

void ImageConduction::add_row_sums(Evaluation& at, std::span<double> sums) {
  const Conductivity k = at.at(Evaluation::nodes).conductivity(Purpose::bound);
  for (std::size_t b = 0; b < bonds_.G.size(); ++b) {
    const ImageBonds::Image& image = bonds_.images[bonds_.image[b]];
    const auto d = flux_derivatives(k, 0, bonds_.point[b], image.point, image.sign);
    sums[bonds_.point[b]] += std::abs(bonds_.G[b]) * (std::abs(d.by_i) + std::abs(d.by_j));
  }
}

SeriesWalls::SeriesWalls(const Cloud& cloud, std::span<const PrescribedTerm> temperatures, const WallLayers* layers)
    : temperatures_(temperatures), layers_(layers) {
  for (const PrescribedTerm& term : temperatures) {
    std::vector<Wall>& walls = walls_.emplace_back();
    for (std::size_t n = 0; n < term.facet.size(); ++n) {
      const Facet& facet = cloud.facets[term.facet[n]];
      walls.push_back({.point = facet.point,
                       .facet = term.facet[n],
                       .share = term.share[n],
                       .area_over_depth = term.share[n] * facet.area / wall_distance(cloud, facet)});
    }
    has_walls_ = has_walls_ || !walls.empty();
  }
}

template <class Use>
void SeriesWalls::for_each_facet(double t, const Use& use) {
  for (std::size_t m = 0; m < temperatures_.size(); ++m) {
    const PrescribedTerm& term = temperatures_[m];
    T_wall_.resize(term.x.size());
    term.temperature.evaluate({.x = term.x, .t = t}, T_wall_);
    for (std::size_t n = 0; n < T_wall_.size(); ++n) use(term, walls_[m][n], T_wall_[n]);
  }
}

void SeriesWalls::add_rate(Evaluation& at, std::span<double> F, std::span<double> power) {
  const std::span<const double> T = at.T(), k = coefficients(at).k();
  for_each_facet(at.t(), [&](const PrescribedTerm& term, const Wall& wall, double T_wall) {
    const double heat = conductance(wall, k) * (T_wall - T[wall.point]);
    F[wall.point] += heat;
    power[term.account] += heat;
  });
}

void SeriesWalls::add_jacobian(Evaluation& at, JacobianEntries& J) {
  const std::span<const double> T = at.T(), dk_dT = coefficients(at).dk_dT(), k = coefficients(at).k();
  for_each_facet(at.t(), [&](const PrescribedTerm&, const Wall& wall, double T_wall) {
    J.add_nodal(wall.point, derivative(wall, k, dk_dT) * (T_wall - T[wall.point]) - conductance(wall, k));
  });
}

void SeriesWalls::add_row_sums(Evaluation& at, std::span<double> sums) {
  const std::span<const double> k = coefficients(at).k();
  for (const std::vector<Wall>& walls : walls_)
    for (const Wall& wall : walls) sums[wall.point] += conductance(wall, k);
}

template <class Use>
void PenaltyWalls::for_each_point(Evaluation& at, const Use& use) {
  const std::span<const double> u = at.u(), T = at.T();
  for (std::size_t m = 0; m < temperatures_.size(); ++m) {
    const PrescribedTerm& term = temperatures_[m];
    const SparseRows& slope = rows_.slope[m];
    T_star_.resize(term.x.size());
    term.temperature.evaluate({.x = term.x, .t = at.t()}, T_star_);
    for (std::size_t n = 0; n < T_star_.size(); ++n) {
      const int i = term.point[n];
      double flux = rows_.stiffness[m][n] * (T_star_[n] - T[i]);
      // The rows sum to zero: with differences a uniform temperature gives no flux, to the last bit.
      for (auto e = slope.row[n]; e < slope.row[n + 1]; ++e) flux += slope.value[e] * (u[slope.column[e]] - u[i]);
      use(m, n, flux);
    }
  }
}

void PenaltyWalls::add_rate(Evaluation& at, std::span<double> F, std::span<double> power) {
  const std::span<const double> k = at.at(Evaluation::nodes).k();
  for_each_point(at, [&](std::size_t m, std::size_t n, double flux) {
    const int i = temperatures_[m].point[n];
    const double heat = k[i] * flux;
    F[i] += heat;
    power[temperatures_[m].account] += heat;
  });
}

void PenaltyWalls::add_jacobian(Evaluation& at, JacobianEntries& J) {
  const std::span<const double> k = at.at(Evaluation::nodes).k(), dk_dT = at.at(Evaluation::nodes).dk_dT();
  for_each_point(at, [&](std::size_t m, std::size_t n, double flux) {
    const int i = temperatures_[m].point[n];
    const auto slope = rows_.slope[m].values(n);
    row_.assign(slope.begin(), slope.end());
    for (double& value : row_) value *= k[i];
    J.add(i, rows_.slope[m].columns(n), row_);
    J.add_nodal(i, (dk_dT.empty() ? 0 : dk_dT[i] * flux) - k[i] * rows_.stiffness[m][n]);
  });
}

void PenaltyWalls::add_row_sums(Evaluation& at, std::span<double> sums) {
  const std::span<const double> k = at.at(Evaluation::nodes).k();
  for (std::size_t m = 0; m < temperatures_.size(); ++m) {
    const SparseRows& slope = rows_.slope[m];
    for (std::size_t n = 0; n < slope.count(); ++n) {
      const int i = temperatures_[m].point[n];
      double sum = rows_.stiffness[m][n];
      for (const double value : slope.values(n)) sum += std::abs(value);
      sums[i] += k[i] * sum;
    }
  }
}

}  // namespace calor
