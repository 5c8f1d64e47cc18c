#pragma once
// Moving least squares at one place, for tests.
#include <span>
#include <vector>

#include "conduction/mls.hpp"

namespace calor {

/// Shape functions at one place with their full gradients.
struct ShapesAtPlace {
  bool fitted;
  std::vector<double> phi;
  std::vector<Vec3> gradient;
};

/// All nodes count; R: semi-axes of their supports.
inline ShapesAtPlace shape_functions(const MovingLeastSquares& mls, const Vec3& x, std::span<const Vec3> nodes,
                                     std::span<const Vec3> R) {
  std::vector<MlsNode> all;
  for (std::size_t k = 0; k < nodes.size(); ++k) all.push_back({nodes[k], quotient({1, 1, 1}, R[k])});
  MlsPlaces places;  // the same three times, once for every axis
  for (int a = 0; a < 3; ++a) places.add(x, {a == 0 ? 1. : 0., a == 1 ? 1. : 0., a == 2 ? 1. : 0.});
  std::vector<MlsPlaces::Lanes> phi(all.size()), slope(all.size());
  const std::vector<std::uint8_t> sees(all.size(), 0b111);
  ShapesAtPlace out{mls.evaluate(places, all, sees, phi, slope) == 0b111, {}, {}};
  for (std::size_t k = 0; k < all.size(); ++k)
    out.phi.push_back(phi[k][0]), out.gradient.push_back({slope[k][0], slope[k][1], slope[k][2]});
  return out;
}

}  // namespace calor
