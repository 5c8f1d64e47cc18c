#include "app/run.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <set>

#include "app/model.hpp"
#include "base/parallel.hpp"
#include "output/files.hpp"
#include "output/observer.hpp"
#include "output/probes.hpp"
#include "output/weld.hpp"
#include "solve/integrator.hpp"

namespace calor {
namespace {

volatile std::sig_atomic_t interrupted = 0;

/// The times a run lands on, and those in between at which it is recorded.
class Timeline {
 public:
  Timeline(const Case& c, const HeatSystem& system, const Observers& observers)
      : end_(c.section("time").number("end")),
        sample_every_(end_ / static_cast<double>(c.section("output").integer("samples"))),
        next_sample_(sample_every_) {
    add(end_);
    for (const auto& observer : observers)
      for (const double t : observer->times()) add(t);
    for (const double t : system.events()) add(t);
  }

  double end() const { return end_; }
  const std::set<double>& stops() const { return stops_; }
  /// Is a sample due at t? Not at a stop, where there is one anyway.
  bool sample_is_due(double t) {
    if (t < next_sample_ * (1 - 1e-12) || stops_.contains(t)) return false;
    next_sample_ = (std::floor(t / sample_every_ * (1 + 1e-12)) + 1) * sample_every_;
    return true;
  }

 private:
  /// Adds t if it lies in (0, end]. What differs by round-off alone is one time.
  void add(double t) {
    if (t <= 0 || t > end_ * (1 + 1e-12)) return;
    const auto near = stops_.lower_bound(t - 1e-12 * end_);
    if (near == stops_.end() || *near > t + 1e-12 * end_) stops_.insert(t);
  }

  double end_, sample_every_, next_sample_;
  std::set<double> stops_;
};

void solve(const RunSetup& run, State& state, const Observers& observers, RunResult& result) {
  SteadyReport report;
  run.phases.measure("solve", [&] { report = solve_steady(run.description, run.system, state); });
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

void march(const RunSetup& run, State& state, Integrator& integrator, const Observers& observers, RunResult& result) {
  HeatSystem& system = run.system;
  Timeline timeline(run.description, system, observers);
  bool is_over = false;
  double recorded_at = -1;
  const auto record = [&](const Moment& m) {
    if (state.t == recorded_at) return;
    recorded_at = state.t;
    for (const auto& observer : observers) observer->record(m);
  };
  const auto after_step = [&](const State&) {
    const Moment m(system, state, integrator.counts.steps);
    for (const auto& observer : observers) is_over = !observer->after_step(m) || is_over;
    if (timeline.sample_is_due(state.t)) record(m);
    if (any(run.comm(), interrupted != 0)) result.interrupted_by = interrupted != 0 ? interrupted : SIGTERM;
    return !is_over && result.interrupted_by == 0;
  };
  const auto look = [&] {
    Moment m(system, state, integrator.counts.steps);
    m.is_last = is_over || state.t == timeline.end();
    m.interrupted_by = result.interrupted_by;
    record(m);
    for (const auto& observer : observers) observer->at_stop(m);
  };

  look();
  for (const double stop : timeline.stops()) {
    system.apply(state.t * (1 + 1e-12));
    run.phases.measure("march", [&] { integrator.advance(system, state, stop, after_step); });
    look();
    if (is_over || result.interrupted_by) break;
  }
  const StepCounts& n = integrator.counts;
  result.numbers.insert({{"steps", n.steps},
                         {"rejected_steps", n.rejected},
                         {"rate_evaluations", n.rate_evaluations},
                         {"newton_iterations", n.newton_iterations},
                         {"linear_iterations", n.linear_iterations},
                         {"most_stages", n.most_stages},
                         {"smallest_step", n.smallest_step},
                         {"largest_step", n.largest_step},
                         {"end", state.t}});
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

RunResult logged_run(const Case& c, MPI_Comm comm, const RunOptions& options, RunLog& log) {
  const auto say = [&](spdlog::level::level_enum level, const std::string& text) {
    if (rank_of(comm) == 0) spdlog::log(level, text);
  };
  const TemperatureUnit unit = TemperatureUnit::of(c);
  Phases phases;
  Model model = build_model(c, comm, phases);
  HeatSystem& system = *model.system;
  const std::string method = chosen_method(c).name;
  say(spdlog::level::debug, fmt::format("calor {}: {} on {} process{}", CALOR_VERSION, c.path(), size_of(comm),
                                        size_of(comm) > 1 ? "es" : ""));
  say(spdlog::level::debug,
      fmt::format("{} points in {}D, method {}", model.cloud->count, model.cloud->dimension, method));
  for (const std::string& note : model.notes) say(spdlog::level::info, note);

  const Probes probes(c, *model.cloud, &system.dofs(), &system.material().parts());
  for (const std::string& note : probes.notes()) say(spdlog::level::warn, note);
  Start begin = start(model);
  State& state = begin.state;
  const RunSetup setup{.description = c,
                       .system = system,
                       .probes = probes,
                       .weld = WeldResults::make(c, system, probes, state, begin.E_before_walls),
                       .start_E = begin.E_before_walls,
                       .start = state,
                       .folder = options.folder,
                       .is_quiet = options.quiet,
                       .phases = phases};
  const Observers observers = make_observers(setup);
  const std::unique_ptr<Integrator> integrator = is_steady(c) ? nullptr : make_integrator(c, system, state);
  if (integrator)
    for (const std::string& note : integrator->notes) say(spdlog::level::info, note);
  RunResult result;
  result.texts = {{"method", method}, {"integrator", integrator ? integrator->name() : "steady"}};
  if (integrator) result.texts["integrator_why"] = integrator->why;

  // What a case can be refused for has been refused: from here on files are written.
  log.open(options.folder);
  set_report_aside(comm, options.folder);
  for (const auto& observer : observers) observer->begin();
  say(spdlog::level::debug, fmt::format("integrator {}", result.texts["integrator"]));
  try {
    if (integrator)
      march(setup, state, *integrator, observers, result);
    else
      solve(setup, state, observers, result);
  } catch (const Error& e) {
    if (e.fault() != Fault::bad_case) throw;
    throw Error(Fault::numbers, e.location(), e.problem(), e.cure());  // the case went well until here
  }
  add_numbers(model, state, result);
  Moment end(system, state);
  end.interrupted_by = result.interrupted_by;
  for (const auto& observer : observers) observer->finish(end, result);
  result.numbers["interrupted_by"] = result.interrupted_by;
  write_report(comm, options.folder, c, result, phases);
  result.wall = phases.elapsed();
  for (const std::string& text : summary(result, unit)) say(spdlog::level::debug, text);
  for (const Verdict& v : result.verdicts) say(spdlog::level::debug, line(v, unit));
  return result;
}

}  // namespace

void catch_interrupts() {
  const auto note = [](int number) {
    interrupted = number == SIGUSR1 ? SIGINT : number;
    std::signal(number, SIG_DFL);  // the second time it is meant
  };
  for (int signal : {SIGINT, SIGTERM, SIGUSR1}) std::signal(signal, note);
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
