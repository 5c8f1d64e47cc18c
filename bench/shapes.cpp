// Speed of moving least squares: shape functions and their slopes along a vector, as places a CPU second. The places
// are the points of a cube of displaced points and the middles of its pairs, as faces of cells have them.
// Process CPU time, the median of several repeats. Arguments: points along an edge (default 40).
#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <vector>

#include "cloud/neighbours.hpp"
#include "cloud/shapes.hpp"
#include "conduction/supports.hpp"
#include "cpu_time.hpp"

namespace {

using namespace calor;

Cloud make_cloud(int edge) {
  BoxLattice box;
  box.dimension = 3;
  for (int a = 0; a < 3; ++a) box.points[a] = edge, box.size[a] = 1;
  box.jitter = 0.2;
  return distribute(PETSC_COMM_WORLD, make_box(PETSC_COMM_WORLD, box), 6.0 / edge);
}

void measure(const char* name, const Cloud& cloud, int degree, double spacings) {
  std::vector<Vec3> places;
  const Neighbours neighbours = find_neighbours(cloud, 1.3);
  for (int i = 0; i < cloud.owned; ++i) {
    places.push_back(cloud.x[i]);
    for (const int j : neighbours.of(i))
      if (j > i) places.push_back(0.5 * (cloud.x[i] + cloud.x[j]));
  }
  const std::vector<Vec3> along(places.size(), {1, 2, 3});
  std::vector<double> times;
  std::size_t entries = 0;
  for (int repeat = 0; repeat < 7; ++repeat) {
    std::vector<double> R(cloud.local(), spacings);
    times.push_back(seconds([&] {
      entries = shape_rows(cloud, {3, degree}, {.spacings = spacings}, R, places, along).phi.column.size();
    }));
  }
  std::ranges::sort(times);
  const auto count = static_cast<double>(places.size());
  fmt::print("{:<28}{:>9.1f} points a place{:>9.2f}e6 places a second\n", name, static_cast<double>(entries) / count,
             1e-6 * count / times[times.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) {
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  const Cloud cloud = make_cloud(argc > 1 ? std::atoi(argv[1]) : 40);
  measure("linear, 1.8 spacings", cloud, 1, 1.8);
  measure("linear, 2.3 spacings", cloud, 1, 2.3);
  measure("quadratic, 2.3 spacings", cloud, 2, 2.3);
  PetscCall(PetscFinalize());
  return 0;
}
