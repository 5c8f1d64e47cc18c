#include "app/run.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <set>

#include "app/model.hpp"
#include "base/parallel.hpp"
#include "output/energy.hpp"
#include "output/final.hpp"
#include "output/log.hpp"
#include "output/phases.hpp"
#include "output/progress.hpp"
#include "output/report.hpp"
#include "output/vtu.hpp"
#include "output/weld.hpp"
#include "solve/integrator.hpp"

namespace calor {
namespace {

volatile std::sig_atomic_t interrupted = 0;

/// The times a run lands on. What differs by round-off alone is one time.
class Timeline {
 public:
  explicit Timeline(double end) : end_(end) {}
  /// Adds t if it lies in (0, end]; returns the time that stands for it.
  double add(double t) {
    if (t <= 0 || t > end_ * (1 + 1e-12)) return -1;
    const auto near = times_.lower_bound(t - 1e-12 * end_);
    return near != times_.end() && *near <= t + 1e-12 * end_ ? *near : *times_.insert(t).first;
  }
  const std::set<double>& times() const { return times_; }

 private:
  double end_;
  std::set<double> times_;
};

/// Temperature, heat flux and properties of the owned points, as ParaView gets them; for a body of several materials
/// also how much of each there is, and of a weld its peaks and cooling times.
void write_fields(FieldWriter& writer, HeatSystem& system, State& state, const WeldResults* weld) {
  const std::size_t n = system.cloud().owned;
  std::vector<Vec3> q(n);
  system.heat_flux(state.t, state.T, q);
  const std::vector<double> T = system.temperatures(state.T);
  const std::vector<std::string> ingredients = system.material().ingredients();
  std::vector<double> k(n), rho_c(n);
  std::vector<std::vector<double>> fractions(ingredients.size() > 1 ? ingredients.size() : 0, std::vector<double>(n));
  collective_try(system.cloud().comm, [&] {
    system.material().conductivity(state.t, T, k, {});
    system.material().enthalpy(T, {}, rho_c);
    for (std::size_t m = 0; m < fractions.size(); ++m) system.material().volume_fraction(ingredients[m], fractions[m]);
  });
  std::vector<Field> fields{{"temperature [K]", 1, T},
                            {"heat flux [W/m^2]", 3, std::span(&q.data()->x, 3 * n)},
                            {"conductivity [W/(m K)]", 1, k},
                            {"volumetric heat capacity [J/(m^3 K)]", 1, rho_c}};
  for (std::size_t m = 0; m < fractions.size(); ++m)
    fields.push_back({"volume fraction of " + ingredients[m], 1, fractions[m]});
  if (weld) {
    fields.push_back({"peak temperature [K]", 1, weld->points().peak()});
    if (weld->has_cooling()) fields.push_back({"cooling time [s]", 1, weld->points().cooling()});
  }
  writer.write(state.t, fields);
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024. * usage.ru_maxrss;
}

RunResult logged_run(const Case& c, MPI_Comm comm, const RunOptions& options, RunLog& log) {
  Phases phases;
  Model model = build_model(c, comm, phases);
  HeatSystem& system = *model.system;
  const Cloud& cloud = *model.cloud;
  const bool steady = is_steady(c);
  const auto say = [&](spdlog::level::level_enum level, const std::string& text) {
    if (rank_of(comm) == 0) spdlog::log(level, text);
  };
  say(spdlog::level::debug, fmt::format("calor {}: {} on {} process{}", CALOR_VERSION, c.path(), size_of(comm),
                                        size_of(comm) > 1 ? "es" : ""));
  say(spdlog::level::debug,
      fmt::format("{} points in {}D, method {}", cloud.count, cloud.dimension, chosen_method(c).name));
  for (const std::string& note : model.notes) say(spdlog::level::info, note);

  Probes probes(c, cloud, &system.dofs());
  Start begin = start(model);
  State& state = begin.state;
  const std::unique_ptr<WeldResults> weld = WeldResults::make(c, system, probes, state, begin.E_before_walls);
  Expectations expectations(c, cloud, system.material(), probes, weld.get(), options.folder);
  std::unique_ptr<Integrator> integrator = steady ? nullptr : make_integrator(c, system, state);
  if (integrator)
    for (const std::string& note : integrator->notes) say(spdlog::level::info, note);

  // What a case can be refused for has been refused: from here on files are written.
  log.open(options.folder);
  forget_report(comm, options.folder);
  if (weld) weld->open(options.folder);
  EnergyLog energy(system, std::move(begin.E_before_walls), steady ? "" : options.folder);
  ProbeLog probe_log(comm, probes, options.folder);
  std::unique_ptr<FieldWriter> fields;
  const Table output = c.section("output");
  if (!options.folder.empty() && output.flag("fields")) fields = std::make_unique<FieldWriter>(cloud, options.folder);

  RunResult result;
  std::map<std::string, std::string> texts{{"method", chosen_method(c).name},
                                           {"integrator", steady ? "steady" : integrator->name()}};
  say(spdlog::level::debug, fmt::format("integrator {}", texts["integrator"]));
  // Brings the ghosts of state.T up to date, too, which probes need.
  const auto owned = [&] { return system.temperatures(state.T); };
  const auto show = [&] {
    if (fields) phases.measure("output", [&] { write_fields(*fields, system, state, weld.get()); });
  };

  if (steady) {
    SteadyReport report;
    phases.measure("solve", [&] { report = solve_steady(c, system, state); });
    result.numbers["newton_iterations"] = report.newton_iterations;
    result.numbers["linear_iterations"] = static_cast<double>(report.linear_iterations);
    result.numbers["residual"] = report.residual;
    result.numbers["imbalance"] = report.imbalance;
    say(spdlog::level::debug,
        fmt::format("steady after {} iterations: the largest imbalance of a point is {:.3g} W, the largest heat flow "
                    "through one {:.6g} W{}",
                    report.newton_iterations, report.imbalance, report.flow,
                    report.at_round_off ? "; it fell no further: this is round-off" : ""));
    const auto T = owned();
    probe_log.record(state.t, state.T);
    show();
    expectations.observe(state, true, T);
  } else {
    const Table time = c.section("time");
    const double end = time.number("end");
    Timeline timeline(end);
    std::set<double> shown{timeline.add(end)};
    if (output.has("times"))
      for (double t : output.numbers("times")) shown.insert(timeline.add(t));
    if (output.has("every"))
      for (long n = 1; n * output.number("every") < end; ++n) shown.insert(timeline.add(n * output.number("every")));
    for (double t : expectations.times()) timeline.add(t);
    for (double t : system.events()) timeline.add(t);
    const std::set<double>& stops = timeline.times();

    const double sample_every = end / static_cast<double>(output.integer("samples"));
    double next_sample = sample_every;
    bool is_over = false;
    double sampled_at = -1;
    const auto sample = [&] {
      if (state.t == sampled_at) return;
      sampled_at = state.t;
      energy.record(state);
      const auto T = owned();
      probe_log.record(state.t, state.T);
      if (weld) weld->record(state, T);
    };
    Progress progress(comm, end, options.quiet);
    std::vector<double> T_before = time.has("steady_below") ? state.T : std::vector<double>{};
    double t_before = 0;
    const auto after_step = [&](const State& s) {
      progress.show(s.t, integrator->counts.steps);
      if (weld) weld->observe(s, owned());
      if (s.t >= next_sample * (1 - 1e-12) && !stops.contains(s.t)) {
        sample();
        next_sample = (std::floor(s.t / sample_every * (1 + 1e-12)) + 1) * sample_every;
      }
      if (!T_before.empty()) {
        double change = 0;
        for (int i = 0; i < cloud.owned; ++i) change = std::max(change, std::abs(s.T[i] - T_before[i]));
        is_over = max(comm, change) < time.number("steady_below") * (s.t - t_before);
        T_before = s.T, t_before = s.t;
      }
      if (any(comm, interrupted != 0)) result.interrupted_by = interrupted != 0 ? interrupted : SIGTERM;
      return !is_over && result.interrupted_by == 0;
    };

    if (weld) weld->observe(state, owned());
    sample();
    show();
    expectations.observe(state, false, owned());
    for (auto stop = stops.begin(); stop != stops.end() && !is_over && !result.interrupted_by; ++stop) {
      system.apply(state.t * (1 + 1e-12));
      phases.measure("march", [&] { integrator->advance(system, state, *stop, after_step); });
      sample();
      if (shown.contains(state.t) || is_over || result.interrupted_by) show();
      if (!result.interrupted_by) expectations.observe(state, is_over || *stop == end, owned());
    }
    progress.done();
    const StepCounts& n = integrator->counts;
    result.numbers.insert({{"steps", n.steps},
                           {"rejected_steps", n.rejected},
                           {"rate_evaluations", n.rate_evaluations},
                           {"newton_iterations", n.newton_iterations},
                           {"linear_iterations", n.linear_iterations},
                           {"most_stages", n.most_stages},
                           {"smallest_step", n.smallest_step},
                           {"largest_step", n.largest_step},
                           {"end", state.t},
                           {"energy_imbalance", energy.worst_imbalance()},
                           {"source_error", energy.worst_source_error()}});
    if (energy.worst_source_error() > 1e-9 && rank_of(comm) == 0)
      spdlog::warn("sources deposited up to {:.3g} % more or less power than asked for: see energy.csv",
                   100 * energy.worst_source_error());
  }
  if (weld) result.numbers.merge(weld->finish(state, owned()));
  phases.measure("output", [&] { write_final(cloud, owned(), options.folder); });

  const CloudCheck sound = check(cloud);
  result.numbers.insert(model.weights.begin(), model.weights.end());
  result.numbers.insert({{"points", static_cast<double>(cloud.count)},
                         {"dimension", cloud.dimension},
                         {"volume", sound.volume},
                         {"volume_error", sound.volume_error},
                         {"area_sum", sound.area_sum},
                         {"moment_sum", sound.moment_sum},
                         {"ranks", size_of(comm)},
                         {"memory_bytes", max(comm, peak_memory())}});
  if (!result.interrupted_by) result.verdicts = expectations.finish(result.numbers);
  result.numbers["interrupted_by"] = result.interrupted_by;
  write_report(comm, options.folder, c, result.numbers, texts, phases, result.verdicts, result.passed());
  for (const Verdict& v : result.verdicts) say(spdlog::level::debug, line(v));
  if (result.interrupted_by) say(spdlog::level::debug, fmt::format("interrupted by signal {}", result.interrupted_by));
  return result;
}

}  // namespace

bool RunResult::passed() const { return interrupted_by == 0 && std::ranges::all_of(verdicts, &Verdict::passed); }

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
