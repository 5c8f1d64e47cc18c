#pragma once
// Surfaces in files, in the unit of the file: facets and vertices as they stand there, not welded, not checked.
#include <bit>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "surface/surface.hpp"

namespace calor {

/// Reads a file by its ending: .stl, .obj or .ply. `named` is where the case names it. Throws Error(file) for a file
/// that cannot be read, Error(bad_case) at line or byte for what is wrong in it.
Surface read_surface(const std::string& path, const SourceLocation& named);

/// The solids of a STEP or BREP file, each with its surface, not welded, not oriented; of STEP in m. `chord`: how long
/// facets may be, m. Faces have the names of groups of surfaces, else face1, ... Throws Error(file) where the program
/// gmsh is not installed, Error(bad_case) for what it cannot read.
std::vector<Surface> read_drawing(const std::string& path, const SourceLocation& named, double chord);

// The formats, given the contents of a file; `path` stands in messages.

/// STL, text or binary: triangles with vertices of their own. Faces: the names of its solids; "surface" without one.
Surface read_stl(const std::string& path, std::string_view contents);
/// Wavefront OBJ: polygons, cut into fans. A face is named by the last of g, o, usemtl before it; "surface" without
/// one.
Surface read_obj(const std::string& path, std::string_view contents);
/// PLY, text or binary: polygons, cut into fans. One face, "surface".
Surface read_ply(const std::string& path, std::string_view contents);

/// The face of this name, added where it is new.
std::int32_t face_named(Surface& surface, std::string_view name);

/// Adds a polygon as the fan of its first corner. Throws Error(bad_case) at `where` for fewer than three corners.
void add_polygon(Surface& surface, const std::vector<std::int32_t>& corners, std::int32_t face,
                 const SourceLocation& where);

/// A number from bytes.
template <class Number>
Number from_bytes(const char* bytes, std::endian order) {
  char copy[sizeof(Number)];
  for (std::size_t n = 0; n < sizeof(Number); ++n)
    copy[n] = bytes[order == std::endian::native ? n : sizeof(Number) - 1 - n];
  Number value;
  std::memcpy(&value, copy, sizeof(Number));
  return value;
}

}  // namespace calor
