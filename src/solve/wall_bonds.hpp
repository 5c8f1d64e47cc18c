#pragma once
// Heat through the bonds to mirror images beyond walls of prescribed temperature:
//   F_i += G kbar(k_i, k_m) (T_image - T_i),
// booked to the boundary that holds the wall.
#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "conduction/flux_sites.hpp"
#include "material/material_field.hpp"

namespace calor {

class ImageHeat {
 public:
  /// All of them must outlive this.
  ImageHeat(const WallBonds& bonds, const std::vector<PrescribedTerm>& temperatures, const MaterialField& material);

  // Not collective: formulas may throw on one rank alone. T covers all local points, ghosts up to date.
  void add_rate(double t, const Conductivity& k, std::span<const double> T, std::span<double> F,
                std::span<double> power);
  void add_jacobian(double t, const Conductivity& k, std::span<const double> T, JacobianEntries& J);
  /// Adds to the row sums of |dF_i/dT_j| with the derivative of k left out.
  void add_row_bound(const Conductivity& k, std::span<double> bound) const;

 private:
  /// What the walls give to every image: sum of factor T*, or of factor theta(T*).
  std::span<const double> wall_part(double t, bool of_theta);

  const WallBonds& bonds_;
  const std::vector<PrescribedTerm>& temperatures_;
  const MaterialField& material_;
  struct OnWall {  // the values of one term
    std::vector<std::size_t> value;
    std::vector<Vec3> x;
  };
  std::vector<OnWall> places_;
  bool is_constant_ = true, is_known_[2] = {false, false};
  std::vector<double> wall_part_[2], T_wall_, image_, image_power_;
};

}  // namespace calor
