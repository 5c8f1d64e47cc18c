// Values at the nodes of a grid, multilinear in between.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "case/function_table.hpp"

namespace calor {
namespace {

const Key along_key{"along", Kind::texts, "", required, "Axes of the grid, the outer list first."};
const Key from_key{"from", Kind::quantities, "m", required, "Coordinates of the first node."};
const Key to_key{"to", Kind::quantities, "m", required, "Coordinates of the last node."};

struct GridAxis {
  int axis;         ///< 0..2
  double from, to;  ///< m
  int nodes;
};

class Grid {
 public:
  Grid(std::vector<GridAxis> axes, std::vector<double> values, SourceLocation location)
      : axes_(std::move(axes)), values_(std::move(values)), location_(std::move(location)) {}

  /// Throws Error(bad_case) outside of the grid.
  double operator()(const Vec3& x) const {
    std::array<int, 3> node{};
    std::array<double, 3> s{};  // of the way to the next node
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      const auto& [axis, from, to, nodes] = axes_[a];
      constexpr double tolerance = 1e-9;
      const double along = (x[axis] - from) / (to - from);
      if (!(along >= -tolerance && along <= 1 + tolerance))
        throw Error(
            Fault::bad_case, location_,
            fmt::format("the grid reaches from {0} = {1:.6g} m to {2:.6g} m, but a point lies at {0} = {3:.6g} m",
                        "xyz"[axis], from, to, x[axis]),
            "let the grid cover the body: check from and to");
      const double at = std::clamp(along, 0.0, 1.0) * (nodes - 1);
      node[a] = std::min(static_cast<int>(at), nodes - 2);
      s[a] = at - node[a];
    }
    double sum = 0;
    for (unsigned corner = 0; corner < 1U << axes_.size(); ++corner) {
      double weight = 1;
      std::size_t index = 0;
      for (std::size_t a = 0; a < axes_.size(); ++a) {
        const unsigned next = corner >> a & 1U;
        weight *= next ? s[a] : 1 - s[a];
        index = index * axes_[a].nodes + node[a] + next;
      }
      sum += weight * values_[index];
    }
    return sum;
  }

 private:
  std::vector<GridAxis> axes_;
  std::vector<double> values_;  // the last axis runs fastest
  SourceLocation location_;
};

/// Reads a nested list; all lists of one depth must be as long as the first.
void read_nodes(const FunctionTable& parts, const Value& list, std::size_t depth, std::vector<GridAxis>& axes,
                std::vector<double>& values) {
  if (depth == axes.size()) {
    const double value = parts.value(list, "grid");
    values.push_back(above_absolute_zero(value, list, parts.owner()));
    return;
  }
  if (list.type != Value::Type::list)
    refuse_value(list, "'grid' cannot be " + list.described(),
                 "write lists in lists, as many deep as 'along' has axes: [[1, 2, 3], [4, 5, 6]]");
  const int nodes = static_cast<int>(list.list.size());
  if (axes[depth].nodes == 0) axes[depth].nodes = nodes;
  if (nodes < 2) refuse_value(list, fmt::format("a grid of {} nodes along an axis", nodes), "give at least 2");
  if (nodes != axes[depth].nodes)
    refuse_value(list, fmt::format("a row of the grid has {} values, the first has {}", nodes, axes[depth].nodes),
                 "give all rows the same number of values");
  for (const Value& below : list.list) read_nodes(parts, below, depth + 1, axes, values);
}

}  // namespace

Function read_grid(const FunctionTable& parts) {
  const Value along = parts.get(along_key), from = parts.get(from_key), to = parts.get(to_key);
  const std::vector<std::string> names = read_texts(along, along_key);
  const std::vector<double> first = read_numbers(from, from_key), last = read_numbers(to, to_key);
  std::vector<GridAxis> axes;
  for (const std::string& name : names) {
    const std::size_t axis = std::string("xyz").find(name);
    const bool is_axis = name.size() == 1 && axis < 3;
    if (!is_axis || std::ranges::count(names, name) > 1 || names.size() > 3)
      refuse_value(along, fmt::format("'along' of a grid names \"{}\"", name), "write along = [\"x\", \"y\"]");
    const std::size_t n = axes.size();
    if (first.size() != names.size() || last.size() != names.size())
      refuse_value(first.size() != names.size() ? from : to,
                   fmt::format("a grid of {} axes has {} coordinates", names.size(),
                               first.size() != names.size() ? first.size() : last.size()),
                   "give one an axis");
    if (!(last[n] > first[n]))
      refuse_value(to, fmt::format("the grid ends at {} = {:g} m, where it begins or before", name, last[n]),
                   "let 'to' be above 'from'");
    axes.push_back({static_cast<int>(axis), first[n], last[n], 0});
  }
  const Value& nodes = *parts.table().find("grid");
  std::vector<double> values;
  read_nodes(parts, nodes, 0, axes, values);
  const auto evaluate = [grid = Grid(std::move(axes), std::move(values), nodes.location)](const Arguments& args,
                                                                                          std::span<double> out) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = grid(args.x[i]);
  };
  return Function::callback({.evaluate = evaluate, .on = {.place = true}}, nodes.location);
}

}  // namespace calor
