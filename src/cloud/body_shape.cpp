// Clouds for bodies of any shape: [cloud] shape = "surface", whose surface [[cloud.part]] gives.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "base/function.hpp"
#include "base/parallel.hpp"
#include "cloud/body_measures.hpp"
#include "cloud/body_points.hpp"
#include "cloud/cells.hpp"
#include "cloud/face_distance.hpp"
#include "cloud/shapes.hpp"
#include "surface/part_keys.hpp"
#include "surface/polygon.hpp"
#include "surface/solid_shapes.hpp"
#include "surface/solids.hpp"

namespace calor {
namespace {

/// How long facets on curved faces may be, in spacings: they stay within 1.5 thousandths of a spacing of faces that
/// curve with a radius of ten spacings.
constexpr double chord = 0.35;

/// The parts of a body: no two have a place in common.
struct PartsOfBody {
  std::vector<Surface> solids;
  std::vector<std::string> names;  ///< of every one, "" without
  std::vector<Table> tables;
};

/// Takes the space of a new part from those before it, or leaves them what they share with it.
void combine(PartsOfBody& parts, const Surface& part, const std::string& how, const Table& table) {
  if (how != "part" && parts.solids.empty())
    table.refuse("combine", "there is no part before this one", "begin with the part that it cuts");
  for (std::size_t n = 0; n < parts.solids.size(); ++n) {
    parts.solids[n] = how == "common" ? intersection(parts.solids[n], part) : difference(parts.solids[n], part);
    if (parts.solids[n].facets.empty())
      table.refuse(table.has("combine") ? "combine" : "", fmt::format("nothing is left of part {}", n + 1),
                   how == "common" ? "let them overlap" : "make this part smaller, or leave that one out");
  }
}

PartsOfBody read_parts(const Table& cloud, double least_spacing) {
  const std::vector<Table> tables = cloud.list("part");
  if (tables.empty())
    cloud.refuse("", "shape = \"surface\" needs to know the body", "add [[cloud.part]] with a file or a shape");
  PartsOfBody parts;
  for (const Table& table : tables) {
    Surface part = place(solid_shapes().chosen(table, "shape").make(table, chord * least_spacing), table);
    if (!parts.solids.empty() && part.dimension != parts.solids[0].dimension)
      table.refuse("shape",
                   fmt::format("a part of {} dimensions in a body of {}", part.dimension, parts.solids[0].dimension),
                   "give all parts the same");
    const std::string name = table.has("name") ? table.text("name") : "", how = table.text("combine");
    for (std::string& face : part.faces) face = name.empty() ? face : name + "." + face;
    combine(parts, part, how, table);
    if (how != "part") continue;
    parts.solids.push_back(std::move(part));
    parts.names.push_back(name);
    parts.tables.push_back(table);
  }
  return parts;
}

/// The body that the parts make together.
Assembly assemble(const Table& cloud, const PartsOfBody& parts) {
  Assembly body = assemble(parts.solids);
  if (parts.solids.size() > 1) {
    Surface walls = body.surface;
    walls.facets.resize(body.walls);
    try {
      require_closed(walls, {});
    } catch (const Error& e) {
      parts.tables.back().refuse("", "the parts do not make one body: " + e.problem(),
                                 "parts may touch by their faces or overlap, but not in an edge or corner alone");
    }
  }
  if (body.surface.faces.size() > 32)
    cloud.refuse("part", fmt::format("the body has {} faces, more than 32", body.surface.faces.size()),
                 "give several the same name");
  return body;
}

/// Says where parts nearly touch: a gap that facets on curved faces, or a rounded length, leave.
std::vector<std::string> note_on_gaps(const PartsOfBody& parts, double spacing) {
  constexpr double narrow = 0.05;  // of the spacing
  std::vector<std::string> notes;
  for (std::size_t q = 0; q < parts.solids.size() && parts.solids.size() > 1; ++q) {
    const SurfaceTree tree(parts.solids[q]);
    const Bounds box = bounds_of(parts.solids[q].vertices);
    for (std::size_t p = 0; p < parts.solids.size(); ++p) {
      if (p == q) continue;
      for (const Vec3& x : parts.solids[p].vertices) {
        bool is_near = true;
        for (int a = 0; a < parts.solids[q].dimension; ++a)
          is_near = is_near && x[a] > box.low[a] - narrow * spacing && x[a] < box.high[a] + narrow * spacing;
        if (!is_near) continue;
        const auto near = tree.closest(x, narrow * spacing);
        if (!near || near->distance < 1e-3 * narrow * spacing) continue;
        notes.push_back(
            fmt::format("parts {} and {} are {:.3g} m apart at ({:.6g}, {:.6g}, {:.6g}) m, where no heat crosses: let "
                        "one of them reach into the other if they are to touch",
                        std::min(p, q) + 1, std::max(p, q) + 1, near->distance, x.x, x.y, x.z));
        return notes;
      }
    }
  }
  return notes;
}

/// A finer spacing on a face or at a place, which grows away from it.
struct Refinement {
  double spacing, growth;
  Vec3 at;  ///< or
  std::shared_ptr<const FaceDistance> face = {};

  /// Distance from it, m, if it is below `bound`.
  std::optional<double> distance(const Vec3& x, double bound) const {
    if (face) return face->within(x, bound);
    return norm(x - at) < bound ? std::optional(norm(x - at)) : std::nullopt;
  }
};

std::vector<Refinement> read_refinements(const Table& cloud, const Surface& body) {
  std::vector<Refinement> out;
  for (const Table& table : cloud.list("near")) {
    if (!(table.number("spacing") > 0))
      table.refuse("spacing", fmt::format("a spacing of {} m is not positive", table.number("spacing")),
                   "give a positive one");
    const Function everywhere = cloud.function("spacing");
    if (everywhere.is_constant() && !(table.number("spacing") < everywhere({})))
      table.refuse("spacing",
                   fmt::format("a spacing of {:.6g} m here is not below that of the cloud, {:.6g} m",
                               table.number("spacing"), everywhere({})),
                   "give a finer one, or a coarser one to [cloud]");
    const double growth = table.number("growth");
    if (!(growth > 0 && growth <= 1))
      table.refuse("growth", fmt::format("growth = {:g}", growth), "give more than 0 and at most 1: 0.2 suits most");
    if (table.has("face") == table.has("at"))
      table.refuse("", "finer points need to know near what", "give either face = \"...\" or at = [...]");
    Refinement& refined = out.emplace_back(table.number("spacing"), growth);
    if (table.has("face")) {
      refined.face = std::make_shared<const FaceDistance>(body, table, "face");
      continue;
    }
    const std::vector<double> at = table.numbers("at");
    if (static_cast<int>(at.size()) != body.dimension)
      table.refuse("at", fmt::format("a place of {} coordinates in a body of {} dimensions", at.size(), body.dimension),
                   "give one coordinate an axis");
    for (int a = 0; a < body.dimension; ++a) refined.at[a] = at[a];
  }
  return out;
}

double positive_spacing(const Function& spacing, const Vec3& x) {
  const double d = spacing(x);
  if (!(d > 0))
    throw Error(Fault::bad_case, spacing.location(),
                spacing.is_constant()
                    ? fmt::format("a spacing of {} m is not positive", d)
                    : fmt::format("a spacing of {} m at ({:.6g}, {:.6g}, {:.6g}) m is not positive", d, x.x, x.y, x.z),
                "give a positive one");
  return d;
}

/// The spacing that the case gives everywhere, by place.
Function spacing_everywhere(const Table& cloud) {
  Function spacing = cloud.function("spacing");
  if (spacing.depends_on_time() || spacing.depends_on_temperature())
    cloud.refuse("spacing", "the spacing depends on time or temperature", "points stay where they are: use x, y, z");
  return spacing;
}

/// The finest spacing that the case asks for, as far as places all over the box around the body tell.
double least_spacing(const Table& cloud, const Function& spacing) {
  double least = std::numeric_limits<double>::max();
  if (spacing.is_constant()) {
    least = positive_spacing(spacing, {});
  } else {
    constexpr double coarse = 1e9;  // m: facets as large as they come
    constexpr int places = 32;      // along every axis
    const PartsOfBody parts = read_parts(cloud, coarse);
    if (cloud.has("distance")) set_distances(cloud, assemble(cloud, parts).surface);
    std::vector<Vec3> corners;
    for (const Surface& solid : parts.solids)
      corners.insert(corners.end(), solid.vertices.begin(), solid.vertices.end());
    const Bounds box = bounds_of(corners);
    for (int n = 0; n < places * places * places; ++n) {
      const Vec3 part{(n % places + 0.5) / places, (n / places % places + 0.5) / places,
                      (n / (places * places) + 0.5) / places};
      least = std::min(least, positive_spacing(spacing, box.low + product(part, box.high - box.low)));
    }
  }
  for (const Table& table : cloud.list("near")) least = std::min(least, table.number("spacing"));
  return least;
}

SpacingField spacing_field(const Table& cloud, const Function& spacing, const Surface& body) {
  std::vector<Refinement> refined = read_refinements(cloud, body);
  if (spacing.is_constant() && refined.empty())
    return {.at = [d = spacing({})](const Vec3&) { return d; }, .is_uniform = true};
  return {.at =
              [spacing, refined = std::move(refined)](const Vec3& x) {
                double least = positive_spacing(spacing, x);
                for (const Refinement& r : refined) {
                  const auto distance = r.distance(x, std::max(0.0, (least - r.spacing) / r.growth));
                  if (distance) least = std::min(least, r.spacing + r.growth * *distance);
                }
                return least;
              },
          .is_uniform = false};
}

/// Refuses spacings that do not fit the body, before points are made.
void refuse_misfits(MPI_Comm comm, const Assembly& body, double spacing) {
  Surface walls = body.surface;
  walls.facets.resize(body.walls);
  const Bounds bounds = bounds_of(walls.vertices);
  const double volume = std::abs(enclosed_volume(walls));
  if (!(volume > 0))
    throw Error(Fault::bad_case, "the surface encloses no volume", "give it facets on all sides of the body");
  const double size = norm(bounds.high - bounds.low);
  if (spacing > 0.5 * size)
    throw Error(Fault::bad_case,
                fmt::format("a spacing of {:.6g} m is too large for a body that is {:.6g} m long", spacing, size),
                "take a smaller one");
  refuse_too_many(comm, volume / std::pow(spacing, walls.dimension));
}

/// Every point gets the tag of its part.
void add_tags(PartsOfBody parts, Surface interfaces, Points& out) {
  out.tags.clear();
  std::vector<int> tags;
  for (const std::string& name : parts.names) {
    const auto found = std::ranges::find(out.tags, name);
    tags.push_back(static_cast<int>(found - out.tags.begin()));
    if (found == out.tags.end()) out.tags.push_back(name);
  }
  out.solids = std::make_shared<const Solids>(std::move(parts.solids), std::move(tags), std::move(interfaces));
  for (Point& p : out.points)
    p.tag = std::max(0, out.solids->tag_at(out.body->moved_inside(p.x, Body::skin * p.spacing)));
}

Points body_from(MPI_Comm comm, const Table& cloud) {
  const Function everywhere = spacing_everywhere(cloud);
  const double least = least_spacing(cloud, everywhere);
  PartsOfBody parts = read_parts(cloud, least);
  const double section = section_of(cloud, parts.solids[0].dimension);
  Assembly body = assemble(cloud, parts);
  set_distances(cloud, body.surface);
  located(cloud.location("spacing"), [&] { refuse_misfits(comm, body, least); });
  const SpacingField spacing = spacing_field(cloud, everywhere, body.surface);
  std::vector<std::string> notes = note_on_gaps(parts, least);
  Surface interfaces = body.surface;
  interfaces.facets.erase(interfaces.facets.begin(), interfaces.facets.begin() + body.walls);
  Points out = make_body(comm, std::move(body), spacing, static_cast<std::uint64_t>(cloud.integer("seed")), section);
  std::ranges::move(notes, std::back_inserter(out.notes));
  add_tags(std::move(parts), std::move(interfaces), out);
  return out;
}

/// Refuses a point that has nothing of the body.
[[noreturn]] void refuse_thin(const BodyPoints& points, int i) {
  const Vec3& x = points.grid.x(i);
  const double d = points.grid.spacing(i);
  throw Error(
      Fault::bad_case,
      fmt::format("the body is too thin or too sharp at ({:.6g}, {:.6g}, {:.6g}) m for points {:.6g} m apart, or "
                  "parts of it touch there",
                  x.x, x.y, x.z, d),
      "take a smaller spacing, or finer points there by [[cloud.near]]");
}

/// Says where the body is thinner than two spacings. Near edges it is so everywhere.
std::vector<std::string> note_on_thin_walls(const Body& body, const BodyPoints& points) {
  constexpr double thin = 2, near_edges = 0.02;
  int count = 0;
  Vec3 place;
  for (int i = 0; i < points.on_surface(); ++i) {
    if (points.on[i].size() != 1 || !body.is_wall(points.on[i][0].patch)) continue;
    const Vec3& x = points.grid.x(i);
    const double d = points.grid.spacing(i);
    if (body.sees(body.moved_inside(x, Body::skin * d), x - thin * d * points.on[i][0].normal)) continue;
    if (count++ == 0) place = x;
  }
  if (count <= near_edges * points.on_surface()) return {};
  return {
      fmt::format("at {} of {} points of the surface the body is thinner than two spacings, first at ({:.6g}, {:.6g}, "
                  "{:.6g}) m: heat crosses it on fewer than three points",
                  count, points.on_surface(), place.x, place.y, place.z)};
}

}  // namespace

Points make_body(MPI_Comm comm, Assembly assembly, const SpacingField& spacing, std::uint64_t seed, double section) {
  const int D = assembly.surface.dimension;
  const auto body = std::make_shared<const Body>(std::move(assembly));
  // All ranks make the same points and keep a part of them.
  const std::vector<Box> boxes = cover(*body, spacing);
  const BodyPoints points = make_points(*body, spacing, boxes, seed);
  const std::vector<double> volume = body_volumes(*body, points, boxes);
  for (int i = 0; i < points.grid.count(); ++i)
    if (!(volume[i] > 0)) refuse_thin(points, i);
  const std::vector<PatchShare> shares = body_areas(*body, points);

  Points out;
  out.dimension = D;
  out.section = section;
  out.faces = body->surface().faces;
  out.exact.volume = section * enclosed_volume(body->surface());
  out.body = body;
  out.notes = note_on_thin_walls(*body, points);
  std::vector<int> face(body->features().count);
  for (std::size_t f = 0; f < body->surface().facets.size(); ++f)
    face[body->features().patch[f]] = body->surface().facets[f].face;
  const Slice mine = slice(comm, points.grid.count());
  auto share = std::ranges::lower_bound(shares, mine.begin, {}, &PatchShare::point);
  for (std::int64_t id = mine.begin; id < mine.end; ++id) {
    const int i = static_cast<int>(id);
    const double d = points.grid.spacing(i);
    out.points.push_back({.id = id,
                          .x = points.grid.x(i),
                          .volume = section * volume[i],
                          .full_volume = section * std::pow(d, D),
                          .spacing = d});
    for (; share != shares.end() && share->point == i; ++share)
      out.add_patch(face[share->patch], section * share->area, (1 / norm(share->vector)) * share->vector,
                    section * share->vector);
  }
  return out;
}

CloudShape surface_shape() {
  return {
      .name = "surface",
      .sentence =
          "A body of any shape, given by [[cloud.part]]: files of its surface, or shapes. Points lie on its corners, "
          "edges and faces and, on a lattice or at random, inside. Faces: those of the parts",
      .keys = {{"spacing", Kind::function, "m", required, "Distance of the points; a formula in x, y, z or a number."},
               {"seed", Kind::integer, "", "1", "Chooses the points that are placed at random."}},
      .make = body_from};
}

void declare_surface(Schema& schema) {
  std::vector<Key> keys = placing_keys();
  keys.insert(keys.begin(),
              {{"shape", Kind::choice, "", "file", "What it is.", solid_shapes().names()},
               {"name", Kind::text, "", optional,
                "Comes before the names of its faces, NAME.FACE, and is the tag of what it holds."},
               {"combine",
                Kind::choice,
                "",
                "part",
                "What it does to the parts before it. part: takes its space from them, and touches them there. cut: "
                "leaves a hole in them. common: leaves of them what they share with it.",
                {"part", "cut", "common"}}});
  schema.add({.path = "cloud.part[]", .sentence = "A part of a body of shape = \"surface\".", .keys = keys});
  for (const SolidShape& shape : solid_shapes())
    schema.add({.path = "cloud.part[]",
                .sentence = shape.sentence + ".",
                .keys = shape.keys,
                .when_key = "shape",
                .when_value = shape.name});
  declare_holes(schema);
  declare_distances(schema);
  schema.add({.path = "cloud.near[]",
              .sentence = "Finer points near a face or a place of a body of shape = \"surface\".",
              .keys = {{"face", Kind::text, "", optional, "Name of the face; or"},
                       {"at", Kind::quantities, "m", optional, "the place, one coordinate an axis."},
                       {"spacing", Kind::quantity, "m", required, "Distance of the points there."},
                       {"growth", Kind::number, "", "0.2",
                        "What the spacing grows by over the distance from there; above 0, at most 1."}}});
}

}  // namespace calor
