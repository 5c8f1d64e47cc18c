#include "method/pair_sites.hpp"

#include <cmath>
#include <utility>

#include "method/small_matrix.hpp"

namespace calor {

namespace {

// The three means as pair fluxes. Every one is exactly antisymmetric in (i, j), so heat is conserved to round-off, and
// exactly zero where the temperature is uniform.
struct IntegralFlux {
  const double* __restrict theta;
  double operator()(std::int32_t i, std::int32_t j) const { return theta[j] - theta[i]; }
};

struct ArithmeticFlux {
  const double* __restrict k;
  const double* __restrict T;
  double operator()(std::int32_t i, std::int32_t j) const { return 0.5 * (k[i] + k[j]) * (T[j] - T[i]); }
};

struct HarmonicFlux {
  const double* __restrict k;
  const double* __restrict T;
  double operator()(std::int32_t i, std::int32_t j) const { return 2 * (k[i] * k[j]) / (k[i] + k[j]) * (T[j] - T[i]); }
};

/// Calls `loop` with the pair flux kbar_ij (T_j - T_i) of this mean.
template <class Loop>
void with_flux(const Conductivity& k, std::span<const double> T, const Loop& loop) {
  switch (k.mean) {
    case Mean::integral:
      return loop(IntegralFlux{k.theta.data()});
    case Mean::arithmetic:
      return loop(ArithmeticFlux{k.k.data(), T.data()});
    case Mean::harmonic:
      return loop(HarmonicFlux{k.k.data(), T.data()});
  }
}

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

/// Derivatives of the pair flux kbar(k_i, k_j) (T_j - T_i) by T_i and T_j.
struct FluxDerivatives {
  double by_i, by_j;
};

FluxDerivatives flux_derivatives(const Conductivity& k, std::span<const double> T, std::int32_t i, std::int32_t j) {
  const double ki = k.k[i], kj = k.k[j];
  if (k.mean == Mean::integral) return {-ki, kj};
  const double dki = k.dk_dT.empty() ? 0 : k.dk_dT[i], dkj = k.dk_dT.empty() ? 0 : k.dk_dT[j];
  const double jump = T[j] - T[i];
  if (k.mean == Mean::arithmetic) {
    const double mean = 0.5 * (ki + kj);
    return {-mean + 0.5 * dki * jump, mean + 0.5 * dkj * jump};
  }
  // d/dk_i [2 k_i k_j / (k_i + k_j)] = 2 (k_j / (k_i + k_j))^2
  const double mean = 2 * (ki * kj) / (ki + kj), a = ki / (ki + kj), b = kj / (ki + kj);
  return {-mean + 2 * b * b * dki * jump, mean + 2 * a * a * dkj * jump};
}

}  // namespace

PairSites::PairSites(const Cloud& cloud, Neighbours neighbours, std::vector<double> G, std::optional<WallRows> walls)
    : cloud_(cloud), neighbours_(std::move(neighbours)), G_(std::move(G)), walls_(std::move(walls)) {}

void PairSites::add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const {
  with_flux(k, T, [&](const auto& flux) {
    add_pair_fluxes(cloud_.owned, neighbours_.row.data(), neighbours_.column.data(), G_.data(), flux, F.data());
  });
}

void PairSites::add_jacobian(const Conductivity& k, std::span<const double> T, JacobianEntries& J) const {
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
      const auto d = flux_derivatives(k, T, i, neighbours[n]);
      values.push_back(G[n] * d.by_j);
      diagonal += G[n] * d.by_i;
    }
    values.push_back(diagonal);
    J.add(i, columns, values);
  }
}

bool PairSites::symmetric(Mean mean, bool k_depends_on_T) const {
  return !walls_ && (mean == Mean::integral || !k_depends_on_T);
}

void PairSites::add_row_bound(const Conductivity& k, std::span<double> bound) const {
  // |dF_i/dT_i| + sum_j |dF_i/dT_j| without dk/dT; with G >= 0 it is twice the diagonal for a constant k.
  const Conductivity frozen{.mean = k.mean, .k = k.k, .dk_dT = {}, .theta = {}};
  const std::vector<double> uniform(k.k.size(), 0.0);
  for (std::int32_t i = 0; i < cloud_.owned; ++i) {
    double sum = 0;
    for (std::int64_t n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
      const auto d = flux_derivatives(frozen, uniform, i, neighbours_.column[n]);
      sum += std::abs(G_[n]) * (std::abs(d.by_i) + std::abs(d.by_j));
    }
    bound[i] += sum;
  }
}

void PairSites::heat_flux(const Conductivity& k, std::span<const double> T, std::span<Vec3> q) const {
  // q_i = -M_i^-1 sum_j G_ij kbar_ij (T_j - T_i) x_ji with M_i = sum_j G_ij x_ji (x) x_ji: exact for linear T on any
  // cloud. It is built from the pair fluxes, not from k_i grad T, so it does not jump where k does.
  with_flux(k, T, [&](const auto& flux) {
    for (std::int32_t i = 0; i < cloud_.owned; ++i) {
      Symmetric3 M;
      Vec3 b;
      for (std::int64_t n = neighbours_.row[i]; n < neighbours_.row[i + 1]; ++n) {
        const std::int32_t j = neighbours_.column[n];
        const Vec3 x = cloud_.x[j] - cloud_.x[i];
        M.add(G_[n], x);
        b += G_[n] * flux(i, j) * x;
      }
      q[i] = -(pseudo_inverse(M) * b);  // zero in directions without neighbours
    }
  });
}

std::span<const std::int32_t> PairSites::coupled(int i) const { return neighbours_.of(i); }

const WallRows* PairSites::wall_rows() const { return walls_ ? &*walls_ : nullptr; }

}  // namespace calor
