#pragma once
// Weights of pairs on a lattice for the edge-stabilised flux: every face takes the differences across it and, with a
// twelfth each, across the faces beside it.
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

struct BrickWeights {
  Neighbours neighbours;  ///< the corners of the bricks between the points around every owned point
  std::vector<double> G;  ///< m, all positive
};

/// G = -sum_a S_a (x) M_b (x) M_c over the bricks between the points of an unjittered lattice with points on the walls:
/// S = [1 -1; -1 1] / D along an axis of length D, M = D [1/2 - mu, mu; mu, 1/2 - mu] across it. With mu = 1/12 the
/// error of the operator is h^2/12 times the Laplacian of what it should be (Collatz, The Numerical Treatment of
/// Differential Equations, Springer 1960: "Mehrstellenverfahren"), so that steady temperatures without sources inside
/// are of fourth order, next to walls that heat flows through, too; mu = 0 would leave the 5 or 7 point formula.
/// Where bricks are flatter than 1 : sqrt(2) mu is smaller, for the sake of positive weights. Collective.
BrickWeights brick_weights(const Cloud& cloud);

}  // namespace calor
