#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <string>
#include <vector>

#include "app/derivatives.hpp"
#include "app/model.hpp"
#include "app/run.hpp"
#include "app/say.hpp"
#include "app/verbs.hpp"
#include "base/parallel.hpp"
#include "cloud/points.hpp"
#include "output/expect.hpp"
#include "output/observer.hpp"
#include "output/probes.hpp"
#include "output/temperature_unit.hpp"
#include "output/thermal_stress.hpp"
#include "output/weld.hpp"
#include "solve/integrator.hpp"
#include "solve/linear_solver.hpp"
#include "solve/stepper.hpp"

namespace calor {
namespace {

/// Bytes that the process holds now.
double resident_memory() {
  long pages = 0, resident = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%ld %ld", &pages, &resident) != 2) resident = 0;
    std::fclose(file);
  }
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// What a run takes besides what building leaves.
enum class Solution { explicit_steps, matrix, products };

/// Bytes that the process with the most of them will need: what building took at its worst, or what is left of it with
/// the arrays of steps and fields and, where equations are solved, their matrix (or, by products, that of the nearest
/// pairs and the arrays of the iteration) and its preconditioner. Collective.
double expected_memory(const Cloud& cloud, double pairs, Solution solution) {
  const double of_point = solution == Solution::products ? 650 : 90, of_pair = solution == Solution::matrix ? 24 : 0;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const double share = 1.0 / size_of(cloud.comm);
  const double more = share * (of_point * static_cast<double>(cloud.count) + of_pair * pairs);
  return max(cloud.comm, std::max(1024. * static_cast<double>(usage.ru_maxrss), resident_memory() + more));
}

/// What report.json will have, with its units.
int list(MPI_Comm comm, const std::vector<ReportNumber>& numbers) {
  if (rank_of(comm) != 0) return 0;
  for (const auto& [name, unit] : numbers) say(unit.empty() ? name + "\n" : fmt::format("{} [{}]\n", name, unit));
  return 0;
}

}  // namespace

int check_case(const Case& c, MPI_Comm comm, bool lists_numbers) {
  Phases phases;
  Model model = build_model(c, comm, phases);
  HeatSystem& system = *model.system;
  Probes probes(c, *model.cloud, &system.dofs(), &system.material().parts());
  std::ranges::copy(probes.notes(), std::back_inserter(model.notes));
  const Cloud& cloud = *model.cloud;
  const CloudCheck sound = check(cloud);
  const Bounds bounds = bounds_of_all(cloud);
  Start begin = start(model);
  State& state = begin.state;
  const RunSetup setup{.description = c,
                       .system = system,
                       .probes = probes,
                       .weld = WeldResults::make(c, system, probes, state, begin.E_before_walls),
                       .stress = ThermalStress::make(c, system, probes),
                       .start_E = begin.E_before_walls,
                       .start = state,
                       .phases = phases};
  const std::vector<ReportNumber> numbers = report_numbers(model, make_observers(setup));
  require_numbers(c, numbers);
  if (lists_numbers) return list(comm, numbers);
  TemperatureUnit::of(c);  // refuses what does not fit, as does the integrator
  const auto integrator = is_steady(c) ? nullptr : make_integrator(c, system, state);
  check_derivatives(setup, integrator.get());
  if (integrator) std::ranges::copy(integrator->notes, std::back_inserter(model.notes));
  const bool takes_explicit = !is_steady(c) && system.capacity_is_lumped();
  const double bound = takes_explicit ? system.explicit_rate_bound(0, state.T) : 0;
  const double prescribed = static_cast<double>(total(comm, static_cast<std::int64_t>(system.prescribed().size())));
  const double pairs = model.weights.contains("pairs") ? model.weights.at("pairs") : 0;
  const Solution solution = multiplies_without_matrix(system, !integrator) ? Solution::products
                            : !integrator || !integrators().find(integrator->name())->is_explicit
                                ? Solution::matrix
                                : Solution::explicit_steps;
  const double memory = expected_memory(cloud, pairs, solution);
  const auto powers = system.source_powers(0, system.temperatures(state.T));
  if (rank_of(comm) != 0) return 0;

  const auto line = [](const char* what, const std::string& value) { say(fmt::format("{:<22}{}\n", what, value)); };
  line("case", c.name());
  line("method", chosen_method(c).name);
  line("points", fmt::format("{} in {}D, {} with prescribed temperature", cloud.count, cloud.dimension, prescribed));
  std::vector<std::string> extents;
  extents.reserve(3);
  for (int a = 0; a < cloud.dimension; ++a) extents.push_back(fmt::format("{:.6g}", bounds.high[a] - bounds.low[a]));
  line("size", fmt::format("{} m between the outermost points", fmt::join(extents, " x ")));
  if (pairs > 0) line("neighbours", fmt::format("{:.1f} a point", pairs / static_cast<double>(cloud.count)));
  line("volume", fmt::format("{:.9g} m^3, off by {:.1e}", sound.volume, sound.volume_error));
  line("boundary areas",
       fmt::format("sum {:.1e}, moment {:.1e} (both should vanish)", sound.area_sum, sound.moment_sum));
  for (const auto& [name, area] : model.heated_areas)
    line("heat flows by", fmt::format("{} on {:.9g} m^2", name, area));
  for (std::size_t n = 0; n < powers.size(); ++n)
    line("source",
         fmt::format("{} gives {:.9g} W of {:.9g} W at the start", system.accounts()[system.boundary_accounts() + n],
                     powers[n].deposited, powers[n].asked));
  if (model.weights.contains("weight_residual"))
    line("weights", fmt::format("residual {:.1e}", model.weights.at("weight_residual")));
  if (model.weights.contains("moment_error"))
    line("second moments", fmt::format("off by {:.2g} along an axis; share of negative weights {:.2g}",
                                       model.weights.at("moment_error"), model.weights.at("negative_share")));
  if (integrator) line("integrator", fmt::format("{}: {}", integrator->name(), integrator->why));
  if (bound > 0) line("explicit step", fmt::format("stable up to {:.4g} s (Gershgorin)", 2 / bound));
  line("memory", fmt::format("about {:.3g} MB{}", memory / 1e6, size_of(comm) > 1 ? " a process" : ""));
  for (const std::string& note : model.notes) line("note", note);
  return 0;
}

}  // namespace calor
