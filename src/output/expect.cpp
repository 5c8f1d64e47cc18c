#include "output/expect.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "output/balance.hpp"
#include "output/comparison.hpp"
#include "output/files.hpp"

namespace calor {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

bool is_summary(const Quantity& q) { return q.name == "mean" || q.name == "minimum" || q.name == "maximum"; }

/// Refuses a name that is none of those known.
void require_name(const Table& table, const Quantity& q, const std::vector<std::string>& known, const char* what) {
  const std::string name = table.text(q.name);
  if (std::ranges::count(known, name)) return;
  const std::string near = nearest(name, known);
  table.refuse(
      q.name, fmt::format("there is no {} '{}'", what, name),
      near.empty() ? fmt::format("there are {}", fmt::join(known, ", ")) : fmt::format("did you mean '{}'?", near));
}

bool reached(double t, double at) { return std::abs(t - at) <= 1e-9 * std::max(std::abs(t), std::abs(at)); }

}  // namespace

struct Expectations::Impl {
  const Cloud& cloud;
  const MaterialField& material;
  const Probes& probes;
  const WeldResults* weld;
  std::string folder;
  std::optional<Balance> balance;
  std::vector<Comparison> comparisons;
  std::vector<ReportBound> bounds;
  // What the k-th [[expect]] became: comparison or bounds, by their first index.
  struct Entry {
    bool is_report;
    std::size_t first, count;
  };
  std::vector<Entry> entries;

  void read_report(const Table& table);
  void read_comparison(const Case& c, const Table& table, const std::string& subject);
  const Quantity& read_quantity(const Table& table) const;
  std::vector<int> select(const Case& c, const Table& table, const std::string& subject) const;
  /// The quantity at the owned points.
  std::vector<double> values(const Comparison& comparison, double t, std::span<const double> T) const;
  void compare(Comparison& comparison, std::size_t k, const State& state, std::span<const double> T) const;
  double at_probe(const Comparison& comparison, const State& state, std::span<const double> T) const;
  double of_body(const Comparison& comparison, const State& state, std::span<const double> T) const;
  void write(const Comparison& comparison, std::size_t k, const PointReference::Values& reference,
             std::span<const double> values) const;
  void write_history(const Comparison& comparison) const;
};

void Expectations::Impl::read_report(const Table& table) {
  refuse_others(table, "report", {"quantity", "at", "value", "reference", "column", "filter", "within", "norm", "of"});
  const std::size_t first = bounds.size();
  for (const std::string key : {"at_most", "at_least"}) {
    if (!table.has(key)) continue;
    const std::string number = table.text("report");
    bounds.push_back(
        {number, key == "at_most", read_report_bound(table, key), table.text(table.has("name") ? "name" : "report")});
  }
  if (bounds.size() == first)
    table.refuse("report", "[[expect]] with 'report' has no bound", "add at_most = 1e-12 or at_least = 1");
  entries.push_back({true, first, bounds.size() - first});
}

std::vector<int> Expectations::Impl::select(const Case& c, const Table& table, const std::string& subject) const {
  std::vector<char> is_selected(cloud.owned, true);
  if (subject == "where") collective_try(cloud.comm, [&] { is_selected = where(c, table, cloud.owned_points()); });
  std::vector<int> points;
  for (int i = 0; i < cloud.owned; ++i)
    if (is_selected[i]) points.push_back(i);
  if (total(cloud.comm, static_cast<std::int64_t>(points.size())) == 0)
    table.refuse(subject, fmt::format("'{}' selects no point of the cloud", table.text("where")),
                 "allow for round-off: abs(y - 2) < 1e-9; lengths are in 'length', by default m");
  return points;
}

const Quantity& Expectations::Impl::read_quantity(const Table& table) const {
  const Quantity& q = quantity_of(table);
  if (!balance && (q.name == "heat_flow" || is_summary(q)))
    table.refuse(q.name, "there is no balance to look at", "run the whole case");
  if (q.name == "volumetric_heat_capacity" && !material.has_capacity())
    table.refuse("quantity", "density or specific heat of the body are not known", "give its materials both");
  const bool is_of_weld =
      std::ranges::count(std::vector<std::string>{"peak_temperature", "cooling_time", "extent", "average_temperature"},
                         q.name) > 0;
  if (is_of_weld && !weld)
    table.refuse("quantity", fmt::format("{} are results of a weld, and the case has no [weld]", q.plural),
                 "add [weld]");
  if (q.name == "cooling_time" && !weld->has_cooling())
    table.refuse("quantity", "[weld] does not say between which temperatures",
                 "add cooling = [\"800 degC\", \"500 degC\"]");
  if (q.name == "extent") {
    std::vector<std::string> names;
    for (const Extent& extent : weld->extents()) names.push_back(extent.name());
    if (!std::ranges::count(names, table.text("extent")))
      table.refuse("extent", fmt::format("there is no extent '{}'", table.text("extent")),
                   names.empty() ? fmt::format("add [weld.extent.{}]", table.text("extent"))
                                 : fmt::format("the extents are: {}", fmt::join(names, ", ")));
  }
  if (q.name == "heat_flow") require_name(table, q, balance->accounts(), "boundary section or source");
  if (is_summary(q)) {
    std::vector<std::string> zones;
    for (const Balance::Zone& zone : balance->zones()) zones.push_back(zone.name);
    require_name(table, q, zones, "material or face");
  }
  if (q.name != "volume_fraction") return q;
  const std::vector<std::string> known = material.ingredients();
  if (const std::string name = table.text("material"); !std::ranges::count(known, name))
    table.refuse("material", fmt::format("'{}' is not mixed into the body", name),
                 fmt::format("it is made of {}", fmt::join(known, ", ")));
  return q;
}

void Expectations::Impl::read_comparison(const Case& c, const Table& table, const std::string& subject) {
  refuse_others(table, subject, {"at_most"});
  Comparison e{.table = table,
               .quantity = &read_quantity(table),
               .number = static_cast<int>(entries.size()) + 1,
               .name = {},
               .is_steady = c.root().has("steady"),
               .times = read_times(c, table),
               .within = {},
               .at_least = {}};
  e.within = read_differences(table, "within", *e.quantity, e.times.size());
  if (table.has("at_least")) {
    e.at_least = read_differences(table, "at_least", *e.quantity, e.times.size());
    if (e.at_least.size() != e.within.size() || e.at_least[0].is_relative != e.within[0].is_relative)
      table.refuse("at_least", "'at_least' and 'within' do not match", "give as many numbers, in the same unit");
  }
  e.results.resize(e.times.size());
  if (subject == "probe") {
    const std::string name = table.text("probe");
    const auto found = std::ranges::find(probes.names(), name);
    if (found == probes.names().end()) {
      const std::string near = nearest(name, probes.names());
      table.refuse("probe", fmt::format("there is no probe '{}'", name),
                   near.empty() ? fmt::format("the probes are: {}", fmt::join(probes.names(), ", "))
                                : fmt::format("did you mean '{}'?", near));
    }
    refuse_others(table, "probe", {"norm"});
    if (table.text("of") == "range") table.refuse("of", "a single value has no range", "leave 'of' out");
    e.probe = static_cast<int>(found - probes.names().begin());
  } else if (e.quantity->is_of_body) {
    refuse_others(table, e.quantity->name, {"norm"});
  } else {
    e.points = select(c, table, subject);
  }

  if (one_of(table, {"value", "reference"}, "what to compare with") == "value") {
    refuse_others(table, "value", {"column", "filter"});
    e.value = table.function("value");
    if (e.value->depends_on_temperature())
      table.refuse("value", "the expected value depends on T", "use x, y, z, r and t");
  } else if (e.probe >= 0 || e.quantity->is_of_body) {
    collective_try(cloud.comm, [&] { e.probe_reference = reference_values(table, e.quantity->unit, e.times); });
  } else {
    e.reference.emplace(table, e.quantity->unit, cloud, e.points, e.times);
  }

  if (table.has("name")) {
    e.name = table.text("name");
  } else {
    e.name = e.quantity->name == "extent" ? table.text("extent")
             : e.quantity->is_of_body
                 ? e.quantity->name + (table.has(e.quantity->name) ? " of " + table.text(e.quantity->name) : "")
             : subject == "probe" ? "probe " + table.text("probe")
             : subject == "where" ? "points with " + table.text("where")
                                  : "all points";
    if (e.quantity->name != "temperature" && !e.quantity->is_of_body)
      e.name = e.quantity->plural + (table.has("material") ? " of " + table.text("material") : "") + ", " + e.name;
    if (e.reference || !e.probe_reference.empty())
      e.name += ", " + std::filesystem::path(table.text("reference")).filename().string();
  }
  entries.push_back({false, comparisons.size(), 1});
  comparisons.push_back(std::move(e));
}

std::vector<double> Expectations::Impl::values(const Comparison& e, double t, std::span<const double> T) const {
  if (e.quantity->name == "temperature") return {T.begin(), T.end()};
  if (e.quantity->name == "peak_temperature") return {weld->points().peak().begin(), weld->points().peak().end()};
  if (e.quantity->name == "cooling_time") return {weld->points().cooling().begin(), weld->points().cooling().end()};
  std::vector<double> out(T.size());
  collective_try(cloud.comm, [&] {
    if (e.quantity->name == "conductivity")
      material.conductivity(t, T, out, {});
    else if (e.quantity->name == "volumetric_heat_capacity")
      material.enthalpy(T, {}, out);
    else
      material.volume_fraction(e.table.text("material"), out);
  });
  return out;
}

double Expectations::Impl::of_body(const Comparison& e, const State& state, std::span<const double> T) const {
  const std::string& name = e.quantity->name;
  if (name == "average_temperature") return weld->average(state, T);
  if (name == "heat_flow") {
    const auto at = std::ranges::find(balance->accounts(), e.table.text(name)) - balance->accounts().begin();
    return balance->heat_flows(state.t, state.T)[at];
  }
  if (is_summary(*e.quantity)) {
    const auto [mean, minimum, maximum] =
        balance->summary(*std::ranges::find(balance->zones(), e.table.text(name), &Balance::Zone::name),
                         balance->temperatures(state.t, state.T));
    return name == "mean" ? mean : name == "minimum" ? minimum : maximum;
  }
  return std::ranges::find(weld->extents(), e.table.text("extent"), &Extent::name)->of_temperatures(state.T).length();
}

/// What a probe went through is not what the points around it went through, interpolated: it has a history of its own.
double Expectations::Impl::at_probe(const Comparison& e, const State& state, std::span<const double> T) const {
  if (e.quantity->name == "temperature") return probes.temperatures(state.T)[e.probe];
  if (e.quantity->name == "peak_temperature") return weld->probes().peak()[e.probe];
  if (e.quantity->name == "cooling_time") return weld->probes().cooling()[e.probe];
  return probes.sample(values(e, state.t, T))[e.probe];
}

void Expectations::Impl::compare(Comparison& e, std::size_t k, const State& state, std::span<const double> T) const {
  const double t = e.times[k];
  const bool is_relative = e.tolerance(k).is_relative;
  const std::string of = e.table.text("of");
  if (e.probe >= 0 || e.quantity->is_of_body) {
    const double value = e.probe >= 0 ? at_probe(e, state, T) : of_body(e, state, T);
    const Vec3 place = e.probe >= 0 ? probes.places()[e.probe] : Vec3{};
    const double reference = e.value ? (*e.value)(place, t) : e.probe_reference[k];
    const double error =
        difference(MPI_COMM_SELF, std::span(&value, 1), std::span(&reference, 1), "max", of, is_relative);
    e.results[k] = {error, value, reference};
    return;
  }
  const std::vector<double> all = values(e, t, T);
  PointReference::Values reference;
  if (e.value) {
    reference.point = e.points;
    reference.value.resize(e.points.size());
    std::vector<Vec3> x;
    for (int i : e.points) x.push_back(cloud.x[i]);
    collective_try(cloud.comm, [&] { e.value->evaluate({.x = x, .t = t}, reference.value); });
  } else {
    reference = e.reference->at(static_cast<int>(k), cloud, e.points);
  }
  std::vector<double> compared;
  for (int i : reference.point) compared.push_back(all[i]);
  e.results[k] = worst_point(cloud, reference.point, compared, reference.value, is_relative && of == "value");
  e.results[k]->error = difference(cloud.comm, compared, reference.value, e.table.text("norm"), of, is_relative);
  if (!folder.empty()) write(e, k, reference, all);
}

void Expectations::Impl::write(const Comparison& e, std::size_t k, const PointReference::Values& reference,
                               std::span<const double> values) const {
  const std::string unit = e.quantity->unit.empty() ? "" : fmt::format(" [{}]", e.quantity->unit);
  const std::string time = e.is_steady ? "" : fmt::format("-{:g}", e.times[k]);
  make_folder(cloud.comm, folder);
  write_in_turns(cloud.comm, fmt::format("{}/expect-{}{}.csv", folder, e.number, time),
                 fmt::format("x [m],y [m],z [m],{}{},reference{}", e.quantity->column, unit, unit),
                 [&](std::FILE* file) {
                   for (std::size_t n = 0; n < reference.point.size(); ++n) {
                     const int i = reference.point[n];
                     const Vec3& x = cloud.x[i];
                     fmt::print(file, "{},{},{},{},{}\n", x.x, x.y, x.z, values[i], reference.value[n]);
                   }
                 });
}

/// expect-N.csv of a probe or the body: value and reference at every time that was reached. Collective.
void Expectations::Impl::write_history(const Comparison& e) const {
  const std::string unit = e.quantity->unit.empty() ? "" : fmt::format(" [{}]", e.quantity->unit);
  write_in_turns(cloud.comm, fmt::format("{}/expect-{}.csv", folder, e.number),
                 fmt::format("time [s],{}{},reference{}", e.quantity->column, unit, unit), [&](std::FILE* file) {
                   if (rank_of(cloud.comm) != 0) return;
                   for (std::size_t k = 0; k < e.times.size(); ++k)
                     if (e.results[k])
                       fmt::print(file, "{},{},{}\n", e.times[k], e.results[k]->value, e.results[k]->reference);
                 });
}

Expectations::Expectations(const Case& c, const Cloud& cloud, const MaterialField& material, const Probes& probes,
                           const WeldResults* weld, const std::string& folder, HeatSystem* system)
    : impl_(new Impl{cloud, material, probes, weld, folder, {}, {}, {}, {}}) {
  if (system) impl_->balance.emplace(*system);
  for (const Table& table : c.root().list("expect")) {
    const Quantity& quantity = quantity_of(table);
    if (quantity.is_of_body) {
      refuse_others(table, quantity.name, {"probe", "where", "report"});
      impl_->read_comparison(c, table, "quantity");
      continue;
    }
    const std::string subject = one_of(table, {"probe", "field", "where", "report"}, "what it is about");
    if (subject == "report")
      impl_->read_report(table);
    else
      impl_->read_comparison(c, table, subject);
  }
}

Expectations::~Expectations() = default;

std::vector<double> Expectations::times() const {
  std::vector<double> all;
  for (const Comparison& e : impl_->comparisons)
    if (!e.is_steady) all.insert(all.end(), e.times.begin(), e.times.end());
  return all;
}

void Expectations::observe(const State& state, bool last, std::span<const double> T) {
  const double t = state.t;
  for (Comparison& e : impl_->comparisons)
    for (std::size_t k = 0; k < e.times.size(); ++k)
      if (!e.results[k] && (reached(t, e.times[k]) || (last && t < e.times[k]) || e.is_steady))
        impl_->compare(e, k, state, T);
}

void Expectations::at_stop(const Moment& m) {
  if (!m.is_cut_short) observe(m.state(), m.is_last, m.temperatures());
}

void Expectations::exchange(Archive& archive) {
  for (Comparison& e : impl_->comparisons)
    for (std::optional<Result>& result : e.results) {
      bool is_there = result.has_value();
      archive.value("is compared", is_there);
      if (!is_there) continue;
      if (!result) result.emplace();
      std::array<double, 3> numbers{result->error, result->value, result->reference};
      archive.values("comparison", numbers);
      result = Result{numbers[0], numbers[1], numbers[2]};
    }
}

void Expectations::finish(const Moment& m, RunResult& result) {
  if (m.is_cut_short) return;
  result.verdicts = verdicts(result.numbers);
  if (impl_->folder.empty()) return;
  for (const Comparison& e : impl_->comparisons)
    if (e.probe >= 0 || e.quantity->is_of_body) impl_->write_history(e);
}

std::vector<Verdict> Expectations::verdicts(const std::map<std::string, double>& report) {
  std::vector<Verdict> all;
  for (const Impl::Entry& entry : impl_->entries) {
    if (entry.is_report) {
      for (std::size_t n = entry.first; n < entry.first + entry.count; ++n) {
        const ReportBound& b = impl_->bounds[n];
        const auto found = report.find(b.number);
        Verdict v{.what = b.name,
                  .norm = b.is_upper ? "at most" : "at least",
                  .unit = "",
                  .error = nan,
                  .tolerance = b.bound};
        if (found == report.end()) {
          std::vector<std::string> names;
          for (const auto& [name, value] : report) names.push_back(name);
          const std::string near = nearest(b.number, names);
          v.what += near.empty() ? " (no such number in the report)" : fmt::format(" (did you mean {}?)", near);
        } else {
          v.error = v.value = found->second;
          v.reference = b.bound;
          v.passed = b.is_upper ? v.error <= b.bound : v.error >= b.bound;
        }
        all.push_back(v);
      }
      continue;
    }
    const Comparison& e = impl_->comparisons[entry.first];
    // One verdict for every tolerance; where one holds for several times, the worst of them counts.
    const bool is_joint = e.within.size() == 1 && e.times.size() > 1;
    for (std::size_t first = 0; first < e.within.size(); ++first) {
      std::size_t k = first;
      const auto error_at = [&](std::size_t n) { return e.results[n] ? e.results[n]->error : nan; };
      if (is_joint)
        for (std::size_t n = 0; n < e.times.size(); ++n)
          if (!(error_at(n) <= error_at(k)) && !std::isnan(error_at(k))) k = n;
      const Tolerance& tolerance = e.tolerance(k);
      const Result result = e.results[k].value_or(Result{nan, nan, nan});
      Verdict v{.what = e.name,
                .norm = e.probe >= 0 || e.quantity->is_of_body ? "value" : e.table.text("norm"),
                .unit = tolerance.is_relative ? "%" : e.quantity->unit,
                .error = result.error,
                .tolerance = tolerance.value,
                .passed = e.passes(result.error, k),
                .value = result.value,
                .reference = result.reference,
                .value_unit = e.quantity->unit,
                .least = e.least(k),
                .worst_place = result.place};
      if (is_joint)
        v.what += fmt::format(" at {} times, worst at {:g} s", e.times.size(), e.times[k]);
      else if (!e.is_steady)
        v.what += fmt::format(" at {:g} s", e.times[k]);
      if (!e.results[k]) v.what += " (never reached)";
      if (e.table.has("source")) v.source = e.table.text("source");
      all.push_back(v);
    }
  }
  return all;
}

std::unique_ptr<Observer> make_expectations(const RunSetup& run) {
  return std::make_unique<Expectations>(run.description, run.system.cloud(), run.system.material(), run.probes,
                                        run.weld.get(), run.folder, &run.system);
}

}  // namespace calor
