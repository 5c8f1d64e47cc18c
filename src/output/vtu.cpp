#include "output/vtu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <functional>

#include "base/parallel.hpp"
#include "output/files.hpp"

namespace calor {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string vtk_file(const std::string& type, const std::string& content) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\">\n{}",
      type, std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", content);
}

/// One array of a piece; its numbers are made when they are written, a chunk at a time.
struct Array {
  std::string type, name;
  int components;
  std::uint64_t bytes;
  std::function<void(std::FILE*)> write;

  /// DataArray, or PDataArray with prefix "P".
  std::string declared(const std::string& prefix, const std::string& more) const {
    return fmt::format("<{}DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"{}/>\n", prefix, type,
                       escaped(name), components, more);
  }
};

/// An array of make(point, component).
template <class Number, class Make>
Array array(const std::string& type, const std::string& name, int components, int points, Make make) {
  const std::uint64_t bytes = sizeof(Number) * components * static_cast<std::uint64_t>(points);
  return {type, name, components, bytes, [=](std::FILE* file) {
            constexpr int most = 1 << 14;
            std::vector<Number> chunk;
            for (int begin = 0; begin < points; begin += most) {
              chunk.clear();
              for (int i = begin; i < std::min(points, begin + most); ++i)
                for (int c = 0; c < components; ++c) chunk.push_back(static_cast<Number>(make(i, c)));
              std::fwrite(chunk.data(), sizeof(Number), chunk.size(), file);
            }
          }};
}

std::vector<Array> point_arrays(const Cloud& cloud, const std::vector<Field>& fields) {
  std::vector<Array> arrays;
  for (const Field& f : fields)
    arrays.push_back(array<double>("Float64", f.name, f.components, cloud.owned, [&f](int i, int c) {
      return f.values[static_cast<std::size_t>(i) * f.components + c];
    }));
  arrays.push_back(array<std::int64_t>("Int64", "id", 1, cloud.owned, [&cloud](int i, int) { return cloud.id[i]; }));
  arrays.push_back(array<std::int64_t>("Int64", "tag", 1, cloud.owned, [&cloud](int i, int) { return cloud.tag[i]; }));
  return arrays;
}

/// Names of the tags as a VTK string array (codes of the characters, 0 after each text), and the time.
std::string field_data(const Cloud& cloud, double t) {
  std::string codes;
  for (const std::string& tag : cloud.tags) {
    for (unsigned char c : tag) codes += fmt::format("{} ", c);
    codes += "0 ";
  }
  return fmt::format(
      "<FieldData>\n"
      "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n"
      "<DataArray type=\"String\" Name=\"tag names\" NumberOfTuples=\"{}\" format=\"ascii\">{}</DataArray>\n"
      "</FieldData>\n",
      t, cloud.tags.size(), codes);
}

/// The owned points of one rank, as vertex cells. Throws Error(file).
void write_piece(const std::string& path, const Cloud& cloud, double t, const std::vector<Array>& data) {
  const int n = cloud.owned;
  const Array points = array<double>("Float64", "Points", 3, n, [&cloud](int i, int c) { return cloud.x[i][c]; });
  const std::vector<Array> cells{
      array<std::int64_t>("Int64", "connectivity", 1, n, [](int i, int) { return i; }),
      array<std::int64_t>("Int64", "offsets", 1, n, [](int i, int) { return i + 1; }),
      array<std::uint8_t>("UInt8", "types", 1, n, [](int, int) { return 1; }),  // 1: VTK_VERTEX
  };

  std::uint64_t offset = 0;
  std::vector<const Array*> in_order;
  const auto appended = [&](const Array& a) {
    std::string text = a.declared("", fmt::format(" format=\"appended\" offset=\"{}\"", offset));
    offset += sizeof(std::uint64_t) + a.bytes;
    in_order.push_back(&a);
    return text;
  };
  std::string head = "<UnstructuredGrid>\n" + field_data(cloud, t);
  head += fmt::format("<Piece NumberOfPoints=\"{0}\" NumberOfCells=\"{0}\">\n<PointData>\n", n);
  for (const Array& a : data) head += appended(a);
  head += "</PointData>\n<Points>\n" + appended(points) + "</Points>\n<Cells>\n";
  for (const Array& a : cells) head += appended(a);
  head += "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";

  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file) refuse_writing(path, errno);
  fmt::print(file, "{}", vtk_file("UnstructuredGrid", head));
  for (const Array* a : in_order) {
    std::fwrite(&a->bytes, sizeof a->bytes, 1, file);
    a->write(file);
  }
  fmt::print(file, "\n</AppendedData>\n</VTKFile>\n");
  const bool failed = std::ferror(file) != 0;
  if (std::fclose(file) != 0 || failed) refuse_writing(path, errno);
}

std::string list_of_pieces(const std::string& name, int ranks, const std::vector<Array>& data) {
  std::string text = "<PUnstructuredGrid GhostLevel=\"0\">\n<PPointData>\n";
  for (const Array& a : data) text += a.declared("P", "");
  text +=
      "</PPointData>\n<PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n</PPoints>\n";
  for (int r = 0; r < ranks; ++r) text += fmt::format("<Piece Source=\"{}_{}.vtu\"/>\n", name, r);
  return vtk_file("PUnstructuredGrid", text + "</PUnstructuredGrid>\n</VTKFile>\n");
}

}  // namespace

FieldWriter::FieldWriter(const Cloud& cloud, std::string folder) : cloud_(cloud), folder_(std::move(folder)) {
  make_folder(cloud.comm, folder_ + "/fields");
  collective_try(cloud.comm, [&] {
    if (rank_of(cloud.comm) == 0) replace_file(folder_ + "/fields.pvd", collection());
  });
}

void FieldWriter::write(double t, const std::vector<Field>& fields) {
  const int rank = rank_of(cloud_.comm), ranks = size_of(cloud_.comm);
  const std::string name = fmt::format("fields_{:04}", written_.size());
  const std::string stem = folder_ + "/fields/" + name;
  const std::vector<Array> data = point_arrays(cloud_, fields);
  collective_try(cloud_.comm, [&] {
    write_piece(ranks == 1 ? stem + ".vtu" : fmt::format("{}_{}.vtu", stem, rank), cloud_, t, data);
    if (rank == 0 && ranks > 1) replace_file(stem + ".pvtu", list_of_pieces(name, ranks, data));
  });
  written_.emplace_back(t, fmt::format("fields/{}.{}", name, ranks == 1 ? "vtu" : "pvtu"));
  collective_try(cloud_.comm, [&] {
    if (rank == 0) replace_file(folder_ + "/fields.pvd", collection());
  });
}

std::string FieldWriter::collection() const {
  std::string text = "<Collection>\n";
  for (const auto& [t, file] : written_)
    text += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", t, file);
  return vtk_file("Collection", text + "</Collection>\n</VTKFile>\n");
}

}  // namespace calor
