#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "surface/surface_files.hpp"
#include "surface/words.hpp"

namespace calor {
namespace {

constexpr const char* damaged = "the file may be damaged: write it anew";

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  Type type;
  std::optional<Type> count;  ///< of a list: type of the number of its values
};

struct Element {
  std::string name;
  std::int64_t count;
  std::vector<Property> properties;
};

struct Header {
  std::optional<std::endian> binary;  ///< none: text
  std::vector<Element> elements;
};

Type type_of(const Words& words, std::string_view word) {
  constexpr std::array<std::array<const char*, 2>, 8> names = {{{"char", "int8"},
                                                                {"uchar", "uint8"},
                                                                {"short", "int16"},
                                                                {"ushort", "uint16"},
                                                                {"int", "int32"},
                                                                {"uint", "uint32"},
                                                                {"float", "float32"},
                                                                {"double", "float64"}}};
  for (std::size_t n = 0; n < names.size(); ++n)
    if (word == names[n][0] || word == names[n][1]) return static_cast<Type>(n);
  words.refuse_word(word, "a type (char, uchar, short, ushort, int, uint, float or double)");
}

/// Up to the line "end_header", included.
Header read_header(Words& words) {
  Header header;
  bool has_format = false;
  if (words.next_on_line() != "ply") words.refuse("a PLY file begins with 'ply'", "export the surface again");
  while (words.next_line()) {
    const std::string_view keyword = words.next_on_line();
    if (keyword == "end_header") {
      if (!has_format) words.refuse("the header has no format", damaged);
      words.next_line();
      return header;
    }
    if (keyword == "format") {
      const std::string_view format = words.next_on_line();
      has_format = true;
      if (format == "binary_little_endian")
        header.binary = std::endian::little;
      else if (format == "binary_big_endian")
        header.binary = std::endian::big;
      else if (format != "ascii")
        words.refuse_word(format, "ascii, binary_little_endian or binary_big_endian");
    } else if (keyword == "element") {
      const std::string name(words.next_on_line());
      const std::int64_t count = words.integer(words.next_on_line());
      if (count < 0) words.refuse(fmt::format("{} elements '{}'", count, name), damaged);
      header.elements.push_back({name, count, {}});
    } else if (keyword == "property") {
      if (header.elements.empty()) words.refuse("a property of no element", damaged);
      Property property;
      std::string_view type = words.next_on_line();
      if (type == "list") {
        property.count = type_of(words, words.next_on_line());
        type = words.next_on_line();
      }
      property.type = type_of(words, type);
      property.name = words.next_on_line();
      header.elements.back().properties.push_back(property);
    } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
      words.refuse_word(keyword, "a line of a PLY header");
    }
  }
  words.refuse("the header has no end", "it may be cut off: write it anew");
}

/// The values after the header, one after the other.
class Values {
 public:
  Values(Words& words, std::optional<std::endian> binary, std::string_view contents, std::size_t at)
      : words_(words), binary_(binary), contents_(contents), at_(at) {}

  double next(Type type) {
    if (!binary_) return words_.number(words_.next());
    switch (type) {
      case Type::int8:
        return take<std::int8_t>();
      case Type::uint8:
        return take<std::uint8_t>();
      case Type::int16:
        return take<std::int16_t>();
      case Type::uint16:
        return take<std::uint16_t>();
      case Type::int32:
        return take<std::int32_t>();
      case Type::uint32:
        return take<std::uint32_t>();
      case Type::float32:
        return take<float>();
      case Type::float64:
        return take<double>();
    }
    return 0;
  }

  [[noreturn]] void refuse(const std::string& what, const std::string& cure) const {
    if (!binary_) words_.refuse(what, cure);
    throw Error(Fault::bad_case, SourceLocation{.file = words_.path(), .line = 0, .column = 0},
                fmt::format("byte {}: {}", at_, what), cure);
  }
  /// For messages; of binary files without line.
  SourceLocation location() const {
    return binary_ ? SourceLocation{.file = words_.path(), .line = 0, .column = 0} : words_.location();
  }

 private:
  template <class Number>
  double take() {
    if (contents_.size() - at_ < sizeof(Number)) refuse("the file ends too early", "it is cut off: write it anew");
    const auto value = from_bytes<Number>(&contents_[at_], *binary_);
    at_ += sizeof(Number);
    return static_cast<double>(value);
  }

  Words& words_;
  std::optional<std::endian> binary_;
  std::string_view contents_;
  std::size_t at_;
};

/// A whole number of 32 bits; both counts of lists and their values are such.
std::int32_t whole_number(Values& values, Type type) {
  const double value = values.next(type);
  if (!(std::abs(value) < 2147483648.0) || value != std::floor(value))
    values.refuse(fmt::format("{} where a number of vertices or of a vertex should come", value), damaged);
  return static_cast<std::int32_t>(value);
}

std::vector<std::int32_t> read_list(Values& values, const Property& property) {
  std::vector<std::int32_t> list;  // grows with what is there: the count may be nonsense
  for (std::int32_t left = whole_number(values, *property.count); left > 0; --left)
    list.push_back(whole_number(values, property.type));
  return list;
}

bool is_corners(const Property& property) {
  return property.count && (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// 0, 1, 2 for x, y, z; -1 for what is no coordinate.
int axis_of(const Property& property) {
  if (property.count || property.name.size() != 1) return -1;
  const std::size_t axis = std::string_view("xyz").find(property.name);
  return axis == std::string_view::npos ? -1 : static_cast<int>(axis);
}

void read_element(Values& values, const Element& element, Surface& surface) {
  const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
  const std::int32_t face = is_face ? face_named(surface, "") : 0;
  for (std::int64_t n = 0; n < element.count && !element.properties.empty(); ++n) {
    Vec3 x;
    for (const Property& property : element.properties) {
      if (is_face && is_corners(property)) {
        add_polygon(surface, read_list(values, property), face, values.location());
      } else if (property.count) {
        for (std::int32_t left = whole_number(values, *property.count); left > 0; --left) values.next(property.type);
      } else {
        const double value = values.next(property.type);
        const int axis = is_vertex ? axis_of(property) : -1;
        if (axis < 0) continue;
        if (!std::isfinite(value))
          values.refuse(fmt::format("a coordinate of vertex {} is not finite", n), "coordinates are finite numbers");
        x[axis] = value;
      }
    }
    if (is_vertex) surface.vertices.push_back(x);
  }
}

const Element& element_of(const Words& words, const Header& header, const std::string& name) {
  for (const Element& element : header.elements)
    if (element.name == name) return element;
  words.refuse(fmt::format("the file has no element '{}'", name), "export the surface as vertices and faces");
}

}  // namespace

Surface read_ply(const std::string& path, std::string_view contents) {
  Words words(path, contents);
  const Header header = read_header(words);
  for (int axis = 0; axis < 3; ++axis)
    if (std::ranges::count(element_of(words, header, "vertex").properties, axis, axis_of) != 1)
      words.refuse(fmt::format("the vertices have no property '{}'", "xyz"[axis]), "export the surface again");
  if (std::ranges::none_of(element_of(words, header, "face").properties, is_corners))
    words.refuse("the faces have no list 'vertex_indices'", "export the surface as vertices and faces");

  Surface surface;
  Values values(words, header.binary, contents, words.byte());
  for (const Element& element : header.elements) read_element(values, element, surface);

  const auto count = static_cast<std::int32_t>(surface.vertices.size());
  for (std::size_t f = 0; f < surface.facets.size(); ++f)
    for (const std::int32_t vertex : surface.facets[f].vertex)
      if (vertex < 0 || vertex >= count)
        throw Error(Fault::bad_case, SourceLocation{.file = path, .line = 0, .column = 0},
                    fmt::format("facet {} has vertex {}, but there are {}, counted from 0", f, vertex, count), damaged);
  if (surface.facets.empty()) words.refuse("the file has no facets", "export the surface again");
  return surface;
}

}  // namespace calor
