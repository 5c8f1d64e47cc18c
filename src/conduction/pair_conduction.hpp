#pragma once
// Conduction by pairs of points: one symmetric weight G_ij per pair; every formula here is linear in G.
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/heat_term.hpp"

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

class PairConduction final : public Conduction {
 public:
  /// G[n] belongs to neighbours.column[n], m^3/m^2 = m; G_ij = G_ji to the last bit on both sides.
  PairConduction(const Cloud& cloud, Neighbours neighbours, std::vector<double> G, CrackBonds cracks = {});

  void add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const override;
  void add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const override;
  void add_row_sums(const Conductivity& k, std::span<double> sums) const override;
  void heat_flux(const Conductivity& k, std::span<const double> T, std::span<Vec3> q) const override;
  using Conduction::add_jacobian, Conduction::add_rate, Conduction::add_row_sums, Conduction::heat_flux;
  std::span<const std::int32_t> coupled(int i) const override { return neighbours_.of(i); }
  Traits traits() const override { return {.is_constant = closed_.openings.empty()}; }
  std::vector<double> events() const override { return closed_.openings; }
  /// Opens the cracks whose time has come.
  void apply(double t) override;

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
  CrackBonds closed_;              ///< bonds of cracks that have not opened
  std::vector<Contact> contacts_;  ///< by entry
};

}  // namespace calor
