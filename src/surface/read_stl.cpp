#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "surface/surface_files.hpp"
#include "surface/words.hpp"

namespace calor {
namespace {

constexpr std::size_t head = 84, record = 50;  // bytes of a binary file: 80 of text and a count; of a facet

std::string lower(std::string_view word) {
  std::string out(word);
  std::ranges::transform(out, out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

void add_facet(Surface& surface, std::int32_t face) {
  const auto first = static_cast<std::int32_t>(surface.vertices.size()) - 3;
  surface.facets.push_back({{first, first + 1, first + 2}, face});
}

Surface read_binary(const std::string& path, std::string_view contents, std::size_t count) {
  Surface surface;
  face_named(surface, "");
  for (std::size_t f = 0; f < count; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t at = head + record * f + 12 * (k + 1);  // after the normal
      Vec3 x;
      for (int a = 0; a < 3; ++a) x[a] = from_bytes<float>(&contents[at + 4 * a], std::endian::little);
      if (!std::isfinite(x.x + x.y + x.z))
        throw Error(Fault::bad_case, SourceLocation{.file = path, .line = 0, .column = 0},
                    fmt::format("a coordinate of facet {} (byte {}) is not finite", f + 1, at),
                    "coordinates are finite numbers");
      surface.vertices.push_back(x);
    }
    add_facet(surface, 0);
  }
  return surface;
}

/// After "facet": up to "endfacet".
void read_facet(Words& words, Surface& surface, std::int32_t face) {
  // The normal is told by the corners, too, and some programs write nonsense there.
  std::string word;
  do word = lower(words.next());
  while (!word.empty() && word != "outer");
  if (word.empty() || lower(words.next()) != "loop") words.refuse_word(word, "'outer loop'");
  int corners = 0;
  for (word = lower(words.next()); word == "vertex"; word = lower(words.next()), ++corners) {
    Vec3 x;
    for (int a = 0; a < 3; ++a) x[a] = words.coordinate(words.next());
    surface.vertices.push_back(x);
  }
  if (word != "endloop") words.refuse_word(word, "'vertex' or 'endloop'");
  if (corners != 3) words.refuse(fmt::format("a facet has {} corners", corners), "facets of STL files are triangles");
  if (word = lower(words.next()); word != "endfacet") words.refuse_word(word, "'endfacet'");
  add_facet(surface, face);
}

Surface read_text(Words words) {
  Surface surface;
  std::string name, last;
  for (std::string word = lower(words.next()); !word.empty(); word = lower(words.next())) {
    if (word == "solid") {
      name = words.rest_of_line();
    } else if (word == "facet") {
      read_facet(words, surface, face_named(surface, name));
    } else if (word == "endsolid") {
      words.rest_of_line();
    } else {
      words.refuse_word(word, "'facet', 'solid' or 'endsolid'");
    }
    last = word;
  }
  if (last != "endsolid") words.refuse("the file ends without 'endsolid'", "it may be cut off: write it anew");
  if (surface.facets.empty()) words.refuse("the file has no facets", "export the surface again");
  return surface;
}

}  // namespace

Surface read_stl(const std::string& path, std::string_view contents) {
  // Many binary files begin with "solid" as text files do, but none of those has the length that its bytes 81 to 84
  // tell: as text, they are a count of more than 10^8.
  const std::size_t count = contents.size() < head ? 0 : from_bytes<std::uint32_t>(&contents[80], std::endian::little);
  const auto error = [&](const std::string& what, const std::string& cure) {
    return Error(Fault::bad_case, SourceLocation{.file = path, .line = 0, .column = 0}, what, cure);
  };
  if (contents.size() == head + record * count) {
    if (count == 0) throw error("the file has no facets", "export the surface again");
    return read_binary(path, contents, count);
  }
  const std::size_t begin = std::min(contents.find_first_not_of(" \t\r\n"), contents.size());
  const bool is_text = contents.find('\0') == std::string_view::npos;
  if (is_text && lower(contents.substr(begin, 5)) == "solid") return read_text(Words(path, contents));
  if (contents.size() < head || is_text)
    throw error("this is no STL file: it neither begins with 'solid' nor has the length of a binary one",
                "export the surface again");
  throw error(fmt::format("a binary STL file of {} facets has {} bytes, this one has {}", count, head + record * count,
                          contents.size()),
              "it may be cut off or damaged: write it anew");
}

}  // namespace calor
