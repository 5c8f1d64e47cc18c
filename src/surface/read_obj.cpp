#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "surface/surface_files.hpp"
#include "surface/words.hpp"

namespace calor {
namespace {

/// "7", "7/1", "7//3": the vertex, counted from 1, or back from the last one where it is negative.
std::int32_t vertex_of(const Words& words, std::string_view word, std::size_t vertices) {
  const std::int64_t written = words.integer(word.substr(0, word.find('/')));
  const auto count = static_cast<std::int64_t>(vertices);
  const std::int64_t vertex = written > 0 ? written - 1 : written + count;
  if (written == 0 || vertex < 0 || vertex >= count)
    words.refuse(fmt::format("a facet has vertex {}, but there are {} before it", written, count),
                 "vertices are counted from 1, or back from -1");
  return static_cast<std::int32_t>(vertex);
}

}  // namespace

Surface read_obj(const std::string& path, std::string_view contents) {
  constexpr std::array curved = {"curv", "curv2", "surf", "cstype"};
  Surface surface;
  Words words(path, contents);
  std::string face;
  std::vector<std::int32_t> corners;
  do {
    const std::string_view keyword = words.next_on_line();
    if (keyword == "v") {
      Vec3 x;
      for (int a = 0; a < 3; ++a) x[a] = words.coordinate(words.next_on_line());
      surface.vertices.push_back(x);
    } else if (keyword == "f") {
      corners.clear();
      for (auto word = words.next_on_line(); !word.empty(); word = words.next_on_line())
        corners.push_back(vertex_of(words, word, surface.vertices.size()));
      add_polygon(surface, corners, face_named(surface, face), words.location());
    } else if (keyword == "g" || keyword == "o" || keyword == "usemtl") {
      face = words.rest_of_line();
    } else if (std::ranges::find(curved, keyword) != curved.end()) {
      words.refuse(fmt::format("'{}' belongs to a curved surface", keyword), "export flat facets");
    }
  } while (words.next_line());  // normals, textures and the like are of no use here
  if (surface.facets.empty()) words.refuse("the file has no facets", "export the surface again");
  return surface;
}

}  // namespace calor
