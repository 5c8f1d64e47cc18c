#pragma once
// Surface fluxes where the points lie off the walls: the heat passes the layer between the wall and its point first.
#include <span>
#include <vector>

#include "boundary/conditions.hpp"
#include "cloud/cloud.hpp"
#include "conduction/heat_term.hpp"
#include "conduction/wall_layers.hpp"

namespace calor {

/// All surface fluxes on the facets of a cloud without points on its walls. The temperature T_w of each facet follows
/// from that of its point i, at the distance y behind it, by the balance of the wall, which holds no heat:
///   sum_m A_m q_m(x, t, T_w) + A k(T_i) / y (T_i - T_w) = 0,   F_i += sum_m A_m q_m(x, t, T_w).
/// k is that across the wall, k n.R n where the material conducts differently by direction; where several parts lie
/// there, their conductance takes the place of A k / y.
/// So linear laws act by the conductance 1 / (1/h + y/k), and the heat is of second order in y. A is the part of the
/// facet on which fluxes act. Several fluxes on one facet see the same T_w.
class WallFluxes final : public HeatTerm {
 public:
  /// `terms`: those on plates are left out. `layers`: see Discretisation. All but the material must outlive this.
  /// Collective.
  WallFluxes(const Cloud& cloud, const MaterialField& material, std::span<const SurfaceTerm> terms,
             const WallLayers* layers);

  void add_rate(Evaluation& at, std::span<double> F, std::span<double> power) override;
  void add_jacobian(Evaluation& at, JacobianEntries& J) override;
  void add_row_sums(Evaluation& at, std::span<double> sums) override;
  Traits traits() const override;
  Changes changes() const override;

  /// Sets T[n] of Cloud::facets[n] that carry a flux to the temperature of the wall there, K.
  void wall_temperatures(Evaluation& at, std::span<double> T);

 private:
  /// A facet with fluxes. W, K, m.
  struct Wall {
    int facet, point;
    double share, area_over_depth;  ///< of the facet on which fluxes act; its A / y
    // At the state that was solved last:
    double G, T_point, T;    ///< conductance of the layer; temperatures of point and wall
    double given, Q, slope;  ///< heat that does not depend on T; all heat, and its derivative by T
    double low, high, step;  ///< between which T lies; the last step towards it
    bool is_open;            ///< still sought
  };
  struct Flux {
    const SurfaceTerm* term;
    std::vector<int> wall;  ///< of every place
    std::vector<double> T = {}, q = {}, dq_dT = {}, q_new = {}, dq_dT_new = {};
  };

  void find_walls();
  void count_direction(const MaterialField& material);
  /// Fills the state of all walls and the fluxes at all places.
  void solve(Evaluation& at);
  void begin(Evaluation& at);
  void bound_by_ambients(double t);
  void evaluate(Flux& flux, double t);
  void take_step(Wall& wall) const;
  double derivative(const Wall& wall, std::span<const double> k, std::span<const double> dk_dT) const;
  Coefficients& coefficients(Evaluation& at) const { return at.at(layers_ ? layers_->location : Evaluation::nodes); }

  const Cloud& cloud_;
  const WallLayers* layers_;
  std::vector<Flux> fluxes_;
  std::vector<Wall> walls_;
  bool depends_on_T_ = false, is_linear_ = true;
};

}  // namespace calor
