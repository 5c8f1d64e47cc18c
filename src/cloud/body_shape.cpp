// Clouds for bodies of any shape: [cloud] shape = "surface", whose surface [[cloud.part]] gives.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "base/cache.hpp"
#include "base/function.hpp"
#include "base/parallel.hpp"
#include "cloud/body_cloud.hpp"
#include "cloud/body_spacing.hpp"
#include "cloud/cells.hpp"
#include "cloud/face_distance.hpp"
#include "cloud/given_points.hpp"
#include "cloud/shapes.hpp"
#include "cloud/symmetry.hpp"
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
    if (!name.empty())
      for (std::string& face : part.faces) face = fmt::format("{}.{}", name, face);
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
  if (parts.solids.size() < 2) return {};
  std::deque<SurfaceTree> trees;
  for (const Surface& solid : parts.solids) trees.emplace_back(solid);
  for (std::size_t q = 0; q < parts.solids.size(); ++q) {
    const Bounds box = bounds_of(parts.solids[q].vertices);
    for (std::size_t p = 0; p < parts.solids.size(); ++p) {
      if (p == q) continue;
      for (const Vec3& x : parts.solids[p].vertices) {
        bool is_near = true;
        for (int a = 0; a < parts.solids[q].dimension; ++a)
          is_near = is_near && x[a] > box.low[a] - narrow * spacing && x[a] < box.high[a] + narrow * spacing;
        if (!is_near) continue;
        const auto near = trees[q].closest(x, narrow * spacing);
        if (!near || near->distance < 1e-3 * narrow * spacing) continue;
        // Of faces flush with each other, the way between them runs along the part itself.
        const double half = 0.5 * near->distance;
        if (trees[p].closest(0.5 * (x + near->x), 0.5 * half)) continue;
        return {
            fmt::format("parts {} and {} are {:.3g} m apart at ({:.6g}, {:.6g}, {:.6g}) m, where no heat crosses: "
                        "let one of them reach into the other if they are to touch",
                        std::min(p, q) + 1, std::max(p, q) + 1, near->distance, x.x, x.y, x.z)};
      }
    }
  }
  return {};
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
      const int i = n % places, j = n / places % places, k = n / (places * places);
      const Vec3 part{(i + 0.5) / places, (j + 0.5) / places, (k + 0.5) / places};
      least = std::min(least, positive_spacing(spacing, box.low + product(part, box.high - box.low)));
    }
  }
  for (const Table& table : cloud.list("near")) least = std::min(least, table.number("spacing"));
  return least;
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

/// The planes in the middle of the body that key `symmetry` names, and what of the parts lies above all of them. The
/// rest of the parts becomes its images; refuses parts that are not so already but for the facets.
struct Symmetry {
  std::vector<MirrorPlane> planes;
  std::vector<FaceImages> faces;  ///< by plane
  std::vector<Surface> wedges;
};

MirrorPlane plane_across(const Table& cloud, const std::string& name, const PartsOfBody& parts, double alike) {
  const int axis = name == "x" ? 0 : name == "y" ? 1 : name == "z" ? 2 : 3;
  if (axis == 3) cloud.refuse("symmetry", fmt::format("'{}' is not an axis", name), "write x, y or z");
  if (axis >= parts.solids[0].dimension) cloud.refuse("symmetry", "the body has no axis z: it is 2D", "write x or y");
  std::vector<Vec3> corners;
  for (const Surface& solid : parts.solids) corners.insert(corners.end(), solid.vertices.begin(), solid.vertices.end());
  const Bounds box = bounds_of(corners);
  const MirrorPlane plane{.axis = axis, .at = 0.5 * (box.low[axis] + box.high[axis])};
  for (const Surface& solid : parts.solids) {
    const SurfaceTree tree(solid);
    for (const Vec3& x : solid.vertices)
      if (!tree.closest(plane.image(x), alike))
        cloud.refuse("symmetry",
                     fmt::format("{} not its own image in the plane {} = {:.6g} m: ({:.6g}, {:.6g}, {:.6g}) m "
                                 "lies on its surface, but the image of it does not",
                                 parts.solids.size() == 1 ? "the body is" : "a part of the body is", name, plane.at,
                                 x.x, x.y, x.z),
                     "leave the axis out");
  }
  return plane;
}

std::optional<Symmetry> make_symmetric(const Table& cloud, PartsOfBody& parts, double spacing) {
  if (!cloud.has("symmetry")) return std::nullopt;
  constexpr double alike = 0.05;  // spacings
  Symmetry out;
  for (const std::string& name : cloud.texts("symmetry")) {
    out.planes.push_back(plane_across(cloud, name, parts, alike * spacing));
    if (std::ranges::count(out.planes, out.planes.back().axis, &MirrorPlane::axis) > 1)
      cloud.refuse("symmetry", fmt::format("the axis {} comes twice", name), "leave one of them out");
  }
  for (const MirrorPlane& plane : out.planes) {
    FaceImages& images = out.faces.emplace_back();
    for (const Surface& solid : parts.solids) add_face_images(solid, plane, alike * spacing, images);
  }
  for (Surface& solid : parts.solids) {
    for (const MirrorPlane& plane : out.planes) solid = upper_half(solid, plane);
    out.wedges.push_back(solid);
    for (std::size_t n = 0; n < out.planes.size(); ++n) solid = with_image(solid, out.planes[n], out.faces[n]);
  }
  return out;
}

constexpr const char* finer = "take a smaller spacing, or finer points there by [[cloud.near]]";

MeasuredPoints made_points(MPI_Comm comm, const Body& body, const SpacingField& spacing, std::uint64_t seed,
                           Cache* cache) {
  const std::vector<Box> boxes = cover(body, spacing);
  return measured(comm, body, make_points(body, spacing, boxes, seed), boxes, finer, cache);
}

MeasuredPoints symmetric_points(MPI_Comm comm, const Body& body, const Symmetry& symmetry, const SpacingField& spacing,
                                std::uint64_t seed, Cache* cache) {
  const Body wedge(assemble(symmetry.wedges));
  // Faces by their numbers in the body; that of the cuts, which it does not have, is the last.
  std::vector<std::string> faces = body.surface().faces;
  const auto cut = static_cast<int>(faces.size());
  faces.emplace_back(cut_face);
  const auto number = [&](const std::string& name) {
    return static_cast<int>(std::ranges::find(faces, name) - faces.begin());
  };
  MeasuredPoints out = made_points(comm, wedge, spacing, seed, cache);
  for (MeasuredPoints::Piece& piece : out.pieces) piece.face = number(wedge.surface().faces[piece.face]);
  for (std::size_t n = 0; n < symmetry.planes.size(); ++n) {
    std::vector<int> image(faces.size());
    std::iota(image.begin(), image.end(), 0);
    for (const auto& [above, below] : symmetry.faces[n])
      if (std::max(number(above), number(below)) < cut) image[number(above)] = number(below);  // not inside the body
    out = with_images(out, symmetry.planes[n], cut, image);
  }
  return out;
}

MeasuredPoints given_points(MPI_Comm comm, const Body& body, const GivenPoints& given, Cache* cache) {
  PlacedPoints placed = place_given(body, given);
  MeasuredPoints out = measured(comm, body, placed.points, cover(body, spacing_of_nearest(placed.points)),
                                "leave this point out, or give it more room", cache);
  out.id = std::move(placed.id);
  return out;
}

/// Refuses what makes no points, and what has no effect on points that are given.
void check_keys(const Table& cloud) {
  const bool given = cloud.has("points");
  if (given == cloud.has("spacing"))
    cloud.refuse(given ? "spacing" : "",
                 given ? "the points are given, and have their spacing" : "the cloud says nothing of its points",
                 given ? "leave 'spacing' out, or 'points'"
                       : "add spacing = the distance of the points, or points = a file that holds them");
  if (given && !cloud.list("near").empty())
    cloud.list("near").front().refuse("", "[[cloud.near]] has no effect on points that are given", "remove it");
  if (given && cloud.has("symmetry"))
    cloud.refuse("symmetry", "'symmetry' has no effect on points that are given", "leave it out");
}

Points body_from(MPI_Comm comm, const Table& cloud) {
  check_keys(cloud);
  std::optional<GivenPoints> given;
  if (cloud.has("points")) given = read_given_points(cloud);
  const Function everywhere = given ? Function::constant(given->least) : spacing_everywhere(cloud);
  const double least = given ? given->least : least_spacing(cloud, everywhere);
  PartsOfBody parts = read_parts(cloud, least);
  const double section = section_of(cloud, parts.solids[0].dimension);
  const std::optional<Symmetry> symmetry = make_symmetric(cloud, parts, least);
  Assembly assembly = assemble(cloud, parts);
  set_distances(cloud, assembly.surface);
  located(cloud.location(given ? "points" : "spacing"), [&] { refuse_misfits(comm, assembly, least); });
  const SpacingField spacing = spacing_field(cloud, everywhere, assembly.surface);
  std::vector<std::string> notes = note_on_gaps(parts, least);
  Surface interfaces = assembly.surface;
  interfaces.facets.erase(interfaces.facets.begin(), interfaces.facets.begin() + assembly.walls);
  const auto body = std::make_shared<const Body>(std::move(assembly));
  const auto seed = static_cast<std::uint64_t>(cloud.integer("seed"));
  const std::shared_ptr<Cache> cache = cache_of(cloud);
  // All ranks make the same points and keep a part of them.
  const MeasuredPoints all = located(cloud.location(given ? "points" : "spacing"), [&] {
    return given      ? given_points(comm, *body, *given, cache.get())
           : symmetry ? symmetric_points(comm, *body, *symmetry, spacing, seed, cache.get())
                      : made_points(comm, *body, spacing, seed, cache.get());
  });
  Points out = slice_of(comm, all, body, section);
  std::ranges::move(notes, std::back_inserter(out.notes));
  if (cache) std::ranges::copy(cache->notes(), std::back_inserter(out.notes));
  add_tags(std::move(parts), std::move(interfaces), out);
  return out;
}

}  // namespace

CloudShape surface_shape() {
  return {
      .name = "surface",
      .sentence =
          "A body of any shape, given by [[cloud.part]]: files of its surface, or shapes. Points lie on its corners, "
          "edges and faces and, on a lattice or at random, inside. Faces: those of the parts",
      .keys =
          {{"spacing", Kind::function, "m", optional, "Distance of the points; a formula in x, y, z or a number. Or"},
           {"points", Kind::text, "", optional,
            "a CSV file with columns x [m], y [m] and in space z [m]: points on the walls and inside, whose volumes "
            "and areas calor computes."},
           {"symmetry", Kind::texts, "", optional,
            "Axis, or list of axes, across which the body is its own mirror image: the points are made so, to the last "
            "digit."},
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
