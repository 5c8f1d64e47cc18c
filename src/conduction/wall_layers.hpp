#pragma once
// What lies between points in the middle of cells and the walls of the body, in lattices of several parts: a wall may
// cut through layers, and others may lie along it.
#include <memory>
#include <span>
#include <vector>

#include "base/symmetric3.hpp"
#include "cloud/cloud.hpp"
#include "conduction/evaluation.hpp"
#include "conduction/quadrature.hpp"
#include "geometry/parts.hpp"

namespace calor {

/// Behind a facet of Cloud::facets heat runs to its point through fibres side by side, each in series:
///   G = sum_f A_f / sum_p (l_p / k_p),   A_f their areas, l_p the ways through the parts.
class WallLayers {
 public:
  /// `R`: of every part whose conductivity is k R, along the axes of the lattice; empty: it is k. Collective; throws
  /// Error(bad_case) where a contact lies between a wall and its point.
  WallLayers(const Cloud& cloud, const Parts& parts, std::span<const Symmetric3> R);

  /// Where conductivities are wanted, and which location of an Evaluation that is.
  const QuadraturePoints& ends() const { return ends_; }
  Location location = Evaluation::nodes;

  /// G of a facet, W/K, and its derivative by the temperature of the point; k and dk/dT at the ends.
  double conductance(int facet, std::span<const double> k) const;
  double derivative(int facet, std::span<const double> k, std::span<const double> dk_dT) const;

 private:
  struct Piece {
    std::int32_t end;  ///< index into ends_
    double length;     ///< m, over R across the wall
  };
  struct Run {
    double area;  ///< m^2
    std::vector<Piece> pieces;
    double resistance(std::span<const double> k) const;  ///< m^2 K/W
  };
  std::vector<std::vector<Run>> runs_;  ///< of every facet
  QuadraturePoints ends_;
};

/// Null where every wall has points on it or one part alone behind each of its points, as far as is known. Collective.
std::unique_ptr<WallLayers> layers_before_walls(const Cloud& cloud, const Parts& parts, std::span<const Symmetric3> R);

}  // namespace calor
