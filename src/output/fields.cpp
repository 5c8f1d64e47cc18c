// Fields for ParaView at the times of [output], and the end of a run for a run that starts from it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "output/facet_fields.hpp"
#include "output/field_writer.hpp"
#include "output/files.hpp"
#include "output/observer.hpp"
#include "output/thermal_stress.hpp"
#include "output/weld.hpp"

namespace calor {
namespace {

/// Temperature, heat flux and properties of the owned points, temperature and heat flux of the surface; for a body of
/// several materials also how much of each there is, and of a weld its peaks and cooling times.
class Fields : public Observer {
 public:
  explicit Fields(const RunSetup& run) : run_(run) {
    const Table output = run.description.section("output");
    if (!run.folder.empty() && output.flag("fields")) {
      Label part;
      collective_try(run.comm(), [&] {
        part = part_of_points(run.system);
        condition_ = condition_of_facets(run.system);
      });
      writer_ =
          field_formats()
              .chosen(output, "format")
              .make(
                  {.cloud = run.system.cloud(), .folder = run.folder, .of_points = {part}, .of_facets = {condition_}});
    }
    if (run.is_steady()) return;
    end_ = run.description.section("time").number("end");
    if (output.has("times")) times_ = output.numbers("times");
    if (output.has("every"))
      for (long n = 1; n * output.number("every") < end_; ++n) times_.push_back(n * output.number("every"));
  }

  std::vector<double> times() const override { return times_; }
  void begin() override {
    if (writer_) writer_->open();
  }
  void exchange(Archive& archive) override {
    if (writer_) writer_->exchange(archive);
  }
  void at_stop(const Moment& m) override {
    // What differs by round-off alone is one time.
    const double t = m.state().t;
    const auto is_now = [&](double output_time) { return std::abs(t - output_time) <= 1e-12 * end_; };
    if (!writer_ || writer_->has(t)) return;
    if (t == 0 || m.is_last || m.is_cut_short || std::ranges::any_of(times_, is_now))
      run_.phases.measure("output", [&] { write(m); });
  }

 private:
  void write(const Moment& m);

  const RunSetup& run_;
  double end_ = 0;
  std::vector<double> times_;
  Label condition_;  ///< of the facets
  std::unique_ptr<FieldWriter> writer_;
};

void Fields::write(const Moment& m) {
  HeatSystem& system = run_.system;
  const MaterialField& material = system.material();
  const double t = m.state().t;
  const std::span<const double> T = m.temperatures();
  std::vector<Vec3> q(T.size());
  system.heat_flux(t, m.u(), q);
  const std::vector<std::string> ingredients = material.ingredients();
  const std::vector<double> T_walls = system.wall_temperatures(t, m.u());
  std::vector<double> k(T.size()), rho_c(T.size()), q_walls;
  std::vector<std::vector<double>> fractions(ingredients.size() > 1 ? ingredients.size() : 0, k);
  collective_try(run_.comm(), [&] {
    material.conductivity(t, T, k, {});
    material.enthalpy(T, {}, rho_c);
    for (std::size_t n = 0; n < fractions.size(); ++n) material.volume_fraction(ingredients[n], fractions[n]);
    q_walls = heat_flux_of_facets(system, t, condition_, T_walls, q);
  });
  std::vector<Field> fields{{"temperature [K]", 1, T},
                            {"heat flux [W/m^2]", 3, std::span(&q.data()->x, 3 * q.size())},
                            {"conductivity [W/(m K)]", 1, k},
                            {"volumetric heat capacity [J/(m^3 K)]", 1, rho_c}};
  for (std::size_t n = 0; n < fractions.size(); ++n)
    fields.push_back({"volume fraction of " + ingredients[n], 1, fractions[n]});
  if (const WeldResults* weld = run_.weld.get()) {
    fields.push_back({"peak temperature [K]", 1, weld->points().peak()});
    if (weld->has_cooling()) fields.push_back({"cooling time [s]", 1, weld->points().cooling()});
  }
  std::vector<std::vector<double>> stresses;
  if (const ThermalStress* stress = run_.stress.get()) {
    const Deformation deformation = stress->deformation(m.u());
    collective_try(run_.comm(), [&] {
      for (std::size_t n = 0; n < stress->components().size(); ++n)
        stresses.push_back(stress->at_points(deformation, n, T));
    });
    for (std::size_t n = 0; n < stresses.size(); ++n)
      fields.push_back({stress->components()[n] + " [Pa]", 1, stresses[n]});
  }
  writer_->write(t, fields, {{"temperature [K]", 1, T_walls}, {"heat flux into the body [W/m^2]", 1, q_walls}});
}

/// final.csv: id,x [m],y [m],z [m],T [K] with all digits, in the order of the points.
class FinalState : public Observer {
 public:
  explicit FinalState(const RunSetup& run) : run_(run) {}

  void finish(const Moment& m, RunResult&) override {
    run_.phases.measure("output", [&] {
      const std::vector<Row> rows = in_order(run_.system.cloud(), m.temperatures());
      write_in_turns(run_.comm(), run_.folder + "/final.csv", "id,x [m],y [m],z [m],T [K]", [&](std::FILE* file) {
        NumberLines lines(file);
        for (const auto& [id, x, T] : rows) lines.add({static_cast<double>(id), x.x, x.y, x.z, T});
        lines.finish();
      });
    });
  }

 private:
  struct Row {
    std::int64_t id;  // far from what a double does not hold
    Vec3 x;
    double T;
  };

  /// The rows of every rank by their numbers, lower ones on lower ranks. Collective.
  static std::vector<Row> in_order(const Cloud& cloud, std::span<const double> T) {
    std::vector<Row> rows;
    rows.reserve(cloud.owned);
    for (int i = 0; i < cloud.owned; ++i) rows.push_back({cloud.id[i], cloud.x[i], T[i]});
    std::ranges::sort(rows, {}, &Row::id);
    const int ranks = size_of(cloud.comm);
    std::vector<int> counts(ranks, 0);
    for (const Row& row : rows) ++counts[static_cast<std::size_t>(row.id * ranks / cloud.count)];
    rows = calor::exchange(cloud.comm, rows, counts);
    std::ranges::sort(rows, {}, &Row::id);
    return rows;
  }

  const RunSetup& run_;
};

}  // namespace

std::unique_ptr<Observer> make_fields(const RunSetup& run) { return std::make_unique<Fields>(run); }

std::unique_ptr<Observer> make_final_state(const RunSetup& run) {
  return run.folder.empty() ? nullptr : std::make_unique<FinalState>(run);
}

}  // namespace calor
