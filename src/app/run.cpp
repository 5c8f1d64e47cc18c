#include "app/run.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <utility>

#include "app/derivatives.hpp"
#include "app/interrupts.hpp"
#include "app/march.hpp"
#include "app/model.hpp"
#include "base/parallel.hpp"
#include "output/checkpoint.hpp"
#include "output/expect.hpp"
#include "output/files.hpp"
#include "output/observer.hpp"
#include "output/probes.hpp"
#include "output/thermal_stress.hpp"
#include "output/weld.hpp"
#include "solve/integrator.hpp"

namespace calor {
namespace {

/// Until the state is found there are no results that an interrupt would have to wait for.
void solve(const RunSetup& run, State& state, const Observers& observers, std::optional<InterruptsWait>& results_first,
           RunResult& result) {
  SteadyReport report;
  run.phases.measure("solve", [&] { report = solve_steady(run.description, run.system, state); });
  results_first.emplace();
  result.numbers.insert({{"newton_iterations", report.newton_iterations},
                         {"linear_iterations", static_cast<double>(report.linear_iterations)},
                         {"residual", report.residual},
                         {"imbalance", report.imbalance}});
  if (rank_of(run.comm()) == 0)
    spdlog::debug(
        "steady after {} iterations: the largest imbalance of a point is {:.3g} W, the largest heat flow through one "
        "{:.6g} W{}",
        report.newton_iterations, report.imbalance, report.flow,
        report.at_round_off ? "; it fell no further: this is round-off" : "");
  Moment end(run.system, state);
  end.is_last = true;
  for (const auto& observer : observers) observer->record(end), observer->at_stop(end);
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024. * usage.ru_maxrss;
}

/// Numbers of cloud, weights, heated areas and, at the end, sources for the report. Collective.
void add_numbers(const Model& model, State& end, RunResult& result) {
  const Cloud& cloud = *model.cloud;
  const CloudCheck sound = check(cloud);
  result.numbers.insert(model.weights.begin(), model.weights.end());
  result.numbers.insert({{"points", static_cast<double>(cloud.count)},
                         {"dimension", cloud.dimension},
                         {"volume", sound.volume},
                         {"volume_error", sound.volume_error},
                         {"area_sum", sound.area_sum},
                         {"moment_sum", sound.moment_sum},
                         {"ranks", size_of(cloud.comm)},
                         {"memory_bytes", max(cloud.comm, peak_memory())}});
  for (const auto& [name, area] : model.heated_areas) result.numbers["area." + name] = area;
  HeatSystem& system = *model.system;
  auto name = system.accounts().begin() + system.boundary_accounts();
  for (const auto& [asked, deposited] : system.source_powers(end.t, system.temperatures(end.T))) {
    result.numbers["power_asked." + *name] = asked;
    result.numbers["power_deposited." + *name++] = deposited;
  }
}

/// Adds what is known at the end. Collective.
void finish(const Model& model, State& state, const Observers& observers, RunResult& result) {
  add_numbers(model, state, result);
  Moment end(*model.system, state);
  end.is_cut_short = result.is_cut_short();
  for (const auto& observer : observers) observer->finish(end, result);
  result.numbers["interrupted_by"] = result.interrupted_by;
}

/// Tells sources that have given no heat: what they are to heat, or when, is not what was meant.
void tell_idle_sources(const Case& c, const Model& model, const RunResult& result) {
  const HeatSystem& system = *model.system;
  for (const auto& [name, table] : c.section("source").children()) {
    const auto heat = result.numbers.find((is_steady(c) ? "power_deposited." : "heat.") + name);
    if (heat == result.numbers.end() || heat->second != 0 || rank_of(system.cloud().comm) != 0) continue;
    spdlog::warn("{}: the source '{}' has given no heat", table.location().text(), name);
  }
}

void refuse_restart_of_steady(const Case& c) {
  if (is_steady(c))
    c.root().refuse("steady", "a steady state has no checkpoints to go on from", "run it anew, without --restart");
}

void say(MPI_Comm comm, spdlog::level::level_enum level, const std::string& text) {
  if (rank_of(comm) == 0) spdlog::log(level, text);
}

/// Says what is run: the model, whatever is to be known of it, the integrator.
void introduce(const Case& c, const Model& model, const Probes& probes, const Integrator* integrator) {
  const Cloud& cloud = *model.cloud;
  MPI_Comm comm = cloud.comm;
  say(comm, spdlog::level::debug,
      fmt::format("calor {}: {} on {} process{}", CALOR_VERSION, c.path(), size_of(comm),
                  size_of(comm) > 1 ? "es" : ""));
  say(comm, spdlog::level::debug,
      fmt::format("{} points in {}D, method {}", cloud.count, cloud.dimension, chosen_method(c).name));
  for (const std::string& note : model.notes) say(comm, spdlog::level::info, note);
  for (const std::string& note : probes.notes()) say(comm, spdlog::level::warn, note);
  if (!integrator) return;
  for (const std::string& note : integrator->notes) say(comm, spdlog::level::info, note);
}

/// With all that is known of it beforehand.
RunResult result_of(const Case& c, const RunOptions& options, const std::vector<ReportNumber>& numbers,
                    const Integrator* integrator) {
  RunResult result;
  result.command = options.command;
  for (const auto& [name, unit] : numbers)
    if (!unit.empty()) result.units[name] = unit;
  result.texts = {{"method", chosen_method(c).name}, {"integrator", integrator ? integrator->name() : "steady"}};
  if (integrator) result.texts["integrator_why"] = integrator->why;
  return result;
}

RunResult logged_run(const Case& c, MPI_Comm comm, const RunOptions& options, RunLog& log) {
  const TemperatureUnit unit = TemperatureUnit::of(c);
  FolderLock lock(comm, options.folder);
  // A new folder is made when nothing is left for which the case can be refused.
  if (any(comm, std::filesystem::is_directory(options.folder))) lock.take();
  std::optional<StoredRun> stored;
  if (options.restart) {
    refuse_restart_of_steady(c);
    stored = find_checkpoint(comm, options.folder, c);
  }
  Pace pace(c, comm, options.time_limit);
  Phases phases;
  Model model = build_model(c, comm, phases);
  HeatSystem& system = *model.system;
  const Probes probes(c, *model.cloud, &system.dofs(), &system.material().parts());
  Start begin = start(model);
  State& state = begin.state;
  const RunSetup setup{.description = c,
                       .system = system,
                       .probes = probes,
                       .weld = WeldResults::make(c, system, probes, state, begin.E_before_walls),
                       .stress = ThermalStress::make(c, system, probes),
                       .start_E = begin.E_before_walls,
                       .start = state,
                       .folder = options.folder,
                       .is_quiet = options.quiet,
                       .phases = phases};
  Observers observers = make_observers(setup);
  const std::vector<ReportNumber> numbers = report_numbers(model, observers);
  require_numbers(c, numbers);
  const std::unique_ptr<Integrator> integrator = is_steady(c) ? nullptr : make_integrator(c, system, state);
  if (auto derivatives = make_derivative_log(setup, model, integrator.get()))
    observers.push_back(std::move(derivatives));
  introduce(c, model, probes, integrator.get());
  RunResult result = result_of(c, options, numbers, integrator.get());

  const NumberedPoints points(comm, std::span(model.cloud->id).first(model.cloud->owned));
  Checkpoints checkpoints(c, points, options.folder, stored ? std::optional(stored->slot) : std::nullopt);
  std::optional<March> march;
  if (integrator) march.emplace(setup, state, *integrator, observers, lock);
  if (stored) {
    stored->archive->distribute(points);
    march->exchange(*stored->archive);
  }

  // What a case can be refused for has been refused: from here on files are written.
  lock.take();
  std::optional<InterruptsWait> results_first;
  if (march) results_first.emplace();
  log.open(options.folder, stored.has_value());
  if (stored) {
    for (const std::string& note : stored->notes) say(comm, spdlog::level::warn, note);
    say(comm, spdlog::level::info,
        fmt::format("restarted at t = {:.6g} s, after {} steps", state.t, stored->head.steps));
  } else {
    checkpoints.remove();
    remove_earlier_results(comm, options.folder);
  }
  set_report_aside(comm, options.folder);
  for (const auto& observer : observers) observer->begin();
  say(comm, spdlog::level::debug, fmt::format("integrator {}", result.texts["integrator"]));
  try {
    if (march)
      march->run(pace, checkpoints, result);
    else
      solve(setup, state, observers, results_first, result);
  } catch (const Error& e) {
    if (e.fault() != Fault::bad_case) throw;
    throw Error(Fault::numbers, e.location(), e.problem(), e.cure());  // the case went well until here
  }
  lock.require_folder();
  finish(model, state, observers, result);
  if (!result.is_cut_short()) tell_idle_sources(c, model, result);
  write_report(comm, options.folder, c, result, phases);
  result.wall = phases.elapsed();
  for (const std::string& text : summary(result, unit)) say(comm, spdlog::level::debug, text);
  for (const Verdict& v : result.verdicts) say(comm, spdlog::level::debug, line(v, unit));
  if (!result.is_cut_short()) checkpoints.remove();
  return result;
}

}  // namespace

std::vector<ReportNumber> report_numbers(const Model& model, const Observers& observers) {
  std::vector<ReportNumber> all{{"points", ""},       {"dimension", ""},    {"volume", "m^3"},
                                {"volume_error", ""}, {"area_sum", ""},     {"moment_sum", ""},
                                {"ranks", ""},        {"memory_bytes", ""}, {"interrupted_by", ""}};
  const std::initializer_list<ReportNumber> of_steady{
      {"newton_iterations", ""}, {"linear_iterations", ""}, {"residual", ""}, {"imbalance", "W"}},
      of_steps{{"steps", ""},
               {"rejected_steps", ""},
               {"rate_evaluations", ""},
               {"newton_iterations", ""},
               {"linear_iterations", ""},
               {"most_stages", ""},
               {"smallest_step", "s"},
               {"largest_step", "s"},
               {"end", "s"}};
  const auto& of_kind = is_steady(model.description) ? of_steady : of_steps;
  all.insert(all.end(), of_kind.begin(), of_kind.end());
  for (const auto& [name, value] : model.weights) all.push_back({name, ""});
  for (const auto& [name, area] : model.heated_areas) all.push_back({"area." + name, "m^2"});
  const auto& accounts = model.system->accounts();
  for (auto name = accounts.begin() + model.system->boundary_accounts(); name != accounts.end(); ++name)
    for (const char* power : {"power_asked.", "power_deposited."}) all.push_back({power + *name, "W"});
  for (const auto& observer : observers) std::ranges::copy(observer->numbers(), std::back_inserter(all));
  return all;
}

RunResult run(const Case& c, MPI_Comm comm, const RunOptions& options) {
  RunLog log(comm);
  try {
    return logged_run(c, comm, options, log);
  } catch (const Error& e) {
    if (rank_of(comm) == 0) spdlog::debug("{}", e.what());
    throw;
  }
}

}  // namespace calor
