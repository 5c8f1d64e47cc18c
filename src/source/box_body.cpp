#include "source/box_body.hpp"

#include <cmath>
#include <string>

#include "base/parallel.hpp"
#include "cloud/cells.hpp"
#include "cloud/lattice.hpp"

namespace calor {

bool BoxBody::holds(const Vec3& x, const std::array<bool, 3>& along) const {
  for (int a = 0; a < dimension; ++a) {
    const double rounding = 1e-9 * length(a);
    if (along[a] && (x[a] < low[a] - rounding || x[a] > high[a] + rounding)) return false;
  }
  return true;
}

std::optional<BoxBody> box_body(const Cloud& cloud) {
  std::vector<std::string> walls;
  for (int a = 0; a < cloud.dimension; ++a)
    for (const char* end : {"min", "max"}) walls.push_back("xyz"[a] + std::string(end));
  if (cloud.faces != walls) return std::nullopt;
  Bounds bounds = bounds_of(cloud.owned_points());
  double half_cell = 0;
  if (!cloud.points_on_walls)
    for (int i = 0; i < cloud.owned; ++i) half_cell = std::max(half_cell, 0.5 * cloud.spacing[i]);
  half_cell = max(cloud.comm, half_cell);
  BoxBody box{.low = {}, .high = {}, .dimension = cloud.dimension};
  double volume = cloud.cross_section;
  for (int a = 0; a < cloud.dimension; ++a) {
    box.low[a] = min(cloud.comm, bounds.low[a]) - half_cell;
    box.high[a] = max(cloud.comm, bounds.high[a]) + half_cell;
    if (cloud.lattice) {
      box.low[a] = cloud.lattice->box().origin[a];
      box.high[a] = box.low[a] + cloud.lattice->box().size[a];
    }
    volume *= box.length(a);
  }
  const double held = sum(cloud.comm, std::span(cloud.volume).first(cloud.owned));
  if (std::abs(held - volume) > 1e-6 * volume) return std::nullopt;
  return box;
}

std::optional<LatticeCells> lattice_cells(const Cloud& cloud, const BoxBody& box) {
  if (!cloud.lattice) return std::nullopt;
  const Lattice& lattice = *cloud.lattice;
  LatticeCells cells;
  for (int a = 0; a < box.dimension; ++a) {
    cells.planes[a].push_back(lattice.cell(a, 0).first);
    for (std::int64_t i = 0; i < lattice.box().points[a]; ++i) cells.planes[a].push_back(lattice.cell(a, i).second);
  }
  cells.index.resize(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    const LatticeIndex index = lattice.index(cloud.id[i]);
    for (int a = 0; a < box.dimension; ++a) cells.index[i][a] = static_cast<std::int32_t>(index[a]);
  }
  return cells;
}

}  // namespace calor
