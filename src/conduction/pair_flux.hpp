#pragma once
// The three means of two conductivities as pair fluxes. Every one is exactly antisymmetric in (i, j), so heat is
// conserved to round-off, and exactly zero where the temperature is uniform.
#include <span>

#include "base/simd.hpp"
#include "conduction/evaluation.hpp"

namespace calor {

// A flux says what it needs of a point, at(load) with load(p) = p[i], and makes kbar_ij (T_j - T_i) of two points. A
// load gives the value of one point or those of several at once, in a vector.

struct IntegralFlux {
  const double* theta;
  template <class Load>
  CALOR_ALWAYS_INLINE auto at(const Load& load) const {
    return load(theta);
  }
  template <class V>
  CALOR_ALWAYS_INLINE static V between(const V& theta_i, const V& theta_j) {
    return theta_j - theta_i;
  }
};

template <class V>
struct PointState {
  V k, T;
};

struct ArithmeticFlux {
  const double *k, *T;
  template <class Load>
  CALOR_ALWAYS_INLINE auto at(const Load& load) const {
    return PointState<decltype(load(T))>{load(k), load(T)};
  }
  template <class V>
  CALOR_ALWAYS_INLINE static V between(const PointState<V>& i, const PointState<V>& j) {
    return 0.5 * (i.k + j.k) * (j.T - i.T);
  }
};

/// Keeps the harmonic mean of two insulators from being 0 / 0; no conductivity is so small.
constexpr double tiny_conductivity = 1e-100;  // W/(m K)

struct HarmonicFlux {
  const double *k, *T;
  template <class Load>
  CALOR_ALWAYS_INLINE auto at(const Load& load) const {
    return PointState<decltype(load(T))>{load(k), load(T)};
  }
  template <class V>
  CALOR_ALWAYS_INLINE static V between(const PointState<V>& i, const PointState<V>& j) {
    return 2 * (i.k * j.k) / (i.k + j.k + tiny_conductivity) * (j.T - i.T);
  }
};

/// What changes dk of the conductivities change of a flux, at the same temperatures: dkbar (T_j - T_i).
template <class V>
struct ChangingState {
  V k, dk, T;
};

struct HarmonicChange {
  const double *k, *dk, *T;
  template <class Load>
  CALOR_ALWAYS_INLINE auto at(const Load& load) const {
    return ChangingState<decltype(load(T))>{load(k), load(dk), load(T)};
  }
  template <class V>
  CALOR_ALWAYS_INLINE static V between(const ChangingState<V>& i, const ChangingState<V>& j) {
    // d/dk_i [2 k_i k_j / (k_i + k_j)] = 2 (k_j / (k_i + k_j))^2
    const V of_i = i.k / (i.k + j.k + tiny_conductivity), of_j = j.k / (i.k + j.k + tiny_conductivity);
    return 2 * (of_j * of_j * i.dk + of_i * of_i * j.dk) * (j.T - i.T);
  }
};

/// Calls `use` with the flux of this mean.
template <class Use>
void with_flux(const Conductivity& k, std::span<const double> T, const Use& use) {
  switch (k.mean) {
    case Mean::integral:
      return use(IntegralFlux{k.theta.data()});
    case Mean::arithmetic:
      return use(ArithmeticFlux{k.k.data(), T.data()});
    case Mean::harmonic:
      return use(HarmonicFlux{k.k.data(), T.data()});
  }
}

/// The flux from j to i.
template <class Flux>
double pair_flux(const Flux& flux, std::int32_t i, std::int32_t j) {
  const auto of = [](std::int32_t point) { return [point](const double* p) { return p[point]; }; };
  return Flux::between(flux.at(of(i)), flux.at(of(j)));
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
