// Speed of the core on a lattice of about 10^6 points in 3D, as ratios measured side by side in this one run:
//   one evaluation of dE/dt with k(T), against a plain loop over the same pairs in compressed rows with constant k;
//   cloud, neighbours and weights, against that evaluation; peak memory a point.
// Process CPU time, the median of several repeats taken in turn. Arguments: points along an edge (default 100).
#include <fmt/format.h>
#include <petscsys.h>
#include <sys/resource.h>

#include <algorithm>
#include <vector>

#include "app/model.hpp"
#include "app/schema.hpp"
#include "conduction/pair_conduction.hpp"
#include "cpu_time.hpp"

namespace {

using namespace calor;

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// F_i = sum_j G_ij (T_j - T_i): what every code for this problem contains.
void plain_rows(const SparseRows& G, std::span<const double> T, std::span<double> F) {
  for (std::size_t i = 0; i < F.size(); ++i) {
    double f = 0;
    for (std::int64_t n = G.row[i]; n < G.row[i + 1]; ++n) f += G.value[n] * (T[G.column[n]] - T[i]);
    F[i] = f;
  }
}

std::string lattice_case(int edge) {
  return fmt::format(R"case(
title = "lattice"
method = "sph"
[cloud]
shape = "box"
size = ["1 m", "1 m", "1 m"]
points = [{0}, {0}, {0}]
[material.solid]
conductivity = {{ formula = "exp(T)", unit = "W/(m K)" }}
density = "1 kg/m^3"
specific_heat = "1 J/(kg K)"
[initial]
temperature = {{ formula = "x*y + z", unit = "K" }}
[time]
end = "1 s"
)case",
                     edge);
}

int measure(int edge) {
  const Case c = Case::parse(lattice_case(edge), "speed.toml", schema());
  Phases phases;
  Model model = build_model(c, PETSC_COMM_WORLD, phases);
  HeatSystem& system = *model.system;
  const PairRows& pairs = dynamic_cast<const PairConduction&>(*system.discretisation().conduction).rows();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);  // before the plain loop takes its own
  SparseRows plain_pairs;
  PairRows::Row row;
  for (int i = 0; i < pairs.count(); ++i) {
    pairs.read(i, row);
    plain_pairs.column.insert(plain_pairs.column.end(), row.column.begin(), row.column.end());
    plain_pairs.value.insert(plain_pairs.value.end(), row.weight.begin(), row.weight.end());
    plain_pairs.close_row();
  }
  State state = system.start(0, model.T_start);
  std::vector<double> F(state.E.size()), power(system.accounts().size());

  std::vector<double> plain, rate;
  for (int repeat = 0; repeat < 15; ++repeat) {
    plain.push_back(seconds([&] { plain_rows(plain_pairs, state.T, F); }));
    rate.push_back(seconds([&] { system.rate(0, state.T, F, power); }));
  }
  const auto points = static_cast<double>(model.cloud->count);
  double set_up = 0;
  for (const auto& [phase, timing] : phases.timings())
    if (phase == "cloud" || phase == "weights") set_up += timing.cpu;
  fmt::print("{} points, {:.1f} neighbours a point\n", model.cloud->count,
             static_cast<double>(pairs.entries()) / points);
  fmt::print("{:<44}{:>9.2f} ms\n", "plain rows, constant k", 1e3 * median(plain));
  fmt::print("{:<44}{:>9.2f} ms  ratio {:.2f} (at most 1.5)\n", "dE/dt, k(T)", 1e3 * median(rate),
             median(rate) / median(plain));
  fmt::print("{:<44}{:>9.2f} s   ratio {:.1f} (at most 60)\n", "cloud, neighbours and weights", set_up,
             set_up / median(rate));
  fmt::print("{:<44}{:>9.0f} B a point (at most 1600)\n", "peak memory", 1024. * usage.ru_maxrss / points);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  const int code = measure(argc > 1 ? std::atoi(argv[1]) : 100);
  PetscCall(PetscFinalize());
  return code;
}
