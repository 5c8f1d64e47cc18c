#pragma once
// How much of a material every point of a body stands for.
#include <cstdint>
#include <string>
#include <vector>

#include "solve/heat_system.hpp"

namespace calor {

/// A material fills slices of cells whose points do not lie in it, or lie beyond another one: these slices are as warm
/// as the points of the material next to them.
class MaterialVolumes {
 public:
  /// The system must outlive this. Throws Error, maybe on one rank alone.
  explicit MaterialVolumes(HeatSystem& system);

  struct Material {
    std::vector<char> lies_in;   ///< does a local point lie in it?
    std::vector<double> volume;  ///< of local points, m^3; owned points have all, once added up over the ranks
  };
  /// Of the layers and regions of that material. Collective.
  Material of(const std::string& material) const;

 private:
  /// From the point of a cell that several parts share to a point next to it.
  struct Ray {
    int i;
    std::int32_t j;
  };
  void add_slices(const std::string& material, std::size_t first_ray, double volume, Material& found) const;
  int nearest_in(const std::vector<char>& lies_in, int i) const;

  HeatSystem& system_;
  std::vector<Ray> rays_;  ///< those of a cell in a row
  Parts::Pieces pieces_;   ///< of the rays
};

}  // namespace calor
