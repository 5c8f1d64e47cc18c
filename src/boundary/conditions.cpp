#include "boundary/conditions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "base/parallel.hpp"
#include "boundary/segments.hpp"
#include "boundary/surface_fluxes.hpp"
#include "cloud/cell_samples.hpp"

namespace calor {
namespace {

/// The faces of a plate, a body of two dimensions with a thickness: every point has a part of them. They are no walls
/// of the plane that the points fill, so the cloud does not know them.
const std::vector<std::string> plate_faces = {"bottom", "top"};

/// One [boundary.NAME]: what it says and what it selects on this rank.
struct BoundarySection {
  std::string name;
  Table table;
  bool prescribed, insulated;
  std::uint32_t faces = 0;    // bit f: cloud.faces[f]
  int plate = 0;              // how many of the plate's faces
  std::vector<char> in = {};  // `where` at the owned points, of prescribed and insulated ones; empty: true everywhere
  std::optional<Function> where = {};   // of a flux
  std::vector<char> whole_facets = {};  // with `where`, of fluxes and off the walls: those that it selects as a whole

  bool holds(int point) const { return in.empty() || in[point]; }
  bool holds(const Facet& p) const { return faces >> p.face & 1 && holds(p.point); }
  bool holds_all(const Cloud& cloud, std::size_t n) const {
    return whole_facets.empty() ? holds(cloud.facets[n]) : whole_facets[n];
  }
  std::string key() const { return table.has("where") ? "where" : table.has("on") ? "on" : ""; }
};

bool is_plate(const Cloud& cloud) { return cloud.dimension == 2 && !cloud.axisymmetric; }

void add_face(BoundarySection& s, const std::string& face, const Cloud& cloud) {
  const auto found = std::ranges::find(cloud.faces, face);
  if (found != cloud.faces.end()) {
    s.faces |= 1u << (found - cloud.faces.begin());
    return;
  }
  std::vector<std::string> known = cloud.faces;
  if (is_plate(cloud)) {
    if (std::ranges::count(plate_faces, face)) {
      ++s.plate;
      return;
    }
    known.insert(known.end(), plate_faces.begin(), plate_faces.end());
  }
  const std::string near = nearest(face, known);
  const std::string list =
      known.empty() ? "the cloud has none" : fmt::format("the faces are {}", fmt::join(known, ", "));
  s.table.refuse(s.table.has("on") ? "on" : "", fmt::format("there is no face '{}'", face),
                 (near.empty() ? "" : fmt::format("did you mean '{}'? ", near)) + list +
                     (s.table.has("on") ? "" : "; another name needs 'on' or 'where'"));
}

/// Of every facet of a cloud without points on its walls: where its wall is nearest to its point.
std::vector<Vec3> places_on_walls(const Cloud& cloud) {
  std::vector<Vec3> places;
  for (const Facet& p : cloud.facets) places.push_back(place_on_wall(cloud, p));
  return places;
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
    for (const SurfaceFluxKind* kind : surface_fluxes().given(table)) given.push_back(kind->name);
    if (given.empty() && !s.insulated)
      table.refuse("", fmt::format("[{}] says nothing of its wall", table.path()),
                   fmt::format("give a temperature, {}, or insulated = true", surface_fluxes().listed()));
    if (s.insulated && !given.empty())
      table.refuse("insulated", fmt::format("[{}] is insulated and has a {}", table.path(), given.front()),
                   "leave one of them out");
    if (s.prescribed && given.size() > 1)
      table.refuse(given[1], fmt::format("[{}] has a temperature and a {}", table.path(), given[1]),
                   "a wall of prescribed temperature takes whatever heat it needs: leave one of them out");
    if (!s.prescribed && !cloud.has_areas && !s.insulated)
      table.refuse(given.front(), "the cloud has no boundary areas for heat to flow through",
                   "add boundary areas to the file of the cloud, or prescribe temperatures");
    const bool is_face =
        std::ranges::count(cloud.faces, name) || (is_plate(cloud) && std::ranges::count(plate_faces, name));
    if (table.has("on")) {
      for (const auto& face : table.texts("on")) add_face(s, face, cloud);
    } else if (!table.has("where") || is_face) {
      add_face(s, name, cloud);
    } else {
      s.faces = ~0u;
    }
    if (s.plate > 0 && s.prescribed)
      table.refuse("temperature", "the face of a plate cannot have a prescribed temperature: its points have one each",
                   "give convection with a large h");
    if (s.faces != 0 && !s.prescribed && !cloud.has_areas && !s.insulated)
      table.refuse(given.front(), "the cloud has no boundary areas for heat to flow through",
                   "add boundary areas to the file of the cloud, or prescribe temperatures");
    if (table.has("where"))
      collective_try(cloud.comm, [&, &t = table] {
        if (s.prescribed || s.insulated) {
          s.in = where(c, t, cloud.owned_points());
          if (!cloud.points_on_walls) s.whole_facets = where(c, t, places_on_walls(cloud));
          for (std::size_t n = 0; n < s.whole_facets.size(); ++n)
            s.whole_facets[n] = s.whole_facets[n] && s.faces >> cloud.facets[n].face & 1;
        } else {
          s.where = where_function(c, t);
        }
      });
    sections.push_back(std::move(s));
  }
  return sections;
}

/// Owned points that a prescribed section holds. Without boundary areas nobody knows where the walls are: a formula
/// then selects among all points. A cell-centred cloud has none.
std::vector<int> selected_points(const BoundarySection& s, const Cloud& cloud) {
  std::vector<int> points;
  if (!cloud.points_on_walls) return points;
  const bool anywhere = s.faces == ~0u && !cloud.has_areas;
  for (int i = 0; i < cloud.owned; ++i)
    if ((anywhere || cloud.on_faces[i] & s.faces) && s.holds(i)) points.push_back(i);
  return points;
}

/// Two temperatures, or a temperature and anything else, on all of one face contradict each other.
void refuse_contradictions(const std::vector<BoundarySection>& sections, const Cloud& cloud) {
  const std::size_t F = cloud.faces.size(), S = sections.size();
  std::vector<std::int64_t> facets((S + 1) * F);  // of every section on every face; the last row counts all
  for (std::size_t n = 0; n < cloud.facets.size(); ++n) {
    const int face = cloud.facets[n].face;
    for (std::size_t s = 0; s < S; ++s) facets[s * F + face] += sections[s].holds_all(cloud, n);
    ++facets[S * F + face];
  }
  add_up(cloud.comm, facets);
  for (std::size_t b = 0; b < S; ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const bool clash =
          sections[a].prescribed || sections[b].prescribed || sections[a].insulated || sections[b].insulated;
      for (std::size_t f = 0; f < F && clash; ++f) {
        const std::int64_t all = facets[S * F + f];
        if (all == 0 || facets[a * F + f] < all || facets[b * F + f] < all) continue;
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
  std::vector<int> times(cloud.owned), times_of_facet(cloud.facets.size());
  for (const auto& term : terms) {
    for (const int i : term.point) ++times[i];
    for (const int n : term.facet) ++times_of_facet[n];
  }
  for (auto& term : terms) {
    for (const int i : term.point) term.share.push_back(1.0 / times[i]);
    for (const int n : term.facet) term.share.push_back(1.0 / times_of_facet[n]);
  }

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

[[noreturn]] void refuse_empty(const BoundarySection& s, const char* what, const Cloud& cloud) {
  const bool by_formula = s.table.has("where");
  s.table.refuse(s.key(),
                 by_formula ? fmt::format("'{}' selects no {} for [{}]", s.table.text("where"), what, s.table.path())
                            : fmt::format("[{}] holds no {}", s.table.path(), what),
                 by_formula           ? "allow for round-off: abs(y - 2) < 1e-9; lengths are in 'length', by default m"
                 : cloud.axisymmetric ? "change the selection; the axis is no wall"
                                      : "change the selection");
}

/// The area of the places at which a flux does something at the start, at the temperature of the surroundings. What is
/// wrong there is said before the run.
std::vector<double> acting_area(const SurfaceTerm& term) {
  std::vector<double> T = term.flux->ambient(term.x, 0), q(term.x.size()), slope(term.x.size()), area = term.area;
  if (T.empty() && term.flux->depends_on_temperature()) return area;
  T.resize(term.x.size());
  term.flux->evaluate({.x = term.x, .T = T}, q, slope);
  for (std::size_t n = 0; n < area.size(); ++n)
    if (q[n] == 0 && slope[n] == 0) area[n] = 0;
  return area;
}

/// What a flux is at the start, at two temperatures near those of its surroundings: a flux that vanishes at one of them
/// does not at the other. And what it owes to the surroundings, -dq/dT T_ambient, as these may jump from place to
/// place.
Integrand flux_at_start(const SurfaceFlux& flux) {
  return {.f = [&](std::span<const Vec3> x, std::span<double> out) {
    if (!flux.depends_on_temperature()) return flux.evaluate({.x = x}, out, {});
    std::ranges::fill(out, 0.0);
    constexpr double other = 40;  // K
    const std::vector<double> ambient = flux.ambient(x, 0);
    if (ambient.empty()) return;  // nobody knows which temperatures it is made for
    std::vector<double> T = ambient, q(x.size()), slope(x.size());
    for (const double part : {1., 0.6}) {
      flux.evaluate({.x = x, .T = T}, q, slope);
      for (std::size_t n = 0; n < q.size(); ++n) out[n] += part * q[n];
      for (double& t : T) t += other;
    }
    for (std::size_t n = 0; n < q.size(); ++n) out[n] -= slope[n] * ambient[n];
  }};
}

/// The fluxes of one section, and the area on which they flow.
void add_fluxes(BoundarySection& s, int account, const CellIntegrals& integrals, const Cloud& cloud,
                Conditions& conditions) {
  Selection on_walls{.facets = {}, .where = s.where}, on_plate{.facets = {}, .plate = s.plate, .where = s.where};
  for (std::size_t n = 0; n < cloud.facets.size(); ++n)
    if (s.faces >> cloud.facets[n].face & 1) on_walls.facets.push_back(static_cast<int>(n));
  const bool has_walls = s.faces != 0;
  Segments walls, plate;  // for fluxes that are the same at all places
  collective_try(cloud.comm, [&] {
    if (has_walls) walls = selected_facets(integrals, cloud, on_walls);
    if (s.plate > 0) plate = selected_facets(integrals, cloud, on_plate);
  });
  if (s.where) {
    s.whole_facets.assign(cloud.facets.size(), 0);
    for (std::size_t k = 0; k < walls.facet.size(); ++k)
      s.whole_facets[walls.facet[k]] = walls.area[k] >= (1 - 1e-9) * cloud.facets[walls.facet[k]].area;
  }
  const double selected = sum(cloud.comm, walls.area) + sum(cloud.comm, plate.area);
  if (!(selected > 0)) refuse_empty(s, "piece of the surface", cloud);

  double largest = 0;  // area on which one of the fluxes acts
  for (const SurfaceFluxKind* kind : surface_fluxes().given(s.table)) {
    std::unique_ptr<SurfaceFlux> flux;
    collective_try(cloud.comm, [&] { flux = kind->make(s.table, {}); });
    double acting = 0;
    for (const bool is_plate : {false, true}) {
      if (is_plate ? s.plate == 0 : !has_walls) continue;
      SurfaceTerm& term = conditions.fluxes.emplace_back();
      term.name = s.name + "." + kind->name, term.account = account, term.is_plate = is_plate;
      collective_try(cloud.comm, [&] {
        Segments p = is_plate ? plate : walls;
        if (flux->depends_on_place())
          p = selected_places(integrals, cloud, is_plate ? on_plate : on_walls, flux_at_start(*flux));
        term.point = std::move(p.point), term.facet = std::move(p.facet);
        term.area = std::move(p.area), term.x = std::move(p.x);
        term.flux = kind->make(s.table, term.x);
      });
      std::vector<double> area;
      collective_try(cloud.comm, [&] { area = acting_area(term); });
      acting += sum(cloud.comm, area);
    }
    largest = std::max(largest, acting);
  }
  conditions.areas[account] = largest > 0 ? largest : selected;  // nothing acts yet
  if (largest > 0 || !s.table.has("flux")) return;
  const Function flux = s.table.function("flux");
  if (flux.depends_on_place() && !flux.depends_on_time() && !flux.depends_on_temperature())
    conditions.notes.push_back(fmt::format("{}: the flux of [{}] is 0 at all places of its wall",
                                           s.table.location("flux").text(), s.table.path()));
}

PrescribedTerm make_prescribed(const BoundarySection& s, int account, const Cloud& cloud) {
  PrescribedTerm term{.name = s.name,
                      .account = account,
                      .temperature = s.table.function("temperature"),
                      .point = selected_points(s, cloud),
                      .facet = {},
                      .share = {},
                      .area = {},
                      .x = {}};
  if (term.temperature.depends_on_temperature())
    s.table.refuse("temperature", "a prescribed temperature cannot depend on the temperature",
                   "use place and time only: x, y, z, r, t");
  for (const int i : term.point) term.x.push_back(cloud.x[i]);
  term.area.resize(term.point.size());
  for (const Facet& p : cloud.facets) {
    const auto at = std::ranges::lower_bound(term.point, p.point);
    if (at != term.point.end() && *at == p.point && s.holds(p)) term.area[at - term.point.begin()] += p.area * p.normal;
  }
  if (!cloud.points_on_walls) {
    const std::vector<Vec3> places = places_on_walls(cloud);
    for (std::size_t n = 0; n < places.size(); ++n) {
      if (!s.holds_all(cloud, n)) continue;
      term.facet.push_back(static_cast<int>(n));
      term.x.push_back(places[n]);
      if (!cloud.walls.empty()) term.x.back()[cloud.facets[n].face / 2] = cloud.walls[cloud.facets[n].face];
    }
  }
  if (total(cloud.comm, static_cast<std::int64_t>(term.x.size())) == 0)
    refuse_empty(s, cloud.points_on_walls ? "point" : "piece of the surface", cloud);
  return term;
}

WallSection wall_section(const Case& c, const BoundarySection& s, int condition) {
  WallSection wall{.faces = s.faces, .condition = condition, .where = {}};
  if (s.table.has("where")) wall.where = [&c, table = s.table](std::span<const Vec3> x) { return where(c, table, x); };
  return wall;
}

}  // namespace

std::vector<int> conditions_at(const Conditions& conditions, int face, std::span<const Vec3> x) {
  constexpr int unknown = -3;
  std::vector<int> held(x.size(), unknown);
  for (const WallSection& wall : conditions.walls) {
    if (!(wall.faces >> face & 1)) continue;
    const std::vector<char> in = wall.where ? wall.where(x) : std::vector<char>(x.size(), 1);
    for (std::size_t n = 0; n < x.size(); ++n)
      if (in[n] && held[n] == unknown) held[n] = wall.condition;
  }
  std::ranges::replace(held, unknown, WallSection::insulated);
  return held;
}

Conditions make_conditions(const Case& c, const Cloud& cloud) {
  auto sections = read_sections(c, cloud);
  const CellIntegrals integrals(cloud);
  Conditions conditions;
  for (BoundarySection& s : sections) {
    const int account = static_cast<int>(conditions.accounts.size());
    conditions.accounts.push_back(s.name);
    conditions.areas.push_back(0);
    conditions.walls.push_back(wall_section(c, s,
                                            s.prescribed  ? static_cast<int>(conditions.temperatures.size())
                                            : s.insulated ? WallSection::insulated
                                                          : WallSection::flux));
    if (s.prescribed) {
      conditions.temperatures.push_back(make_prescribed(s, account, cloud));
      continue;
    }
    if (!s.insulated) add_fluxes(s, account, integrals, cloud, conditions);
  }
  refuse_contradictions(sections, cloud);
  share_points(conditions, cloud);
  return conditions;
}

void declare_boundaries(Schema& schema) {
  std::vector<Key> keys = {
      {"on", Kind::texts, "", optional,
       "Face or faces of the cloud, of a plate in 2D also its 'top' and 'bottom'; default: the name of the section."}};
  for (const Key& key : where_keys("Formula in x, y, z, r that is true where the condition holds."))
    keys.push_back(key);
  keys.push_back({"temperature", Kind::function, "K", optional, "Prescribed temperature, of place and time."});
  keys.push_back({"insulated", Kind::flag, "", optional, "Says that no heat passes, as where nothing is said."});
  schema.add({.path = "boundary.*",
              .sentence =
                  "A condition on a face of the cloud, or on a part of its surface by 'on' and 'where'. Heat fluxes of "
                  "several sections on one face add up; where nothing is said the wall is insulated.",
              .keys = keys});
  surface_fluxes().declare(schema);
}

}  // namespace calor
