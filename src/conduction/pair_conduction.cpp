#include "conduction/pair_conduction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "conduction/linear_algebra.hpp"
#include "conduction/pair_flux.hpp"

namespace calor {
namespace {

/// F_i += sum_j a_ij v_j of the entries that it is given.
class ProductOfEntries final : public JacobianEntries {
 public:
  ProductOfEntries(std::span<const double> v, std::span<double> F) : v_(v), F_(F) {}
  void add(int row, std::span<const std::int32_t> columns, std::span<const double> values) override {
    for (std::size_t n = 0; n < columns.size(); ++n) F_[row] += values[n] * v_[columns[n]];
  }

 private:
  std::span<const double> v_;
  std::span<double> F_;
};

}  // namespace

PairConduction::PairConduction(const Cloud& cloud, Neighbours neighbours, std::vector<double> G)
    : Conduction(Evaluation::nodes), cloud_(cloud), rows_(std::move(neighbours), std::move(G)) {}

PairConduction::PairConduction(const Cloud& cloud, const Parts& parts, Neighbours neighbours, std::vector<double> G,
                               CrackBonds cracks, const PairDirections& directions)
    : Conduction(Evaluation::nodes),
      cloud_(cloud),
      series_(cloud, parts, neighbours, G, std::move(cracks), directions.of_parts),
      R_of_parts_(directions.of_parts) {
  if (directions.in_weights) R_ = directions.in_weights->power(1);
  if (!R_of_parts_.empty()) {
    collective_try(cloud.comm, [&] { part_ = parts.at(cloud.x, cloud.tag); });
    part_.resize(cloud.owned);
    for (int i = 0; i < cloud.owned; ++i)
      for (auto n = neighbours.row[i]; n < neighbours.row[i + 1]; ++n)
        G[n] *= along(R_of_parts_[part_[i]], neighbours.x_ji(cloud.x, i, n));
  }
  rows_ = PairRows(std::move(neighbours), std::move(G));
}

void PairConduction::add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const {
  rows_.add_fluxes(k, T, F);
  series_.add_rate(k, T, F);
}

void PairConduction::add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const {
  PairRows::Row row;
  std::vector<double> values;
  for (std::int32_t i = 0; i < cloud_.owned; ++i) {
    rows_.read(i, row);
    values.clear();
    double diagonal = 0;
    for (std::size_t n = 0; n < row.column.size(); ++n) {
      const std::int32_t j = row.column[n];
      const auto d = flux_derivatives(k, T[j] - T[i], i, j);
      values.push_back(row.weight[n] * d.by_j);
      diagonal += row.weight[n] * d.by_i;
    }
    row.column.push_back(i);
    values.push_back(diagonal);
    J.add(i, row.column, values);
  }
  series_.add_jacobian(k, T, J);
}

void PairConduction::add_product(const Conductivity& k, std::span<const double> T, std::span<const double> v,
                                 std::span<double> F) const {
  // d(theta_j - theta_i) = k_j dT_j - k_i dT_i; d[kbar (T_j - T_i)] = kbar (dT_j - dT_i) + dkbar (T_j - T_i).
  std::vector<double> dk;
  if (k.mean == Mean::integral) {
    for (std::size_t i = 0; i < v.size(); ++i) dk.push_back(k.k[i] * v[i]);
    rows_.add_fluxes({.mean = k.mean, .k = {}, .dk_dT = {}, .theta = dk}, v, F);
  } else {
    rows_.add_fluxes({.mean = k.mean, .k = k.k, .dk_dT = {}, .theta = {}}, v, F);
    for (std::size_t i = 0; i < k.dk_dT.size(); ++i) dk.push_back(k.dk_dT[i] * v[i]);
    if (!dk.empty()) rows_.add_flux_changes(k, dk, T, F);
  }
  ProductOfEntries product(v, F);
  series_.add_jacobian(k, T, product);
}

void PairConduction::add_row_sums(const Conductivity& k, std::span<double> sums) const {
  // |dF_i/dT_i| + sum_j |dF_i/dT_j| without dk/dT; with G >= 0 it is twice the diagonal for a constant k.
  const Conductivity frozen{.mean = k.mean, .k = k.k, .dk_dT = {}, .theta = {}};
  PairRows::Row row;
  for (std::int32_t i = 0; i < cloud_.owned; ++i) {
    rows_.read(i, row);
    double sum = 0;
    for (std::size_t n = 0; n < row.column.size(); ++n) {
      const auto d = flux_derivatives(frozen, 0, i, row.column[n]);
      sum += std::abs(row.weight[n]) * (std::abs(d.by_i) + std::abs(d.by_j));
    }
    sums[i] += sum;
  }
  series_.add_row_sums(k, sums);
}

void PairConduction::heat_flux(const Conductivity& k, std::span<const double> T, std::span<const int> points,
                               std::span<Vec3> q) const {
  // q_i = -R M_i^-1 sum_j G_ij kbar_ij (T_j - T_i) x_ji with M_i = sum_j G_ij x_ji (x) x_ji: exact for linear T on any
  // cloud. It is built from the pair fluxes, not from k_i grad T, so it does not jump where k does. Where every part
  // has an R of its own, M_i is made of the weights without it instead.
  std::vector<Symmetric3> M_crossing;
  std::vector<Vec3> b_crossing;
  if (ends()) {
    M_crossing.resize(cloud_.owned), b_crossing.resize(cloud_.owned);
    series_.add_moments(k, T, M_crossing, b_crossing);
  }
  using Vector = Doubles<4>;  // x, y, z and what nobody looks at
  const auto place = [x = cloud_.x.data(), last = cloud_.local() - 1](std::int32_t j) CALOR_ALWAYS_INLINE {
    return j < last ? Vector(*reinterpret_cast<const UnalignedDoubles<4>*>(x + j)) : Vector{x[j].x, x[j].y, x[j].z};
  };
  with_flux(k, T, [&](const auto& flux) {
    run_vectorised([&]<int>() CALOR_ALWAYS_INLINE {
      for (std::size_t p = 0; p < points.size(); ++p) {
        const std::int32_t i = points[p];
        const Vector own = place(i);
        Vector squares = {}, mixed = {}, sum = {};
        rows_.for_each_entry(i, [&](std::int32_t j, double G) CALOR_ALWAYS_INLINE {
          const Vector r = place(j) - own;
          const double w = R_of_parts_.empty() ? G : G / along(R_of_parts_[part_[i]], {r[0], r[1], r[2]});
          squares += w * (r * r);
          mixed += w * (__builtin_shufflevector(r, r, 0, 0, 1, 1) * __builtin_shufflevector(r, r, 1, 2, 2, 2));
          sum += G * pair_flux(flux, i, j) * r;
        });
        Symmetric3 M = ends() ? M_crossing[i] : Symmetric3{};
        M.xx += squares[0], M.yy += squares[1], M.zz += squares[2];
        M.xy += mixed[0], M.xz += mixed[1], M.yz += mixed[2];
        const Vec3 b = (ends() ? b_crossing[i] : Vec3{}) + Vec3{sum[0], sum[1], sum[2]};
        q[p] = -(R_ * (pseudo_inverse(M) * b));  // zero in directions without neighbours
      }
    });
  });
}

std::span<const std::int32_t> PairConduction::coupled(int i, std::vector<std::int32_t>& buffer) const {
  rows_.read_columns(i, buffer);
  return buffer;
}

}  // namespace calor
