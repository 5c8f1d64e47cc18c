#include "conduction/pair_conduction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

double pair_conductivity(const Conductivity& k, std::int32_t i, std::int32_t j) {
  const Mean mean = k.mean == Mean::integral ? Mean::arithmetic : k.mean;
  return mean_conductivity(mean, k.k[i], k.k[j]).value;
}

}  // namespace

PairConduction::PairConduction(const Cloud& cloud, Neighbours neighbours, std::vector<double> G, CrackBonds cracks)
    : Conduction(Evaluation::nodes),
      cloud_(cloud),
      neighbours_(std::move(neighbours)),
      G_(std::move(G)),
      closed_(std::move(cracks)) {
  apply(0);
}

void PairConduction::apply(double t) {
  const auto left = std::ranges::stable_partition(closed_.bonds, [&](const CrackBond& b) { return b.opens > t; });
  for (const CrackBond& bond : left) {
    const double G = bond.fraction * G_[bond.entry];
    G_[bond.entry] -= G;
    if (bond.contact > 0) contacts_.push_back({bond.entry, bond.point, G, bond.contact});
  }
  closed_.bonds.erase(left.begin(), left.end());
  std::ranges::stable_sort(contacts_, {}, &Contact::entry);
}

template <class Flux>
double PairConduction::contact_flux(const Contact& c, const Conductivity& k, std::span<const double> T,
                                    const Flux& flux) const {
  const std::int32_t i = c.point, j = neighbours_.column[c.entry];
  const double jump = T[j] - T[i], intact = flux(i, j);
  if (jump == 0) return 0;
  const double K = k.mean == Mean::integral ? intact / jump : pair_conductivity(k, i, j);
  return intact / (1 + K / c.contact);
}

void PairConduction::add_rate(const Conductivity& k, std::span<const double> T, std::span<double> F) const {
  with_flux(k, T, [&](const auto& flux) {
    add_pair_fluxes(cloud_.owned, neighbours_.row.data(), neighbours_.column.data(), G_.data(), flux, F.data());
    for (const Contact& c : contacts_) F[c.point] += c.G * contact_flux(c, k, T, flux);
  });
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
  // With K = kbar and kappa = K / contact, d[K dT / (1 + kappa)] = (d[K dT] - K d[dT]) / (1 + kappa)^2 + K d[dT] / (1 +
  // kappa).
  for (const Contact& c : contacts_) {
    const std::int32_t i = c.point, j = neighbours_.column[c.entry];
    const auto d = flux_derivatives(k, T[j] - T[i], i, j);
    const double K = pair_conductivity(k, i, j), share = 1 / (1 + K / c.contact);
    const auto derivative = [&](double intact, double sign) {
      return c.G * share * (share * (intact - sign * K) + sign * K);
    };
    const std::int32_t column[] = {i, j};
    const double value[] = {derivative(d.by_i, -1), derivative(d.by_j, 1)};
    J.add(i, column, value);
  }
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
  for (const Contact& c : contacts_) {
    const double K = pair_conductivity(k, c.point, neighbours_.column[c.entry]);
    sums[c.point] += 2 * c.G * K / (1 + K / c.contact);
  }
}

void PairConduction::heat_flux(const Conductivity& k, std::span<const double> T, std::span<Vec3> q) const {
  // q_i = -M_i^-1 sum_j G_ij kbar_ij (T_j - T_i) x_ji with M_i = sum_j G_ij x_ji (x) x_ji: exact for linear T on any
  // cloud. It is built from the pair fluxes, not from k_i grad T, so it does not jump where k does.
  with_flux(k, T, [&](const auto& flux) {
    auto contact = contacts_.begin();
    for (std::int32_t i = 0; i < cloud_.owned; ++i) {
      Symmetric3 M;
      Vec3 b;
      for (; contact != contacts_.end() && contact->point == i; ++contact) {
        const Vec3 x = cloud_.x[neighbours_.column[contact->entry]] - cloud_.x[i];
        M.add(contact->G, x);
        b += contact->G * contact_flux(*contact, k, T, flux) * x;
      }
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

}  // namespace calor
