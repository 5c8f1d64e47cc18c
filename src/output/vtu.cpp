#include "output/vtu.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <utility>

#include "base/parallel.hpp"
#include "output/files.hpp"

namespace calor {
namespace {

std::string head_of_file(const std::string& type, const std::string& more = {}) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\"{}>\n",
      type, std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", more);
}

/// Writes bytes in base64.
void put_base64(std::span<const unsigned char> bytes, std::FILE* file) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<char, 1 << 14> text;
  std::size_t length = 0;
  const auto put = [&](std::uint32_t group) {
    for (int k = 0; k < 4; ++k) text[length + k] = digits[group >> (18 - 6 * k) & 63];
    length += 4;
  };
  std::size_t at = 0;
  for (; at + 3 <= bytes.size(); at += 3) {
    put(bytes[at] << 16 | bytes[at + 1] << 8 | bytes[at + 2]);
    if (length == text.size()) std::fwrite(text.data(), 1, std::exchange(length, 0), file);
  }
  if (const std::size_t left = bytes.size() - at; left > 0) {
    put(bytes[at] << 16 | (left > 1 ? bytes[at + 1] << 8 : 0));
    std::fill(text.begin() + length - (3 - left), text.begin() + length, '=');
  }
  std::fwrite(text.data(), 1, length, file);
}

/// The bytes of numbers.
template <class Number>
std::span<const unsigned char> bytes_of(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const unsigned char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

/// Data of an array as VTK compresses them, in base64: the number of blocks, the size of a block and of the last one if
/// it is smaller, sizes of the compressed blocks; then the blocks.
class Compressed {
 public:
  explicit Compressed(std::size_t block) : sizes_{0, block, 0} {}

  void add(std::span<const unsigned char> block) {
    if (block.size() < sizes_[1]) sizes_[2] = block.size();
    ++sizes_[0];
    sizes_.push_back(append(block, is_noise(block) ? Z_NO_COMPRESSION : fast));
  }
  void write(std::FILE* file) const { put_base64(bytes_of(sizes_), file), put_base64(blocks_, file); }

 private:
  static constexpr int fast = 1;  ///< the next levels take twice the time for a twentieth of the size

  std::size_t append(std::span<const unsigned char> bytes, int level) {
    const std::size_t start = blocks_.size();
    uLongf size = compressBound(bytes.size());
    blocks_.resize(start + size);
    compress2(blocks_.data() + start, &size, bytes.data(), bytes.size(), level);
    blocks_.resize(start + size);
    return size;
  }
  /// All digits of temperatures that change from point to point keep four fifths of their size and more, and take most
  /// of the time. Judged by some bytes in the middle.
  bool is_noise(std::span<const unsigned char> block) {
    constexpr std::size_t some = 1 << 12;
    if (block.size() < 4 * some) return false;
    const std::size_t before = blocks_.size(), size = append(block.subspan(block.size() / 2, some), fast);
    blocks_.resize(before);
    return size > some * 4 / 5;
  }

  std::vector<std::uint64_t> sizes_;
  std::vector<unsigned char> blocks_;
};

/// One array of a piece; its data are made when it is written.
struct Array {
  std::string type, name;
  int components;
  std::function<void(std::FILE*)> write;

  /// DataArray, or PDataArray with prefix "P". One component is not told: meshio would make a matrix of it.
  std::string tag(const std::string& prefix, const std::string& more) const {
    const std::string count = components > 1 ? fmt::format(" NumberOfComponents=\"{}\"", components) : "";
    return fmt::format("<{}DataArray type=\"{}\" Name=\"{}\"{}{}>", prefix, type, escaped(name), count, more);
  }
};

/// An array of make(point, component).
template <class Number, class Make>
Array array(const std::string& type, const std::string& name, int components, int points, Make make) {
  return {type, name, components, [=](std::FILE* file) {
            constexpr int most = 1 << 14;
            Compressed compressed(sizeof(Number) * components * most);
            std::vector<Number> block;
            for (int begin = 0; begin < points; begin += most) {
              block.clear();
              for (int i = begin; i < std::min(points, begin + most); ++i)
                for (int c = 0; c < components; ++c) block.push_back(static_cast<Number>(make(i, c)));
              compressed.add(bytes_of(block));
            }
            compressed.write(file);
          }};
}

std::vector<Array> arrays_of(const std::vector<Field>& fields, int count) {
  std::vector<Array> arrays;
  arrays.reserve(fields.size());
  for (const Field& f : fields)
    arrays.push_back(array<double>("Float64", f.name, f.components, count, [&f](int i, int c) {
      return f.values[static_cast<std::size_t>(i) * f.components + c];
    }));
  return arrays;
}

/// The time, and what labels stand for.
std::string field_data(double t, const std::vector<Label>& labels) {
  const auto one = [](const std::string& type, const std::string& name, const std::string& value) {
    return fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n",
                       type, escaped(name), value);
  };
  std::string text = one("Float64", "TimeValue", fmt::format("{}", t));
  for (const Label& label : labels)
    for (std::size_t n = 0; n < label.called.size(); ++n)
      if (!label.called[n].empty()) text += one("Int64", label.name + " " + label.called[n], fmt::format("{}", n));
  return "<FieldData>\n" + text + "</FieldData>\n";
}

/// What this rank has of a grid. No two cells share a point.
struct Piece {
  std::string type;                ///< "UnstructuredGrid" or "PolyData"
  std::string cells;               ///< "Cells" of an unstructured grid; "Verts", "Lines" or "Polys"
  std::string data;                ///< what carries the fields: "PointData" or "CellData"
  std::string field_data = {};     ///< the element
  int count = 0;                   ///< cells
  int corners = 1;                 ///< points of each
  std::vector<Array> values = {};  ///< the first is what viewers show
  std::vector<Array> points = {}, topology = {};

  std::string suffix() const { return type == "PolyData" ? "vtp" : "vtu"; }
  std::string active() const { return values.empty() ? "" : fmt::format(" Scalars=\"{}\"", escaped(values[0].name)); }
};

/// The time, and arrays of labels with their names.
void add_labels(double t, const std::vector<Label>& labels, Piece& piece) {
  piece.field_data = field_data(t, labels);
  for (const Label& label : labels)
    piece.values.push_back(
        array<std::int64_t>("Int64", label.name, 1, piece.count, [&label](int i, int) { return label.values[i]; }));
}

/// Places of points, and cells of them.
void add_cells(const std::function<const Vec3&(int)>& place, Piece& piece) {
  const int corners = piece.corners, points = piece.count * corners;
  piece.points = {array<double>("Float64", "Points", 3, points, [place](int i, int c) { return place(i)[c]; })};
  piece.topology = {
      array<std::int64_t>("Int64", "connectivity", 1, points, [](int i, int) { return i; }),
      array<std::int64_t>("Int64", "offsets", 1, piece.count, [corners](int i, int) { return (i + 1) * corners; })};
  if (piece.cells == "Cells")
    piece.topology.push_back(
        array<std::uint8_t>("UInt8", "types", 1, points, [](int, int) { return 1; }));  // 1: VTK_VERTEX
}

/// Throws Error(file).
void write_piece(const std::string& path, const Piece& piece) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file) refuse_writing(path, errno);
  const auto put = [&](const std::string& text) { std::fwrite(text.data(), 1, text.size(), file); };
  const auto put_all = [&](const std::vector<Array>& arrays) {
    for (const Array& a : arrays) {
      put(a.tag("", " format=\"binary\"") + "\n");
      a.write(file);
      put("\n</DataArray>\n");
    }
  };
  put(head_of_file(piece.type, " compressor=\"vtkZLibDataCompressor\"") + fmt::format("<{}>\n", piece.type));
  put(piece.field_data + fmt::format("<Piece NumberOfPoints=\"{}\" NumberOf{}=\"{}\">\n", piece.count * piece.corners,
                                     piece.cells, piece.count));
  put(fmt::format("<{}{}>\n", piece.data, piece.active()));
  put_all(piece.values);
  put(fmt::format("</{}>\n<Points>\n", piece.data));
  put_all(piece.points);
  put(fmt::format("</Points>\n<{}>\n", piece.cells));
  put_all(piece.topology);
  put(fmt::format("</{}>\n</Piece>\n</{}>\n</VTKFile>\n", piece.cells, piece.type));
  const bool failed = std::ferror(file) != 0;
  if (std::fclose(file) != 0 || failed) refuse_writing(path, errno);
}

std::string list_of_pieces(const std::string& name, int ranks, const Piece& piece) {
  std::string text = fmt::format("<P{} GhostLevel=\"0\">\n<P{}{}>\n", piece.type, piece.data, piece.active());
  for (const Array& a : piece.values) text += a.tag("P", "/") + "\n";
  text += fmt::format("</P{}>\n<PPoints>\n{}\n</PPoints>\n", piece.data, piece.points[0].tag("P", "/"));
  for (int r = 0; r < ranks; ++r) text += fmt::format("<Piece Source=\"{}_{}.{}\"/>\n", name, r, piece.suffix());
  return head_of_file("P" + piece.type) + text + fmt::format("</P{}>\n</VTKFile>\n", piece.type);
}

/// Writes the pieces of all ranks as `stem`.vtu or .vtp, or of several ranks as `stem`_RANK with a list of them.
/// Throws Error(file) on all ranks. Collective.
void write_grid(MPI_Comm comm, const std::string& folder, const std::string& name, const Piece& piece) {
  const int rank = rank_of(comm), ranks = size_of(comm);
  const std::string stem = folder + "/" + name;
  collective_try(comm, [&] {
    write_piece(
        ranks == 1 ? fmt::format("{}.{}", stem, piece.suffix()) : fmt::format("{}_{}.{}", stem, rank, piece.suffix()),
        piece);
    if (rank == 0 && ranks > 1)
      replace_file(fmt::format("{}.p{}", stem, piece.suffix()), list_of_pieces(name, ranks, piece));
  });
}

/// Collective.
void write_points(const Cloud& cloud, double t, const std::string& folder, const std::string& name,
                  const std::vector<Field>& fields, const std::vector<Label>& labels) {
  Piece points{.type = "UnstructuredGrid", .cells = "Cells", .data = "PointData", .count = cloud.owned};
  points.values = arrays_of(fields, points.count);
  points.values.push_back(
      array<double>("Float64", "volume [m^3]", 1, points.count, [&](int i, int) { return cloud.volume[i]; }));
  points.values.push_back(
      array<double>("Float64", "spacing [m]", 1, points.count, [&](int i, int) { return cloud.spacing[i]; }));
  add_labels(t, labels, points);
  add_cells([&](int i) -> const Vec3& { return cloud.x[i]; }, points);
  write_grid(cloud.comm, folder, name, points);
}

/// Collective.
void write_surface(const Cloud& cloud, std::span<const std::array<Vec3, 4>> outlines, double t,
                   const std::string& folder, const std::string& name, const std::vector<Field>& fields,
                   const std::vector<Label>& labels) {
  const int corners = corners_of_facet(cloud);
  Piece surface{.type = "PolyData",
                .cells = corners == 4   ? "Polys"
                         : corners == 2 ? "Lines"
                                        : "Verts",
                .data = "CellData",
                .count = static_cast<int>(cloud.facets.size()),
                .corners = corners};
  surface.values = arrays_of(fields, surface.count);
  surface.values.push_back(
      array<double>("Float64", "area [m^2]", 1, surface.count, [&](int n, int) { return cloud.facets[n].area; }));
  surface.values.push_back(
      array<double>("Float64", "normal", 3, surface.count, [&](int n, int c) { return cloud.facets[n].normal[c]; }));
  add_labels(t, labels, surface);
  add_cells([&](int n) -> const Vec3& { return outlines[n / corners][n % corners]; }, surface);
  write_grid(cloud.comm, folder, name, surface);
}

class VtuWriter final : public FieldWriter {
 public:
  using FieldWriter::FieldWriter;

 private:
  void write_files(const std::vector<Field>& points, const std::vector<Field>& facets) override {
    const double t = written().back().t;
    const std::string number = fmt::format("{:04}", written().size() - 1);
    write_points(cloud(), t, folder() + "/fields", "fields_" + number, points, of_points());
    write_surface(cloud(), outlines(), t, folder() + "/fields", "surface_" + number, facets, of_facets());
  }

  void write_lists() const override {
    for (const auto& [name, suffix] : {std::pair{"fields", "vtu"}, std::pair{"surface", "vtp"}}) {
      std::string text = "<Collection>\n";
      for (std::size_t n = 0; n < written().size(); ++n)
        text += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"fields/{}_{:04}.{}{}\"/>\n", written()[n].t,
                            name, n, written()[n].ranks > 1 ? "p" : "", suffix);
      replace_file(fmt::format("{}/{}.pvd", folder(), name),
                   head_of_file("Collection") + text + "</Collection>\n</VTKFile>\n");
    }
  }
};

}  // namespace

void write_cloud(const Cloud& cloud, const std::string& stem, const std::vector<Field>& points) {
  const std::filesystem::path path(stem);
  const std::string folder = path.has_parent_path() ? path.parent_path().string() : ".";
  std::vector<Label> of_points, of_facets;
  add_labels_of_points(cloud, of_points), add_labels_of_facets(cloud, of_facets);
  write_points(cloud, 0, folder, path.filename().string(), points, of_points);
  write_surface(cloud, outlines_of(cloud), 0, folder, path.filename().string() + "-surface", {}, of_facets);
}

std::unique_ptr<FieldWriter> make_vtu_writer(FieldSetup setup) { return std::make_unique<VtuWriter>(std::move(setup)); }

}  // namespace calor
