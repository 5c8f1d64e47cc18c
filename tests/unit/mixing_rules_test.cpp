#include "material/mixing_rules.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

namespace calor {
namespace {

const MixingRule& rule(const std::string& name) { return *std::ranges::find(mixing_rules(), name, &MixingRule::name); }

struct Result {
  double k;
  std::vector<double> dk;
};

Result mix(const MixingRule& rule, const std::vector<double>& v, const std::vector<double>& k) {
  Result r{.k = 0, .dk = std::vector<double>(v.size())};
  rule.mix(v, k, {&r.k, 1}, r.dk);
  return r;
}

double mixed(const std::string& name, const std::vector<double>& v, const std::vector<double>& k) {
  return mix(rule(name), v, k).k;
}

struct Phases {
  std::vector<double> v, k;
};

/// Two or three phases whose conductivities lie up to six powers of ten apart.
Phases random_phases(int count) {
  Phases p;
  for (int n = 0; n < count; ++n) {
    p.v.push_back(*rc::gen::inRange(0, 1001));
    p.k.push_back(std::pow(10, *rc::gen::inRange(-3000, 3001) / 1000.));
  }
  double sum = std::accumulate(p.v.begin(), p.v.end(), 0.0);
  if (sum == 0) p.v[0] = sum = 1;
  for (double& v : p.v) v /= sum;
  return p;
}

Phases random_phases() { return random_phases(*rc::gen::inRange(2, 4)); }

TEST(MixingRules, GiveTheValuesOfAluminiumAndZirconiaInHalves) {
  // Al 204, ZrO2 2.09 W/(m K). Voigt (204 + 2.09)/2, Reuss 2 204 2.09/(204 + 2.09); the others from their two-phase
  // formulas, evaluated by hand.
  const std::vector<double> half{0.5, 0.5}, k{204, 2.09};
  const std::map<std::string, double> expected{{"voigt", 103.045},
                                               {"reuss", 4.1376},
                                               {"geometric", std::sqrt(204 * 2.09)},
                                               {"kerner", 83.1017},
                                               {"maxwell-eucken", 83.1017},
                                               {"mori-tanaka", 83.1017},
                                               {"bruggeman", 55.3724},
                                               {"hashin-shtrikman-lower", 7.9934},
                                               {"hashin-shtrikman-upper", 83.1017}};
  for (const auto& [name, value] : expected) EXPECT_NEAR(mixed(name, half, k), value, 5e-5) << name;
  EXPECT_NEAR(mixed("kerner", half, {2.09, 204}), 7.9934, 5e-5);  // zirconia as the matrix: the lower bound
}

TEST(MixingRules, TakeThreePhasesAtOnce) {
  // Ti-6Al-4V with zirconia and air, porosity 1/4: (k + 15)^-1 = 0.375/22.5 + 0.375/17.09 + 0.25/15.02625.
  EXPECT_NEAR(mixed("kerner", {0.375, 0.375, 0.25}, {7.5, 2.09, 0.02625}), 3.10057, 5e-6);
  EXPECT_NEAR(mixed("voigt", {0.375, 0.375, 0.25}, {7.5, 2.09, 0.02625}), 3.60281, 5e-6);
}

TEST(MixingRules, HaveNamesOfTheirOwnAndSources) {
  std::set<std::string> names;
  for (const MixingRule& r : mixing_rules()) {
    EXPECT_TRUE(names.insert(r.name).second) << r.name;
    EXPECT_FALSE(r.sentence.empty() || r.source.empty()) << r.name;
  }
}

RC_GTEST_PROP(MixingRules, LieBetweenReussAndVoigt, ()) {
  const auto [v, k] = random_phases();
  const double low = mixed("reuss", v, k), high = mixed("voigt", v, k);
  for (const MixingRule& r : mixing_rules()) {
    const double mean = mix(r, v, k).k;
    RC_LOG() << r.name << ": " << low << " " << mean << " " << high << std::endl;
    RC_ASSERT(mean >= low * (1 - 1e-13));
    RC_ASSERT(mean <= high * (1 + 1e-13));
  }
}

RC_GTEST_PROP(MixingRules, OfIsotropicMixturesLieBetweenHashinAndShtrikman, ()) {
  // Voigt and Reuss are those of layers; the geometric mean is no bound of spheres.
  const std::set<std::string> others{"voigt", "reuss", "geometric"};
  const auto [v, k] = random_phases();
  const double low = mixed("hashin-shtrikman-lower", v, k), high = mixed("hashin-shtrikman-upper", v, k);
  for (const MixingRule& r : mixing_rules()) {
    if (others.contains(r.name)) continue;
    const double mean = mix(r, v, k).k;
    RC_LOG() << r.name << ": " << low << " " << mean << " " << high << std::endl;
    RC_ASSERT(mean >= low * (1 - 1e-13));
    RC_ASSERT(mean <= high * (1 + 1e-13));
  }
}

RC_GTEST_PROP(MixingRules, LeaveAPureMaterialAsItIs, ()) {
  auto [v, k] = random_phases();
  for (std::size_t p = 0; p < k.size(); ++p) {
    std::ranges::fill(v, 0.0);
    v[p] = 1;
    for (const MixingRule& r : mixing_rules()) {
      RC_LOG() << r.name << ", phase " << p << std::endl;
      RC_ASSERT(std::abs(mix(r, v, k).k - k[p]) <= 1e-14 * k[p]);
    }
  }
}

RC_GTEST_PROP(MixingRules, OfAMaterialWithItselfGiveTheMaterial, ()) {
  auto [v, k] = random_phases();
  std::ranges::fill(k, k[0]);
  for (const MixingRule& r : mixing_rules()) {
    const Result mean = mix(r, v, k);
    RC_LOG() << r.name << std::endl;
    RC_ASSERT(std::abs(mean.k - k[0]) <= 1e-13 * k[0]);
    for (std::size_t p = 0; p < v.size(); ++p) RC_ASSERT(std::abs(mean.dk[p] - v[p]) <= 1e-12);
  }
}

RC_GTEST_PROP(MixingRules, HaveTheDerivativesTheySay, ()) {
  const auto [v, k] = random_phases();
  for (const MixingRule& r : mixing_rules()) {
    const Result mean = mix(r, v, k);
    for (std::size_t p = 0; p < k.size(); ++p) {
      const double h = 1e-3 * k[p];
      const auto moved = [&](double steps) {
        std::vector<double> other = k;
        other[p] += steps * h;
        return mix(r, v, other).k;
      };
      // The best phase may change within the step: the bounds have a kink there.
      const auto near = std::ranges::count_if(k, [&](double other) { return std::abs(other - k[p]) <= 3 * h; });
      if (near > 1) continue;
      const double difference = (8 * (moved(1) - moved(-1)) - (moved(2) - moved(-2))) / (12 * h);
      RC_LOG() << r.name << ", phase " << p << ": " << difference << " " << mean.dk[p] << std::endl;
      RC_ASSERT(std::abs(difference - mean.dk[p]) * k[p] <= 1e-9 * mean.k);
    }
  }
}

RC_GTEST_PROP(MixingRules, ScaleWithTheConductivities, ()) {
  // So sum k_p dk/dk_p = k (Euler).
  const auto [v, k] = random_phases();
  std::vector<double> thrice = k;
  for (double& value : thrice) value *= 3;
  for (const MixingRule& r : mixing_rules()) {
    const Result mean = mix(r, v, k);
    RC_LOG() << r.name << std::endl;
    RC_ASSERT(std::abs(mix(r, v, thrice).k - 3 * mean.k) <= 1e-13 * 3 * mean.k);
    RC_ASSERT(std::abs(std::inner_product(k.begin(), k.end(), mean.dk.begin(), 0.0) - mean.k) <= 1e-11 * mean.k);
  }
}

RC_GTEST_PROP(MixingRules, RiseWithEveryConductivity, ()) {
  const auto [v, k] = random_phases();
  for (const MixingRule& r : mixing_rules())
    for (const double d : mix(r, v, k).dk) {
      RC_LOG() << r.name << ": " << d << std::endl;
      RC_ASSERT(d >= 0);
    }
}

RC_GTEST_PROP(MixingRules, DoNotMissAPhaseThatIsNotThere, ()) {
  // But for the bounds of three phases, which hold for any share of the third.
  auto [v, k] = random_phases(2);
  const double absent = random_phases(2).k[0];
  for (const MixingRule& r : mixing_rules()) {
    if (r.name.starts_with("hashin")) continue;
    const double two = mix(r, v, k).k;
    RC_LOG() << r.name << std::endl;
    RC_ASSERT(std::abs(mix(r, {v[0], v[1], 0}, {k[0], k[1], absent}).k - two) <= 1e-12 * two);
  }
}

RC_GTEST_PROP(MixingRules, WithManyNamesForOneFormulaAgree, ()) {
  const auto [v, k] = random_phases();
  const double kerner = mixed("kerner", v, k);
  RC_ASSERT(mixed("maxwell-eucken", v, k) == kerner);
  RC_ASSERT(mixed("mori-tanaka", v, k) == kerner);
  const bool is_best = k[0] == *std::ranges::max_element(k), is_worst = k[0] == *std::ranges::min_element(k);
  if (is_best) RC_ASSERT(mixed("hashin-shtrikman-upper", v, k) == kerner);
  if (is_worst) RC_ASSERT(mixed("hashin-shtrikman-lower", v, k) == kerner);
}

RC_GTEST_PROP(MixingRules, GiveTheFormulasOfTwoPhases, ()) {
  const auto [v, k] = random_phases(2);
  // Kerner as it is usually written: k1 + 3 k1 (k2 - k1) f / (3 k1 + (k2 - k1)(1 - f)).
  const double f = v[1], d = k[1] - k[0];
  const double kerner = k[0] * (1 + 3 * d * f / (3 * k[0] + d * (1 - f)));
  // Bruggeman: 2 k^2 - b k - k1 k2 = 0.
  const double b = (3 * v[0] - 1) * k[0] + (3 * v[1] - 1) * k[1], root = std::sqrt(b * b + 8 * k[0] * k[1]);
  const double bruggeman = b > 0 ? (b + root) / 4 : 2 * k[0] * k[1] / (root - b);
  RC_ASSERT(std::abs(mixed("kerner", v, k) - kerner) <= 1e-9 * std::max(kerner, k[0]));
  RC_ASSERT(std::abs(mixed("bruggeman", v, k) - bruggeman) <= 1e-12 * bruggeman);
}

TEST(MixingRules, TakeManyPointsPhaseByPhase) {
  const std::vector<double> v{0.2, 0.7, 1, 0.8, 0.3, 0}, k{1, 2, 3, 10, 20, 30};
  for (const MixingRule& r : mixing_rules()) {
    std::vector<double> mean(3), dk(6);
    r.mix(v, k, mean, dk);
    for (std::size_t i = 0; i < 3; ++i) {
      const Result alone = mix(r, {v[i], v[3 + i]}, {k[i], k[3 + i]});
      EXPECT_EQ(mean[i], alone.k) << r.name;
      EXPECT_EQ(dk[i], alone.dk[0]) << r.name;
      EXPECT_EQ(dk[3 + i], alone.dk[1]) << r.name;
    }
  }
}

}  // namespace
}  // namespace calor
