#pragma once
// Points spread over the cells of the points, with weights: integrals over cells, for sources as cell means
// and for capacities.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cloud/cells.hpp"
#include "cloud/cloud.hpp"
#include "cloud/nearest_cell.hpp"

namespace calor {

/// Samples of some owned points, in compressed rows: those of point[k] are row[k] .. row[k+1]. Their weights are m^3
/// of the real body and add up to the volume of the point; the integral of f over its cell is sum weight f(x).
struct CellSamples {
  std::vector<std::int32_t> point;  ///< local indices, ascending
  std::vector<std::int64_t> row = {0};
  std::vector<Vec3> x;
  std::vector<double> weight;
};

/// Distance of a facet from its point, m: 0 on clouds with points on the walls. In boxes the plane of the wall is
/// known; elsewhere the wall lies half a cell away.
double wall_distance(const Cloud& cloud, const Facet& facet);
/// Where the wall is nearest to the point of a facet, m.
Vec3 place_on_wall(const Cloud& cloud, const Facet& facet);

/// Weights of places spread evenly over a cell or facet in the plane of the cloud; they add up to 1. The thickness of
/// an axisymmetric body is that of the place.
std::vector<double> weights_of(const Cloud& cloud, std::span<const Vec3> samples);

/// Makes the samples of a cloud's cells. On an unjittered lattice they are the middles of equal boxes that fill the
/// cell (8 along a whole cell, 4 in 3D); on other clouds one random place in each of as many sub-cells per spacing
/// around the point, kept where no other point is nearer and no wall between: the cell is that of the nearest point.
/// Random because a regular sampling beats with nearly regular clouds. The samples of a point follow from the cloud
/// alone; they do not depend on the number of ranks, nor on which other points are asked for. The cloud must stay in
/// place.
class CellSampler {
 public:
  explicit CellSampler(const Cloud& cloud);

  /// Of all owned points.
  CellSamples all() const;
  /// Of the owned points within `radius` (m) of a place; replaces what `out` held and reuses its memory.
  void near(const Vec3& centre, double radius, CellSamples& out) const;
  /// Places spread evenly over the cell of owned point i, `finer` times as many along every axis; replaces what `out`
  /// held.
  void of(int i, int finer, std::vector<Vec3>& out) const;
  /// The same on a cloud that is no lattice, by cubes that have one place of `of(i, 1)` each.
  void of(int i, int finer, std::vector<Vec3>& out, SampleCubes& cubes) const;
  /// No part of the cell of owned point i is farther from it than this many spacings, on a cloud that is no lattice.
  double farthest_in_cell(int i) const;
  /// Places spread evenly over the facet Cloud::facets[n] of a cloud of three dimensions, in its tangential plane.
  void of_facet(int n, int finer, std::vector<Vec3>& out) const;
  /// The nearest other points on the face of a facet.
  void beside_facet(int n, std::vector<Vec3>& out) const;
  /// Where the facet lies on a cloud of two dimensions: along two straight pieces, from ends[0] to ends[1] to ends[2],
  /// towards the neighbours on the same face.
  std::array<Vec3, 3> ends_of_facet(int n) const;

 private:
  void add(int i, CellSamples& out) const;
  void add_boxes(int i, int finer, std::vector<Vec3>& out) const;
  std::vector<Rival> rivals(int i) const;
  template <class Visit>
  void visit_within(const Vec3& centre, double radius, const Visit& visit) const;

  const Cloud& cloud_;
  Cells cells_;
  CellOrder order_;
  std::vector<std::int32_t> patches_of_;  ///< first facet of every owned point, and the end
};

}  // namespace calor
