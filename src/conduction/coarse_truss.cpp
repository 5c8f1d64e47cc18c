#include "conduction/coarse_truss.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.hpp"
#include "cloud/cells.hpp"

namespace calor {

namespace {

constexpr double least_width = 2.5;  // of a cell, in spacings
constexpr std::int32_t most_nodes = 40'000, most_of_factor = 500;

/// Adds numbers as integers, so that neither order nor ranks change a bit.
class ExactSums {
 public:
  /// Sums of no more than 2^22 numbers within `largest` each.
  ExactSums(std::size_t count, double largest)
      : scale_(largest > 0 ? std::ldexp(1, 40 - std::ilogb(largest)) : 0), sums_(count) {}
  void add(std::size_t n, double value) { sums_[n] += std::llrint(scale_ * value); }
  std::vector<double> total(MPI_Comm comm) {
    add_up(comm, sums_);
    std::vector<double> values;
    for (const std::int64_t s : sums_) values.push_back(s == 0 ? 0 : static_cast<double>(s) / scale_);
    return values;
  }

 private:
  double scale_;
  std::vector<std::int64_t> sums_;
};

/// c_i of the owned points.
std::vector<double> energies(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g) {
  std::vector<double> c(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    double fourth = 0;
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 xi = quotient(neighbours.x_ji(cloud.x, i, n), cloud.metric[i]);
      fourth += g[n] * dot(xi, xi) * dot(xi, xi);
    }
    c[i] = fourth / (2 * cloud.dimension * (cloud.dimension + 2));
  }
  return c;
}

Vec3 mean_metric(const Cloud& cloud) {
  std::vector<double> numbers;
  for (int i = 0; i < cloud.owned; ++i)
    numbers.insert(numbers.end(), {cloud.metric[i].x, cloud.metric[i].y, cloud.metric[i].z});
  const auto s = sums(cloud.comm, numbers, 3);
  return (1 / static_cast<double>(cloud.count)) * Vec3{s[0], s[1], s[2]};
}

Bounds bounds_of_body(const Cloud& cloud) {
  Bounds body = bounds_of(std::span(cloud.x).first(cloud.owned));
  for (int a = 0; a < 3; ++a) body.low[a] = min(cloud.comm, body.low[a]), body.high[a] = max(cloud.comm, body.high[a]);
  return body;
}

}  // namespace

CoarseTruss::CoarseTruss(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g, const Vec3& unit,
                         const std::array<bool, 3>& held)
    : cloud_(cloud) {
  const Vec3 spacing = mean_metric(cloud);
  const Bounds body = bounds_of_body(cloud);
  grids_.push_back(std::make_unique<TrussGrid>(body, spacing, cloud.dimension, least_width, most_nodes));
  if (grids_[0]->nodes() > most_of_factor) {
    grids_.push_back(std::make_unique<TrussGrid>(body, spacing, cloud.dimension, least_width, most_of_factor));
    for (std::int32_t n = 0; n < grids_[0]->nodes(); ++n) node_.push_back(grids_[1]->place(grids_[0]->node(n)));
  }
  const std::vector<double> c = energies(cloud, neighbours, g);
  double largest = 0;
  for (const double e : c) largest = std::max(largest, e);
  largest = max(cloud.comm, largest);
  for (const auto& grid : grids_) {
    ExactSums sums(grid->nodes(), largest);
    for (int i = 0; i < cloud.owned; ++i) sums.add(grid->place(cloud.x[i]).cell, c[i]);
    grid->set_energies(sums.total(cloud.comm), unit, held);
  }
}

std::vector<double> CoarseTruss::solution(std::vector<double> r) const {
  if (grids_.size() == 1) return grids_[0]->solve(r);
  // Smoothing, the grid with fewer nodes, and smoothing again.
  const TrussGrid& fine = *grids_[0];
  const std::vector<double> f = r;
  std::vector<double> p(r.size());
  fine.smooth(p, r);
  std::vector<double> coarse(3 * static_cast<std::size_t>(grids_[1]->nodes()));
  for (std::size_t n = 0; n < node_.size(); ++n) {
    const TrussGrid::Corners value = TrussGrid::tents(node_[n].at);
    TrussGrid::CellVectors cell;
    for (int a = 0; a < 3; ++a) cell[a] = value * r[3 * n + a];
    grids_[1]->add_to_nodes(cell, node_[n].cell, coarse);
  }
  coarse = grids_[1]->solve(coarse);
  for (std::size_t n = 0; n < node_.size(); ++n) {
    const TrussGrid::Corners value = TrussGrid::tents(node_[n].at);
    TrussGrid::CellVectors cell = grids_[1]->corners(node_[n].cell, coarse);
    for (int a = 0; a < 3; ++a) {
      const TrussGrid::Corners v = value * cell[a];
      p[3 * n + a] += ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
    }
  }
  fine.multiply(p, r);
  for (std::size_t n = 0; n < r.size(); ++n) r[n] = f[n] - r[n];
  fine.smooth(p, r);
  return p;
}

void CoarseTruss::add_solution(std::span<const double> r, std::span<double> z) {
  // Sums over the points of a cell, of values rounded to 2^-30 of the largest; whole numbers below 2^53, for 2^22
  // points a cell, add up without error.
  const int D = cloud_.dimension;
  const TrussGrid& grid = *grids_[0];
  double largest = 0;
  for (const double v : r) largest = std::max(largest, std::abs(v));
  largest = max(cloud_.comm, largest);
  if (largest == 0) return;
  const double scale = std::ldexp(1, 30 - std::ilogb(largest));
  cells_.assign(grid.nodes(), {});
  run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
    constexpr double whole = 0x1.8p52;  // rounds what is added to it
    for (int i = 0; i < cloud_.owned; ++i) {
      const TrussGrid::Place p = grid.place(cloud_.x[i]);
      const TrussGrid::Corners value = scale * TrussGrid::tents(p.at);
      for (int a = 0; a < D; ++a) cells_[p.cell][a] += (value * r[3 * i + a] + whole) - whole;
    }
  });
  std::vector<double> nodes(3 * static_cast<std::size_t>(grid.nodes()));  // whole numbers, too
  for (std::int32_t cell = 0; cell < grid.nodes(); ++cell) grid.add_to_nodes(cells_[cell], cell, nodes);
  std::vector<std::int64_t> sums(nodes.begin(), nodes.end());
  add_up(cloud_.comm, sums);
  for (std::size_t n = 0; n < sums.size(); ++n) nodes[n] = static_cast<double>(sums[n]) / scale;

  nodes = solution(std::move(nodes));
  for (std::int32_t cell = 0; cell < grid.nodes(); ++cell) cells_[cell] = grid.corners(cell, nodes);
  run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
    for (int i = 0; i < cloud_.owned; ++i) {
      const TrussGrid::Place p = grid.place(cloud_.x[i]);
      const TrussGrid::Corners value = TrussGrid::tents(p.at);
      for (int a = 0; a < D; ++a) {
        const TrussGrid::Corners v = value * cells_[p.cell][a];
        z[3 * i + a] += ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
      }
    }
  });
}

}  // namespace calor
