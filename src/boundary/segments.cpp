#include "boundary/segments.hpp"

#include <algorithm>

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
  return {.f = [&](std::span<const Vec3> x, std::span<double> out) { select(where, x, out); }};
}

/// Places of a rule and whether each is selected.
struct Selected {
  CellSamples rule;
  std::vector<double> in;
};

Selected select(const CellIntegrals& integrals, const Selection& selection, const Integrand& f) {
  const auto& [facets, plate, where] = selection;
  Selected out{.rule = plate > 0 ? integrals.cells(f) : integrals.facets(facets, f), .in = {}};
  out.in.resize(out.rule.x.size());
  select(where, out.rule.x, out.in);
  if (!where || plate > 0) return out;
  const std::vector<char> wholly = integrals.hold_on_curved(facets, indicator(where));
  for (std::size_t k = 0; k < wholly.size(); ++k)
    if (wholly[k]) std::fill(out.in.begin() + out.rule.row[k], out.in.begin() + out.rule.row[k + 1], 1.0);
  return out;
}

/// m^2 of a selection for every unit of the rule's weights.
double area_of_weight(const Selection& selection, const Cloud& cloud) {
  return selection.plate > 0 ? selection.plate / cloud.cross_section : 1;
}

}  // namespace

Segments selected_facets(const CellIntegrals& integrals, const Cloud& cloud, const Selection& selection) {
  const auto& [rule, in] = select(integrals, selection, selection.where ? indicator(selection.where) : Integrand{});
  Segments out;
  for (std::size_t k = 0; k < rule.point.size(); ++k) {
    double selected = 0, all = 0;
    for (auto n = rule.row[k]; n < rule.row[k + 1]; ++n) selected += in[n] * rule.weight[n], all += rule.weight[n];
    if (selected == 0) continue;
    const int i = rule.point[k];
    const double area = selection.plate > 0 ? selection.plate * cloud.volume[i] / cloud.cross_section
                                            : cloud.facets[selection.facets[k]].area;
    out.point.push_back(i);
    if (selection.plate == 0) out.facet.push_back(selection.facets[k]);
    out.area.push_back(area * std::min(1.0, selected / all));
    out.x.push_back(cloud.x[i]);
  }
  return out;
}

Segments selected_places(const CellIntegrals& integrals, const Cloud& cloud, const Selection& selection,
                         const Integrand& f) {
  const Integrand both{.f = [&](std::span<const Vec3> x, std::span<double> out) {
    f.f(x, out);
    std::vector<double> in(x.size());
    select(selection.where, x, in);
    for (std::size_t n = 0; n < out.size(); ++n) out[n] = in[n] != 0 ? 1 + out[n] : 0;
  }};
  const auto& [rule, in] = select(integrals, selection, both);
  Segments out;
  for (std::size_t k = 0; k < rule.point.size(); ++k) {
    for (auto n = rule.row[k]; n < rule.row[k + 1]; ++n) {
      if (in[n] == 0) continue;
      out.point.push_back(rule.point[k]);
      if (selection.plate == 0) out.facet.push_back(selection.facets[k]);
      out.area.push_back(rule.weight[n] * area_of_weight(selection, cloud));
      out.x.push_back(rule.x[n]);
    }
  }
  return out;
}

}  // namespace calor
