#pragma once
// Heat through walls of prescribed temperature that no point holds, booked to the boundary that holds the wall: by
// mirror images beyond it, by the layer before it, or by a penalty.
#include <array>
#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "conduction/heat_term.hpp"
#include "conduction/wall_layers.hpp"

namespace calor {

/// Bonds from points to mirror images beyond walls:
///   F_i += G kbar(k_i, k_m) (T_image - T_i).
/// An image stands for a local point m: it has its conductivity and the temperature
///   T = sign T_m + sum_n factor_n T*_n(x_n, t)
/// (odd reflection: sign = -1 and 2 T*; beyond an edge of two such walls +1; a constant layer: 0 and T*). Where fluxes
/// are differences of theta = integral of k dT, theta takes the place of T.
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

/// Walls of prescribed temperature T* off the points, beyond which no images lie: into point i, the distance y behind
/// its facet of area A, flows what the layer between them conducts,
///   F_i += A k(T_i) / y (T* - T_i),
/// or the conductance of the parts that lie there.
class SeriesWalls final : public HeatTerm {
 public:
  /// `layers`: see Discretisation. All must outlive this.
  SeriesWalls(const Cloud& cloud, std::span<const PrescribedTerm> temperatures, const WallLayers* layers = nullptr);

  void add_rate(Evaluation& at, std::span<double> F, std::span<double> power) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;
  void add_row_sums(Evaluation& at, std::span<double> sums) override;
  Traits traits() const override { return {.fixes_level = has_walls_}; }

 private:
  struct Wall {
    int point, facet;
    double share, area_over_depth;  ///< of the term in the facet; its A / y, m
  };
  double conductance(const Wall& wall, std::span<const double> k) const {
    return layers_ ? wall.share * layers_->conductance(wall.facet, k) : wall.area_over_depth * k[wall.point];
  }
  double derivative(const Wall& wall, std::span<const double> k, std::span<const double> dk_dT) const {
    if (dk_dT.empty()) return 0;
    return layers_ ? wall.share * layers_->derivative(wall.facet, k, dk_dT) : wall.area_over_depth * dk_dT[wall.point];
  }
  /// Where they want k.
  Coefficients& coefficients(Evaluation& at) const { return at.at(layers_ ? layers_->location : Evaluation::nodes); }
  /// Calls use(term, wall, T*) for all facets.
  template <class Use>
  void for_each_facet(double t, const Use& use);

  std::span<const PrescribedTerm> temperatures_;
  const WallLayers* layers_;
  std::vector<std::vector<Wall>> walls_;  ///< of every term
  bool has_walls_ = false;
  std::vector<double> T_wall_;
};

/// Walls that a penalty holds at their temperature (as in the papers on MLPG): into point i of the wall flows the heat
///   F_i += k_i [slope . u + stiffness (T* - T(x_i))],
/// that of the temperature's gradient and that of the penalty. For every one of Conditions::temperatures, its points.
struct PenaltyRows {
  std::vector<SparseRows> slope;               ///< area . grad T, m
  std::vector<std::vector<double>> stiffness;  ///< m
};

class PenaltyWalls final : public HeatTerm {
 public:
  /// `temperatures` must outlive this.
  PenaltyWalls(PenaltyRows rows, std::span<const PrescribedTerm> temperatures)
      : rows_(std::move(rows)), temperatures_(temperatures) {}

  void add_rate(Evaluation& at, std::span<double> F, std::span<double> power) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;
  void add_row_sums(Evaluation& at, std::span<double> sums) override;
  Traits traits() const override { return {.is_symmetric = false, .fixes_level = true}; }

 private:
  /// Calls use(m, n, flux over k) for point n of term m.
  template <class Use>
  void for_each_point(Evaluation& at, const Use& use);

  PenaltyRows rows_;
  std::span<const PrescribedTerm> temperatures_;
  std::vector<double> T_star_, row_;
};

}  // namespace calor
