#include "material/mixture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "base/point_function.hpp"

namespace calor {
namespace {

constexpr std::size_t block = 256;  // points at a time, so that scratch stays on the stack
using Scratch = std::array<double, block>;

struct Recipe {
  std::string name;
  const MixingRule* rule;
  Basis basis;
  Function fraction;
  std::shared_ptr<const Material> first, second;

  bool of_T_alone() const {
    return fraction.is_constant() && first->conductivity_of_T_alone() && second->conductivity_of_T_alone();
  }
  bool has_capacity() const { return first->has_capacity() && second->has_capacity(); }
};

double mixed(const MixingRule& rule, double a, double k1, double k2) {
  double k, d1, d2;
  rule.mix({&a, 1}, {&k1, 1}, {&k2, 1}, {&k, 1}, {&d1, 1}, {&d2, 1});
  return k;
}

class MixturePointProperties final : public PointProperties {
 public:
  MixturePointProperties(const Recipe& recipe, std::span<const Vec3> x, const TemperatureRange& range)
      : rule_(*recipe.rule), first_(recipe.first->at(x, range)), second_(recipe.second->at(x, range)) {
    PointValues a(recipe.fraction, x);
    for (std::size_t i = 0; i < a.all().size(); ++i)
      if (!(a[i] >= 0 && a[i] <= 1))
        throw Error(Fault::bad_case, recipe.fraction.place(),
                    fmt::format("the fraction in '{}' is {:.6g} at ({:.6g}, {:.6g}, {:.6g}) m", recipe.name, a[i],
                                x[i].x, x[i].y, x[i].z),
                    "a fraction lies between 0 and 1");
    // In one mass unit of the mixture the second phase takes the volume a / rho2 of (1-a) / rho1 + a / rho2, so with
    // the fraction of the volume both bases hold heat and mass alike.
    if (recipe.has_capacity() && recipe.basis == Basis::mass) {
      std::vector<double> rho1(x.size()), rho2(x.size()), v(x.size());
      first_->density(0, rho1);
      second_->density(0, rho2);
      for (std::size_t i = 0; i < v.size(); ++i) v[i] = a[i] / rho2[i] / ((1 - a[i]) / rho1[i] + a[i] / rho2[i]);
      volume_fraction_ = v.empty() ? PointValues() : PointValues(std::move(v));
    } else {
      volume_fraction_ = a;
    }
    if (recipe.of_T_alone() && !x.empty()) {
      const std::shared_ptr<const PointProperties> one = recipe.first->at(x.first(1), range),
                                                   two = recipe.second->at(x.first(1), range);
      curve_ = Curve::sampled(
          [rule = recipe.rule, a = a[0], one, two](double T) {
            double k1, k2;
            one->conductivity(0, 0, {&T, 1}, {&k1, 1}, {});
            two->conductivity(0, 0, {&T, 1}, {&k2, 1}, {});
            return mixed(*rule, a, k1, k2);
          },
          range.low, range.high);
    }
    fraction_ = std::move(a);
  }

  void conductivity(std::size_t first, double t, std::span<const double> T, std::span<double> k,
                    std::span<double> dk_dT) const override {
    if (curve_) {
      curve_->values(T, k);
      if (!dk_dT.empty()) curve_->derivatives(T, dk_dT);
      return;
    }
    Scratch a, k1, k2, dk1, dk2, d1, d2;
    for (std::size_t b = 0; b < T.size(); b += block) {
      const std::size_t n = std::min(block, T.size() - b), nd = dk_dT.empty() ? 0 : n;
      for (std::size_t i = 0; i < n; ++i) a[i] = fraction_[first + b + i];
      first_->conductivity(first + b, t, T.subspan(b, n), {k1.data(), n}, {dk1.data(), nd});
      second_->conductivity(first + b, t, T.subspan(b, n), {k2.data(), n}, {dk2.data(), nd});
      rule_.mix({a.data(), n}, {k1.data(), n}, {k2.data(), n}, k.subspan(b, n), {d1.data(), n}, {d2.data(), n});
      for (std::size_t i = 0; i < nd; ++i) dk_dT[b + i] = d1[i] * dk1[i] + d2[i] * dk2[i];
    }
  }

  void theta(std::span<const double> T, std::span<double> theta) const override {
    if (curve_) curve_->integrals(T, theta);
  }

  void enthalpy(std::size_t first, std::span<const double> T, std::span<double> H,
                std::span<double> rho_c) const override {
    Scratch H2, c2;
    for (std::size_t b = 0; b < T.size(); b += block) {
      const std::size_t n = std::min(block, T.size() - b), nH = H.empty() ? 0 : n, nc = rho_c.empty() ? 0 : n;
      const auto H1 = H.subspan(H.empty() ? 0 : b, nH), c1 = rho_c.subspan(rho_c.empty() ? 0 : b, nc);
      first_->enthalpy(first + b, T.subspan(b, n), H1, c1);
      second_->enthalpy(first + b, T.subspan(b, n), {H2.data(), nH}, {c2.data(), nc});
      blend(first + b, H2, H1);
      blend(first + b, c2, c1);
    }
  }

  void density(std::size_t first, std::span<double> rho) const override {
    Scratch rho2;
    for (std::size_t b = 0; b < rho.size(); b += block) {
      const auto part = rho.subspan(b, std::min(block, rho.size() - b));
      first_->density(first + b, part);
      second_->density(first + b, {rho2.data(), part.size()});
      blend(first + b, rho2, part);
    }
  }

 private:
  void blend(std::size_t first, const Scratch& second, std::span<double> value) const {
    for (std::size_t i = 0; i < value.size(); ++i) {
      const double v = volume_fraction_[first + i];
      value[i] = (1 - v) * value[i] + v * second[i];
    }
  }

  const MixingRule& rule_;
  std::unique_ptr<PointProperties> first_, second_;
  PointValues fraction_, volume_fraction_;
  std::optional<Curve> curve_;  // k(T) where both phases and the fraction allow it
};

class Mixture final : public Material {
 public:
  explicit Mixture(Recipe recipe) : Material(recipe.name), recipe_(std::move(recipe)) {}

  std::unique_ptr<PointProperties> at(std::span<const Vec3> x, const TemperatureRange& range) const override {
    return std::make_unique<MixturePointProperties>(recipe_, x, range);
  }
  bool conductivity_of_T_alone() const override { return recipe_.of_T_alone(); }
  bool conductivity_is_layered() const override {
    return recipe_.fraction.is_layered() || either(&Material::conductivity_is_layered);
  }
  bool conductivity_depends_on_T() const override { return either(&Material::conductivity_depends_on_T); }
  bool conductivity_depends_on_time() const override { return either(&Material::conductivity_depends_on_time); }
  bool capacity_depends_on_T() const override { return has_capacity() && either(&Material::capacity_depends_on_T); }
  bool density_depends_on_T() const override { return either(&Material::density_depends_on_T); }
  bool has_capacity() const override { return recipe_.has_capacity(); }

 private:
  bool either(bool (Material::*is)() const) const { return ((*recipe_.first).*is)() || ((*recipe_.second).*is)(); }

  Recipe recipe_;
};

}  // namespace

std::unique_ptr<Material> make_mixture(const std::string& name, const MixingRule& rule, Basis basis, Function fraction,
                                       std::shared_ptr<const Material> first, std::shared_ptr<const Material> second,
                                       const Place& place) {
  if (fraction.depends_on_time() || fraction.depends_on_temperature())
    throw Error(
        Fault::bad_case, fraction.place(),
        fmt::format("the fraction in '{}' depends on {}", name, fraction.depends_on_time() ? "time" : "temperature"),
        "a fraction is a number or a function of place");
  for (const auto& phase : {first, second})
    if (basis == Basis::mass && phase->has_capacity() && phase->density_depends_on_T())
      throw Error(Fault::bad_case, place,
                  fmt::format("'{}' mixes by mass, but the density of '{}' depends on temperature", name, phase->name),
                  "give that phase a density that does not depend on temperature, or write basis = \"volume\"");
  return std::make_unique<Mixture>(
      Recipe{name, &rule, basis, std::move(fraction), std::move(first), std::move(second)});
}

}  // namespace calor
