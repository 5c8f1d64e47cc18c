#include "output/comparison.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/parallel.hpp"
#include "output/expect.hpp"

namespace calor {

const std::vector<Quantity>& quantities() {
  static const std::vector<Quantity> all = {
      {"temperature", "K", "temperatures", "T"},
      {"conductivity", "W/(m K)", "conductivities", "k"},
      {"volumetric_heat_capacity", "J/(m^3 K)", "volumetric heat capacities", "rho c"},
      {"volume_fraction", "", "volume fractions", "v"},
      {"peak_temperature", "K", "peak temperatures", "T"},
      {"cooling_time", "s", "cooling times", "t"},
      {"extent", "m", "extents", "length", true},
      {"average_temperature", "K", "average temperatures", "T", true},
      {"heat_flow", "W", "heat flows", "heat flow", true},
      {"mean", "K", "mean temperatures", "T", true},
      {"minimum", "K", "lowest temperatures", "T", true},
      {"maximum", "K", "highest temperatures", "T", true}};
  return all;
}

const Quantity& quantity_of(const Table& table) {
  if (!table.has("quantity"))
    for (const Quantity& q : quantities())
      if (table.has(q.name)) return q;
  return *std::ranges::find(quantities(), table.text("quantity"), &Quantity::name);
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

double read_report_bound(const Table& table, const std::string& key) {
  const auto written = table.quantities_with_units(key);
  if (written.size() != 1 || !written[0].second.empty())
    table.refuse(key, "the bound of a number of the report is one number without unit", "write it so, e.g. 1e-12");
  return written[0].first;
}

void declare_expect(Schema& schema) {
  std::vector<std::string> names;
  for (const Quantity& q : quantities()) names.push_back(q.name);
  std::vector<Key> keys{
      {"name", Kind::text, "", optional, "What the verdict is called; made from the other keys where absent."},
      {"source", Kind::text, "", optional, "Where the expected number comes from."},
      {"probe", Kind::text, "", optional, "Compare at this probe."},
      {"field", Kind::flag, "", "false", "Compare at all points."},
      {"report", Kind::text, "", optional, "Compare this number of report.json, by at_most and at_least."},
      {"quantity", Kind::choice, "", "temperature",
       "What is compared. May be left out where a key of that name says of what: heat_flow = \"inside\".", names},
      {"at", Kind::quantities, "s", optional, "Time or times of the comparison; the end where absent."},
      {"reference", Kind::text, "", optional,
       "CSV file with expected values, beside the case. With one column of coordinates (x, y, z or r) its rows "
       "are "
       "interpolated by cubics, with more they are matched to the points; a column t gives their times."},
      {"column", Kind::text, "", "T", "Column of the reference file that holds the values."},
      {"within", Kind::raw_quantities, "", optional,
       "Allowed difference in the unit of the quantity or %: one, or one a time. One for several times is judged at "
       "the worst of them."},
      {"norm",
       Kind::choice,
       "",
       "max",
       "Over the points compared: the largest difference or the root of its mean square.",
       {"max", "rms"}},
      {"of",
       Kind::choice,
       "",
       "value",
       "What a difference in % is relative to: the reference at the point, the largest reference, or the span of the "
       "references.",
       {"value", "maximum", "range"}},
      {"at_most", Kind::raw_quantities, "", optional, "Upper bound of a number of the report."},
      {"at_least", Kind::raw_quantities, "", optional,
       "Lower bound of a number of the report, or of the difference, for errors that are known: like 'within'."},
  };
  for (Key& key : where_keys("Compare at the points where this formula of x, y, z and r is true."))
    keys.push_back(std::move(key));
  schema.add({.path = "expect[]", .sentence = "What the result is compared with.", .keys = std::move(keys)});
  for (const Quantity& q : quantities()) {
    std::vector<Key> own{{"value", Kind::function, q.unit, optional, "Expected value, a function of place and time."}};
    if (q.name == "volume_fraction")
      own.push_back(
          {"material", Kind::text, "", required, "Whose fraction; that of what fills the pores is the porosity."});
    if (q.name == "heat_flow")
      own.push_back({q.name, Kind::text, "", required,
                     "Name of the boundary section or source; heat that flows into the body is positive."});
    for (const char* summary : {"mean", "minimum", "maximum"})
      if (q.name == summary)
        own.push_back({q.name, Kind::text, "", required,
                       "Name of the material, boundary section or face of the cloud whose temperature it is."});
    if (q.name == "extent") own.push_back({"extent", Kind::text, "", required, "Name of the [weld.extent.*]."});
    schema.add({.path = "expect[]",
                .sentence = fmt::format("A comparison of {}.", q.plural),
                .keys = std::move(own),
                .when_key = "quantity",
                .when_value = q.name});
  }
  schema.add({.path = "expect[].filter",
              .sentence = "Rows of the reference file in which these columns have these values.",
              .keys = {{"*", Kind::number, "", optional, "Name of a column and its value, as written in the file."}}});
}

}  // namespace calor
