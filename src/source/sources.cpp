#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "base/parallel.hpp"
#include "source/moving_source.hpp"
#include "source/path.hpp"
#include "source/source.hpp"

namespace calor {

SourceKind body_source();
std::unique_ptr<Source> make_spread_source(const Case& c, const std::string& name, const Table& table,
                                           const Cloud& cloud);
void declare_spread_source(Schema& schema);

Registry<SourceKind>& source_kinds() {
  static Registry<SourceKind> all = {body_source()};
  return all;
}

namespace {

/// Does it say where it is at which time?
bool moves(const Table& source) { return source.has("at") || source.has("path") || source.has("pass"); }

/// What [source.NAME] is: one of the kinds, a moving source of one of the profiles, or else a power that is spread.
std::unique_ptr<Source> make_source(const Case& c, const std::string& name, const Table& table, const Cloud& cloud) {
  const auto kinds = source_kinds().given(table);
  const auto profiles = source_profiles().given(table);
  std::vector<std::string> given;
  for (const SourceKind* kind : kinds) given.push_back(kind->name);
  for (const SourceProfileKind* profile : profiles) given.push_back(profile->name);
  if (given.size() > 1)
    table.refuse(given.back(), fmt::format("[{}] is more than one kind of source", table.path()),
                 fmt::format("keep one of: {}", fmt::join(given, ", ")));
  if (given.empty() && table.has("power") && !moves(table)) return make_spread_source(c, name, table, cloud);
  if (given.empty())
    table.refuse("", fmt::format("[{}] does not say how much heat it gives", table.path()),
                 fmt::format("add one of: {}, {}; or only a power, which is spread",
                             fmt::join(source_kinds().names(), ", "), fmt::join(source_profiles().names(), ", ")));
  for (const char* key : {"where", "on", "relative_density"})
    if (table.has(key))
      table.refuse(key, fmt::format("'{}' goes with a power that is spread, not with '{}'", key, given.front()),
                   "leave it out");
  if (!kinds.empty()) return kinds.front()->make(name, table, cloud);
  const SourceProfileKind& profile = *profiles.front();
  const double end = c.root().has("time") ? c.section("time").number("end") : std::numeric_limits<double>::infinity();
  return make_moving_source(name, table, cloud, profile.make(table.sub(profile.name), cloud), end);
}

}  // namespace

std::vector<std::unique_ptr<Source>> make_sources(const Case& c, const Cloud& cloud) {
  std::vector<std::unique_ptr<Source>> sources;
  for (const auto& [name, table] : c.section("source").children()) {
    collective_try(cloud.comm,
                   [&, &name = name, &table = table] { sources.push_back(make_source(c, name, table, cloud)); });
    if (std::ranges::count(c.section("boundary").children(), name, [](const auto& b) { return b.first; }))
      table.refuse("", fmt::format("'{}' is the name of a boundary too", name),
                   "give it another name: both have a column of that name in energy.csv");
  }
  return sources;
}

void declare_sources(Schema& schema) {
  source_kinds().declare(schema);
  declare_spread_source(schema);
  for (const SourceProfileKind& profile : source_profiles()) {
    schema.add({.path = "source.*",
                .sentence = profile.sentence + ".",
                .keys = {{profile.name, Kind::table, "", optional, "Makes it such a source."}}});
    schema.add({.path = "source.*." + profile.name, .sentence = profile.sentence + ".", .keys = profile.keys});
  }
  declare_paths(schema);
}

}  // namespace calor
