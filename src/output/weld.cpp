#include "output/weld.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "output/files.hpp"
#include "output/observer.hpp"

namespace calor {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The parabola through the last three values, T = T2 + (t - t2) (slope + (t - t1) bend).
struct Parabola {
  double t1, t2, T2, slope, bend;

  double at(double t) const { return T2 + (t - t2) * (slope + (t - t1) * bend); }
  /// Time between t1 and t2 at which it falls through a level that lies between its values there.
  double falls_through(double level) const {
    double low = t1, high = t2, t = t2 + (level - T2) / slope;
    for (int iteration = 0; iteration < 60 && high - low > 1e-14 * t2; ++iteration) {
      (at(t) > level ? low : high) = t;
      const double derivative = slope + (2 * t - t1 - t2) * bend;
      const double next = t - (at(t) - level) / derivative;
      if (std::abs(next - t) <= 1e-14 * t2) return t;
      t = next > low && next < high ? next : 0.5 * (low + high);
    }
    return t;
  }
};

std::optional<ThermalHistory::Levels> cooling_levels(const Case& c) {
  const Table weld = c.section("weld");
  if (!weld.has("cooling")) return std::nullopt;
  const std::vector<double> T = weld.numbers("cooling");
  if (T.size() != 2 || !(T[0] > T[1]))
    weld.refuse("cooling", "cooling is between two temperatures, the higher one first",
                "write cooling = [\"800 degC\", \"500 degC\"]");
  return ThermalHistory::Levels{T[0], T[1]};
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

ThermalHistory::ThermalHistory(std::size_t count, std::optional<Levels> levels)
    : levels_(levels),
      T1_(count),
      T0_(count),
      peak_(count, -std::numeric_limits<double>::infinity()),
      below_high_(levels ? count : 0, nan),
      cooling_(levels ? count : 0, -1) {}

void ThermalHistory::observe(double t, std::span<const double> T) {
  if (known_ > 0 && t <= t1_) return;
  for (std::size_t i = 0; i < T.size(); ++i) {
    peak_[i] = std::max(peak_[i], T[i]);
    if (known_ == 0) continue;
    Parabola p{.t1 = t1_, .t2 = t, .T2 = T[i], .slope = (T[i] - T1_[i]) / (t - t1_), .bend = 0};
    if (known_ > 1) {
      const double before = (T1_[i] - T0_[i]) / (t1_ - t0_);
      p.bend = (p.slope - before) / (t - t0_);
      if (before > 0 && p.slope < 0)  // the top lies between t0 and t
        peak_[i] = std::max(peak_[i], p.at(0.5 * (t1_ + t) - 0.5 * p.slope / p.bend));
    }
    if (!levels_) continue;
    const auto falls = [&](double level) { return T1_[i] > level && T[i] <= level; };
    if (falls(levels_->high)) below_high_[i] = p.falls_through(levels_->high);
    if (falls(levels_->low) && !std::isnan(below_high_[i])) {
      cooling_[i] = p.falls_through(levels_->low) - below_high_[i];
      below_high_[i] = nan;
    }
  }
  std::swap(T0_, T1_);
  std::ranges::copy(T, T1_.begin());
  t0_ = t1_, t1_ = t;
  known_ = std::min(known_ + 1, 2);
}

void ThermalHistory::exchange(Archive& archive, const std::string& of, const Values& values) {
  archive.value("known times of " + of, known_);
  archive.value("last time of " + of, t1_);
  archive.value("time before it of " + of, t0_);
  values("last temperatures of " + of, T1_);
  values("temperatures before them of " + of, T0_);
  values("peaks of " + of, peak_);
  if (!levels_) return;
  values("times below the upper level of " + of, below_high_);
  values("cooling times of " + of, cooling_);
}

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

std::shared_ptr<WeldResults> WeldResults::make(const Case& c, HeatSystem& system, const Probes& probes,
                                               const State& start, const std::vector<double>& start_E) {
  if (!c.root().has("weld")) return nullptr;
  if (!c.root().has("time"))
    c.root().refuse("weld", "a steady case has no weld", "take [time] instead of [steady], or leave [weld] out");
  return std::shared_ptr<WeldResults>(new WeldResults(c, system, probes, start, start_E));
}

WeldResults::WeldResults(const Case& c, HeatSystem& system, const Probes& probes, const State& start,
                         std::vector<double> start_E)
    : system_(system),
      probes_(probes),
      has_cooling_(cooling_levels(c).has_value()),
      points_(system.cloud().owned, cooling_levels(c)),
      at_probes_(probes.names().size(), cooling_levels(c)),
      start_E_(std::move(start_E)) {
  const Cloud& cloud = system.cloud();
  const Table weld = c.section("weld");
  for (const auto& [name, table] : weld.sub("extent").children()) {
    if (!table.has("isotherm") && !weld.has("isotherm"))
      table.refuse("", fmt::format("[{}] has no isotherm", table.path()), "add isotherm = \"1450 degC\" to [weld]");
    const Vec3 from = place_of(table, "from", cloud), to = place_of(table, "to", cloud);
    if (from == to) table.refuse("to", "the line ends where it begins", "give two places");
    extents_.emplace_back(name, cloud, from, to, (table.has("isotherm") ? table : weld).number("isotherm"),
                          table.location(), &system.dofs());
  }
  largest_.resize(extents_.size());

  std::vector<double> T(start.T), C(cloud.owned);
  system.capacity(T, C);
  capacity_ = sum(cloud.comm, C);
  start_mean_ = dot(cloud.comm, system.temperatures(T), C) / capacity_;
}

void WeldResults::observe(const State& state, std::span<const double> T) {
  points_.observe(state.t, T);
  if (!probes_.names().empty()) at_probes_.observe(state.t, probes_.temperatures(state.T));
  for (std::size_t e = 0; e < extents_.size(); ++e)
    largest_[e] = std::max(largest_[e], extents_[e].of_temperatures(state.T).length());
}

std::vector<ReportNumber> WeldResults::listed() const {
  std::vector<ReportNumber> all;
  for (const Extent& extent : extents_)
    for (const char* what : {"largest_", "peak_"}) all.push_back({what + extent.name(), "m"});
  for (const std::string& probe : probes_.names()) all.push_back({"peak." + probe, "K"});
  return all;
}

std::vector<double> WeldResults::numbers() const {
  std::vector<double> all;
  for (std::size_t e = 0; e < extents_.size(); ++e) {
    all.push_back(largest_[e]);
    all.push_back(extents_[e].of_field(points_.peak()).length());
  }
  const auto peaks = at_probes_.peak();
  all.insert(all.end(), peaks.begin(), peaks.end());
  return all;
}

void WeldResults::exchange(Archive& archive) {
  archive.values("largest extents", largest_);
  const auto of_points = [&](const std::string& name, std::span<double> values) { archive.points(name, values); };
  const auto of_probes = [&](const std::string& name, std::span<double> values) { archive.values(name, values); };
  points_.exchange(archive, "points", of_points);
  at_probes_.exchange(archive, "probes", of_probes);
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

namespace {

/// weld.csv and, in the end, cooling.csv and numbers for the report.
class WeldLog : public Observer {
 public:
  explicit WeldLog(const RunSetup& run) : run_(run), weld_(*run.weld) {
    if (run.folder.empty()) return;
    std::string header = weld_.theory(0) ? "time [s],average [K],theory [K]" : "time [s],average [K]";
    for (const Extent& extent : weld_.extents())
      for (const char* what : {"", " from", " to"}) header += "," + csv_field(extent.name() + what + " [m]");
    log_ = CsvLog(run.comm(), run.folder + "/weld.csv", header);
  }

  void begin() override { log_.open(); }
  void exchange(Archive& archive) override {
    weld_.exchange(archive);
    log_.exchange(archive);
  }
  bool after_step(const Moment& m) override {
    weld_.observe(m.state(), m.temperatures());
    return true;
  }
  void record(const Moment& m) override {
    const auto T = m.temperatures();
    weld_.observe(m.state(), T);
    std::vector<double> row{m.state().t, weld_.average(m.state(), T)};
    if (const auto expected = weld_.theory(m.state().t)) row.push_back(*expected);
    for (const Extent& extent : weld_.extents()) {
      const Extent::Part part = extent.of_temperatures(m.u());
      row.insert(row.end(), {part.length(), part.begin, part.end});
    }
    log_.row(row);
  }
  void finish(const Moment& m, RunResult& result) override {
    if (!run_.folder.empty() && !run_.probes.names().empty()) write_cooling();
    const double average = weld_.average(m.state(), m.temperatures()), start = weld_.start_average();
    result.numbers["average_temperature"] = average;
    if (const auto expected = weld_.theory(m.state().t); expected && *expected != start)
      result.numbers["average_temperature_error"] = std::abs(average - *expected) / std::abs(*expected - start);
    const std::vector<ReportNumber> listed = weld_.listed();
    const std::vector<double> numbers = weld_.numbers();
    for (std::size_t n = 0; n < numbers.size(); ++n) result.numbers[listed[n].name] = numbers[n];
  }
  std::vector<ReportNumber> numbers() const override {
    std::vector<ReportNumber> all{{"average_temperature", "K"}};
    if (weld_.theory(0)) all.push_back({"average_temperature_error", ""});
    std::ranges::copy(weld_.listed(), std::back_inserter(all));
    return all;
  }

 private:
  void write_cooling() const {
    const std::vector<std::string>& names = run_.probes.names();
    const ThermalHistory& history = weld_.probes();
    const bool is_written_here = rank_of(run_.comm()) == 0;
    write_in_turns(run_.comm(), run_.folder + "/cooling.csv",
                   weld_.has_cooling() ? "probe,peak [K],cooling time [s]" : "probe,peak [K]", [&](std::FILE* file) {
                     for (std::size_t p = 0; is_written_here && p < names.size(); ++p) {
                       fmt::print(file, "{},{}", names[p], history.peak()[p]);
                       if (weld_.has_cooling()) std::fputc(',', file);
                       if (weld_.has_cooling() && history.cooling()[p] >= 0)
                         fmt::print(file, "{}", history.cooling()[p]);
                       std::fputc('\n', file);
                     }
                   });
  }

  const RunSetup& run_;
  WeldResults& weld_;
  CsvLog log_;
};

}  // namespace

std::unique_ptr<Observer> make_weld_log(const RunSetup& run) {
  return run.weld ? std::make_unique<WeldLog>(run) : nullptr;
}

void declare_weld(Schema& schema) {
  schema.add(
      {.path = "weld",
       .sentence =
           "What a weld is judged by: the melt's extents and the average temperature over time (weld.csv), "
           "peaks and cooling times as fields and at the probes (cooling.csv; in the report the peaks, as peak.PROBE).",
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
