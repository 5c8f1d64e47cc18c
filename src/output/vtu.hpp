#pragma once
// Fields for ParaView, VTK, pyvista and meshio: at every time the points as an unstructured grid (VTU) and the surface
// as polygons (VTP), appended-raw, one file a rank with a PVTU or PVTP over several ranks; and a PVD over the times of
// each. Names of tags, parts, faces and conditions are in the field data, as arrays of one integer: "tag core" = 1.
// (Not as texts: meshio reads none.)
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cloud/cloud.hpp"

namespace calor {

class Archive;

struct Field {
  std::string name;                ///< with unit, if it has one: "temperature [K]"
  int components = 1;              ///< 1 or 3
  std::span<const double> values;  ///< one entry a point or facet of this rank, row-major
};

/// A whole number a point or facet, such as that of its part, and what it stands for.
struct Label {
  std::string name;                    ///< "part"
  std::vector<std::string> called;     ///< by number, the same on all ranks; empty names are left out
  std::vector<std::int64_t> values{};  ///< of the owned points or the facets of this rank
};

/// Writes the points alone, as `stem`.vtu, and the surface, as `stem`-surface.vtp, with what FieldWriter writes along.
/// Throws Error(file). Collective.
void write_cloud(const Cloud& cloud, const std::string& stem, const std::vector<Field>& points);

class FieldWriter {
 public:
  /// Writes below `folder`/fields, and `folder`/fields.pvd and surface.pvd. Of a point id, tag, volume and spacing are
  /// written along, of a facet its face, area, outward normal and the id of its point; `of_points` and `of_facets` are
  /// more of the kind. The cloud must outlive this. Collective.
  FieldWriter(const Cloud& cloud, std::string folder, std::vector<Label> of_points = {},
              std::vector<Label> of_facets = {});
  /// Makes the folder and the PVD files, with the times that `exchange` has read. Throws Error(file). Collective.
  void open();
  /// Stores the list of the times.
  void exchange(Archive& archive);
  bool has(double t) const { return !written_.empty() && written_.back().t == t; }
  /// Adds a time, with fields of the owned points and of Cloud::facets; the first of each is what viewers show. The PVD
  /// files are complete after every call. Collective.
  void write(double t, const std::vector<Field>& points, const std::vector<Field>& facets);

 private:
  void write_collections() const;

  const Cloud& cloud_;
  std::string folder_;
  std::vector<Label> of_points_, of_facets_;
  std::vector<std::array<Vec3, 4>> outlines_;  ///< of the facets
  struct Written {
    double t;         ///< s
    bool is_divided;  ///< into pieces of several ranks
  };
  std::vector<Written> written_;
};

}  // namespace calor
