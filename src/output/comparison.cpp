#include "output/comparison.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/parallel.hpp"
#include "base/units.hpp"

namespace calor {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// By the tolerance of the k-th time.
Verdict verdict_at(const Comparison& e, std::size_t k) {
  const Tolerance& tolerance = e.tolerance(k);
  const Result result = e.results[k].value_or(Result{nan, nan, nan});
  return {.what = e.name,
          .norm = e.probe >= 0 || e.quantity->is_of_body ? "value" : e.table.text("norm"),
          .unit = tolerance.is_relative ? "%" : e.quantity->unit,
          .error = result.error,
          .tolerance = tolerance.value,
          .passed = e.passes(result.error, k),
          .value = result.value,
          .reference = result.reference,
          .value_unit = e.quantity->unit,
          .least = e.least(k),
          .worst_place = result.place,
          .source = e.table.has("source") ? e.table.text("source") : ""};
}

}  // namespace

std::vector<Verdict> verdicts_of(const Comparison& e) {
  std::vector<Verdict> all;
  const bool is_joint = e.within.size() == 1 && e.times.size() > 1;
  const auto error_at = [&](std::size_t n) { return e.results[n] ? e.results[n]->error : nan; };
  for (std::size_t first = 0; first < e.within.size(); ++first) {
    std::size_t k = first;
    if (is_joint)
      for (std::size_t n = 0; n < e.times.size(); ++n)
        if (!(error_at(n) <= error_at(k)) && !std::isnan(error_at(k))) k = n;
    Verdict v = verdict_at(e, k);
    if (is_joint)
      v.what += fmt::format(" at {} times, worst at {:g} s", e.times.size(), e.times[k]);
    else if (!e.is_steady)
      v.what += fmt::format(" at {:g} s", e.times[k]);
    if (!e.results[k]) v.what += " (never reached)";
    all.push_back(std::move(v));
  }
  return all;
}

Verdict verdict_of(const ReportBound& b, const std::map<std::string, double>& numbers,
                   const std::map<std::string, std::string>& units) {
  const bool is_upper = b.key == "at_most";
  const auto unit = units.find(b.number);
  const double bound = read_report_bound(b.table, b.key, unit == units.end() ? "" : unit->second);
  Verdict v{.what = b.name, .norm = is_upper ? "at most" : "at least", .unit = "", .error = nan, .tolerance = bound};
  const auto found = numbers.find(b.number);
  if (found == numbers.end()) {
    v.what += " (no such number in the report)";
    return v;
  }
  v.error = v.value = found->second;
  v.reference = bound;
  v.passed = is_upper ? v.error <= bound : v.error >= bound;
  return v;
}

std::string one_of(const Table& table, const std::vector<std::string>& keys, const std::string& purpose) {
  std::string found;
  for (const std::string& key : keys) {
    if (!table.has(key) || (key == "field" && !table.flag(key))) continue;
    if (!found.empty())
      table.refuse(key, fmt::format("'{}' and '{}' in one [[expect]]", found, key), "keep one of the two");
    found = key;
  }
  if (found.empty())
    table.refuse("", "[[expect]] does not say " + purpose, fmt::format("add one of {}", fmt::join(keys, ", ")));
  return found;
}

void refuse_others(const Table& table, const std::string& subject, const std::vector<std::string>& keys) {
  for (const std::string& key : keys)
    if (table.has(key)) table.refuse(key, fmt::format("'{}' does not go with '{}'", key, subject), "leave it out");
}

std::vector<double> read_times(const Case& c, const Table& table) {
  if (c.root().has("steady")) {
    if (table.has("at")) table.refuse("at", "a steady case has no times", "leave 'at' out");
    return {0};
  }
  const double end = c.section("time").number("end");
  if (!table.has("at")) return {end};
  std::vector<double> times = table.numbers("at");
  for (double t : times)
    if (t < 0 || t > end * (1 + 1e-9))
      table.refuse("at", fmt::format("{} s is not between the start and the end of the run, {} s", t, end),
                   "choose an earlier time, or a later end of [time]");
  return times;
}

std::vector<Tolerance> read_differences(const Table& table, const std::string& key, const Quantity& quantity,
                                        std::size_t times) {
  std::vector<Tolerance> out;
  const std::string cure = quantity.unit.empty()
                               ? "write a number, or in %: 1e-3 or \"0.02 %\""
                               : fmt::format("write it in {0} or in %, e.g. \"0.2 {0}\" or \"0.02 %\"", quantity.unit);
  for (const auto& written : table.quantities_with_units(key)) {
    const bool is_relative = written.second == "%";
    const double value = is_relative
                             ? written.first
                             : table.in_si(key, written, quantity.unit, "difference of " + quantity.plural, cure);
    if (!(value >= 0))
      table.refuse(key, fmt::format("{} is negative", written.first), "the allowed difference is a positive number");
    out.push_back({value, is_relative});
  }
  if (out.size() != 1 && out.size() != times)
    table.refuse(key, fmt::format("{} differences for {} times", out.size(), times),
                 "give one for all times, or one a time");
  return out;
}

double difference(MPI_Comm comm, std::span<const double> T, std::span<const double> reference, const std::string& norm,
                  const std::string& of, bool is_relative) {
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest, largest = 0;
  for (double ref : reference) {
    lowest = std::min(lowest, ref), highest = std::max(highest, ref);
    largest = std::max(largest, std::abs(ref));
  }
  double scale = 1;
  if (is_relative && of == "maximum") scale = max(comm, largest) / 100;
  if (is_relative && of == "range") scale = (max(comm, highest) - min(comm, lowest)) / 100;

  std::vector<double> squares(T.size());
  double most = 0;
  bool is_finite = true;
  for (std::size_t i = 0; i < T.size(); ++i) {
    double error = std::abs(T[i] - reference[i]);
    const double by = is_relative && of == "value" ? std::abs(reference[i]) / 100 : scale;
    error = error == 0 ? 0 : error / by;
    is_finite = is_finite && std::isfinite(error);
    most = std::max(most, error);
    squares[i] = error * error;
  }
  const auto count = static_cast<double>(total(comm, static_cast<std::int64_t>(T.size())));
  const double result = norm == "rms" ? std::sqrt(sum(comm, squares) / count) : max(comm, most);
  return any(comm, !is_finite) ? std::numeric_limits<double>::quiet_NaN() : result;
}

Result worst_point(const Cloud& cloud, std::span<const int> point, std::span<const double> values,
                   std::span<const double> reference, bool by_value) {
  struct Candidate {
    double error = -1;
    std::int64_t id = 0;
    Vec3 x = {};
    double value = 0, reference = 0;
  };
  const auto worse = [](const Candidate& a, const Candidate& b) {
    return a.error != b.error ? a.error > b.error : a.id < b.id;
  };
  Candidate mine;
  for (std::size_t n = 0; n < point.size(); ++n) {
    const double off = std::abs(values[n] - reference[n]), error = by_value ? off / std::abs(reference[n]) : off;
    const Candidate here{.error = std::isnan(error) ? (off == 0 ? 0 : std::numeric_limits<double>::infinity()) : error,
                         .id = cloud.id[point[n]],
                         .x = cloud.x[point[n]],
                         .value = values[n],
                         .reference = reference[n]};
    if (worse(here, mine)) mine = here;
  }
  const std::vector<Candidate> all = gather(cloud.comm, std::vector{mine});
  const Candidate& worst = *std::ranges::min_element(all, worse);
  Result result{std::numeric_limits<double>::quiet_NaN(), worst.value, worst.reference};
  for (int axis = 0; axis < cloud.dimension; ++axis) result.place.push_back(worst.x[axis]);
  return result;
}

double read_report_bound(const Table& table, const std::string& key, const std::string& unit) {
  const auto written = table.quantities_with_units(key);
  if (written.size() != 1)
    table.refuse(key, fmt::format("{} bounds of one number of the report", written.size()), "write one, e.g. 1e-12");
  const auto& [value, its_unit] = written[0];
  try {
    return its_unit.empty() ? value : to_si(value, its_unit, unit);
  } catch (const std::invalid_argument& e) {
    table.refuse(key, fmt::format("the bound of '{}': {}", table.text("report"), e.what()), "correct the unit");
  }
}

}  // namespace calor
