#include "output/xdmf.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "output/files.hpp"
#include "output/hdf5_file.hpp"

namespace calor {
namespace {

/// An array in a file as XDMF describes it.
struct Item {
  std::string name;    ///< with unit
  int components = 1;  ///< numbers in a row
  bool is_whole = false;

  /// Its name in the file: no unit, and no slash, which would be a path.
  std::string dataset() const {
    std::string out = name.substr(0, name.find(" ["));
    for (char& letter : out)
      if (letter == '/') letter = '_';
    return out;
  }
  std::string unit() const {
    const auto begin = name.find(" [");
    return begin == std::string::npos ? "" : name.substr(begin + 2, name.size() - begin - 3);
  }
  std::string element(std::int64_t rows, const std::string& file_and_group) const {
    const std::string width = components > 1 ? fmt::format(" {}", components) : "";
    return fmt::format(
        "<DataItem Dimensions=\"{}{}\" NumberType=\"{}\" Precision=\"8\" Format=\"HDF\">{}/{}</DataItem>", rows, width,
        is_whole ? "Int" : "Float", file_and_group, escaped(dataset()));
  }
};

/// Points or surface: what the XDMF file of it says.
struct Grid {
  std::string name;                                        ///< of the XDMF file and of the groups
  std::string kind;                                        ///< of the data: "Node" or "Cell"
  int corners;                                             ///< of a cell
  std::int64_t rows;                                       ///< cells on all ranks
  std::vector<Item> fields = {};                           ///< of a time
  std::vector<Item> values = {};                           ///< of the mesh
  std::vector<std::pair<std::string, int>> meanings = {};  ///< of labels: "part core", 1
};

class XdmfWriter final : public FieldWriter {
 public:
  explicit XdmfWriter(FieldSetup setup)
      : FieldWriter(std::move(setup)),
        points_{.name = "fields", .kind = "Node", .corners = 1, .rows = cloud().count},
        surface_{.name = "surface",
                 .kind = "Cell",
                 .corners = corners_of_facet(cloud()),
                 .rows = total(cloud().comm, static_cast<std::int64_t>(cloud().facets.size()))} {
    describe(of_points(), {"volume [m^3]", "spacing [m]"}, points_);
    describe(of_facets(), {"area [m^2]"}, surface_);
    surface_.values.push_back({"normal", 3});
  }

 private:
  static void describe(const std::vector<Label>& labels, const std::vector<std::string>& numbers, Grid& grid) {
    for (const Label& label : labels) {
      grid.values.push_back({label.name, 1, true});
      for (std::size_t n = 0; n < label.called.size(); ++n)
        if (!label.called[n].empty()) grid.meanings.emplace_back(label.name + " " + label.called[n], n);
    }
    for (const std::string& name : numbers) grid.values.push_back({name});
  }

  void write_files(const std::vector<Field>& points, const std::vector<Field>& facets) override {
    const int number = static_cast<int>(written().size()) - 1;
    if (number == written().back().start) write_mesh(number);
    Hdf5File file(cloud().comm, folder() + "/" + file_of_time(number), size_of_time(points, facets));
    put(file, points, points_);
    put(file, facets, surface_);
    file.close();
  }

  void write_mesh(int number) const {
    const Cloud& c = cloud();
    Hdf5File file(c.comm, folder() + "/" + file_of_mesh(number), size_of_mesh());
    file.make_group(points_.name);
    file.write("fields/places", 3, std::span(&c.x.data()->x, 3 * static_cast<std::size_t>(c.owned)), "m");
    write_cells(file, points_, c.owned);
    for (const Label& label : of_points()) file.write("fields/" + label.name, 1, label.values);
    file.write("fields/volume", 1, std::span(c.volume).first(c.owned), "m^3");
    file.write("fields/spacing", 1, std::span(c.spacing).first(c.owned), "m");

    file.make_group(surface_.name);
    std::vector<Vec3> places, normals;
    std::vector<double> areas;
    for (const auto& outline : outlines())
      places.insert(places.end(), outline.begin(), outline.begin() + surface_.corners);
    for (const Facet& facet : c.facets) normals.push_back(facet.normal), areas.push_back(facet.area);
    const auto numbers = [](const std::vector<Vec3>& v) { return std::span(&v.data()->x, 3 * v.size()); };
    file.write("surface/places", 3, numbers(places), "m");
    write_cells(file, surface_, c.facets.size());
    for (const Label& label : of_facets()) file.write("surface/" + label.name, 1, label.values);
    file.write("surface/area", 1, areas, "m^2");
    file.write("surface/normal", 3, numbers(normals));
    file.close();
  }

  /// Bytes of the files without compression, at most.
  std::int64_t size_of_mesh() const {
    constexpr std::int64_t of_point = 16, of_facet = 32;  // numbers: places, cells, values; labels of the case on top
    const auto labels = static_cast<std::int64_t>(of_points().size() + of_facets().size());
    return overhead + bytes * ((of_point + labels) * points_.rows + (of_facet + labels) * surface_.rows);
  }
  std::int64_t size_of_time(const std::vector<Field>& points, const std::vector<Field>& facets) const {
    std::int64_t numbers = 0;
    for (const Field& field : points) numbers += points_.rows * field.components;
    for (const Field& field : facets) numbers += surface_.rows * field.components;
    return overhead + bytes * numbers;
  }

  /// No two cells share a place: their corners are all numbers in order.
  void write_cells(Hdf5File& file, const Grid& grid, std::size_t mine) const {
    std::vector<std::int64_t> corners(mine * grid.corners);
    std::iota(corners.begin(), corners.end(), grid.corners * offset(cloud().comm, static_cast<std::int64_t>(mine)));
    file.write(grid.name + "/cells", grid.corners, corners);
  }

  static void put(Hdf5File& file, const std::vector<Field>& fields, Grid& grid) {
    file.make_group(grid.name);
    grid.fields.clear();
    for (const Field& field : fields) {
      const Item item{field.name, field.components};
      file.write(grid.name + "/" + item.dataset(), field.components, field.values, item.unit());
      grid.fields.push_back(item);
    }
  }

  void write_lists() const override { write_list(points_), write_list(surface_); }

  void write_list(const Grid& grid) const {
    std::string text = "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"" + grid.name +
                       "\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
    for (std::size_t n = 0; n < written().size(); ++n) text += element_of_time(static_cast<int>(n), grid);
    replace_file(fmt::format("{}/{}.xdmf", folder(), grid.name), text + "</Grid>\n</Domain>\n</Xdmf>\n");
  }

  std::string element_of_time(int n, const Grid& grid) const {
    const std::string time = file_of_time(n) + ":/" + grid.name,
                      mesh = file_of_mesh(written()[n].start) + ":/" + grid.name;
    std::string text =
        fmt::format("<Grid Name=\"{}\" GridType=\"Uniform\">\n<Time Value=\"{}\"/>\n", grid.name, written()[n].t);
    const char* shape = grid.corners == 4 ? "Quadrilateral" : grid.corners == 2 ? "Polyline" : "Polyvertex";
    text += fmt::format("<Topology TopologyType=\"{}\" NumberOfElements=\"{}\" NodesPerElement=\"{}\">{}</Topology>\n",
                        shape, grid.rows, grid.corners, Item{"cells", grid.corners, true}.element(grid.rows, mesh));
    text +=
        "<Geometry GeometryType=\"XYZ\">" + Item{"places", 3}.element(grid.rows * grid.corners, mesh) + "</Geometry>\n";
    const auto add = [&](const std::vector<Item>& items, const std::string& where) {
      for (const Item& item : items)
        text += fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"{}\">{}</Attribute>\n",
                            escaped(item.name), item.components > 1 ? "Vector" : "Scalar", grid.kind,
                            item.element(grid.rows, where));
    };
    add(grid.fields, time), add(grid.values, mesh);
    for (const auto& [what, value] : grid.meanings)
      text += fmt::format("<Information Name=\"{}\" Value=\"{}\"/>\n", escaped(what), value);
    return text + "</Grid>\n";
  }

  /// The names of the fields, for the lists of times that were written before.
  void exchange_own(Archive& archive) override {
    for (Grid* grid : {&points_, &surface_}) {
      std::size_t count = grid->fields.size();
      archive.value("fields of " + grid->name, count);
      grid->fields.resize(count);
      for (Item& item : grid->fields) {
        archive.text("field", item.name);
        archive.value("components", item.components);
      }
    }
  }

  static std::string file_of_time(int n) { return fmt::format("fields/fields_{:04}.h5", n); }
  static std::string file_of_mesh(int n) { return fmt::format("fields/mesh_{:04}.h5", n); }

  static constexpr std::int64_t bytes = 8, overhead = 100'000;  ///< of a number; of what HDF5 adds

  Grid points_, surface_;
};

}  // namespace

std::unique_ptr<FieldWriter> make_xdmf_writer(FieldSetup setup) {
  return std::make_unique<XdmfWriter>(std::move(setup));
}

}  // namespace calor
