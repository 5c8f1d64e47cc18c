#pragma once
// Conduction by pairs of points: one symmetric weight G_ij per pair; every formula here is linear in G. Pairs across
// interfaces and cracks are kept apart.
#include <vector>

#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/heat_term.hpp"
#include "conduction/pair_directions.hpp"
#include "conduction/pair_rows.hpp"
#include "conduction/series_pairs.hpp"

namespace calor {

class PairConduction final : public Conduction {
 public:
  /// G[n] belongs to neighbours.column[n], m^3/m^2 = m; G_ij = G_ji to the last bit on both sides. One part alone, no
  /// cracks.
  PairConduction(const Cloud& cloud, Neighbours neighbours, std::vector<double> G);
  /// In a body of several parts, with cracks, or of materials that conduct differently by direction. Collective; throws
  /// Error.
  PairConduction(const Cloud& cloud, const Parts& parts, Neighbours neighbours, std::vector<double> G,
                 CrackBonds cracks = {}, const PairDirections& directions = {});

  void add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const override;
  void add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const override;
  void add_row_sums(const Conductivity& k, std::span<double> sums) const override;
  void heat_flux(const Conductivity& k, std::span<const double> T, std::span<const int> points,
                 std::span<Vec3> q) const override;
  bool multiplies() const override { return true; }
  void add_product(const Conductivity& k, std::span<const double> T, std::span<const double> v,
                   std::span<double> F) const override;
  using Conduction::add_jacobian, Conduction::add_product, Conduction::add_rate, Conduction::add_row_sums,
      Conduction::heat_flux;
  std::span<const std::int32_t> coupled(int i, std::vector<std::int32_t>& buffer) const override;
  Traits traits() const override {
    return {.is_symmetric = !series_.depends_on_T(),
            .is_constant = series_.openings().empty() && !series_.depends_on_T() && !series_.depends_on_time()};
  }
  Changes changes() const override { return series_.changes(); }
  /// Opens the cracks whose time has come.
  void apply(double t) override { series_.open(t); }
  const QuadraturePoints* ends() const override { return series_.exist() ? &series_.ends() : nullptr; }

  const PairRows& rows() const { return rows_; }

 private:
  const Cloud& cloud_;
  SeriesPairs series_;
  PairRows rows_;             ///< G, 0 for the pairs in series_
  Symmetric3 R_ = {1, 1, 1};  ///< that the weights hold in the whole body; or
  /// Where every part has an R of its own, along which the weights hold it: those R and the parts of the owned points.
  std::vector<Symmetric3> R_of_parts_;
  std::vector<int> part_;
};

}  // namespace calor
