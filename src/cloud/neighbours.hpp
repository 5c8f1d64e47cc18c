#pragma once
// Neighbour lists within the support, by a cell list; beyond plane walls of a box, if asked for, the mirror images of
// its points.
#include <cstdint>
#include <span>
#include <vector>

#include "cloud/cloud.hpp"

namespace calor {

/// x -> sign x + shift, axis by axis: the reflection across one wall, or across several that meet at an edge or corner.
struct Mirror {
  Vec3 sign = {1, 1, 1}, shift = {};

  Vec3 vector(const Vec3& a) const { return {sign.x * a.x, sign.y * a.y, sign.z * a.z}; }
  Vec3 point(const Vec3& x) const { return vector(x) + shift; }
  /// Image of `to` minus `from`; the same bits, reflected, when the two change places.
  Vec3 displacement(const Vec3& from, const Vec3& to) const { return (vector(to) - from) + shift; }
};

/// Reflection for every set of walls that have no axis in common: bit f of its index is the wall at walls[f], normal to
/// axis f / 2. Other sets hold the identity.
std::vector<Mirror> mirrors_of(const std::vector<double>& walls);

/// Does the set hold two opposite walls?
inline bool has_opposite_walls(std::uint32_t set) { return (set & set >> 1 & 0b010101) != 0; }

/// Directed lists in compressed rows: neighbours of owned point i are column[row[i]] .. column[row[i+1]], local indices
/// (ghosts >= cloud.owned), without i itself, in ascending order of id, so that sums over neighbours do not depend on
/// the number of ranks. Mirror images follow, by their walls and then by id; a point's own images are among them.
struct Neighbours {
  std::vector<std::int64_t> row;
  std::vector<std::int32_t> column;
  /// Of every entry: bit f: the neighbour is the mirror image of point column[n] across faces[f] (several bits: across
  /// an edge or corner); 0: the point itself. Empty: there are no images.
  std::vector<std::uint8_t> image = {};
  std::vector<Mirror> mirrors = {};  ///< of every value of `image`
  std::vector<char> mirrored = {};   ///< of every facet of the cloud: mirror images lie beyond it. Empty: nowhere

  std::span<const std::int32_t> of(int i) const {
    return {column.data() + row[i], static_cast<std::size_t>(row[i + 1] - row[i])};
  }
  bool is_image(std::int64_t n) const { return !image.empty() && image[n] != 0; }
  /// x_j - x_i, or x of the image less x_i, of entry n in row i.
  Vec3 x_ji(std::span<const Vec3> x, int i, std::int64_t n) const {
    const Vec3& x_j = x[column[n]];
    return image.empty() ? x_j - x[i] : mirrors[image[n]].displacement(x[i], x_j);
  }
  /// A vector of entry n's point as its image has it.
  Vec3 reflected(const Vec3& a, std::int64_t n) const { return image.empty() ? a : mirrors[image[n]].vector(a); }
};

/// Neighbours::x_ji and reflected for hot loops: compiled with and without images.
template <bool has_images>
struct PairVectors {
  const Neighbours& neighbours;
  const Vec3* x;

  Vec3 x_ji(int i, std::int64_t n) const {
    const Vec3& x_j = x[neighbours.column[n]];
    return has_images ? neighbours.mirrors[neighbours.image[n]].displacement(x[i], x_j) : x_j - x[i];
  }
  Vec3 reflected(const Vec3& a, std::int64_t n) const {
    return has_images ? neighbours.mirrors[neighbours.image[n]].vector(a) : a;
  }
};

/// Calls use(PairVectors).
template <class Use>
void with_pair_vectors(const Neighbours& neighbours, std::span<const Vec3> x, const Use& use) {
  if (neighbours.image.empty())
    use(PairVectors<false>{neighbours, x.data()});
  else
    use(PairVectors<true>{neighbours, x.data()});
}

/// All pairs whose x_j - x_i lies in the ellipsoid support.radius((s_i + s_j) / 2) (1 - 1e-9), s the metric of the
/// points. Refuses points that coincide (closer than 1e-9 of that). With `mirrored_faces` (bit f: faces[f], of a box)
/// images across these faces, their edges and corners count too; refuses a body so thin that images of images would be
/// within reach. Collective; throws Error.
Neighbours find_neighbours(const Cloud& cloud, const Support& support, std::uint32_t mirrored_faces = 0);

/// Refuses points with fewer neighbours than the body has dimensions (ends of a line: one), which cannot carry heat in
/// every direction. Collective; throws Error.
void require_neighbours(const Cloud& cloud, const Neighbours& neighbours);

}  // namespace calor
