// Speed of neighbour lists in 3D: CPU seconds for 10^6 points, with 49 neighbours each, of a lattice, of a lattice of
// displaced points, and of the same read in random order. The least of several repeats.
// Arguments: points along an edge (default 100).
#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "cloud/neighbours.hpp"
#include "cloud/shapes.hpp"
#include "cpu_time.hpp"

namespace {

using namespace calor;

void measure(const char* name, int edge, bool displaced, bool shuffled) {
  BoxLattice box;
  box.dimension = 3;
  for (int a = 0; a < 3; ++a) box.points[a] = edge, box.size[a] = 1;
  Points points = make_box(PETSC_COMM_WORLD, box);
  const double d = 1.0 / (edge - 1);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-0.3, 0.3);
  for (Point& p : points.points) {
    if (displaced)
      for (int a = 0; a < 3; ++a) p.x[a] += d * u(random);
    p.facets = 0;
  }
  points.facets.clear();
  points.lattice = nullptr;
  if (shuffled) {
    std::vector<std::int64_t> id(points.points.size());
    std::iota(id.begin(), id.end(), 0);
    std::ranges::shuffle(id, random);
    for (std::size_t i = 0; i < id.size(); ++i) points.points[i].id = id[i];
    std::ranges::sort(points.points, {}, &Point::id);
  }
  const Cloud cloud = distribute(PETSC_COMM_WORLD, std::move(points), 2.4 * d);
  std::vector<double> times;
  std::size_t pairs = 0;
  for (int repeat = 0; repeat < 5; ++repeat)
    times.push_back(seconds([&] { pairs = find_neighbours(cloud, 2.3).column.size(); }));
  fmt::print("{:<28}{:>8.1f} neighbours{:>8.3f} s\n", name, static_cast<double>(pairs) / cloud.owned,
             *std::ranges::min_element(times));
}

}  // namespace

int main(int argc, char** argv) {
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  const int edge = argc > 1 ? std::atoi(argv[1]) : 100;
  measure("lattice", edge, false, false);
  measure("displaced points", edge, true, false);
  measure("the same in random order", edge, true, true);
  PetscCall(PetscFinalize());
  return 0;
}
