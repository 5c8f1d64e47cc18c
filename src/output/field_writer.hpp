#pragma once
// Files of fields: what the formats have in common. A format is one file and its name in field_formats.cpp.
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "case/registry.hpp"
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

/// The text as it stands in XML.
std::string escaped(const std::string& text);

/// The labels that every cloud has: id and tag of the points, face of the facets and the id of their points.
void add_labels_of_points(const Cloud& cloud, std::vector<Label>& labels);
void add_labels_of_facets(const Cloud& cloud, std::vector<Label>& labels);

/// Polygons that stand for the facets, as large as these. Corners of a facet: 4 in space, 2 in the plane, 1 on a line.
int corners_of_facet(const Cloud& cloud);
std::vector<std::array<Vec3, 4>> outlines_of(const Cloud& cloud);

/// What is written of a cloud along with the fields. The cloud must outlive this.
struct FieldSetup {
  const Cloud& cloud;
  std::string folder;  ///< of the results
  std::vector<Label> of_points = {}, of_facets = {};
};

class FieldWriter {
 public:
  /// Of a point id, tag, volume and spacing are written along, of a facet its face, area, outward normal and the id of
  /// its point. Collective.
  explicit FieldWriter(FieldSetup setup);
  virtual ~FieldWriter() = default;
  /// Makes the folder and the files that list the times, with the times that `exchange` has read. Throws Error(file).
  /// Collective.
  void open();
  /// Stores the list of the times.
  void exchange(Archive& archive);
  bool has(double t) const { return !written_.empty() && written_.back().t == t; }
  /// Adds a time, with fields of the owned points and of Cloud::facets; the first of each is what viewers show. The
  /// lists of the times are complete after every call. Collective.
  void write(double t, const std::vector<Field>& points, const std::vector<Field>& facets);

 protected:
  struct Written {
    double t;   ///< s
    int ranks;  ///< that wrote it
    int start;  ///< number of the first time that was written since the run was started, anew or again
  };
  const Cloud& cloud() const { return setup_.cloud; }
  const std::string& folder() const { return setup_.folder; }
  const std::vector<Label>& of_points() const { return setup_.of_points; }
  const std::vector<Label>& of_facets() const { return setup_.of_facets; }
  std::span<const std::array<Vec3, 4>> outlines() const { return outlines_; }
  std::span<const Written> written() const { return written_; }

 private:
  /// Writes the files of a time, `written().back()`. Collective.
  virtual void write_files(const std::vector<Field>& points, const std::vector<Field>& facets) = 0;
  /// Writes the files that list the times. On rank 0 alone; throws Error(file).
  virtual void write_lists() const = 0;
  virtual void exchange_own(Archive&) {}

  FieldSetup setup_;
  std::vector<std::array<Vec3, 4>> outlines_;  ///< of the facets
  std::vector<Written> written_;
  int start_ = 0;  ///< times that were written before
};

/// A value of [output] format.
struct FieldFormat {
  std::string name, sentence;
  std::unique_ptr<FieldWriter> (*make)(FieldSetup setup);
  std::vector<std::string> files;  ///< as `remove_files` takes them
};
Registry<FieldFormat>& field_formats();

}  // namespace calor
