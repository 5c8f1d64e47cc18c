#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

#include "base/units.hpp"
#include "surface/solid_shapes.hpp"
#include "surface/surface_files.hpp"

namespace calor {
namespace {

constexpr std::size_t most_faces = 32;  // bits of Point::on_faces

bool ends_with(std::string name, const std::string& ending) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.ends_with(ending);
}

bool is_step(const std::string& file) { return ends_with(file, ".step") || ends_with(file, ".stp"); }
bool is_brep(const std::string& file) { return ends_with(file, ".brep"); }

/// Length of one unit of the file, m: "mm" or "25.4 mm".
double unit_of(const Table& part) {
  const std::string cure = "write unit = \"mm\", or what one unit of the file is";
  if (!part.has("unit"))
    part.refuse("", fmt::format("the file \"{}\" does not tell its unit of length", part.text("file")), cure);
  const std::string text = part.text("unit");
  double unit = 0;
  try {
    const bool has_number = text.find_first_of("+-.0123456789") == 0;
    const NumberWithUnit written = has_number ? split_quantity(text) : NumberWithUnit{1, text};
    unit = to_si(written.value, written.unit, "m");
  } catch (const std::invalid_argument& e) {
    part.refuse("unit", fmt::format("\"{}\" is no unit of length: {}", text, e.what()), cure);
  }
  if (!(unit > 0)) part.refuse("unit", fmt::format("\"{}\" is not positive", text), cure);
  return unit;
}

double diagonal(const Surface& surface) {
  Vec3 low = surface.vertices.front(), high = low;
  for (const auto& facet : surface.facets)
    for (const std::int32_t vertex : facet.vertex)
      for (int a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], surface.vertices[vertex][a]);
        high[a] = std::max(high[a], surface.vertices[vertex][a]);
      }
  return norm(high - low);
}

/// The facets of one solid of an STL or OBJ file.
void keep_solid(Surface& surface, const Table& part) {
  const auto face = std::ranges::find(surface.faces, part.text("solid"));
  if (face == surface.faces.end())
    part.refuse("solid", fmt::format("the file \"{}\" has no solid '{}'", part.text("file"), part.text("solid")),
                fmt::format("its solids are {}", fmt::join(surface.faces, ", ")));
  std::erase_if(surface.facets, [&](const Surface::Triangle& f) { return f.face != face - surface.faces.begin(); });
  for (Surface::Triangle& f : surface.facets) f.face = 0;
  surface.faces = {*face};
}

/// The solid of a drawing that the part means.
Surface solid_of_drawing(const Table& part, double chord) {
  std::vector<Surface> solids = read_drawing(part.file("file"), part.location("file"), chord);
  if (!part.has("solid")) {
    if (solids.size() == 1) return std::move(solids[0]);
    part.refuse("", fmt::format("the file \"{}\" holds {} solids", part.text("file"), solids.size()),
                "add solid = \"1\" to this part, and a part for each of the others");
  }
  for (std::size_t n = 0; n < solids.size(); ++n)
    if (part.text("solid") == std::to_string(n + 1)) return std::move(solids[n]);
  part.refuse("solid", fmt::format("the file \"{}\" has no solid '{}'", part.text("file"), part.text("solid")),
              fmt::format("they are numbered from 1 to {}", solids.size()));
}

Surface facets_of(const Table& part, double chord) {
  const std::string file = part.text("file");
  if (is_step(file)) {
    if (part.has("unit")) part.refuse("unit", "a STEP file tells its unit of length", "leave it out");
    return solid_of_drawing(part, chord);
  }
  const double unit = unit_of(part);
  Surface surface =
      is_brep(file) ? solid_of_drawing(part, chord / unit) : read_surface(part.file("file"), part.location("file"));
  if (part.has("solid") && !is_brep(file)) keep_solid(surface, part);
  for (Vec3& x : surface.vertices) x *= unit;
  return surface;
}

Surface surface_of(const Table& part, double chord) {
  const double tolerance = part.number("weld");
  if (!(tolerance >= 0 && tolerance < 0.1))
    part.refuse("weld", fmt::format("weld = {:g} is no small part of the body", tolerance), "give 0 to 0.1, e.g. 1e-6");
  const SourceLocation file{.file = part.file("file"), .line = 0, .column = 0};
  Surface surface = facets_of(part, chord);
  weld(surface, tolerance * diagonal(surface));
  orient(surface);
  require_closed(surface, file);
  const std::string name_by = part.text("faces");
  if (name_by == "angle") name_faces_by_angle(surface, part.number("angle"));
  if (surface.faces.size() > most_faces)
    part.refuse("faces",
                fmt::format("the file \"{}\" has {} faces, the most are {}", part.text("file"), surface.faces.size(),
                            most_faces),
                name_by == "angle" ? "take a larger angle"
                                   : "put solids of one condition together, or write faces = \"angle\"");
  return surface;
}

}  // namespace

SolidShape solid_file() {
  return {
      .name = "file",
      .sentence =
          "A surface of triangles or polygons from an STL, OBJ or PLY file, or a solid from a STEP or BREP file, which "
          "the program gmsh reads",
      .keys =
          {{"file", Kind::text, "", required, "The file; its name counts from the folder of the case."},
           {"unit", Kind::text, "", optional,
            "The length of one unit of the file, such as \"mm\" or \"25.4 mm\"; required, as the file does not tell, "
            "but of "
            "STEP."},
           {"solid", Kind::text, "", optional,
            "Takes one solid of the file alone: its name in an STL or OBJ file, its number (\"1\", \"2\", ...) in a "
            "drawing of several."},
           {"weld", Kind::number, "", "1e-6",
            "Vertices nearer to each other than this part of the diagonal of the body become one."},
           {"faces",
            Kind::choice,
            "",
            "solids",
            "What makes a face. solids: the solids of an STL file and the groups, objects or materials (the last of g, "
            "o, usemtl) of an OBJ file, by their names; what has none is the face surface. angle: facets that meet at "
            "a small angle; face1 is the largest, then face2, ...",
            {"solids", "angle"}},
           {"angle", Kind::quantity, "rad", "30 deg",
            "Of faces = \"angle\": facets whose directions differ by less than this belong together."}},
      .make = surface_of};
}

}  // namespace calor
