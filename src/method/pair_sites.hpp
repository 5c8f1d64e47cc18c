#pragma once
// Flux sites of the pair methods: one symmetric weight G_ij per pair; every formula here is linear in G.
#include <optional>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "method/flux_sites.hpp"

namespace calor {

class PairSites final : public FluxSites {
 public:
  /// G[n] belongs to neighbours.column[n], m^3/m^2 = m; G_ij = G_ji to the last bit on both sides.
  PairSites(const Cloud& cloud, Neighbours neighbours, std::vector<double> G, std::optional<WallRows> walls = {});

  void add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const override;
  void add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const override;
  bool symmetric(Mean mean, bool k_depends_on_T) const override;
  void add_row_bound(const Conductivity& k, std::span<double> bound) const override;
  void heat_flux(const Conductivity& k, std::span<const double> T, std::span<Vec3> q) const override;
  std::span<const std::int32_t> coupled(int i) const override;
  const WallRows* wall_rows() const override;

  const Neighbours& neighbours() const { return neighbours_; }
  std::span<const double> weights() const { return G_; }

 private:
  const Cloud& cloud_;
  Neighbours neighbours_;
  std::vector<double> G_;
  std::optional<WallRows> walls_;
};

}  // namespace calor
