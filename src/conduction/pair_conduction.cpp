#include "conduction/pair_conduction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "conduction/linear_algebra.hpp"
#include "conduction/pair_flux.hpp"

namespace calor {

namespace {

// The hot loop. Four sums in a fixed order let the additions overlap; the result depends on the order of the
// neighbours only, hence not on the number of ranks.
template <class Flux>
void add_pair_fluxes(int owned, const std::int64_t* __restrict row, const std::int32_t* __restrict column,
                     const double* __restrict G, const Flux& flux, double* __restrict F) {
  for (std::int32_t i = 0; i < owned; ++i) {
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    const std::int64_t end = row[i + 1];
    std::int64_t n = row[i];
    for (; n + 4 <= end; n += 4) {
      s0 += G[n] * flux(i, column[n]);
      s1 += G[n + 1] * flux(i, column[n + 1]);
      s2 += G[n + 2] * flux(i, column[n + 2]);
      s3 += G[n + 3] * flux(i, column[n + 3]);
    }
    for (; n < end; ++n) s0 += G[n] * flux(i, column[n]);
    F[i] += (s0 + s1) + (s2 + s3);
  }
}

}  // namespace

PairConduction::PairConduction(const Cloud& cloud, Neighbours neighbours, std::vector<double> G)
    : Conduction(Evaluation::nodes), cloud_(cloud), neighbours_(std::move(neighbours)), G_(std::move(G)) {}

PairConduction::PairConduction(const Cloud& cloud, const Parts& parts, Neighbours neighbours, std::vector<double> G,
                               CrackBonds cracks, const PairDirections& directions)
    : PairConduction(cloud, std::move(neighbours), std::move(G)) {
  series_ = SeriesPairs(cloud, parts, neighbours_, G_, std::move(cracks), directions.of_parts);
  if (directions.in_weights) R_ = directions.in_weights->power(1);
  if (directions.of_parts.empty()) return;
  std::vector<int> part;
  collective_try(cloud.comm, [&] { part = parts.at(cloud.x, cloud.tag); });
  for (int i = 0; i < cloud.owned; ++i)
    for (auto n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n)
      factor_.push_back(along(directions.of_parts[part[i]], neighbours_.x_ji(cloud.x, i, n)));
  for (std::size_t n = 0; n < G_.size(); ++n) G_[n] *= factor_[n];
}

void PairConduction::add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const {
  with_flux(k, T, [&](const auto& flux) {
    add_pair_fluxes(cloud_.owned, neighbours_.row.data(), neighbours_.column.data(), G_.data(), flux, F.data());
  });
  series_.add_rate(k, T, F);
}

void PairConduction::add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const {
  std::vector<std::int32_t> columns;
  std::vector<double> values;
  for (std::int32_t i = 0; i < cloud_.owned; ++i) {
    const auto neighbours = neighbours_.of(i);
    columns.assign(neighbours.begin(), neighbours.end());
    columns.push_back(i);
    values.clear();
    double diagonal = 0;
    const double* G = G_.data() + neighbours_.row[i];
    for (std::size_t n = 0; n < neighbours.size(); ++n) {
      const auto d = flux_derivatives(k, T[neighbours[n]] - T[i], i, neighbours[n]);
      values.push_back(G[n] * d.by_j);
      diagonal += G[n] * d.by_i;
    }
    values.push_back(diagonal);
    J.add(i, columns, values);
  }
  series_.add_jacobian(k, T, J);
}

void PairConduction::add_row_sums(const Conductivity& k, std::span<double> sums) const {
  // |dF_i/dT_i| + sum_j |dF_i/dT_j| without dk/dT; with G >= 0 it is twice the diagonal for a constant k.
  const Conductivity frozen{.mean = k.mean, .k = k.k, .dk_dT = {}, .theta = {}};
  for (std::int32_t i = 0; i < cloud_.owned; ++i) {
    double sum = 0;
    for (std::int64_t n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
      const auto d = flux_derivatives(frozen, 0, i, neighbours_.column[n]);
      sum += std::abs(G_[n]) * (std::abs(d.by_i) + std::abs(d.by_j));
    }
    sums[i] += sum;
  }
  series_.add_row_sums(k, sums);
}

void PairConduction::heat_flux(const Conductivity& k, std::span<const double> T, std::span<Vec3> q) const {
  // q_i = -R M_i^-1 sum_j G_ij kbar_ij (T_j - T_i) x_ji with M_i = sum_j G_ij x_ji (x) x_ji: exact for linear T on any
  // cloud. It is built from the pair fluxes, not from k_i grad T, so it does not jump where k does. Where every part
  // has an R of its own, M_i is made of the weights without it instead.
  std::vector<Symmetric3> M(cloud_.owned);
  std::vector<Vec3> b(cloud_.owned);
  series_.add_moments(k, T, M, b);
  with_flux(k, T, [&](const auto& flux) {
    for (std::int32_t i = 0; i < cloud_.owned; ++i) {
      for (std::int64_t n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
        const std::int32_t j = neighbours_.column[n];
        const Vec3 x = cloud_.x[j] - cloud_.x[i];
        M[i].add(factor_.empty() ? G_[n] : G_[n] / factor_[n], x);
        b[i] += G_[n] * flux(i, j) * x;
      }
      q[i] = -(R_ * (pseudo_inverse(M[i]) * b[i]));  // zero in directions without neighbours
    }
  });
}

}  // namespace calor
