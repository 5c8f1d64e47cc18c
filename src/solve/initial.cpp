#include "solve/initial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <unordered_map>

#include "base/csv.hpp"
#include "base/parallel.hpp"
#include "cloud/cell_integrals.hpp"

namespace calor {
namespace {

/// Finds the owned point at given coordinates, to within 1e-6 of its spacing.
class PointFinder {
 public:
  explicit PointFinder(const Cloud& cloud) : cloud_(cloud) {
    cell_ = cloud.owned > 0 ? *std::min_element(cloud.spacing.begin(), cloud.spacing.begin() + cloud.owned) : 1;
    for (int i = 0; i < cloud.owned; ++i)
      cells_.emplace(key(cell(cloud.x[i].x), cell(cloud.x[i].y), cell(cloud.x[i].z)), i);
  }

  /// Local index, -1 where there is no point of this rank.
  int find(const Vec3& at) const {
    const double near = 2e-6 * cell_;  // beside the side of a cell both are searched
    for (auto a = cell(at.x - near); a <= cell(at.x + near); ++a)
      for (auto b = cell(at.y - near); b <= cell(at.y + near); ++b)
        for (auto c = cell(at.z - near); c <= cell(at.z + near); ++c) {
          const auto [begin, end] = cells_.equal_range(key(a, b, c));
          for (auto entry = begin; entry != end; ++entry) {
            const int i = entry->second;
            if (norm(cloud_.x[i] - at) <= 1e-6 * cloud_.spacing[i]) return i;
          }
        }
    return -1;
  }

 private:
  std::int64_t cell(double x) const { return std::llround(std::floor(x / cell_)); }
  static std::size_t key(std::int64_t a, std::int64_t b, std::int64_t c) {
    return static_cast<std::size_t>(a) * 73856093u ^ static_cast<std::size_t>(b) * 19349663u ^
           static_cast<std::size_t>(c) * 83492791u;
  }

  const Cloud& cloud_;
  double cell_;
  std::unordered_multimap<std::size_t, int> cells_;
};

/// Temperatures from the rows of a file: every rank reads it through and keeps what belongs to its points. Rows are
/// matched by the coordinates if the file has them, otherwise by id.
std::vector<double> from_file(const std::string& path, const Cloud& cloud, const Table& table, const std::string& key) {
  CsvReader csv(path, table.location(key));
  const int T_column = csv.require("T", "K");
  const bool by_place = csv.find("x") >= 0;
  std::vector<int> columns;
  if (by_place) {
    for (const char* axis : {"x", "y", "z"})
      if (static_cast<int>(columns.size()) < cloud.dimension) columns.push_back(csv.require(axis, "m"));
  } else {
    columns.push_back(csv.require("id", ""));
  }

  const PointFinder finder(cloud);
  std::unordered_map<std::int64_t, int> of_id;
  for (int i = 0; i < cloud.owned && !by_place; ++i) of_id.emplace(cloud.id[i], i);

  std::vector<double> T(cloud.owned);
  std::vector<char> found(cloud.owned);
  while (csv.next()) {
    int i = -1;
    if (by_place) {
      Vec3 at;
      for (std::size_t axis = 0; axis < columns.size(); ++axis) at[static_cast<int>(axis)] = csv.number(columns[axis]);
      i = finder.find(at);
    } else {
      const auto point = of_id.find(csv.integer(columns[0]));
      if (point != of_id.end()) i = point->second;
    }
    const double value = csv.number(T_column);
    if (i < 0) continue;
    if (found[i])
      throw Error(Fault::bad_case, csv.location(), fmt::format("a second row for the point of id {}", cloud.id[i]),
                  "leave one of them");
    T[i] = value, found[i] = 1;
  }
  const auto missing = std::ranges::find(found, 0);
  if (missing != found.end()) {
    const auto i = missing - found.begin();
    const Vec3& at = cloud.x[i];
    table.refuse(key,
                 fmt::format("\"{}\" has no row for the point at ({:.9g}, {:.9g}, {:.9g}) m, id {}", path, at.x, at.y,
                             at.z, cloud.id[i]),
                 by_place ? "the coordinates must be those of the cloud, to 1e-6 of the spacing"
                          : "ids count the points of the cloud from 0; or give columns x [m], y [m], z [m]");
  }
  return T;
}

/// The temperature at the points; where it jumps within a cell, the mean over the cell: the heat is what counts.
std::vector<double> from_function(const Function& f, const Cloud& cloud) {
  std::vector<double> T(cloud.owned);
  collective_try(cloud.comm, [&] { f.evaluate({.x = cloud.owned_points()}, T); });
  if (!f.may_jump()) return T;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : T) low = std::min(low, value), high = std::max(high, value);
  low = min(cloud.comm, low), high = max(cloud.comm, high);
  const auto above_lowest = [&](std::span<const Vec3> x, std::span<double> out) {
    f.evaluate({.x = x}, out);
    for (double& value : out) value -= low;
  };
  collective_try(cloud.comm, [&] {
    const std::vector<double> rise = CellIntegrals(cloud).values({.f = above_lowest, .scale = high - low});
    for (std::size_t i = 0; i < T.size(); ++i)
      if (rise[i] != T[i] - low) T[i] = low + rise[i];
  });
  return T;
}

}  // namespace

std::vector<double> initial_temperatures(const Case& c, const Cloud& cloud) {
  const Table table = c.section("initial");
  std::vector<std::string> given;
  for (const char* key : {"temperature", "csv", "result"})
    if (table.has(key)) given.push_back(key);
  if (given.empty()) {
    if (!c.root().has("time") && !c.root().has("initial")) return {};
    table.refuse("", "the temperature at the start is missing",
                 "add [initial] with temperature = \"... K\", csv = \"FILE\" or result = \"FOLDER\"");
  }
  if (given.size() > 1)
    table.refuse(given[1], fmt::format("[initial] has both '{}' and '{}'", given[0], given[1]),
                 "leave one of them out");

  std::vector<double> T(cloud.owned);
  if (given[0] == "temperature") {
    const Function f = table.function("temperature");
    if (f.depends_on_time() || f.depends_on_temperature())
      table.refuse(
          "temperature",
          fmt::format("the temperature at the start depends on {}", f.depends_on_time() ? "time" : "temperature"),
          "use place only: x, y, z, r");
    T = from_function(f, cloud);
  } else {
    std::string path = table.file(given[0]);
    if (given[0] == "result") path = (std::filesystem::path(path) / "final.csv").string();
    collective_try(cloud.comm, [&] { T = from_file(path, cloud, table, given[0]); });
  }
  return T;
}

void declare_initial(Schema& schema) {
  schema.add(
      {.path = "initial",
       .sentence = "The temperature at the start: one of these. A case with [steady] does without and then starts from "
                   "the mean of the temperatures at its walls.",
       .keys = {
           {"temperature", Kind::function, "K", optional,
            "A number or a function of place; where it jumps within the cell of a point, the point takes its mean over "
            "the cell."},
           {"csv", Kind::text, "", optional,
            "File with a column T [K] and either x [m], y [m], z [m] (as many as the body has dimensions) or id, "
            "the point's number from 0."},
           {"result", Kind::text, "", optional,
            "Result folder of another run with the same cloud: its temperatures at the end."}}});
}

}  // namespace calor
