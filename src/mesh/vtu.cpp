// VTK's unstructured grids in XML (VTK file formats, "XML file formats"): arrays as text, in base64 or appended, not
// compressed. Appended raw data make the file no XML, so its tags are read here, one after the other.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "mesh/mesh.hpp"
#include "mesh/text_file.hpp"

namespace calor {
namespace {

constexpr const char* cure_by_paraview =
    "write it again, in ParaView by File, Save Data with the data mode Ascii, or by meshio convert --ascii";

/// VTK's number of a cell, and its corners in the order of Gmsh.
struct VtkType {
  ElementShape shape;
  int nodes;
  std::array<int, 8> corner = {0, 1, 2, 3, 4, 5, 6, 7};
};
const std::map<std::int64_t, VtkType>& vtk_types() {
  using enum ElementShape;
  constexpr std::array<int, 8> pixel = {0, 1, 3, 2, 4, 5, 7, 6};
  static const std::map<std::int64_t, VtkType> types = {
      {3, {line, 2}},          {5, {triangle, 3}},       {8, {quadrilateral, 4, pixel}},
      {9, {quadrilateral, 4}}, {10, {tetrahedron, 4}},   {11, {hexahedron, 8, pixel}},
      {12, {hexahedron, 8}},   {13, {prism, 6}},         {14, {pyramid, 5}},
      {21, {line, 3}},         {22, {triangle, 6}},      {23, {quadrilateral, 8}},
      {24, {tetrahedron, 10}}, {25, {hexahedron, 20}},   {26, {prism, 15}},
      {27, {pyramid, 13}},     {28, {quadrilateral, 9}}, {29, {hexahedron, 27}}};
  return types;
}
constexpr std::int64_t vertex = 1;

/// Arrays of the cells that hold the number of their group, as Gmsh, meshio, OpenGeoSys and others write them.
constexpr const char* group_arrays[] = {"gmsh:physical", "CellEntityIds", "MaterialIDs", "Material",
                                        "material",      "RegionId",      "medit:ref"};

/// Padding may come in the middle: a new group begins after it.
std::string from_base64(std::string_view text) {
  std::string bytes;
  std::uint32_t value = 0;
  int bits = 0;
  for (const char c : text) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::size_t digit = digits.find(c);
    if (c == '=') value = 0, bits = 0;
    if (digit == digits.npos) continue;
    value = value << 6 | static_cast<std::uint32_t>(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<char>(value >> bits & 255));
  }
  return bytes;
}

/// The numbers of raw bytes, as VTK's type `Number`.
template <class Number>
std::vector<double> numbers_in(std::string_view bytes) {
  std::vector<double> out;
  out.reserve(bytes.size() / sizeof(Number));
  for (std::size_t at = 0; at + sizeof(Number) <= bytes.size(); at += sizeof(Number)) {
    Number number;
    std::memcpy(&number, bytes.data() + at, sizeof number);
    out.push_back(static_cast<double>(number));
  }
  return out;
}

using Decoder = std::vector<double> (*)(std::string_view);
const std::map<std::string, Decoder>& decoders() {
  static const std::map<std::string, Decoder> all = {
      {"Float64", numbers_in<double>},     {"Float32", numbers_in<float>},
      {"Int64", numbers_in<std::int64_t>}, {"UInt64", numbers_in<std::uint64_t>},
      {"Int32", numbers_in<std::int32_t>}, {"UInt32", numbers_in<std::uint32_t>},
      {"Int16", numbers_in<std::int16_t>}, {"UInt16", numbers_in<std::uint16_t>},
      {"Int8", numbers_in<std::int8_t>},   {"UInt8", numbers_in<std::uint8_t>}};
  return all;
}

/// A tag of the file: its name, with a slash where it closes, and its attributes.
struct Tag {
  std::string name;
  std::map<std::string, std::string> attributes;
  bool is_empty = false;     ///< <.../>
  std::string_view written;  ///< in the file

  std::string get(const std::string& key, const std::string& fallback = {}) const {
    const auto found = attributes.find(key);
    return found == attributes.end() ? fallback : found->second;
  }
};

class VtuReader {
 public:
  VtuReader(const std::string& path, const SourceLocation& named) : file_(path, named), text_(file_.text()) {}

  Mesh read() {
    std::optional<Tag> tag = next_tag();
    while (tag && (tag->name.starts_with('?') || tag->name.starts_with('!'))) tag = next_tag();
    if (!tag || tag->name != "VTKFile" || tag->get("type") != "UnstructuredGrid")
      file_.refuse_at(text_.substr(0, 1), "this is no unstructured grid of VTK in XML", "give a file .vtu");
    if (!tag->get("compressor").empty()) file_.refuse_at(tag->written, "the arrays are compressed", cure_by_paraview);
    if (tag->get("byte_order", "LittleEndian") != "LittleEndian")
      file_.refuse_at(tag->written, "the byte order is not that of this machine", cure_by_paraview);
    header_size_ = tag->get("header_type", "UInt32") == "UInt64" ? 8 : 4;
    find_appended_data();
    std::string section;
    while ((tag = next_tag()) && tag->name != "AppendedData") {
      if (tag->name == "Points" || tag->name == "Cells" || tag->name == "CellData") section = tag->name;
      if (tag->name == "PointData" || tag->name == "FieldData") section.clear();
      if (tag->name == "DataArray" && !section.empty()) keep(section, *tag);
      if (tag->name == "/Piece") add_piece(*tag);
    }
    if (mesh_.x.empty()) file_.refuse_at(text_.substr(0, 1), "the mesh has no points", cure_by_paraview);
    if (second_order_ > 0)
      mesh_.notes.push_back(fmt::format("of {} elements of higher order only the corners count", second_order_));
    return std::move(mesh_);
  }

 private:
  std::optional<Tag> next_tag() {
    const std::size_t open = text_.find('<', at_);
    if (open == text_.npos) return std::nullopt;
    const bool is_comment = text_.substr(open).starts_with("<!--");
    const std::size_t close = text_.find(is_comment ? "-->" : ">", open);
    if (close == text_.npos) file_.refuse_at(text_.substr(open), "a tag without end", "write the file again");
    Tag tag{.name = {}, .attributes = {}, .is_empty = text_[close - 1] == '/', .written = text_.substr(open)};
    std::string_view inside = text_.substr(open + 1, close - open - 1);
    at_ = close + 1;
    const std::size_t blank = std::min(inside.find_first_of(" \t\r\n/", 1), inside.size());
    tag.name = inside.substr(0, blank);
    inside.remove_prefix(blank);
    while (!is_comment) {
      const std::size_t equals = inside.find('=');
      const std::size_t from = inside.find_first_of("\"'", equals);
      const std::size_t to = from == inside.npos ? from : inside.find(inside[from], from + 1);
      if (equals == inside.npos || to == inside.npos) break;
      tag.attributes[std::string(trimmed(inside.substr(0, equals)))] = inside.substr(from + 1, to - from - 1);
      inside.remove_prefix(to + 1);
    }
    return tag;
  }

  void find_appended_data() {
    const std::size_t open = text_.find("<AppendedData");
    if (open == text_.npos) return;
    const std::size_t start = text_.find('_', text_.find('>', open));
    if (start == text_.npos) file_.refuse_at(text_.substr(open), "there are no appended data", cure_by_paraview);
    appended_ = text_.substr(start + 1);
    appended_is_raw_ = text_.substr(open, start - open).find("raw") != text_.npos;
  }

  void keep(const std::string& section, const Tag& tag) {
    const std::string name = section == "Points" ? "points" : tag.get("Name");
    const bool is_group = std::ranges::find(group_arrays, name) != std::end(group_arrays);
    if (section == "CellData" && !is_group) return;
    arrays_[name] = numbers(tag);
  }

  std::vector<double> numbers(const Tag& tag) {
    const std::string format = tag.get("format", "ascii"), type = tag.get("type");
    const std::string_view inside = text_.substr(at_, std::min(text_.find('<', at_), text_.size()) - at_);
    std::vector<double> out;
    if (format == "ascii") {
      for (std::size_t at = 0; at < inside.size();) {
        const std::size_t begin = std::min(inside.find_first_not_of(" \t\r\n", at), inside.size());
        at = std::min(inside.find_first_of(" \t\r\n", begin), inside.size());
        if (begin < at) out.push_back(file_.to_number(inside.substr(begin, at - begin)));
      }
      return out;
    }
    const auto decoder = decoders().find(type);
    if (decoder == decoders().end() || (format != "binary" && format != "appended"))
      file_.refuse_at(tag.written, fmt::format("an array of '{}' in the format '{}'", type, format), cure_by_paraview);
    std::string_view data = inside;
    bool is_raw = false;
    if (format == "appended") {
      const auto offset = static_cast<std::size_t>(file_.to_integer(tag.get("offset", "0")));
      if (offset >= appended_.size())
        file_.refuse_at(tag.written, "the array lies beyond the end of the file", cure_by_paraview);
      data = appended_.substr(offset);
      is_raw = appended_is_raw_;
    }
    std::string decoded;
    if (!is_raw) {
      decoded = from_base64(format == "binary" ? data : data.substr(0, base64_length(data)));
      data = decoded;
    }
    std::uint64_t size = 0;
    if (data.size() >= header_size_) std::memcpy(&size, data.data(), header_size_);
    if (data.size() < header_size_ || size > data.size() - header_size_)
      file_.refuse_at(tag.written, "the array is longer than the file", cure_by_paraview);
    return decoder->second(data.substr(header_size_, size));
  }

  /// Letters of an appended array with its header, which tells how long it is.
  std::size_t base64_length(std::string_view data) const {
    const std::string header = from_base64(data.substr(0, 12));
    std::uint64_t size = 0;
    std::memcpy(&size, header.data(), std::min(header.size(), header_size_));
    return std::min<std::uint64_t>(data.size(),
                                   size > data.size() ? data.size() : (size + header_size_ + 8) * 4 / 3 + 8);
  }

  const std::vector<double>& array(const std::string& name, const Tag& piece) const {
    const auto found = arrays_.find(name);
    if (found == arrays_.end())
      file_.refuse_at(piece.written, fmt::format("a piece without '{}'", name), cure_by_paraview);
    return found->second;
  }

  void add_piece(const Tag& piece) {
    const auto &x = array("points", piece), &nodes = array("connectivity", piece), &ends = array("offsets", piece),
               &types = array("types", piece);
    const auto bad = [&](const std::string& what) { file_.refuse_at(piece.written, what, cure_by_paraview); };
    if (x.size() % 3 != 0 || ends.size() != types.size()) bad("arrays of a piece that do not fit one another");
    const auto first = static_cast<std::int32_t>(mesh_.x.size());
    const double points = static_cast<double>(x.size()) / 3;
    for (std::size_t n = 0; n < x.size(); n += 3) {
      if (!std::isfinite(x[n] + x[n + 1] + x[n + 2])) bad("a point without a finite place");
      mesh_.label.push_back(static_cast<std::int64_t>(mesh_.x.size()));
      mesh_.x.push_back({x[n], x[n + 1], x[n + 2]});
    }
    const std::vector<double>* groups = nullptr;
    for (const char* name : group_arrays)
      if (const auto found = arrays_.find(name); !groups && found != arrays_.end()) groups = &found->second;
    if (groups && groups->size() != ends.size()) bad("an array of groups that does not fit the cells");
    std::int64_t begin = 0;
    for (std::size_t c = 0; c < ends.size(); ++c) {
      const auto end = static_cast<std::int64_t>(ends[c]), type = static_cast<std::int64_t>(types[c]);
      if (end < begin || end > static_cast<std::int64_t>(nodes.size())) bad("cells with nodes that the file has not");
      const auto known = vtk_types().find(type);
      if (type != vertex && (known == vtk_types().end() || known->second.nodes != end - begin))
        bad(fmt::format("cells of type {} with {} nodes, which are not known", type, end - begin));
      if (type != vertex) {
        MeshElement e{.shape = known->second.shape};
        for (int k = 0; k < corners_of(e.shape); ++k) {
          const double node = nodes[begin + known->second.corner[k]];
          if (!(node >= 0 && node < points)) bad("a cell with a node that the file has not");
          e.node[k] = first + static_cast<std::int32_t>(node);
        }
        if (groups) e.name = mesh_.name_index(fmt::format("{}", static_cast<std::int64_t>((*groups)[c])));
        second_order_ += known->second.nodes > corners_of(e.shape);
        mesh_.elements.push_back(e);
      }
      begin = end;
    }
    arrays_.clear();
  }

  TextFile file_;
  std::string_view text_, appended_;
  std::size_t at_ = 0, header_size_ = 4;
  bool appended_is_raw_ = false;
  Mesh mesh_;
  std::int64_t second_order_ = 0;
  std::map<std::string, std::vector<double>> arrays_;  // of the piece
};

}  // namespace

Mesh read_vtu(const std::string& path, const SourceLocation& named) { return VtuReader(path, named).read(); }

}  // namespace calor
