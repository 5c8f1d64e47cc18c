#pragma once
// Integrals over the cells of the points and over their facets, of functions that may jump. What a case says by a
// formula of place is not what holds at the points, it is what the cells and facets hold of it.
#include <memory>
#include <span>
#include <vector>

#include "cloud/cell_samples.hpp"
#include "cloud/cloud.hpp"
#include "cloud/integrand.hpp"

namespace calor {

/// Quadrature of cells and facets. On unjittered lattices they are boxes: a cell in which the function is smooth has
/// Gauss points (exact up to the fifth degree along every axis at least, halved where two rules disagree); where it
/// jumps the box is split at the jump, to round-off where the edge is parallel to the axes, to about 1e-4 of a cell
/// where it is curved. On other clouds cells and facets are samples (CellSampler), more of them where the function
/// jumps. The result for a point follows from the cloud alone, not from the number of ranks. The cloud must stay in
/// place.
class CellIntegrals {
 public:
  explicit CellIntegrals(const Cloud& cloud);
  ~CellIntegrals();

  /// Integral of f over the cell of every owned point: unit of f times m^3.
  std::vector<double> over_cells(const Integrand& f) const;
  /// f at every owned point, but its mean over the cell where it jumps in the cell, or between the point and the places
  /// of its cell, as beside curved walls; where the point lies on a jump at the edge of its cell, the value on the
  /// inner side.
  std::vector<double> values(const Integrand& f) const;

  /// Places and weights (m^3, with the sum of the cell's volume) for all owned points, split where f jumps, so that
  /// functions that jump there and are smooth otherwise are integrated, too. Without f.f: for smooth functions.
  CellSamples cells(const Integrand& f = {}) const;
  /// Appends those of one owned point.
  void add_cell(int i, const Integrand& f, CellSamples& out) const;
  /// The same of some facets of the cloud, by their indices in Cloud::facets: weights in m^2, with the sum of the
  /// facet's area. `point` holds the points of the facets.
  CellSamples facets(std::span<const int> facets, const Integrand& f = {}) const;
  /// Of curved faces the points alone surely lie on the face, and an indicator such as r > 0.999 may be false beside
  /// them. 1 for the facets that bend (to the neighbours on the face) and on which the indicator holds at the point and
  /// at these neighbours: there it holds everywhere. 0 for all others, and on lattices and rings.
  std::vector<char> hold_on_curved(std::span<const int> facets, const Integrand& indicator) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace calor
