// Speed of the sum over pairs, F_i += sum_j G_ij kbar_ij (T_j - T_i), on about 10^6 points in 3D with 50 to 55
// neighbours, as pairs a CPU second, beside a plain loop over compressed rows with constant k in this one run:
//   a cubic lattice, a ball cut out of it, and a lattice whose points are displaced by 0.2 spacings.
// The weights depend on the distance alone, as inside lattices; on the displaced points no two are the same.
// Process CPU time, the median of several repeats taken in turn. Arguments: points along an edge (default 100).
#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "cloud/neighbours.hpp"
#include "cloud/shapes.hpp"
#include "conduction/pair_rows.hpp"
#include "cpu_time.hpp"

namespace {

using namespace calor;

/// F_i = sum_j G_ij (T_j - T_i): what every code for this problem contains.
void plain_rows(const Neighbours& n, std::span<const double> G, std::span<const double> T, std::span<double> F) {
  for (std::size_t i = 0; i < F.size(); ++i) {
    double f = 0;
    for (std::int64_t p = n.row[i]; p < n.row[i + 1]; ++p) f += G[p] * (T[n.column[p]] - T[i]);
    F[i] += f;
  }
}

enum class Region { cube, ball, displaced };

Cloud make_cloud(Region body, int edge) {
  BoxLattice box;
  box.dimension = 3;
  const double d = 1.0 / edge;
  for (int a = 0; a < 3; ++a) box.points[a] = edge, box.size[a] = d * (edge - 1);
  box.jitter = body == Region::displaced ? 0.2 : 0;
  Points points = make_box(PETSC_COMM_WORLD, box);
  if (body == Region::ball) {
    const double R = 0.5 * d * (edge - 1);
    std::vector<Point> inside;
    for (Point p : points.points) {
      const Vec3 r = p.x - Vec3{R, R, R};
      p.facets = 0;
      if (dot(r, r) <= R * R) inside.push_back(p);
    }
    points.points = std::move(inside), points.facets.clear();
  }
  return distribute(PETSC_COMM_WORLD, std::move(points), 2.4 * d);
}

void measure(const char* name, Region body, int edge) {
  const Cloud cloud = make_cloud(body, edge);
  const Neighbours neighbours = find_neighbours(cloud, 2.3);
  std::vector<double> G, T, k, theta, F(cloud.owned);
  for (int i = 0; i < cloud.owned; ++i) {
    for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n) {
      const Vec3 xi = (1.0 * edge) * neighbours.x_ji(cloud.x, i, n);
      const double square = body == Region::displaced ? dot(xi, xi) : std::round(dot(xi, xi));
      G.push_back(std::exp(-square));
    }
    const Vec3& x = cloud.x[i];
    T.push_back(x.x * x.y + x.z), k.push_back(std::exp(T.back())), theta.push_back(std::exp(T.back()));
  }
  const PairRows rows(neighbours, G);
  const auto with = [&](Mean mean) { return Conductivity{.mean = mean, .k = k, .dk_dT = {}, .theta = theta}; };
  struct Loop {
    const char* name;
    std::function<void()> run;
    std::vector<double> times = {};
  };
  std::vector<Loop> loops = {{"plain rows", [&] { plain_rows(neighbours, G, T, F); }},
                             {"theta", [&] { rows.add_fluxes(with(Mean::integral), T, F); }},
                             {"arithmetic mean", [&] { rows.add_fluxes(with(Mean::arithmetic), T, F); }},
                             {"harmonic mean", [&] { rows.add_fluxes(with(Mean::harmonic), T, F); }}};
  for (int repeat = 0; repeat < 9; ++repeat)
    for (Loop& loop : loops) loop.times.push_back(seconds(loop.run));
  fmt::print("{}: {} points, {:.1f} neighbours, {:.0f} B a point\n", name, cloud.owned,
             static_cast<double>(rows.entries()) / cloud.owned, static_cast<double>(rows.memory()) / cloud.owned);
  for (Loop& loop : loops) {
    std::ranges::sort(loop.times);
    const double median = loop.times[loop.times.size() / 2];
    fmt::print("  {:<16}{:>9.2f} ms{:>9.2f}e9 pairs a second\n", loop.name, 1e3 * median,
               1e-9 * static_cast<double>(rows.entries()) / median);
  }
}

}  // namespace

int main(int argc, char** argv) {
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  const int edge = argc > 1 ? std::atoi(argv[1]) : 100;
  fmt::print("instruction set: {}\n", name_of(best_instruction_set()));
  measure("cube", Region::cube, edge);
  measure("ball", Region::ball, static_cast<int>(1.24 * edge));
  measure("displaced points", Region::displaced, edge);
  PetscCall(PetscFinalize());
  return 0;
}
