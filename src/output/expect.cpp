#include "output/expect.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "output/comparison.hpp"
#include "output/files.hpp"

namespace calor {
namespace {

bool reached(double t, double at) { return std::abs(t - at) <= 1e-9 * std::max(std::abs(t), std::abs(at)); }

}  // namespace

struct Expectations::Impl {
  Results results;
  const Cloud& cloud = results.cloud;
  std::string folder;
  std::vector<Comparison> comparisons = {};
  std::vector<ReportBound> bounds = {};
  // What every [[expect]] became: comparison or bounds, by their first index.
  struct Entry {
    bool is_report;
    std::size_t first, count;
  };
  std::vector<Entry> entries = {};

  void read_report(const Table& table);
  void read_comparison(const Case& c, const Table& table, const std::string& subject);
  std::vector<int> select(const Case& c, const Table& table, const std::string& subject) const;
  void compare(Comparison& comparison, std::size_t k, const State& state, std::span<const double> T) const;
  double single_value(const Comparison& comparison, const State& state, std::span<const double> T) const;
  void write(const Comparison& comparison, std::size_t k, const PointReference::Values& reference,
             std::span<const double> values) const;
  void write_history(const Comparison& comparison) const;
};

void Expectations::Impl::read_report(const Table& table) {
  refuse_others(table, "report", {"quantity", "at", "value", "reference", "column", "filter", "within", "norm", "of"});
  const std::size_t first = bounds.size();
  for (const std::string key : {"at_most", "at_least"}) {
    if (!table.has(key)) continue;
    bounds.push_back({table, key, table.text("report"), table.text(table.has("name") ? "name" : "report")});
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

void Expectations::Impl::read_comparison(const Case& c, const Table& table, const std::string& subject) {
  refuse_others(table, subject, {"at_most"});
  const Quantity& quantity = quantity_of(table);
  Comparison e{.table = table,
               .quantity = &quantity,
               .measure = quantity.make(table, results),
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
    const std::vector<std::string>& names = results.probes.names();
    require_name(table, "probe", "probe", names);
    refuse_others(table, "probe", {"norm"});
    if (table.text("of") == "range") table.refuse("of", "a single value has no range", "leave 'of' out");
    e.probe = static_cast<int>(std::ranges::find(names, name) - names.begin());
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

double Expectations::Impl::single_value(const Comparison& e, const State& state, std::span<const double> T) const {
  if (e.quantity->is_of_body) return e.measure.values(state, T).at(0);
  return e.measure.at_probes ? e.measure.at_probes(state)[e.probe]
                             : results.probes.sample(e.measure.values(state, T))[e.probe];
}

void Expectations::Impl::compare(Comparison& e, std::size_t k, const State& state, std::span<const double> T) const {
  const double t = e.times[k];
  const bool is_relative = e.tolerance(k).is_relative;
  const std::string of = e.table.text("of");
  if (e.probe >= 0 || e.quantity->is_of_body) {
    const double value = single_value(e, state, T);
    const Vec3 place = e.probe >= 0 ? results.probes.places()[e.probe] : Vec3{};
    const double reference = e.value ? (*e.value)(place, t) : e.probe_reference[k];
    const double error =
        difference(MPI_COMM_SELF, std::span(&value, 1), std::span(&reference, 1), "max", of, is_relative);
    e.results[k] = {error, value, reference};
    return;
  }
  const std::vector<double> all = e.measure.values(state, T);
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
                   NumberLines lines(file);
                   for (std::size_t n = 0; n < reference.point.size(); ++n) {
                     const int i = reference.point[n];
                     const Vec3& x = cloud.x[i];
                     lines.add({x.x, x.y, x.z, values[i], reference.value[n]});
                   }
                   lines.finish();
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

Expectations::Expectations(const Case& c, const Results& results, const std::string& folder)
    : impl_(new Impl{.results = results, .folder = folder}) {
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
  result.verdicts = verdicts(result.numbers, result.units);
  if (impl_->folder.empty()) return;
  for (const Comparison& e : impl_->comparisons)
    if (e.probe >= 0 || e.quantity->is_of_body) impl_->write_history(e);
}

std::vector<Verdict> Expectations::verdicts(const std::map<std::string, double>& numbers,
                                            const std::map<std::string, std::string>& units) const {
  std::vector<Verdict> all;
  for (const Impl::Entry& entry : impl_->entries)
    for (std::size_t n = entry.first; n < entry.first + entry.count; ++n) {
      if (entry.is_report)
        all.push_back(verdict_of(impl_->bounds[n], numbers, units));
      else
        std::ranges::move(verdicts_of(impl_->comparisons[n]), std::back_inserter(all));
    }
  return all;
}

void require_numbers(const Case& c, const std::vector<ReportNumber>& numbers) {
  std::vector<std::string> names;
  names.reserve(numbers.size());
  for (const ReportNumber& number : numbers) names.push_back(number.name);
  const auto require = [&](const Table& table, const std::string& key) {
    if (!table.has(key)) return;
    const std::string name = table.text(key);
    if (std::ranges::count(names, name)) return;
    const std::string near = nearest(name, names);
    table.refuse(key, fmt::format("the report has no number '{}'", name),
                 fmt::format("{}it has {}", near.empty() ? "" : fmt::format("did you mean '{}'? ", near),
                             fmt::join(names, ", ")));
  };
  for (const Table& expect : c.root().list("expect")) {
    require(expect, "report");
    if (!expect.has("report")) continue;
    const auto number = std::ranges::find(numbers, expect.text("report"), &ReportNumber::name);
    for (const char* bound : {"at_most", "at_least"})
      if (expect.has(bound)) read_report_bound(expect, bound, number->unit);
  }
  for (const Table& data : c.section("fit").list("data")) require(data, "report");
  const Table optimise = c.section("optimise");
  for (const char* aim : {"minimise", "maximise"}) require(optimise, aim);
  for (const Table& limit : optimise.list("limit")) require(limit, "report");
}

std::unique_ptr<Observer> make_expectations(const RunSetup& run) {
  return std::make_unique<Expectations>(run.description,
                                        Results{.cloud = run.system.cloud(),
                                                .material = run.system.material(),
                                                .probes = run.probes,
                                                .weld = run.weld,
                                                .balance = std::make_shared<Balance>(run.system),
                                                .stress = run.stress},
                                        run.folder);
}

}  // namespace calor
