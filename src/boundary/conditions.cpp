#include "boundary/conditions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "base/parallel.hpp"
#include "boundary/surface_fluxes.hpp"
#include "case/where.hpp"

namespace calor {
namespace {

/// One [boundary.NAME]: what it says and what it selects on this rank.
struct BoundarySection {
  std::string name;
  Table table;
  bool prescribed, insulated;
  std::uint32_t faces = 0;    // bit f: cloud.faces[f]
  std::vector<char> in = {};  // `where` at the owned points; empty: true everywhere

  bool holds(int point) const { return in.empty() || in[point]; }
  bool holds(const Patch& p) const { return faces >> p.face & 1 && holds(p.point); }
  std::string key() const { return table.has("where") ? "where" : table.has("on") ? "on" : ""; }
};

int face_index(const BoundarySection& s, const std::string& face, const Cloud& cloud) {
  const auto found = std::ranges::find(cloud.faces, face);
  if (found != cloud.faces.end()) return static_cast<int>(found - cloud.faces.begin());
  const std::string near = nearest(face, cloud.faces);
  const std::string list =
      cloud.faces.empty() ? "the cloud has none" : fmt::format("the faces are {}", fmt::join(cloud.faces, ", "));
  s.table.refuse(s.table.has("on") ? "on" : "", fmt::format("there is no face '{}'", face),
                 (near.empty() ? "" : fmt::format("did you mean '{}'? ", near)) + list +
                     (s.table.has("on") ? "" : "; another name needs 'on' or 'where'"));
}

std::vector<BoundarySection> read_sections(const Case& c, const Cloud& cloud) {
  std::vector<BoundarySection> sections;
  for (const auto& [name, table] : c.section("boundary").children()) {
    BoundarySection s{.name = name,
                      .table = table,
                      .prescribed = table.has("temperature"),
                      .insulated = table.has("insulated") && table.flag("insulated")};
    std::vector<std::string> given;
    if (s.prescribed) given.push_back("temperature");
    for (const auto& kind : surface_flux_kinds())
      if (table.has(kind.key)) given.push_back(kind.key);
    if (given.empty() && !s.insulated)
      table.refuse("", fmt::format("[{}] says nothing of its wall", table.path()),
                   "give a temperature, flux, convection or radiation, or insulated = true");
    if (s.insulated && !given.empty())
      table.refuse("insulated", fmt::format("[{}] is insulated and has a {}", table.path(), given.front()),
                   "leave one of them out");
    if (s.prescribed && given.size() > 1)
      table.refuse(given[1], fmt::format("[{}] has a temperature and a {}", table.path(), given[1]),
                   "a wall of prescribed temperature takes whatever heat it needs: leave one of them out");
    if (s.prescribed && !cloud.points_on_walls)
      table.refuse("temperature", "a cell-centred cloud has no points on its walls that could take a temperature",
                   "write at = \"walls\" in [cloud], or give convection with a large h");
    if (!s.prescribed && !cloud.has_areas && !s.insulated)
      table.refuse(given.front(), "the cloud has no boundary areas for heat to flow through",
                   "add boundary areas to the file of the cloud, or prescribe temperatures");

    if (table.has("on")) {
      for (const auto& face : table.texts("on")) s.faces |= 1u << face_index(s, face, cloud);
    } else if (!table.has("where") || std::ranges::count(cloud.faces, name)) {
      s.faces = 1u << face_index(s, name, cloud);
    } else {
      s.faces = ~0u;
    }
    if (table.has("where")) together(cloud.comm, [&] { s.in = where(c, table, cloud.owned_points()); });
    sections.push_back(std::move(s));
  }
  return sections;
}

/// Adds up counts of all ranks, in place.
void add_up(MPI_Comm comm, std::vector<std::int64_t>& counts) {
  MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(counts.size()), MPI_INT64_T, MPI_SUM, comm);
}

/// Owned points that a prescribed section holds. Without boundary areas nobody knows where the walls are: a formula
/// then selects among all points.
std::vector<int> selected_points(const BoundarySection& s, const Cloud& cloud) {
  std::vector<int> points;
  const bool anywhere = s.faces == ~0u && !cloud.has_areas;
  for (int i = 0; i < cloud.owned; ++i)
    if ((anywhere || cloud.on_faces[i] & s.faces) && s.holds(i)) points.push_back(i);
  return points;
}

/// Two temperatures, or a temperature and anything else, on all of one face contradict each other.
void refuse_contradictions(const std::vector<BoundarySection>& sections, const Cloud& cloud) {
  const std::size_t F = cloud.faces.size(), S = sections.size();
  std::vector<std::int64_t> patches((S + 1) * F);  // of every section on every face; the last row counts all
  for (const Patch& p : cloud.patches) {
    for (std::size_t s = 0; s < S; ++s) patches[s * F + p.face] += sections[s].holds(p);
    ++patches[S * F + p.face];
  }
  add_up(cloud.comm, patches);
  for (std::size_t b = 0; b < S; ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const bool clash =
          sections[a].prescribed || sections[b].prescribed || sections[a].insulated || sections[b].insulated;
      for (std::size_t f = 0; f < F && clash; ++f) {
        const std::int64_t all = patches[S * F + f];
        if (all == 0 || patches[a * F + f] < all || patches[b * F + f] < all) continue;
        const auto says = [](const BoundarySection& s) {
          return s.prescribed ? "a temperature" : s.insulated ? "insulation" : "a heat flux";
        };
        if (sections[a].insulated && sections[b].insulated) continue;
        sections[b].table.refuse(
            sections[b].key(),
            fmt::format("the face '{}' has {} from [{}] and {} from [{}]", cloud.faces[f], says(sections[a]),
                        sections[a].table.path(), says(sections[b]), sections[b].table.path()),
            "leave one of them out, or limit them to parts of the face by 'where'");
      }
    }
  }
}

/// Where several prescribed temperatures meet every one gets its share, and a note says so.
void share_points(Conditions& conditions, const Cloud& cloud) {
  auto& terms = conditions.temperatures;
  std::vector<int> times(cloud.owned);
  for (const auto& term : terms)
    for (const int i : term.point) ++times[i];
  for (auto& term : terms)
    for (const int i : term.point) term.share.push_back(1.0 / times[i]);

  const std::size_t n = terms.size();
  if (n < 2) return;
  std::vector<std::int64_t> common(n * n);
  for (std::size_t a = 0; a < n; ++a) {
    std::vector<char> in(cloud.owned);
    for (const int i : terms[a].point) in[i] = 1;
    for (std::size_t b = a + 1; b < n; ++b)
      for (const int i : terms[b].point) common[a * n + b] += in[i];
  }
  add_up(cloud.comm, common);
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = a + 1; b < n; ++b) {
      const Function &f = terms[a].temperature, &g = terms[b].temperature;
      const bool same = f.is_constant() && g.is_constant() && f() == g();
      if (const std::int64_t points = common[a * n + b]; points > 0 && !same)
        conditions.notes.push_back(fmt::format("{} on '{}' and '{}' take{} the mean of their temperatures",
                                               points == 1 ? "1 point" : fmt::format("{} points", points),
                                               terms[a].name, terms[b].name, points == 1 ? "s" : ""));
    }
  }
}

PrescribedTerm make_prescribed(const BoundarySection& s, int account, const Cloud& cloud) {
  PrescribedTerm term{.name = s.name,
                      .account = account,
                      .temperature = s.table.function("temperature"),
                      .point = selected_points(s, cloud),
                      .share = {},
                      .x = {}};
  if (term.temperature.depends_on_temperature())
    s.table.refuse("temperature", "a prescribed temperature cannot depend on the temperature",
                   "use place and time only: x, y, z, r, t");
  if (total(cloud.comm, static_cast<std::int64_t>(term.point.size())) == 0)
    s.table.refuse(s.key(), fmt::format("[{}] holds no point", s.table.path()), "change the selection");
  for (const int i : term.point) term.x.push_back(cloud.x[i]);
  return term;
}

}  // namespace

Conditions make_conditions(const Case& c, const Cloud& cloud) {
  const auto sections = read_sections(c, cloud);
  Conditions conditions;
  for (const BoundarySection& s : sections) {
    const int account = static_cast<int>(conditions.accounts.size());
    conditions.accounts.push_back(s.name);
    if (s.prescribed) {
      conditions.temperatures.push_back(make_prescribed(s, account, cloud));
      continue;
    }
    SurfaceTerm place{.name = s.name, .account = account, .flux = nullptr, .point = {}, .area = {}, .x = {}};
    for (const Patch& p : cloud.patches) {
      if (!s.holds(p)) continue;
      place.point.push_back(p.point);
      place.area.push_back(p.area);
      place.x.push_back(cloud.x[p.point]);
    }
    if (total(cloud.comm, static_cast<std::int64_t>(place.point.size())) == 0)
      s.table.refuse(s.key(), fmt::format("[{}] holds no piece of the surface", s.table.path()),
                     "change the selection");
    for (const auto& kind : surface_flux_kinds()) {
      if (!s.table.has(kind.key)) continue;
      conditions.fluxes.push_back({s.name + "." + kind.key, account, nullptr, place.point, place.area, place.x});
      SurfaceTerm& term = conditions.fluxes.back();
      together(cloud.comm, [&] {
        term.flux = kind.make(s.table, term.x);
        // What is wrong at the start is said before the run: at the temperature of the surroundings.
        std::vector<double> T = term.flux->ambient(term.x, 0), q(term.x.size());
        if (T.empty() && term.flux->depends_on_temperature()) return;
        T.resize(term.x.size());
        term.flux->evaluate({.x = term.x, .T = T}, q, {});
      });
    }
  }
  refuse_contradictions(sections, cloud);
  share_points(conditions, cloud);
  return conditions;
}

void declare_boundaries(Schema& schema) {
  std::vector<Key> keys = {
      {"on", Kind::texts, "", optional, "Face or faces of the cloud; default: the name of the section."}};
  for (const Key& key : where_keys("Formula in x, y, z, r that is true where the condition holds."))
    keys.push_back(key);
  keys.push_back({"temperature", Kind::function, "K", optional, "Prescribed temperature, of place and time."});
  keys.push_back({"insulated", Kind::flag, "", optional, "Says that no heat passes, as where nothing is said."});
  schema.add({.path = "boundary.*",
              .sentence =
                  "A condition on a face of the cloud, or on a part of its surface by 'on' and 'where'. Heat fluxes of "
                  "several sections on one face add up; where nothing is said the wall is insulated.",
              .keys = keys});
  for (const auto& kind : surface_flux_kinds()) kind.declare(schema);
}

}  // namespace calor
