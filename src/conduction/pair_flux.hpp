#pragma once
// The three means of two conductivities as pair fluxes. Every one is exactly antisymmetric in (i, j), so heat is
// conserved to round-off, and exactly zero where the temperature is uniform.
#include <span>

#include "conduction/evaluation.hpp"

namespace calor {

struct IntegralFlux {
  const double* __restrict theta;
  double operator()(std::int32_t i, std::int32_t j) const { return theta[j] - theta[i]; }
};

struct ArithmeticFlux {
  const double* __restrict k;
  const double* __restrict T;
  double operator()(std::int32_t i, std::int32_t j) const { return 0.5 * (k[i] + k[j]) * (T[j] - T[i]); }
};

/// Keeps the harmonic mean of two insulators from being 0 / 0; no conductivity is so small.
constexpr double tiny_conductivity = 1e-100;  // W/(m K)

struct HarmonicFlux {
  const double* __restrict k;
  const double* __restrict T;
  double operator()(std::int32_t i, std::int32_t j) const {
    return 2 * (k[i] * k[j]) / (k[i] + k[j] + tiny_conductivity) * (T[j] - T[i]);
  }
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

/// kbar(k_i, k_j) and its derivatives by k_i and k_j; not for Mean::integral.
struct MeanConductivity {
  double value, by_i, by_j;
};

inline MeanConductivity mean_conductivity(Mean mean, double k_i, double k_j) {
  if (mean == Mean::arithmetic) return {0.5 * (k_i + k_j), 0.5, 0.5};
  // d/dk_i [2 k_i k_j / (k_i + k_j)] = 2 (k_j / (k_i + k_j))^2
  const double sum = k_i + k_j + tiny_conductivity, a = k_i / sum, b = k_j / sum;
  return {2 * (k_i * k_j) / sum, 2 * b * b, 2 * a * a};
}

/// Derivatives of the pair flux kbar(k_i, k_j) (T_j - T_i) by T_i and T_j.
struct FluxDerivatives {
  double by_i, by_j;
};

/// `jump`: T_j - T_i. `slope`: dT/dT_j of the neighbour's temperature T, which differs from 1 where j stands for its
/// own mirror image; `jump` is then that of the image.
inline FluxDerivatives flux_derivatives(const Conductivity& k, double jump, std::int32_t i, std::int32_t j,
                                        double slope = 1) {
  if (k.mean == Mean::integral) return {-k.k[i], slope * k.k[j]};
  const MeanConductivity kbar = mean_conductivity(k.mean, k.k[i], k.k[j]);
  if (k.dk_dT.empty()) return {-kbar.value, slope * kbar.value};
  return {-kbar.value + kbar.by_i * k.dk_dT[i] * jump, slope * kbar.value + kbar.by_j * k.dk_dT[j] * jump};
}

}  // namespace calor
