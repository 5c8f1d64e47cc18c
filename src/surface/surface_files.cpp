#include "surface/surface_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "surface/words.hpp"

namespace calor {

Surface read_surface(const std::string& path, const SourceLocation& named) {
  std::string lower = path;
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto read = lower.ends_with(".stl")   ? read_stl
                    : lower.ends_with(".obj") ? read_obj
                    : lower.ends_with(".ply") ? read_ply
                                              : nullptr;
  if (!read)
    throw Error(Fault::bad_case, named, fmt::format("the file \"{}\" is no surface by its name", path),
                "surfaces are read from .stl, .obj, .ply, .step and .brep files");
  const std::string contents = read_whole_file(path, named);
  const bool is_empty = std::ranges::all_of(contents, [](unsigned char c) { return std::isspace(c); });
  if (is_empty)
    throw Error(Fault::bad_case, SourceLocation{.file = path, .line = 1, .column = 0}, "the file is empty",
                "export the surface again");
  return read(path, contents);
}

std::int32_t face_named(Surface& surface, std::string_view name) {
  const std::string face(name.empty() ? "surface" : name);
  const auto found = std::ranges::find(surface.faces, face);
  if (found == surface.faces.end()) surface.faces.push_back(face);
  return static_cast<std::int32_t>(std::ranges::find(surface.faces, face) - surface.faces.begin());
}

void add_polygon(Surface& surface, const std::vector<std::int32_t>& corners, std::int32_t face,
                 const SourceLocation& where) {
  if (corners.size() < 3)
    throw Error(Fault::bad_case, where, fmt::format("a facet has {} corners", corners.size()),
                "facets are triangles or polygons");
  for (std::size_t n = 2; n < corners.size(); ++n)
    surface.facets.push_back({{corners[0], corners[n - 1], corners[n]}, face});
}

}  // namespace calor
