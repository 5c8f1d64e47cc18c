#pragma once
// Heat through the bonds from points to mirror images beyond walls of prescribed temperature:
//   F_i += G kbar(k_i, k_m) (T_image - T_i),
// booked to the boundary that holds the wall. An image stands for a local point m: it has its conductivity and the
// temperature
//   T = sign T_m + sum_n factor_n T*_n(x_n, t)
// (odd reflection: sign = -1 and 2 T*; beyond an edge of two such walls +1; a constant layer: 0 and T*). Where fluxes
// are differences of theta = integral of k dT, theta takes the place of T.
#include <array>
#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "conduction/heat_term.hpp"

namespace calor {

struct ImageBonds {
  /// A wall temperature that enters an image's: Conditions::temperatures[term] at a place on its wall.
  struct Value {
    std::int32_t image, term;
    double factor;
    Vec3 x;
  };
  struct Image {
    std::int32_t point;  ///< m
    double sign;
    std::array<int, 3> term;  ///< of the walls across every axis that give it heat, in equal parts; -1: none
  };
  std::vector<Image> images;
  std::vector<Value> values;
  // One entry a bond, by ascending owned point.
  std::vector<std::int32_t> point, image;
  std::vector<double> G;  ///< m; the bond of j to the image of i has that of i to the image of j
};

class ImageConduction final : public HeatTerm {
 public:
  /// `temperatures` must outlive this.
  ImageConduction(ImageBonds bonds, std::span<const PrescribedTerm> temperatures);

  void add_rate(Evaluation& at, std::span<double> F, std::span<double> power) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;
  void add_row_sums(Evaluation& at, std::span<double> sums) override;
  Traits traits() const override { return {.fixes_level = true}; }

  const ImageBonds& bonds() const { return bonds_; }

 private:
  /// What the walls give to every image: sum of factor T*, or of factor theta(T*).
  std::span<const double> wall_part(Evaluation& at, bool of_theta);

  ImageBonds bonds_;
  std::span<const PrescribedTerm> temperatures_;
  struct OnWall {  // the values of one term
    std::vector<std::size_t> value;
    std::vector<Vec3> x;
  };
  std::vector<OnWall> walls_;
  bool is_constant_ = true, is_known_[2] = {false, false};
  std::vector<double> wall_part_[2], T_wall_, image_, image_power_;
};

}  // namespace calor
