#include "app/model.hpp"

#include <algorithm>
#include <limits>

#include "base/parallel.hpp"
#include "cloud/points.hpp"
#include "solve/initial.hpp"

namespace calor {
namespace {

/// Lowest and highest temperature that conditions and the start bring in, and the volume mean of the start.
TemperatureRange expected_range(const Cloud& cloud, const Conditions& conditions, const std::vector<double>& T_start,
                                double& driving_mean) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  std::vector<double> driving;  // of conditions: sum, count
  double driving_sum = 0, driving_count = 0;
  const auto see = [&](double T) { low = std::min(low, T), high = std::max(high, T); };
  const auto see_driving = [&](double T) { see(T), driving_sum += T, driving_count += 1; };
  together(cloud.comm, [&] {
    for (const SurfaceTerm& term : conditions.fluxes)
      for (double T : term.flux->ambient(term.x, 0)) see_driving(T);
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
  driving_mean = driving_count > 0 ? driving_sum / driving_count : 293.15;
  if (!(low <= high)) low = high = driving_mean;
  return {.low = low, .high = high, .reference = driving_mean};
}

double volume_mean(const Cloud& cloud, const std::vector<double>& T) {
  return dot(cloud.comm, T, std::span(cloud.volume).first(T.size())) /
         sum(cloud.comm, std::span(cloud.volume).first(T.size()));
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
  phases.measure("cloud", [&] { m.cloud = std::make_unique<Cloud>(make_cloud(comm, c, method.reach(c))); });
  Conditions conditions = make_conditions(c, *m.cloud);
  std::vector<std::unique_ptr<Source>> sources = make_sources(c, *m.cloud);
  m.notes = conditions.notes;

  m.T_start = initial_temperatures(c, *m.cloud);
  double driving_mean = 0;
  TemperatureRange range = expected_range(*m.cloud, conditions, m.T_start, driving_mean);
  if (!c.root().has("initial")) {
    if (!steady)
      c.root().refuse("", "a transient case needs the temperature at the start",
                      "add [initial] with temperature = \"293 K\"");
    m.T_start.assign(m.cloud->owned, driving_mean);
  }
  range.reference = volume_mean(*m.cloud, m.T_start);

  std::unique_ptr<FluxSites> sites;
  SystemMaterial material{.points = MaterialField(c, *m.cloud, range), .conduction = {}, .capacity = {}};
  phases.measure("weights", [&] { sites = method.build(c, *m.cloud, m.weights); });
  if (const Places* at = sites->conduction_places()) material.conduction.emplace(c, *m.cloud, at->x, at->tag, range);
  if (const Places* at = sites->capacity_places()) material.capacity.emplace(c, *m.cloud, at->x, at->tag, range);
  m.system = std::make_unique<HeatSystem>(*m.cloud, std::move(sites), std::move(material), std::move(conditions),
                                          std::move(sources));
  return m;
}

}  // namespace calor
