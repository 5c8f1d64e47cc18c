#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/parallel.hpp"
#include "source/kinds.hpp"
#include "source/path.hpp"

namespace calor {
namespace {

const std::vector<SourceKind>& kinds() {
  static const std::vector<SourceKind> all = {body_source, line_source, column_source, surface_source, goldak_source};
  return all;
}

}  // namespace

std::vector<std::unique_ptr<Source>> make_sources(const Case& c, const Cloud& cloud) {
  std::vector<std::unique_ptr<Source>> sources;
  for (const auto& [name, table] : c.section("source").children()) {
    const auto& t = table;
    const auto given = [&](const SourceKind& kind) { return t.has(kind.key); };
    if (const auto count = std::ranges::count_if(kinds(), given); count != 1) {
      std::vector<std::string> keys;
      for (const auto& kind : kinds())
        if (count == 0 || given(kind)) keys.push_back(kind.key);
      table.refuse(count > 1 ? keys.back() : "",
                   fmt::format("[{}] {}", table.path(),
                               count > 1 ? "is more than one kind of source" : "does not say how much heat it gives"),
                   fmt::format("{} one of: {}", count > 1 ? "keep" : "add", fmt::join(keys, ", ")));
    }
    const SourceKind& kind = *std::ranges::find_if(kinds(), given);
    std::unique_ptr<Source> source;
    collective_try(cloud.comm, [&] { source = kind.make(name, t, cloud); });
    if (std::ranges::count(c.section("boundary").children(), name, [](const auto& b) { return b.first; }))
      table.refuse("", fmt::format("'{}' is the name of a boundary too", name),
                   "give it another name: both have a column of that name in energy.csv");
    sources.push_back(std::move(source));
  }
  return sources;
}

void declare_sources(Schema& schema) {
  for (const auto& kind : kinds()) kind.declare(schema);
  declare_paths(schema);
}

}  // namespace calor
