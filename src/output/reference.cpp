#include "output/reference.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <unordered_map>
#include <utility>

#include "base/csv.hpp"
#include "base/parallel.hpp"

namespace calor {
namespace {

bool same(double a, double b) { return std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b)); }

double coordinate(const Vec3& x, const std::string& axis) {
  return axis == "r" ? std::hypot(x.x, x.y) : x[axis[0] - 'x'];
}

std::vector<std::string> filtered(const Table& expect) { return expect.sub("filter").keys(); }

bool is_filtered(const Table& expect, const std::string& name) {
  return std::ranges::count(filtered(expect), name) > 0;
}

[[noreturn]] void refuse_second_row(const Table& expect, const std::string& where) {
  expect.refuse("reference", fmt::format("'{}' has more than one row for {}", expect.text("reference"), where),
                "choose rows by a further column: filter = { \"B\" = 0.5 }");
}

/// Finds the points at given coordinates by a hash of cells.
class Finder {
 public:
  Finder(const Cloud& cloud, std::span<const int> selected, const std::vector<std::string>& axes)
      : cloud_(cloud), axes_(axes) {
    double smallest = std::numeric_limits<double>::infinity(), largest = 0;
    for (int i : selected) {
      smallest = std::min(smallest, cloud.spacing[i]);
      largest = std::max(largest, cloud.spacing[i]);
    }
    cell_ = smallest;
    tolerance_ = 1e-6 * largest;
    for (int i : selected) {
      std::uint64_t key = 0;
      for (const std::string& axis : axes_) key = mix(key, cell(coordinate(cloud.x[i], axis)));
      cells_[key].push_back(i);
    }
  }

  /// Calls found(i) for every selected point there.
  template <class Found>
  void at(const std::array<double, 3>& x, const Found& found) const {
    visit(x, 0, 0, found);
  }

 private:
  std::int64_t cell(double x) const { return static_cast<std::int64_t>(std::floor(x / cell_)); }
  static std::uint64_t mix(std::uint64_t key, std::int64_t cell) {
    return (key ^ static_cast<std::uint64_t>(cell)) * 0x9E3779B97F4A7C15u + (key >> 29);
  }

  template <class Found>
  void visit(const std::array<double, 3>& x, std::size_t axis, std::uint64_t key, const Found& found) const {
    if (axis < axes_.size()) {  // a place next to the border of a cell may belong to the one beside
      for (std::int64_t c = cell(x[axis] - tolerance_); c <= cell(x[axis] + tolerance_); ++c)
        visit(x, axis + 1, mix(key, c), found);
      return;
    }
    const auto points = cells_.find(key);
    if (points == cells_.end()) return;
    for (int i : points->second) {
      bool is_there = true;
      for (std::size_t a = 0; a < axes_.size(); ++a)
        is_there = is_there && std::abs(coordinate(cloud_.x[i], axes_[a]) - x[a]) <= 1e-6 * cloud_.spacing[i];
      if (is_there) found(i);
    }
  }

  const Cloud& cloud_;
  const std::vector<std::string>& axes_;
  double cell_, tolerance_;
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

}  // namespace

ReferenceFile::ReferenceFile(const Table& expect, const std::string& unit)
    : expect_(expect), path_(expect.file("reference")), unit_(unit) {
  CsvReader csv(path_, expect.location("reference"));
  csv.require(expect.text("column"), unit);
  for (const std::string& name : filtered(expect)) csv.require(name, csv.columns()[std::max(csv.find(name), 0)].unit);
  for (const std::string name : {"t", "time"})
    if (csv.find(name) >= 0 && !is_filtered(expect, name)) has_time_ = true, time_ = name;
  for (const std::string axis : {"x", "y", "z", "r"})
    if (csv.find(axis) >= 0 && !is_filtered(expect, axis)) axes_.push_back(axis);
  if (axes_.size() > 3)
    expect.refuse("reference", fmt::format("'{}' has the columns x, y, z and r", expect.text("reference")),
                  "leave r out: x and y determine it");
}

void ReferenceFile::read(std::span<const double> times, const Row& row) const {
  CsvReader csv(path_);
  const int column = csv.require(expect_.text("column"), unit_), t = has_time_ ? csv.require(time_, "s") : -1;
  std::vector<int> columns;
  for (const std::string& axis : axes_) columns.push_back(csv.require(axis, "m"));
  std::vector<std::pair<int, double>> wanted;
  const Table filter = expect_.sub("filter");
  for (const std::string& name : filter.keys()) wanted.emplace_back(csv.find(name), filter.number(name));

  std::vector<char> seen(times.size(), false);
  std::set<double> there;  // for the message
  while (csv.next()) {
    if (!std::ranges::all_of(wanted, [&](const auto& w) { return same(csv.number(w.first), w.second); })) continue;
    std::array<double, 3> x{};
    for (std::size_t axis = 0; axis < columns.size(); ++axis) x[axis] = csv.number(columns[axis]);
    const double value = csv.number(column), time = has_time_ ? csv.number(t) : 0;
    if (there.size() < 20) there.insert(time);
    for (std::size_t k = 0; k < times.size(); ++k) {
      if (has_time_ && !same(time, times[k])) continue;
      seen[k] = true;
      row(static_cast<int>(k), x, value);
    }
  }
  const auto missing = std::ranges::find(seen, false) - seen.begin();
  if (missing == static_cast<std::ptrdiff_t>(seen.size())) return;
  const std::string file = expect_.text("reference");
  if (there.empty())
    expect_.refuse("filter", fmt::format("no row of '{}' passes the filter", file),
                   "give numbers as they stand in the file");
  expect_.refuse(expect_.has("at") ? "at" : "reference", fmt::format("'{}' has no rows at {} s", file, times[missing]),
                 fmt::format("its times are {} s{}", fmt::join(there, ", "), there.size() < 20 ? "" : ", ..."));
}

std::vector<double> reference_values(const Table& expect, const std::string& unit, std::span<const double> times) {
  std::vector<double> values(times.size(), NAN);
  ReferenceFile(expect, unit).read(times, [&](int k, const auto&, double value) {
    if (!std::isnan(values[k])) refuse_second_row(expect, "one time");
    values[k] = value;
  });
  return values;
}

PointReference::PointReference(const Table& expect, const std::string& unit, const Cloud& cloud,
                               std::span<const int> selected, std::span<const double> times) {
  const std::string name = expect.text("reference");
  collective_try(cloud.comm, [&] {
    const ReferenceFile file(expect, unit);
    if (file.axes().empty())
      expect.refuse("reference", fmt::format("'{}' has no column x, y, z or r", name),
                    "add the coordinates of the rows, or compare a probe");
    if (file.axes().size() == 1) {
      axis_ = file.axes().front();
      curves_.resize(times.size());
      file.read(times, [&](int k, const auto& x, double value) { curves_[k].push_back({x[0], value}); });
    } else {
      matched_.resize(times.size());
      const Finder finder(cloud, selected, file.axes());
      file.read(times, [&](int k, const auto& x, double value) {
        finder.at(x, [&](int i) { matched_[k].point.push_back(i), matched_[k].value.push_back(value); });
      });
    }

    for (std::size_t k = 0; k < curves_.size(); ++k) {
      std::vector<Knot>& curve = curves_[k];
      std::ranges::sort(curve, {}, &Knot::x);
      const double low = curve.front().x, high = curve.back().x, span = high - low;
      for (std::size_t i = 1; i < curve.size(); ++i)
        if (curve[i].x - curve[i - 1].x <= 1e-12 * span)
          refuse_second_row(expect, fmt::format("{} = {} m", axis_, curve[i].x));
      for (int i : selected)
        if (const double x = coordinate(cloud.x[i], axis_); x < low - 1e-9 * span || x > high + 1e-9 * span)
          expect.refuse(
              "reference",
              fmt::format("'{}' goes from {} = {} to {} m; a point to compare lies at {} m", name, axis_, low, high, x),
              "select points inside by 'where', or extend the file");
    }
    for (Values& values : matched_) {
      std::vector<std::size_t> order(values.point.size());
      std::iota(order.begin(), order.end(), 0);
      std::ranges::sort(order, {}, [&](std::size_t n) { return values.point[n]; });
      Values sorted;
      for (std::size_t n : order) {
        const int i = values.point[n];
        const Vec3& x = cloud.x[i];
        if (!sorted.point.empty() && sorted.point.back() == i)
          refuse_second_row(expect, fmt::format("the point ({}, {}, {}) m", x.x, x.y, x.z));
        sorted.point.push_back(i);
        sorted.value.push_back(values.value[n]);
      }
      values = std::move(sorted);
    }
  });
  for (std::size_t k = 0; k < matched_.size(); ++k)
    if (total(cloud.comm, static_cast<std::int64_t>(matched_[k].point.size())) == 0)
      expect.refuse("reference", fmt::format("no row of '{}' lies on a point to compare", name),
                    "rows are matched within 1e-6 of the spacing; check their coordinates, units and 'where'");
}

PointReference::Values PointReference::at(int k, const Cloud& cloud, std::span<const int> selected) const {
  if (curves_.empty()) return matched_[k];
  const std::vector<Knot>& curve = curves_[k];
  const int count = static_cast<int>(curve.size()), wide = std::min(count, 4);
  Values out{.point = {selected.begin(), selected.end()}, .value = {}};
  for (int i : selected) {
    const double x = coordinate(cloud.x[i], axis_);
    const int right = static_cast<int>(std::ranges::lower_bound(curve, x, {}, &Knot::x) - curve.begin());
    const int first = std::clamp(right - 2, 0, count - wide);
    double value = 0;  // Lagrange's polynomial, exact at the knots
    for (int a = first; a < first + wide; ++a) {
      double weight = 1;
      for (int b = first; b < first + wide; ++b)
        if (b != a) weight *= (x - curve[b].x) / (curve[a].x - curve[b].x);
      value += weight * curve[a].value;
    }
    out.value.push_back(value);
  }
  return out;
}

}  // namespace calor
