#include "material/mixing_rules.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace calor {
namespace {

/// The phases at one point: entries `stride` apart.
struct Mixed {
  const double *v, *k;
  double* dk;  ///< derivative of the mixed conductivity by the phase's
  std::size_t phases, stride;

  double fraction(std::size_t p) const { return v[p * stride]; }
  double phase(std::size_t p) const { return k[p * stride]; }
  double& derivative(std::size_t p) const { return dk[p * stride]; }
};

template <double (*rule)(const Mixed&)>
void at_points(std::span<const double> v, std::span<const double> k, std::span<double> mixed,
               std::span<double> dmixed_dk) {
  const std::size_t n = mixed.size();
  for (std::size_t i = 0; i < n; ++i)
    mixed[i] = rule({.v = &v[i], .k = &k[i], .dk = &dmixed_dk[i], .phases = v.size() / n, .stride = n});
}

// k = sum v_i k_i; phase by phase, because it is the rule of large runs.
void voigt(std::span<const double> v, std::span<const double> k, std::span<double> mixed, std::span<double> dmixed_dk) {
  std::ranges::copy(v, dmixed_dk.begin());
  std::ranges::fill(mixed, 0.0);
  for (std::size_t first = 0; first < v.size(); first += mixed.size())
    for (std::size_t i = 0; i < mixed.size(); ++i) mixed[i] += v[first + i] * k[first + i];
}

// 1/k = sum v_i / k_i.
double reuss(const Mixed& m) {
  double resistance = 0;
  for (std::size_t p = 0; p < m.phases; ++p) resistance += m.fraction(p) / m.phase(p);
  const double k = 1 / resistance;
  for (std::size_t p = 0; p < m.phases; ++p) {
    const double part = k / m.phase(p);
    m.derivative(p) = m.fraction(p) * part * part;
  }
  return k;
}

// ln k = sum v_i ln k_i.
double geometric(const Mixed& m) {
  double log_k = 0;
  for (std::size_t p = 0; p < m.phases; ++p) log_k += m.fraction(p) * std::log(m.phase(p));
  const double k = std::exp(log_k);
  for (std::size_t p = 0; p < m.phases; ++p) m.derivative(p) = m.fraction(p) * k / m.phase(p);
  return k;
}

// Spheres of all phases in a medium of conductivity k*: k + 2 k* = 1 / sum v_i / (k_i + 2 k*), written as a mean of the
// phases with the weights v_i / (k_i + 2 k*), which does not cancel. Derivatives at constant k*.
struct Spheres {
  double k, weight;  // sum of the weights
};

Spheres spheres_in(const Mixed& m, double medium) {
  double weighted = 0, weight = 0;
  for (std::size_t p = 0; p < m.phases; ++p) {
    const double w = m.fraction(p) / (m.phase(p) + 2 * medium);
    weighted += w * m.phase(p);
    weight += w;
  }
  return {weighted / weight, weight};
}

double spheres_in_phase(const Mixed& m, std::size_t matrix) {
  const double medium = m.phase(matrix);
  const auto [k, weight] = spheres_in(m, medium);
  double by_medium = 0;
  for (std::size_t p = 0; p < m.phases; ++p) {
    const double strength = 1 / ((m.phase(p) + 2 * medium) * weight);
    m.derivative(p) = m.fraction(p) * strength * strength;
    by_medium += 2 * m.fraction(p) * (strength - 1) * (strength - 1);
  }
  m.derivative(matrix) += by_medium;
  return k;
}

double spheres_in_first(const Mixed& m) { return spheres_in_phase(m, 0); }

template <class Better>
double spheres_in_best(const Mixed& m, Better better) {
  std::size_t best = 0;
  for (std::size_t p = 1; p < m.phases; ++p)
    if (better(m.phase(p), m.phase(best))) best = p;
  return spheres_in_phase(m, best);
}

double hashin_shtrikman_lower(const Mixed& m) { return spheres_in_best(m, std::less<>{}); }
double hashin_shtrikman_upper(const Mixed& m) { return spheres_in_best(m, std::greater<>{}); }

// sum v_i (k_i - k) / (k_i + 2 k) = 0: spheres of all phases in the mixture itself. The sum falls with k and is convex,
// so that Newton from below rises to the root.
double bruggeman(const Mixed& m) {
  double lowest = m.phase(0);
  for (std::size_t p = 1; p < m.phases; ++p) lowest = std::min(lowest, m.phase(p));
  double k = spheres_in(m, lowest).k;
  bool rises = true;
  for (int n = 0; rises && n < 100; ++n) {  // bounded for conductivities that are none
    double sum = 0, slope = 0;
    for (std::size_t p = 0; p < m.phases; ++p) {
      const double d = m.phase(p) + 2 * k;
      sum += m.fraction(p) * (m.phase(p) - k) / d;
      slope += 3 * m.fraction(p) * m.phase(p) / (d * d);
    }
    const double step = sum / slope;
    rises = step > 1e-15 * k;
    if (rises) k += step;
  }
  double slope = 0;
  for (std::size_t p = 0; p < m.phases; ++p) {
    const double d = m.phase(p) + 2 * k;
    m.derivative(p) = m.fraction(p) * k / (d * d);
    slope += m.fraction(p) * m.phase(p) / (d * d);
  }
  for (std::size_t p = 0; p < m.phases; ++p) m.derivative(p) /= slope;
  return k;
}

}  // namespace

Registry<MixingRule>& mixing_rules() {
  const auto spheres = at_points<spheres_in_first>;
  static const std::string hashin = "Hashin & Shtrikman, J. Appl. Phys. 33 (1962) 3125";
  static Registry<MixingRule> rules = {
      {"voigt", "side by side along the flow of heat, the upper bound", "Voigt, Ann. Phys. 274 (1889) 573", voigt,
       true},
      {"reuss", "one after the other along the flow, the lower bound", "Reuss, Z. angew. Math. Mech. 9 (1929) 49",
       at_points<reuss>},
      {"geometric", "the logarithmic mean", "Lichtenecker, Phys. Z. 27 (1926) 115", at_points<geometric>},
      {"kerner", "spheres in the first phase", "Kerner, Proc. Phys. Soc. B 69 (1956) 802", spheres},
      {"maxwell-eucken", "the same as kerner",
       "Maxwell, Treatise on Electricity and Magnetism (1873), art. 314; Eucken, VDI-Forschungsheft 353 (1932)",
       spheres},
      {"mori-tanaka", "the same as kerner",
       "Mori & Tanaka, Acta Metall. 21 (1973) 571; Benveniste, J. Appl. Phys. 61 (1987) 2840", spheres},
      {"hashin-shtrikman-lower", "spheres in the worst conductor, the lower bound of isotropic mixtures", hashin,
       at_points<hashin_shtrikman_lower>},
      {"hashin-shtrikman-upper", "spheres in the best conductor, the upper bound of isotropic mixtures", hashin,
       at_points<hashin_shtrikman_upper>},
      {"bruggeman", "spheres of all phases in the mixture itself, no phase is the matrix",
       "Bruggeman, Ann. Phys. 416 (1935) 636", at_points<bruggeman>},
  };
  return rules;
}

}  // namespace calor
