#pragma once
// Flux sites of the pair methods: one symmetric weight G_ij per pair; every formula here is linear in G.
#include <optional>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/flux_sites.hpp"

namespace calor {

/// A pair across a crack: a fraction of its weight fails when the crack opens, or conducts in series with a contact.
struct CrackBond {
  std::int64_t entry;  ///< in the neighbour lists
  int point;           ///< owned point in whose row it is
  double fraction;
  double contact;  ///< h_c |x_ji . n|, conductance of the contact over the pair's area / length: W/(m K); 0: none
  double opens;    ///< s; 0: open from the start
};

/// All of a rank, and the times at which cracks open, on all ranks.
struct CrackBonds {
  std::vector<CrackBond> bonds;
  std::vector<double> openings;
};

class PairSites final : public FluxSites {
 public:
  /// G[n] belongs to neighbours.column[n], m^3/m^2 = m; G_ij = G_ji to the last bit on both sides.
  PairSites(const Cloud& cloud, Neighbours neighbours, std::vector<double> G, std::optional<WallRows> walls = {},
            std::optional<WallBonds> bonds = {}, CrackBonds cracks = {});

  void add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const override;
  void add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const override;
  bool symmetric(Mean mean, bool k_depends_on_T) const override;
  void add_row_bound(const Conductivity& k, std::span<double> bound) const override;
  void heat_flux(const Conductivity& k, std::span<const double> T, std::span<Vec3> q) const override;
  std::span<const std::int32_t> coupled(int i) const override;
  const WallRows* wall_rows() const override;
  const WallBonds* wall_bonds() const override;
  std::vector<double> events() const override { return closed_.openings; }
  void change(double t) override;

  const Neighbours& neighbours() const { return neighbours_; }
  std::span<const double> weights() const { return G_; }

 private:
  /// What is left of an opened bond: a share G of its weight that conducts in series with the contact.
  struct Contact {
    std::int64_t entry;
    int point;
    double G;
    double contact;
  };

  /// Flux of the pair and the contact in series, per weight.
  template <class Flux>
  double contact_flux(const Contact& c, const Conductivity& k, std::span<const double> T, const Flux& flux) const;

  const Cloud& cloud_;
  Neighbours neighbours_;
  std::vector<double> G_;
  std::optional<WallRows> walls_;
  std::optional<WallBonds> bonds_;
  CrackBonds closed_;              ///< bonds of cracks that have not opened
  std::vector<Contact> contacts_;  ///< by entry
};

}  // namespace calor
