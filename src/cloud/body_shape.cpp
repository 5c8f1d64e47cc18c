// Clouds for bodies of any shape: [cloud] shape = "surface", whose surface [[cloud.part]] gives.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/body_measures.hpp"
#include "cloud/body_points.hpp"
#include "cloud/cells.hpp"
#include "cloud/shapes.hpp"
#include "surface/part_keys.hpp"
#include "surface/polygon.hpp"
#include "surface/solid_shapes.hpp"

namespace calor {
namespace {

/// Adds the facets of a part to the body; its faces are called as they are, or "PART.FACE" where the part has a name.
void append(const Surface& part, const std::string& name, Surface& body) {
  const int first = static_cast<int>(body.vertices.size());
  body.vertices.insert(body.vertices.end(), part.vertices.begin(), part.vertices.end());
  std::vector<int> face;
  for (const std::string& f : part.faces) {
    const std::string full = name.empty() ? f : name + "." + f;
    const auto found = std::ranges::find(body.faces, full);
    face.push_back(static_cast<int>(found - body.faces.begin()));
    if (found == body.faces.end()) body.faces.push_back(full);
  }
  for (Surface::Triangle facet : part.facets) {
    for (int n = 0; n < part.dimension; ++n) facet.vertex[n] += first;
    facet.face = face[facet.face];
    body.facets.push_back(facet);
  }
}

/// How long facets on curved faces may be, in spacings: they stay within 1.5 thousandths of a spacing of faces that
/// curve with a radius of ten spacings.
constexpr double chord = 0.35;

/// Refuses parts that touch or overlap, as far as corners of one tell: they would be counted twice.
void refuse_overlaps(const std::vector<Table>& tables, const std::vector<Surface>& parts) {
  constexpr double touching = 1e-9, inside = 0.6;  // of the size of a part; winding number
  constexpr std::size_t most = 2000;               // corners that are looked at
  for (std::size_t q = 0; q < parts.size(); ++q) {
    const SurfaceTree tree(parts[q]);
    const Bounds box = bounds_of(parts[q].vertices);
    const double size = norm(box.high - box.low);
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const auto& corners = parts[p].vertices;
      for (std::size_t n = 0; p != q && n < corners.size(); n += 1 + corners.size() / most) {
        const Vec3& x = corners[n];
        bool is_near = true;
        for (int a = 0; a < parts[q].dimension; ++a)
          is_near = is_near && x[a] > box.low[a] - touching * size && x[a] < box.high[a] + touching * size;
        if (!is_near || (!tree.closest(x, touching * size) && tree.winding_number(x) < inside)) continue;
        tables[std::max(p, q)].refuse("",
                                      fmt::format("parts {} and {} touch or overlap at ({:.6g}, {:.6g}, {:.6g}) m",
                                                  std::min(p, q) + 1, std::max(p, q) + 1, x.x, x.y, x.z),
                                      "leave a gap between them, or describe what hangs together by one surface");
      }
    }
  }
}

Surface read_surface(const Table& cloud, double least_spacing) {
  const std::vector<Table> parts = cloud.list("part");
  if (parts.empty())
    cloud.refuse("", "shape = \"surface\" needs to know the body", "add [[cloud.part]] with a file or a shape");
  Surface body;
  std::vector<Surface> surfaces;
  for (const Table& table : parts) {
    const Surface& part =
        surfaces.emplace_back(place(solid_shapes().chosen(table, "shape").make(table, chord * least_spacing), table));
    if (body.facets.empty()) body.dimension = part.dimension;
    if (part.dimension != body.dimension)
      table.refuse("shape", fmt::format("a part of {} dimensions in a body of {}", part.dimension, body.dimension),
                   "give all parts the same");
    append(part, table.has("name") ? table.text("name") : "", body);
  }
  if (parts.size() > 1) refuse_overlaps(parts, surfaces);
  if (body.faces.size() > 32)
    cloud.refuse("part", fmt::format("the body has {} faces, more than 32", body.faces.size()),
                 "give several the same name");
  return body;
}

/// A finer spacing on a face or at a place, which grows away from it.
struct Refinement {
  double spacing, growth;
  Vec3 at;  ///< or
  std::shared_ptr<const Surface> face = {};
  std::shared_ptr<const SurfaceTree> tree = {};

  /// Distance from it, m, if it is below `bound`.
  std::optional<double> distance(const Vec3& x, double bound) const {
    if (!tree) return norm(x - at) < bound ? std::optional(norm(x - at)) : std::nullopt;
    const auto near = tree->closest(x, bound);
    return near ? std::optional(near->distance) : std::nullopt;
  }
};

void find_face(const Table& table, const Surface& body, Refinement& out) {
  const auto face = std::ranges::find(body.faces, table.text("face"));
  if (face == body.faces.end())
    table.refuse("face", fmt::format("'{}' is not a face of the body", table.text("face")),
                 fmt::format("its faces are {}", fmt::join(body.faces, ", ")));
  auto only = std::make_shared<Surface>(body);
  std::erase_if(only->facets, [&](const Surface::Triangle& f) { return f.face != face - body.faces.begin(); });
  out.tree = std::make_shared<SurfaceTree>(*only);
  out.face = std::move(only);
}

std::vector<Refinement> read_refinements(const Table& cloud, const Surface& body) {
  std::vector<Refinement> out;
  for (const Table& table : cloud.list("near")) {
    if (!(table.number("spacing") > 0))
      table.refuse("spacing", fmt::format("a spacing of {} m is not positive", table.number("spacing")),
                   "give a positive one");
    const double growth = table.number("growth");
    if (!(growth > 0 && growth <= 1))
      table.refuse("growth", fmt::format("growth = {:g}", growth), "give more than 0 and at most 1: 0.2 suits most");
    if (table.has("face") == table.has("at"))
      table.refuse("", "finer points need to know near what", "give either face = \"...\" or at = [...]");
    Refinement& refined = out.emplace_back(table.number("spacing"), growth);
    if (table.has("face")) {
      find_face(table, body, refined);
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

double least_spacing(const Table& cloud) {
  const double spacing = cloud.number("spacing");
  if (!(spacing > 0))
    cloud.refuse("spacing", fmt::format("a spacing of {} m is not positive", spacing), "give a positive one");
  double least = spacing;
  for (const Table& table : cloud.list("near")) least = std::min(least, table.number("spacing"));
  return least;
}

SpacingField spacing_field(const Table& cloud, const Surface& body) {
  const double spacing = cloud.number("spacing");
  std::vector<Refinement> refined = read_refinements(cloud, body);
  if (refined.empty()) return {.at = [spacing](const Vec3&) { return spacing; }, .is_uniform = true};
  return {.at =
              [spacing, refined = std::move(refined)](const Vec3& x) {
                double least = spacing;
                for (const Refinement& r : refined) {
                  const auto distance = r.distance(x, std::max(0.0, (least - r.spacing) / r.growth));
                  if (distance) least = std::min(least, r.spacing + r.growth * *distance);
                }
                return least;
              },
          .is_uniform = false};
}

/// Refuses spacings that do not fit the body, before points are made.
void refuse_misfits(MPI_Comm comm, const Surface& surface, double spacing) {
  const Bounds bounds = bounds_of(surface.vertices);
  const double volume = std::abs(enclosed_volume(surface));
  if (!(volume > 0))
    throw Error(Fault::bad_case, "the surface encloses no volume", "give it facets on all sides of the body");
  const double size = norm(bounds.high - bounds.low);
  if (spacing > 0.5 * size)
    throw Error(Fault::bad_case,
                fmt::format("a spacing of {:.6g} m is too large for a body that is {:.6g} m long", spacing, size),
                "take a smaller one");
  refuse_too_many(comm, volume / std::pow(spacing, surface.dimension));
}

Points body_from(MPI_Comm comm, const Table& cloud) {
  const double least = least_spacing(cloud);
  Surface surface = read_surface(cloud, least);
  const double section = section_of(cloud, surface.dimension);
  located(cloud.location("spacing"), [&] { refuse_misfits(comm, surface, least); });
  const SpacingField spacing = spacing_field(cloud, surface);
  return make_body(comm, std::move(surface), spacing, static_cast<std::uint64_t>(cloud.integer("seed")), section);
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
    if (points.on[i].size() != 1) continue;
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

Points make_body(MPI_Comm comm, Surface surface, const SpacingField& spacing, std::uint64_t seed, double section) {
  const int D = surface.dimension;
  const auto body = std::make_shared<const Body>(std::move(surface));
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
  for (std::size_t f = 0; f < body->features().patch.size(); ++f)
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
      .keys = {{"spacing", Kind::quantity, "m", required, "Distance of the points."},
               {"seed", Kind::integer, "", "1", "Chooses the points that are placed at random."}},
      .make = body_from};
}

void declare_surface(Schema& schema) {
  std::vector<Key> keys = placing_keys();
  keys.insert(keys.begin(), {{"shape", Kind::choice, "", "file", "What it is.", solid_shapes().names()},
                             {"name", Kind::text, "", optional, "Comes before the names of its faces: NAME.FACE."}});
  schema.add({.path = "cloud.part[]", .sentence = "A part of a body of shape = \"surface\".", .keys = keys});
  for (const SolidShape& shape : solid_shapes())
    schema.add({.path = "cloud.part[]",
                .sentence = shape.sentence + ".",
                .keys = shape.keys,
                .when_key = "shape",
                .when_value = shape.name});
  declare_holes(schema);
  schema.add({.path = "cloud.near[]",
              .sentence = "Finer points near a face or a place of a body of shape = \"surface\".",
              .keys = {{"face", Kind::text, "", optional, "Name of the face; or"},
                       {"at", Kind::quantities, "m", optional, "the place, one coordinate an axis."},
                       {"spacing", Kind::quantity, "m", required, "Distance of the points there."},
                       {"growth", Kind::number, "", "0.2",
                        "What the spacing grows by over the distance from there; above 0, at most 1."}}});
}

}  // namespace calor
