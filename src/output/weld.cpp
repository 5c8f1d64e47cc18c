#include "output/weld.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"

namespace calor {
namespace {

std::optional<ThermalHistory::Levels> cooling_levels(const Case& c) {
  const Table weld = c.section("weld");
  if (!weld.has("cooling")) return std::nullopt;
  const std::vector<double> T = weld.numbers("cooling");
  if (T.size() != 2 || !(T[0] > T[1]))
    weld.refuse("cooling", "cooling is between two temperatures, the higher one first",
                "write cooling = [\"800 degC\", \"500 degC\"]");
  return ThermalHistory::Levels{T[0], T[1]};
}

Vec3 end_of(const Table& extent, const std::string& key, const Cloud& cloud) {
  const std::vector<double> x = extent.numbers(key);
  if (static_cast<int>(x.size()) != cloud.dimension)
    extent.refuse(key, fmt::format("{} coordinates in a body of {} dimensions", x.size(), cloud.dimension),
                  fmt::format("give {}", cloud.dimension));
  Vec3 place;
  for (int axis = 0; axis < cloud.dimension; ++axis) place[axis] = x[axis];
  return place;
}

double finest_spacing(const Cloud& cloud) {
  double finest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < cloud.owned; ++i) finest = std::min(finest, cloud.spacing[i]);
  return min(cloud.comm, finest);
}

std::vector<Vec3> line_places(const Vec3& from, const Vec3& to, std::size_t count) {
  std::vector<Vec3> places;
  for (std::size_t n = 0; n < count; ++n)
    places.push_back(from + static_cast<double>(n) / static_cast<double>(count - 1) * (to - from));
  return places;
}

/// Points to look at on a line: several a spacing.
std::size_t samples_on(const Cloud& cloud, const Vec3& from, const Vec3& to) {
  constexpr double per_spacing = 4;
  return 2 + static_cast<std::size_t>(per_spacing * norm(to - from) / finest_spacing(cloud));
}

/// Where the cubic through four equally spaced values (fewer at the ends) crosses a level between values k and k + 1.
double crossing(std::span<const double> T, std::size_t k, double level) {
  const std::size_t first = std::min(k > 0 ? k - 1 : 0, T.size() - std::min<std::size_t>(4, T.size()));
  const std::size_t count = std::min<std::size_t>(4, T.size());
  const auto value = [&](double s) {
    double sum = 0;
    for (std::size_t a = 0; a < count; ++a) {
      double weight = 1;
      for (std::size_t b = 0; b < count; ++b)
        if (b != a) weight *= (s - static_cast<double>(first + b)) / (static_cast<double>(a) - static_cast<double>(b));
      sum += weight * T[first + a];
    }
    return sum;
  };
  double low = static_cast<double>(k), high = low + 1;
  const bool rises = T[k + 1] > T[k];
  for (int iteration = 0; iteration < 60; ++iteration) {
    const double middle = 0.5 * (low + high);
    ((value(middle) > level) == rises ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

Extent::Extent(const std::string& name, const Cloud& cloud, const Vec3& from, const Vec3& to, double isotherm,
               const SourceLocation& in_case, const Dofs* dofs)
    : name_(name),
      isotherm_(isotherm),
      step_(norm(to - from) / static_cast<double>(samples_on(cloud, from, to) - 1)),
      line_([&] {
        const std::size_t count = samples_on(cloud, from, to);
        try {
          return Probes(cloud, std::vector<std::string>(count, "on the line of " + name), line_places(from, to, count),
                        dofs);
        } catch (const Error& e) {
          throw Error(e.fault(), in_case, e.problem(), e.cure());
        }
      }()) {}

Extent::Part Extent::of_field(std::span<const double> field) const { return of(line_.sample(field)); }

Extent::Part Extent::of_temperatures(std::span<const double> T) const { return of(line_.temperatures(T)); }

Extent::Part Extent::of(const std::vector<double>& T) const {
  const auto is_hot = [&](double value) { return value > isotherm_; };
  const auto first = std::ranges::find_if(T, is_hot);
  if (first == T.end()) return {};
  const std::size_t begin = first - T.begin(), end = T.rend() - std::find_if(T.rbegin(), T.rend(), is_hot) - 1;
  return {.begin = step_ * (begin == 0 ? 0 : crossing(T, begin - 1, isotherm_)),
          .end = step_ * (end + 1 == T.size() ? static_cast<double>(end) : crossing(T, end, isotherm_))};
}

std::unique_ptr<WeldResults> WeldResults::make(const Case& c, HeatSystem& system, const Probes& probes,
                                               const State& start, const std::vector<double>& start_E) {
  if (!c.root().has("weld")) return nullptr;
  if (!c.root().has("time"))
    c.root().refuse("weld", "a steady case has no weld", "take [time] instead of [steady], or leave [weld] out");
  return std::unique_ptr<WeldResults>(new WeldResults(c, system, probes, start, start_E));
}

WeldResults::WeldResults(const Case& c, HeatSystem& system, const Probes& probes, const State& start,
                         const std::vector<double>& start_E)
    : system_(system),
      probes_(probes),
      has_cooling_(cooling_levels(c).has_value()),
      points_(system.cloud().owned, cooling_levels(c)),
      at_probes_(probes.names().size(), cooling_levels(c)),
      start_E_(start_E) {
  const Cloud& cloud = system.cloud();
  const Table weld = c.section("weld");
  header_ = "time [s],average [K]";
  if (theory(0)) header_ += ",theory [K]";
  for (const auto& [name, table] : weld.sub("extent").children()) {
    if (!table.has("isotherm") && !weld.has("isotherm"))
      table.refuse("", fmt::format("[{}] has no isotherm", table.path()), "add isotherm = \"1450 degC\" to [weld]");
    const Vec3 from = end_of(table, "from", cloud), to = end_of(table, "to", cloud);
    if (from == to) table.refuse("to", "the line ends where it begins", "give two places");
    extents_.emplace_back(name, cloud, from, to, (table.has("isotherm") ? table : weld).number("isotherm"),
                          table.location(), &system.dofs());
    header_ += fmt::format(",{0} [m],{0} from [m],{0} to [m]", name);
  }
  largest_.resize(extents_.size());

  std::vector<double> T(start.T), C(cloud.owned);
  system.capacity(T, C);
  capacity_ = sum(cloud.comm, C);
  start_mean_ = dot(cloud.comm, system.temperatures(T), C) / capacity_;
}

void WeldResults::open(const std::string& folder) {
  folder_ = folder;
  if (!folder.empty()) log_ = CsvLog(system_.cloud().comm, folder + "/weld.csv", header_);
}

void WeldResults::observe(const State& state, std::span<const double> T) {
  points_.observe(state.t, T);
  if (!probes_.names().empty()) at_probes_.observe(state.t, probes_.temperatures(state.T));
  for (std::size_t e = 0; e < extents_.size(); ++e)
    largest_[e] = std::max(largest_[e], extents_[e].of_temperatures(state.T).length());
}

double WeldResults::average(const State& state, std::span<const double> T) const {
  const Cloud& cloud = system_.cloud();
  // The heat of subdomains that overlap is not that of the body.
  if (system_.material().capacity_depends_on_T() || system_.subdomains_overlap()) {
    const auto V = std::span(cloud.volume).first(cloud.owned);
    return dot(cloud.comm, T, V) / sum(cloud.comm, V);
  }
  std::vector<double> gained(start_E_.size());
  for (std::size_t i = 0; i < gained.size(); ++i) gained[i] = state.E[i] - start_E_[i];
  return start_mean_ + sum(cloud.comm, gained) / capacity_;
}

std::optional<double> WeldResults::theory(double t) const {
  const auto asked = system_.energy_asked(t);
  if (!asked) return std::nullopt;
  return start_mean_ + *asked / capacity_;
}

void WeldResults::record(const State& state, std::span<const double> T) {
  std::vector<double> row{state.t, average(state, T)};
  if (const auto expected = theory(state.t)) row.push_back(*expected);
  for (const Extent& extent : extents_) {
    const Extent::Part part = extent.of_temperatures(state.T);
    row.insert(row.end(), {part.length(), part.begin, part.end});
  }
  log_.row(row);
}

std::map<std::string, double> WeldResults::finish(const State& state, std::span<const double> T) {
  if (!folder_.empty() && !probes_.names().empty()) {
    const int rank = rank_of(system_.cloud().comm);
    write_in_turns(system_.cloud().comm, folder_ + "/cooling.csv",
                   has_cooling_ ? "probe,peak [K],cooling time [s]" : "probe,peak [K]", [&](std::FILE* file) {
                     for (std::size_t p = 0; rank == 0 && p < probes_.names().size(); ++p) {
                       fmt::print(file, "{},{}", probes_.names()[p], at_probes_.peak()[p]);
                       if (has_cooling_) fmt::print(file, ",{}", at_probes_.cooling()[p]);
                       std::fputc('\n', file);
                     }
                   });
  }
  std::map<std::string, double> numbers{{"average_temperature", average(state, T)}};
  if (const auto expected = theory(state.t); expected && *expected != start_mean_)
    numbers["average_temperature_error"] = std::abs(average(state, T) - *expected) / std::abs(*expected - start_mean_);
  for (std::size_t e = 0; e < extents_.size(); ++e) {
    numbers["largest_" + extents_[e].name()] = largest_[e];
    numbers["peak_" + extents_[e].name()] = extents_[e].of_field(points_.peak()).length();
  }
  return numbers;
}

void declare_weld(Schema& schema) {
  schema.add({.path = "weld",
              .sentence =
                  "What a weld is judged by: the melt's extents and the average temperature over time (weld.csv), "
                  "peaks and cooling times as fields and at the probes (cooling.csv).",
              .keys = {{"isotherm", Kind::quantity, "K", optional, "Temperature above which the extents count."},
                       {"cooling", Kind::quantities, "K", optional,
                        "Two temperatures, the higher one first: the time to cool between them is a result."}}});
  schema.add({.path = "weld.extent.*",
              .sentence = "The extent of what is hotter than an isotherm along a line: from its first crossing to its "
                          "last. The report has its largest value and, as peak_NAME, that of the peak temperatures.",
              .keys = {{"from", Kind::quantities, "m", required, "Where the line begins."},
                       {"to", Kind::quantities, "m", required, "Where the line ends."},
                       {"isotherm", Kind::quantity, "K", optional, "Isotherm of this line, in place of [weld]'s."}}});
}

}  // namespace calor
