#include "app/run.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <set>

#include "app/model.hpp"
#include "base/parallel.hpp"
#include "output/energy.hpp"
#include "output/final.hpp"
#include "output/phases.hpp"
#include "output/progress.hpp"
#include "output/report.hpp"
#include "output/vtu.hpp"
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

/// Temperature, heat flux and properties of the owned points, as ParaView gets them.
void write_fields(FieldWriter& writer, const HeatSystem& system, State& state) {
  const std::size_t n = system.cloud().owned;
  std::vector<Vec3> q(n);
  system.heat_flux(state.t, state.T, q);
  const std::span<const double> T = system.values(state.T);
  std::vector<double> k(n), rho_c(n);
  together(system.cloud().comm, [&] {
    system.material().conductivity(state.t, T, k, {});
    system.material().enthalpy(T, {}, rho_c);
  });
  writer.write(state.t, {{"temperature [K]", 1, T},
                         {"heat flux [W/m^2]", 3, std::span(&q.data()->x, 3 * n)},
                         {"conductivity [W/(m K)]", 1, k},
                         {"volumetric heat capacity [J/(m^3 K)]", 1, rho_c}});
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024. * usage.ru_maxrss;
}

}  // namespace

bool RunResult::passed() const { return std::ranges::all_of(verdicts, &Verdict::passed); }

void catch_interrupts() {
  for (int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int number) { interrupted = number; });
}

RunResult run(const Case& c, MPI_Comm comm, const RunOptions& options) {
  Phases phases;
  Model model = build_model(c, comm, phases);
  HeatSystem& system = *model.system;
  const Cloud& cloud = *model.cloud;
  const bool steady = is_steady(c);
  if (rank_of(comm) == 0)
    for (const std::string& note : model.notes) spdlog::info("{}", note);

  Probes probes(c, cloud);
  Expectations expectations(c, cloud, probes, options.folder);
  State state = system.start(0, model.T_start);
  EnergyLog energy(system, state, options.folder);
  ProbeLog probe_log(comm, probes, options.folder);
  std::unique_ptr<FieldWriter> fields;
  const Table output = c.section("output");
  if (!options.folder.empty() && output.flag("fields")) fields = std::make_unique<FieldWriter>(cloud, options.folder);

  RunResult result;
  std::map<std::string, std::string> texts{{"method", chosen_method(c).name}};
  system.impose(0, state.T, state.E, state.exchanged);
  const auto owned = [&] { return system.values(state.T); };

  if (steady) {
    texts["integrator"] = "steady";
    SteadyReport report;
    phases.measure("solve", [&] { report = solve_steady(c, system, state); });
    result.numbers["newton_iterations"] = report.newton_iterations;
    result.numbers["linear_iterations"] = static_cast<double>(report.linear_iterations);
    result.numbers["residual"] = report.residual;
    probe_log.record(state.t, owned());
    if (fields) write_fields(*fields, system, state);
    expectations.observe(0, true, owned());
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
    for (double t : system.breaks()) timeline.add(t);
    const std::set<double>& stops = timeline.times();
    std::unique_ptr<Integrator> integrator = make_integrator(c, system, state);
    texts["integrator"] = integrator->name();

    const double sample_every = end / static_cast<double>(output.integer("samples"));
    double next_sample = sample_every;
    bool is_over = false;
    const auto sample = [&] {
      energy.record(state);
      probe_log.record(state.t, owned());
    };
    Progress progress(comm, end, options.quiet);
    std::vector<double> T_before = time.has("steady_below") ? state.T : std::vector<double>{};
    double t_before = 0;
    const auto after_step = [&](const State& s) {
      progress.show(s.t, integrator->counts.steps);
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

    sample();
    if (fields) write_fields(*fields, system, state);
    expectations.observe(0, false, owned());
    for (auto stop = stops.begin(); stop != stops.end() && !is_over && !result.interrupted_by; ++stop) {
      phases.measure("march", [&] { integrator->advance(system, state, *stop, after_step); });
      sample();
      if (fields && (shown.contains(state.t) || is_over || result.interrupted_by)) write_fields(*fields, system, state);
      if (!result.interrupted_by) expectations.observe(state.t, is_over || *stop == end, owned());
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
                           {"energy_imbalance", energy.worst_imbalance()}});
  }
  write_final(cloud, owned(), options.folder);

  const CloudCheck sound = check(cloud);
  result.numbers.insert(model.weights.begin(), model.weights.end());
  result.numbers.insert({{"points", static_cast<double>(cloud.count)},
                         {"volume", sound.volume},
                         {"volume_error", sound.volume_error},
                         {"area_sum", sound.area_sum},
                         {"moment_sum", sound.moment_sum},
                         {"ranks", size_of(comm)},
                         {"memory_bytes", max(comm, peak_memory())}});
  if (!result.interrupted_by) result.verdicts = expectations.finish(result.numbers);
  write_report(comm, options.folder, c, result.numbers, texts, phases, result.verdicts);
  return result;
}

}  // namespace calor
