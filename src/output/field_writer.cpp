#include "output/field_writer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "cloud/cell_integrals.hpp"
#include "output/files.hpp"

namespace calor {
namespace {

/// The polygon of a facet whose places are given, with weights that add up to its area: of their middle and spread, in
/// its tangential plane, as large as the facet. Exact for the rectangles of boxes.
std::array<Vec3, 4> outline(const Facet& facet, std::span<const Vec3> x, std::span<const double> weight,
                            int dimension) {
  const Vec3& n = facet.normal;
  int across = 0;  // the axis that lies flattest
  for (int axis = 1; axis < dimension; ++axis)
    if (std::abs(n[axis]) < std::abs(n[across])) across = axis;
  Vec3 axis;
  axis[across] = 1;
  const Vec3 first = dimension == 3 ? 1 / norm(cross(n, axis)) * cross(n, axis) : Vec3{-n.y, n.x, 0},
             second = cross(n, first);
  Vec3 middle;
  for (std::size_t k = 0; k < x.size(); ++k) middle += weight[k] / facet.area * x[k];
  const auto width = [&](const Vec3& along) {  // of a rectangle of this spread
    double spread = 0;
    for (std::size_t k = 0; k < x.size(); ++k)
      spread += weight[k] / facet.area * std::pow(dot(x[k] - middle, along), 2);
    return std::sqrt(12 * spread);
  };
  double a = width(first), b = 0;
  if (dimension == 3) {
    b = width(second);
    if (!(a * b > 0)) a = b = 1;  // its shape is not known
    const double scale = std::sqrt(facet.area / (a * b));
    a *= scale, b *= scale;
  }
  const Vec3 u = 0.5 * a * first, v = 0.5 * b * second;
  return {middle - u - v, middle + u - v, middle + u + v, middle - u + v};
}

}  // namespace

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

void add_labels_of_points(const Cloud& cloud, std::vector<Label>& labels) {
  labels.push_back({"id", {}, {cloud.id.begin(), cloud.id.begin() + cloud.owned}});
  labels.push_back({"tag", cloud.tags, {cloud.tag.begin(), cloud.tag.begin() + cloud.owned}});
}

void add_labels_of_facets(const Cloud& cloud, std::vector<Label>& labels) {
  Label face{"face", cloud.faces}, point{"point", {}};
  for (const Facet& facet : cloud.facets) {
    face.values.push_back(facet.face);
    point.values.push_back(cloud.id[facet.point]);
  }
  labels.insert(labels.end(), {face, point});
}

int corners_of_facet(const Cloud& cloud) { return cloud.dimension == 3 ? 4 : cloud.dimension; }

std::vector<std::array<Vec3, 4>> outlines_of(const Cloud& cloud) {
  std::vector<int> facets(cloud.facets.size());
  std::iota(facets.begin(), facets.end(), 0);
  const CellIntegrals integrals(cloud);
  const CellSamples places = integrals.facets(facets);
  std::vector<std::array<Vec3, 4>> outlines;
  for (const int n : facets) {
    const auto begin = places.row[n], count = places.row[n + 1] - begin;
    const auto of_facet = [&](const auto& all) { return std::span(all).subspan(begin, count); };
    outlines.push_back(outline(cloud.facets[n], of_facet(places.x), of_facet(places.weight), cloud.dimension));
  }
  return outlines;
}

FieldWriter::FieldWriter(FieldSetup setup) : setup_(std::move(setup)) {
  add_labels_of_points(cloud(), setup_.of_points), add_labels_of_facets(cloud(), setup_.of_facets);
  outlines_ = outlines_of(cloud());
}

void FieldWriter::open() {
  make_folder(cloud().comm, folder() + "/fields");
  collective_try(cloud().comm, [&] {
    if (rank_of(cloud().comm) == 0) write_lists();
  });
}

void FieldWriter::exchange(Archive& archive) {
  std::size_t count = written_.size();
  archive.value("times of fields", count);
  written_.resize(count);
  for (auto& [t, ranks, start] : written_) {
    archive.value("fields at time", t);
    archive.value("written by ranks", ranks);
    archive.value("since time number", start);
  }
  if (archive.reads()) start_ = static_cast<int>(count);
  exchange_own(archive);
}

void FieldWriter::write(double t, const std::vector<Field>& points, const std::vector<Field>& facets) {
  written_.push_back({t, size_of(cloud().comm), start_});
  write_files(points, facets);
  collective_try(cloud().comm, [&] {
    if (rank_of(cloud().comm) == 0) write_lists();
  });
}

}  // namespace calor
