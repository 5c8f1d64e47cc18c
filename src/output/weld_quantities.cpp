// Quantities of a weld.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "output/quantities.hpp"

namespace calor {
namespace {

/// The quantity of a weld that `measure` computes.
Quantity of_weld(Quantity q, Measure (*measure)(const Table& expect, const WeldResults& weld)) {
  q.make = [plural = q.plural, measure](const Table& expect, const Results& results) {
    if (!results.weld)
      expect.refuse("quantity", fmt::format("{} are results of a weld, and the case has no [weld]", plural),
                    "add [weld]");
    return measure(expect, *results.weld);
  };
  return q;
}

std::vector<double> copy(std::span<const double> values) { return {values.begin(), values.end()}; }

// What a probe went through is not what the points around it went through, interpolated: it has a history of its own.

Measure measure_peak_temperature(const Table& /*expect*/, const WeldResults& weld) {
  return {.values = [&weld](const State&, std::span<const double>) { return copy(weld.points().peak()); },
          .at_probes = [&weld](const State&) { return copy(weld.probes().peak()); }};
}

Measure measure_cooling_time(const Table& expect, const WeldResults& weld) {
  if (!weld.has_cooling())
    expect.refuse("quantity", "[weld] does not say between which temperatures",
                  "add cooling = [\"800 degC\", \"500 degC\"]");
  return {.values = [&weld](const State&, std::span<const double>) { return copy(weld.points().cooling()); },
          .at_probes = [&weld](const State&) { return copy(weld.probes().cooling()); }};
}

Measure measure_extent(const Table& expect, const WeldResults& weld) {
  const std::string name = expect.text("extent");
  std::vector<std::string> names;
  for (const Extent& extent : weld.extents()) names.push_back(extent.name());
  if (!std::ranges::count(names, name))
    expect.refuse("extent", fmt::format("there is no extent '{}'", name),
                  names.empty() ? fmt::format("add [weld.extent.{}]", name)
                                : fmt::format("the extents are: {}", fmt::join(names, ", ")));
  const Extent& extent = *std::ranges::find(weld.extents(), name, &Extent::name);
  return {.values = [&extent](const State& state, std::span<const double>) {
    return std::vector{extent.of_temperatures(state.T).length()};
  }};
}

Measure measure_average_temperature(const Table& /*expect*/, const WeldResults& weld) {
  return {
      .values = [&weld](const State& state, std::span<const double> T) { return std::vector{weld.average(state, T)}; }};
}

}  // namespace

Quantity peak_temperature_quantity() {
  return of_weld({.name = "peak_temperature", .plural = "peak temperatures", .unit = "K", .column = "T", .make = {}},
                 measure_peak_temperature);
}

Quantity cooling_time_quantity() {
  return of_weld({.name = "cooling_time", .plural = "cooling times", .unit = "s", .column = "t", .make = {}},
                 measure_cooling_time);
}

Quantity extent_quantity() {
  return of_weld({.name = "extent",
                  .plural = "extents",
                  .unit = "m",
                  .column = "length",
                  .is_of_body = true,
                  .keys = {{"extent", Kind::text, "", required, "Name of the [weld.extent.*]."}},
                  .make = {}},
                 measure_extent);
}

Quantity average_temperature_quantity() {
  return of_weld({.name = "average_temperature",
                  .plural = "average temperatures",
                  .unit = "K",
                  .column = "T",
                  .is_of_body = true,
                  .make = {}},
                 measure_average_temperature);
}

}  // namespace calor
