#include "surface/polygon.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "surface/plane.hpp"

namespace calor {
namespace {

/// Reads one polygon after the other into an outline.
class Reader {
 public:
  Reader(std::string axes, std::vector<std::string> taken) : axes_(std::move(axes)), taken_(std::move(taken)) {}

  /// The polygon of the table; its sides are on `face`, or on side1, side2 ... where it is empty, unless they have
  /// names.
  void add(const Table& table, const std::string& face) {
    Contour contour{.corner = corners(table), .face = {}};
    refuse_crossings(table, contour.corner);
    const std::vector<std::string> names = names_of(table, contour.corner.size(), face);
    for (std::size_t n = 0; n < names.size(); ++n) {
      const std::size_t next = (n + 1) % names.size();
      const bool is_axis = axes_ == "rz" && contour.corner[n].x == 0 && contour.corner[next].x == 0;
      contour.face.push_back(is_axis ? -1 : face_of(names[n]));
    }
    const bool is_hole = !outline_.contours.empty();
    if (is_hole) refuse_place(table, contour.corner);
    const bool is_clockwise = polygon_area(contour.corner) < 0;
    outline_.contours.push_back(is_clockwise == is_hole ? std::move(contour) : reversed(std::move(contour)));
  }

  Outline outline() && { return std::move(outline_); }

 private:
  std::vector<Vec3> corners(const Table& table) const {
    const std::string first = axes_.substr(0, 1), second = axes_.substr(1);
    for (const std::string& key : {first, second})
      if (!table.has(key))
        table.refuse("", "a polygon without " + key, "give the coordinates of its corners: one list for every axis");
    const std::vector<double> x = table.numbers(first), y = table.numbers(second);
    if (x.size() != y.size())
      table.refuse(second, fmt::format("{} coordinates for {} corners", y.size(), x.size()),
                   "give every corner one along every axis");
    if (x.size() < 3)
      table.refuse(first, fmt::format("{} corner{}", x.size(), x.size() == 1 ? "" : "s"), "give at least 3");
    std::vector<Vec3> out;
    for (std::size_t n = 0; n < x.size(); ++n) {
      if (axes_ == "rz" && x[n] < 0)
        table.refuse(first, fmt::format("corner {} has r = {:g} m, beyond the axis", n + 1, x[n]), "give 0 or more");
      out.push_back({x[n], y[n], 0});
    }
    return out;
  }

  void refuse_crossings(const Table& table, const std::vector<Vec3>& corner) const {
    const std::string key = axes_.substr(0, 1);
    const std::size_t count = corner.size();
    const auto at = [&](std::size_t n) { return corner[n % count]; };
    for (std::size_t n = 0; n < count; ++n)
      if (at(n) == at(n + 1))
        table.refuse(key, fmt::format("corners {} and {} coincide", n + 1, (n + 1) % count + 1),
                     "give each corner once: the last side closes the polygon by itself");
    for (std::size_t n = 0; n < count; ++n) {
      if (orientation(at(n), at(n + 1), at(n + 2)) == 0 && dot(at(n + 1) - at(n), at(n + 2) - at(n + 1)) < 0)
        table.refuse(key, fmt::format("the polygon turns back on itself in corner {}", (n + 1) % count + 1),
                     "give the corners in the order in which they follow each other around the polygon");
      for (std::size_t m = n + 2; m < count; ++m)
        if ((m + 1) % count != n && segments_meet(at(n), at(n + 1), at(m), at(m + 1)))
          table.refuse(key, fmt::format("sides {} and {} cross or touch", n + 1, m + 1),
                       "give the corners in the order in which they follow each other around the polygon");
    }
  }

  /// A hole lies inside the polygon and outside other holes.
  void refuse_place(const Table& table, const std::vector<Vec3>& hole) const {
    const std::string key = axes_.substr(0, 1);
    const auto meets = [&](const std::vector<Vec3>& other) {
      for (std::size_t n = 0; n < hole.size(); ++n)
        for (std::size_t m = 0; m < other.size(); ++m)
          if (segments_meet(hole[n], hole[(n + 1) % hole.size()], other[m], other[(m + 1) % other.size()])) return true;
      return false;
    };
    for (std::size_t n = 0; n < outline_.contours.size(); ++n) {
      const std::vector<Vec3>& other = outline_.contours[n].corner;
      const std::string name = n == 0 ? "the polygon" : fmt::format("hole {}", n);
      if (meets(other))
        table.refuse(key, "the hole crosses or touches a side of " + name,
                     "leave material between them, or cut the "
                     "hole out of the polygon's own corners");
      if (n == 0 && !is_inside(other, hole.front()))
        table.refuse(key, "the hole lies outside the polygon", "move it inside");
      if (n > 0 && (is_inside(other, hole.front()) || is_inside(hole, other.front())))
        table.refuse(key, fmt::format("the hole and {} lie in each other", name), "keep the larger one");
    }
  }

  std::vector<std::string> names_of(const Table& table, std::size_t sides, const std::string& face) const {
    if (!table.has("names")) {
      std::vector<std::string> names(sides, face);
      for (std::size_t n = 0; face.empty() && n < sides; ++n) names[n] = fmt::format("side{}", n + 1);
      return names;
    }
    std::vector<std::string> names = table.texts("names");
    if (names.size() == 1) names.resize(sides, names.front());
    if (names.size() != sides)
      table.refuse("names", fmt::format("{} names for {} sides", names.size(), sides),
                   "give one a side, or one for all");
    for (const std::string& name : names)
      if (name.empty() || std::ranges::count(taken_, name))
        table.refuse("names", name.empty() ? "an empty name" : fmt::format("\"{}\" is the name of another face", name),
                     "choose another name");
    return names;
  }

  int face_of(const std::string& name) {
    const auto found = std::ranges::find(outline_.faces, name);
    const auto face = static_cast<int>(found - outline_.faces.begin());
    if (found == outline_.faces.end()) outline_.faces.push_back(name);
    return face;
  }

  std::string axes_;
  std::vector<std::string> taken_;
  Outline outline_;
};

}  // namespace

std::vector<Key> polygon_keys(const std::string& axes) {
  const std::string first = axes.substr(0, 1), second = axes.substr(1);
  return {
      {first, Kind::quantities, "m", required,
       axes == "rz" ? "Distances of the corners from the z axis, in the order in which they follow each other; 0 is "
                      "on the axis."
                    : "Coordinates of the corners along x, in the order in which they follow each other."},
      {second, Kind::quantities, "m", required, fmt::format("The same along {}.", second)},
      {"names", Kind::texts, "", optional,
       "Names of the sides in place of side1, side2 ...: the first one lies between the first and the second corner. "
       "Sides of one name are one face; a single name is that of all."},
      {"hole", Kind::table, "", optional, "Holes: further polygons, each a [[cloud.part.hole]]."}};
}

Outline polygon_from(const Table& part, const std::string& axes, const std::vector<std::string>& taken) {
  Reader reader(axes, taken);
  reader.add(part, "");
  int holes = 0;
  for (const Table& hole : part.list("hole")) reader.add(hole, fmt::format("hole{}", ++holes));
  return std::move(reader).outline();
}

void declare_holes(Schema& schema) {
  schema.add({.path = "cloud.part[].hole[]",
              .sentence = "A hole of a polygon, extrusion or revolution; its sides are the face hole1, hole2 ...",
              .keys = {{"x", Kind::quantities, "m", optional, "As for the polygon around it."},
                       {"y", Kind::quantities, "m", optional, "The same along y."},
                       {"r", Kind::quantities, "m", optional, "As for the polygon around it, of a revolution."},
                       {"z", Kind::quantities, "m", optional, "The same along z."},
                       {"names", Kind::texts, "", optional, "Names of its sides, or one of all of them."}}});
}

}  // namespace calor
