#pragma once
// The stiffness of the lambda solve (linear_consistency.cpp) of points on a line, factorised. Conjugate gradients with
// a diagonal preconditioner would take as many iterations as there are points, as each hands on what it knows by one
// support.
#include <span>

#include "base/petsc.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"

namespace calor {

class LineStiffness {
 public:
  /// `held`: do mirror images fix the level of lambda? Without them the first point is held. Collective.
  LineStiffness(const Cloud& cloud, const Neighbours& neighbours, std::span<const double> g, bool held);
  /// z = stiffness^-1 r; three components a point, of which the first counts. Collective.
  void solve(std::span<const double> r, std::span<double> z) const;

 private:
  petsc::Matrix matrix_;
  petsc::Vector work_;
  petsc::LinearSolver solver_;
};

}  // namespace calor
