#include "boundary/segments.hpp"

#include <algorithm>
#include <cmath>

namespace calor {
namespace {

/// 1 where the section holds.
void select(const std::optional<Function>& where, std::span<const Vec3> x, std::span<double> out) {
  std::ranges::fill(out, 1.0);
  if (!where) return;
  where->evaluate({.x = x}, out);
  for (double& value : out) value = value != 0;
}

Integrand indicator(const std::optional<Function>& where) {
  if (!where) return {};
  return {.f = [&](std::span<const Vec3> x, std::span<double> out) { select(where, x, out); }};
}

/// Jumps where the section ends and where the flux does, at the start and at two temperatures near those of the
/// surroundings: a flux that vanishes at one of them does not at the other.
Integrand jumps_of(const std::optional<Function>& where, const SurfaceFlux& flux) {
  return {.f = [&](std::span<const Vec3> x, std::span<double> out) {
    select(where, x, out);
    constexpr double room = 293.15, other = 40;  // K
    std::vector<double> T = flux.ambient(x, 0), q(x.size());
    if (T.empty()) T.assign(x.size(), room);
    for (const double part : {1., 0.6}) {
      flux.evaluate({.x = x, .T = T}, q, {});
      for (std::size_t n = 0; n < q.size(); ++n)
        if (out[n] != 0) out[n] += part * q[n];
      for (double& t : T) t += other;
    }
  }};
}

/// One entry a row: what of it is selected.
template <class Measure>
Segments whole_rows(const CellSamples& rule, const std::optional<Function>& where, const Measure& measure) {
  std::vector<double> in(rule.x.size());
  select(where, rule.x, in);
  Segments out;
  for (std::size_t k = 0; k < rule.point.size(); ++k) {
    double selected = 0, all = 0;
    for (auto n = rule.row[k]; n < rule.row[k + 1]; ++n) selected += in[n] * rule.weight[n], all += rule.weight[n];
    if (selected == 0) continue;
    out.point.push_back(rule.point[k]);
    out.facet.push_back(static_cast<int>(k));
    out.area.push_back(measure(k) * std::min(1.0, selected / all));
  }
  return out;
}

Segments places_of(const CellSamples& rule, const std::optional<Function>& where, double factor) {
  std::vector<double> in(rule.x.size());
  select(where, rule.x, in);
  Segments out;
  for (std::size_t k = 0; k < rule.point.size(); ++k) {
    for (auto n = rule.row[k]; n < rule.row[k + 1]; ++n) {
      if (in[n] == 0) continue;
      out.point.push_back(rule.point[k]);
      out.facet.push_back(static_cast<int>(k));
      out.area.push_back(factor * rule.weight[n]);
      out.x.push_back(rule.x[n]);
    }
  }
  return out;
}

void name_facets(Segments& segments, std::span<const int> facets) {
  for (int& facet : segments.facet) facet = facets[facet];
}

void place_at_points(Segments& segments, const Cloud& cloud) {
  for (const int i : segments.point) segments.x.push_back(cloud.x[i]);
}

}  // namespace

Segments selected_facets(const CellIntegrals& integrals, const Cloud& cloud, const Selection& selection) {
  const CellSamples rule = integrals.facets(selection.facets, indicator(selection.where));
  Segments out =
      whole_rows(rule, selection.where, [&](std::size_t k) { return cloud.facets[selection.facets[k]].area; });
  name_facets(out, selection.facets);
  place_at_points(out, cloud);
  return out;
}

Segments selected_facets(const CellIntegrals& integrals, const Cloud&, const Selection& selection,
                         const SurfaceFlux& flux) {
  Segments out = places_of(integrals.facets(selection.facets, jumps_of(selection.where, flux)), selection.where, 1);
  name_facets(out, selection.facets);
  return out;
}

Segments selected_plate(const CellIntegrals& integrals, const Cloud& cloud, int faces,
                        const std::optional<Function>& where) {
  Segments out = whole_rows(integrals.cells(indicator(where)), where,
                            [&](std::size_t i) { return faces * cloud.volume[i] / cloud.cross_section; });
  out.facet.clear();
  place_at_points(out, cloud);
  return out;
}

Segments selected_plate(const CellIntegrals& integrals, const Cloud& cloud, int faces,
                        const std::optional<Function>& where, const SurfaceFlux& flux) {
  Segments out = places_of(integrals.cells(jumps_of(where, flux)), where, faces / cloud.cross_section);
  out.facet.clear();
  return out;
}

}  // namespace calor
