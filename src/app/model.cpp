#include "app/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>

#include "base/cache.hpp"
#include "base/parallel.hpp"
#include "case/values.hpp"
#include "cloud/cracks.hpp"
#include "cloud/points.hpp"
#include "cloud/shapes.hpp"
#include "geometry/contact_cells.hpp"
#include "output/probes.hpp"
#include "solve/initial.hpp"
#include "solve/integrator.hpp"
#include "solve/twin.hpp"

namespace calor {
namespace {

/// Lowest and highest temperature that conditions and the start bring in, and the volume mean of the start.
TemperatureRange expected_range(const Cloud& cloud, const Conditions& conditions, const std::vector<double>& T_start,
                                double& driving_mean) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  double driving_sum = 0, driving_count = 0;
  const auto see = [&](double T) { low = std::min(low, T), high = std::max(high, T); };
  const auto see_driving = [&](double T) { see(T), driving_sum += T, driving_count += 1; };
  bool radiates = false;
  collective_try(cloud.comm, [&] {
    for (const SurfaceTerm& term : conditions.fluxes)
      for (double T : term.flux->ambient(term.x, 0)) {
        see_driving(T);
        radiates = radiates || !term.flux->linear_in_temperature();
      }
    for (const PrescribedTerm& term : conditions.temperatures) {
      std::vector<double> T(term.x.size());
      term.temperature.evaluate({.x = term.x}, T);
      std::ranges::for_each(T, see_driving);
    }
  });
  std::ranges::for_each(T_start, see);
  low = min(cloud.comm, low), high = max(cloud.comm, high);
  driving_sum = sum(cloud.comm, std::span(&driving_sum, 1));
  driving_count = sum(cloud.comm, std::span(&driving_count, 1));
  // At absolute zero, as of what a body in space radiates to, radiation has no slope.
  const bool has_no_slope = any(cloud.comm, radiates) && driving_sum == 0;
  driving_mean = driving_count > 0 && !has_no_slope ? driving_sum / driving_count : 293.15;
  if (!(low <= high)) low = high = driving_mean;
  return {.low = low, .high = high, .reference = driving_mean};
}

/// Says which functions of time a steady state takes at t = 0.
std::vector<std::string> notes_on_time(const Case& c) {
  std::vector<std::string> notes;
  for (const char* section : {"body", "material", "boundary", "source"})
    for (const Function& f : c.section(section).functions())
      if (f.depends_on_time())
        notes.push_back(fmt::format("{}: a function of time: the steady state is that of t = 0", f.location().text()));
  return notes;
}

/// Says where the temperatures of the start, walls and ambients are lowest, if that is below absolute zero. Collective.
std::vector<std::string> note_on_absolute_zero(const Cloud& cloud, const Conditions& conditions,
                                               const std::vector<double>& T_start) {
  struct Coldest {
    double T = 0;
    Vec3 x;
  } mine;
  const auto see = [&](double T, const Vec3& x) {
    if (T < mine.T) mine = {T, x};
  };
  for (std::size_t i = 0; i < T_start.size(); ++i) see(T_start[i], cloud.x[i]);
  collective_try(cloud.comm, [&] {
    for (const PrescribedTerm& term : conditions.temperatures)
      for (const Vec3& x : term.x) see(term.temperature(x), x);
  });
  const std::vector<Coldest> all = gather(cloud.comm, std::vector<Coldest>{mine});
  const Coldest& coldest = *std::ranges::min_element(all, {}, &Coldest::T);
  if (coldest.T >= 0) return {};
  return {
      fmt::format("temperatures of the case go down to {:.6g} K at ({:.6g}, {:.6g}, {:.6g}) m, below absolute zero: "
                  "right only where nothing but differences of temperature counts",
                  coldest.T, coldest.x.x, coldest.x.y, coldest.x.z)};
}

/// Refuses [output] keys that make no sense. `end` of the run, s.
void check_output(const Table& output, double end) {
  if (output.integer("samples") < 1)
    output.refuse("samples", fmt::format("{} samples", output.integer("samples")), "give at least 1");
  if (output.has("every") && !(output.number("every") > 0))
    output.refuse("every", fmt::format("a time of {} s is not positive", output.number("every")),
                  "give a positive one");
  constexpr double most_fields = 10'000;
  if (output.has("every") && end / output.number("every") > most_fields)
    output.refuse("every",
                  fmt::format("fields every {:g} s would be {:.3g} in {:g} s", output.number("every"),
                              end / output.number("every"), end),
                  fmt::format("write them at most {:g} times: a row of probes.csv costs less", most_fields));
  if (!(output.number("checkpoint") >= 0))
    output.refuse("checkpoint", fmt::format("a time of {} s is negative", output.number("checkpoint")),
                  "give a positive one, or 0 s for none");
  if (output.has("checkpoint_steps") && output.integer("checkpoint_steps") < 1)
    output.refuse("checkpoint_steps", fmt::format("{} steps", output.integer("checkpoint_steps")), "give at least 1");
  for (double t : output.has("times") ? output.numbers("times") : std::vector<double>{})
    if (!(t >= 0 && t <= end * (1 + 1e-12)))
      output.refuse("times", fmt::format("{} s is not between the start and the end of the run, {} s", t, end),
                    "leave it out, or choose a later end of [time]");
}

double volume_mean(const Cloud& cloud, const std::vector<double>& T) {
  return dot(cloud.comm, T, std::span(cloud.volume).first(T.size())) /
         sum(cloud.comm, std::span(cloud.volume).first(T.size()));
}

/// Notes what a user should know of a cloud that a file describes, and returns what is wrong with its surface.
/// Collective; throws Error.
std::vector<std::string> add_remarks_on_file(Model& m) {
  const Cloud& cloud = *m.cloud;
  std::vector<std::string> remarks = remarks_on_surface(cloud);
  std::ranges::copy(remarks, std::back_inserter(m.notes));
  if (cloud.has_areas && !cloud.points_on_walls)
    m.notes.push_back("the points lie off the walls, by half a cell: conditions act there");
  return remarks;
}

/// Tells of parts of the body that later regions cover as a whole. Collective.
std::vector<std::string> notes_on_covered_parts(const Cloud& cloud, const MaterialField& material) {
  std::vector<std::string> notes;
  for (int p = 0; p < material.parts().count(); ++p) {
    if (any(cloud.comm, !material.cell_shares()[p].place.empty())) continue;
    const Part& part = material.parts()[p];
    notes.push_back(fmt::format("{}: nothing of the body is left for this '{}': later regions cover it",
                                part.location.text(), part.material));
  }
  return notes;
}

/// A place of a part that nothing holds at a level. Collective.
std::optional<Vec3> loose_part(const Model& m) {
  try {
    return m.system->loose_part(m.T_start);
  } catch (const Error&) {  // `start` tells of conductivities that are wrong
    return std::nullopt;
  }
}

/// A steady temperature has a level only where something fixes it, in every part of the body. Collective.
void require_level(const Case& c, const Model& m) {
  const std::string cure =
      "prescribe a temperature, convection or radiation on some wall, or take [time] instead of [steady]";
  if (!m.system->level_is_fixed()) c.root().refuse("steady", "nothing fixes the level of a steady temperature", cure);
  if (const auto loose = loose_part(m))
    c.root().refuse("steady",
                    fmt::format("nothing fixes the level of the steady temperature of the part around ({:.6g}, {:.6g}, "
                                "{:.6g}) m, which is cut off from the rest",
                                loose->x, loose->y, loose->z),
                    cure);
}

/// The materials where the terms of the discretisation want them besides the nodes.
void add_locations(std::vector<MaterialField>& materials, const Discretisation& discretisation) {
  for (const QuadraturePoints* points : discretisation.locations)
    materials.emplace_back(materials.front(), points->x, points->tag, points->part);
}

/// Places of some points of the body, the same on all ranks. Collective.
std::vector<Vec3> some_places(const Cloud& cloud) {
  constexpr int most = 8;
  std::vector<double> x(3 * most);
  for (int n = 0; n < most; ++n) {
    const auto found = std::ranges::find(cloud.id, n * (cloud.count - 1) / (most - 1));
    const auto i = found - cloud.id.begin();
    if (i < cloud.owned)
      for (int a = 0; a < 3; ++a) x[3 * n + a] = cloud.x[i][a];
  }
  add_up(cloud.comm, x);
  std::vector<Vec3> places(most);
  for (int n = 0; n < most; ++n) places[n] = {x[3 * n], x[3 * n + 1], x[3 * n + 2]};
  return places;
}

double number(const MethodReport& report, const std::string& name) {
  const auto found = report.find(name);
  return found == report.end() ? 0 : found->second;
}

}  // namespace

bool is_steady(const Case& c) {
  const bool steady = c.root().has("steady"), transient = c.root().has("time");
  if (steady && transient)
    c.root().refuse("steady", "the case has both [steady] and [time]", "keep the one that you want");
  if (!steady && !transient)
    c.root().refuse("", "the case says neither [steady] nor [time]", "add [steady], or [time] with end = \"10 s\"");
  return steady;
}

Model build_model(const Case& c, MPI_Comm comm, Phases& phases) {
  Model m{.description = c, .cloud = nullptr, .weights = {}, .notes = {}, .system = nullptr, .T_start = {}};
  const Method& method = chosen_method(c);
  const bool steady = is_steady(c);
  if (steady) check_steady(c);
  if (steady) m.notes = notes_on_time(c);
  if (!steady) check_output(c.section("output"), c.section("time").number("end"));
  const SourceLocation cloud_location = location_of_points(c.section("cloud"));
  const Support support = method.support(c);
  located(cloud_location,
          [&] { phases.measure("cloud", [&] { m.cloud = std::make_unique<Cloud>(make_cloud(comm, c, support)); }); });
  std::vector<Crack> cracks = has_cracks(c) ? read_cracks(c, *m.cloud) : std::vector<Crack>();
  std::erase_if(cracks, [](const Crack& crack) { return crack.fails(); });
  end_cells_at_contacts(c, *m.cloud);
  if (!cracks.empty()) end_cells_at_cracks(*m.cloud, Cracks(*m.cloud, std::move(cracks)));
  std::vector<std::string> remarks;
  std::ranges::copy(m.cloud->notes, std::back_inserter(m.notes));
  if (has_cracks(c)) std::ranges::copy(notes_on_cracks(c, *m.cloud), std::back_inserter(m.notes));
  if (c.section("cloud").has("file")) located(cloud_location, [&] { remarks = add_remarks_on_file(m); });
  Conditions conditions;
  std::vector<std::unique_ptr<Source>> sources;
  phases.measure("conditions", [&] {
    conditions = make_conditions(c, *m.cloud);
    sources = make_sources(c, *m.cloud);
    m.T_start = initial_temperatures(c, *m.cloud);
  });
  const std::optional<Twin> twin = read_twin(c, *m.cloud);
  if (twin) sources.clear(), prescribe_twin(*twin, *m.cloud, conditions, m.T_start);
  std::ranges::copy(conditions.notes, std::back_inserter(m.notes));
  for (std::size_t n = 0; n < conditions.areas.size(); ++n)
    if (conditions.areas[n] > 0) m.heated_areas.emplace_back(conditions.accounts[n], conditions.areas[n]);
  for (const auto& source : sources) std::ranges::copy(source->notes, std::back_inserter(m.notes));
  std::ranges::copy(note_on_absolute_zero(*m.cloud, conditions, m.T_start), std::back_inserter(m.notes));
  double driving_mean = 0;
  m.range = expected_range(*m.cloud, conditions, m.T_start, driving_mean);
  if (!c.root().has("initial") && !twin) {
    if (!steady)
      c.root().refuse("", "a transient case needs the temperature at the start",
                      "add [initial] with temperature = \"293 K\"");
    m.T_start.assign(m.cloud->owned, driving_mean);
  }
  m.range.reference = volume_mean(*m.cloud, m.T_start);
  if (!steady) *c.context().course = {c.section("time").number("end"), some_places(*m.cloud), m.range.reference};

  Discretisation discretisation;
  std::vector<MaterialField> materials;
  phases.measure("materials", [&] { materials.emplace_back(c, *m.cloud, m.range); });
  std::ranges::copy(notes_on_covered_parts(*m.cloud, materials.front()), std::back_inserter(m.notes));
  const Probes probes(c, *m.cloud);  // refuses what does not fit, before the weights take their time
  located(cloud_location, [&] {
    try {
      phases.measure("weights",
                     [&] { discretisation = method.build(c, *m.cloud, conditions, materials.front(), m.weights); });
    } catch (const Error& e) {  // all ranks throw alike
      if (remarks.empty()) throw;
      throw Error(e.fault(), e.location(), e.problem(), e.cure() + "; " + remarks.front());
    }
  });
  if (m.cloud->cache) std::ranges::copy(m.cloud->cache->notes(), std::back_inserter(m.notes));
  discretisation.weights_are_positive =
      m.weights.contains("negative_weights") && number(m.weights, "negative_weights") == 0;
  std::ranges::copy(discretisation.notes, std::back_inserter(m.notes));
  try {
    if (const auto note = note_of_jumps(*m.cloud, *discretisation.conduction, materials.front(), m.T_start))
      m.notes.push_back(*note);
  } catch (const Error&) {  // `start` tells of conductivities that are wrong
  }
  if (twin) sources.push_back(make_twin_source(c, *twin, *m.cloud, conditions, materials.front()));
  if (discretisation.subdomains)
    for (const auto& source : sources) source->integrate_over(*discretisation.subdomains);
  add_locations(materials, discretisation);
  if (const double negative = number(m.weights, "negative_weights"); negative > 0)
    m.notes.push_back(
        fmt::format("{:g} of {:g} weights of pairs are negative, the lowest {:.2g} times the mean: temperatures may "
                    "slightly leave the range of the data",
                    negative, number(m.weights, "pairs"), number(m.weights, "most_negative_weight")));
  m.system = std::make_unique<HeatSystem>(*m.cloud, std::move(discretisation), std::move(materials),
                                          std::move(conditions), std::move(sources));
  if (steady) require_level(c, m);
  return m;
}

std::vector<MaterialField> materials_of(const Case& c, const Model& model) {
  std::vector<MaterialField> materials;
  materials.emplace_back(c, *model.cloud, model.range);
  add_locations(materials, model.system->discretisation());
  return materials;
}

Start start(const Model& m) {
  HeatSystem& system = *m.system;
  try {
    Start s{.state = system.start(0, m.T_start), .E_before_walls = {}};
    s.E_before_walls = s.state.E;
    system.impose(0, s.state.T, s.state.E, s.state.cumulative_heat);
    const std::vector<double> T = system.temperatures(s.state.T);
    collective_try(m.cloud->comm, [&] {
      std::vector<double> value(T.size());
      system.material().conductivity(0, T, value, {});
      system.material().enthalpy(T, {}, value);
    });
    return s;
  } catch (const Error& e) {
    if (e.fault() != Fault::numbers) throw;
    throw Error(Fault::bad_case, e.location(), e.problem(), e.cure());  // nothing has run: the case itself is wrong
  }
}

}  // namespace calor
