#include "material/mixture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "base/function.hpp"
#include "material/materials.hpp"
#include "material/simple.hpp"

namespace calor {
namespace {

constexpr std::size_t block = 256, most_phases = 3;  // points at a time, so that scratch stays on the stack
using Scratch = std::array<double, block>;
using PhaseScratch = std::array<double, most_phases * block>;  // phase by phase, as mixing rules want it

std::span<double> part(std::span<double> s, std::size_t first, std::size_t n) {
  return s.empty() ? s : s.subspan(first, n);
}

/// The function at the points; throws Error(bad_case) outside [0, 1], or [0, 1) where not `closed`. What rounding puts
/// beyond an end is the end.
PointValues checked_fraction(const Function& f, std::span<const Vec3> x, const std::string& what, bool closed) {
  constexpr double rounding = 1e-12;
  const PointValues written(f, x);
  std::vector<double> values(written.all().begin(), written.all().end());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double v = values[i];
    if (!(v >= -rounding && (closed ? v <= 1 + rounding : v < 1))) {
      const std::string where =
          written.is_uniform() ? "" : fmt::format(" at ({:.6g}, {:.6g}, {:.6g}) m", x[i].x, x[i].y, x[i].z);
      throw Error(Fault::bad_case, f.location(), fmt::format("the {} is {:.6g}{}", what, v, where),
                  closed ? "a fraction lies between 0 and 1" : "a porosity lies between 0 and 1, below 1");
    }
    values[i] = std::clamp(v, 0.0, 1.0);
  }
  return values.empty() ? PointValues() : PointValues(std::move(values));
}

bool has_capacity(const MixtureRecipe& recipe) {
  return std::ranges::all_of(recipe.phases, [](const auto& phase) { return phase->has_capacity(); });
}

/// Fractions of the mass tell those of the volume through the densities.
bool knows_volumes(const MixtureRecipe& recipe) { return recipe.basis == Basis::volume || has_capacity(recipe); }

class MixturePointProperties final : public PointProperties {
 public:
  MixturePointProperties(const MixtureRecipe& recipe, std::span<const Vec3> x, const TemperatureRange& range,
                         bool of_T_alone)
      : mix_(recipe.rule->mix), pores_(recipe.pores) {
    for (const auto& phase : recipe.phases) phases_.push_back(phase->at(x, range));
    if (knows_volumes(recipe))
      for (const auto& phase : recipe.phases) ingredients_.push_back(phase->ingredients().size());
    fraction_ = volume_fraction_ =
        checked_fraction(recipe.fraction, x, fmt::format("fraction in '{}'", recipe.name), true);
    if (recipe.porosity)
      porosity_ = checked_fraction(*recipe.porosity, x, fmt::format("porosity of '{}'", recipe.name), false);
    if (recipe.factor)
      factor_ = checked_fraction(*recipe.factor, x, fmt::format("factor of the pores of '{}'", recipe.name), true);
    // In one mass unit of the mixture the second phase takes the volume a / rho2 of (1-a) / rho1 + a / rho2, so with
    // the fraction of the volume both bases hold heat and mass alike.
    if (recipe.basis == Basis::mass && has_capacity(recipe) && !x.empty()) {
      std::vector<double> rho1(x.size()), rho2(x.size()), v(x.size());
      phases_[0]->density(0, rho1);
      phases_[1]->density(0, rho2);
      for (std::size_t i = 0; i < v.size(); ++i) {
        const double a = fraction_[i];
        v[i] = a / rho2[i] / ((1 - a) / rho1[i] + a / rho2[i]);
      }
      volume_fraction_ = PointValues(std::move(v));
    }
    if (of_T_alone && !x.empty()) {
      // Properties of their own, since the curve goes on sampling.
      const auto one = std::make_shared<MixturePointProperties>(recipe, x.first(1), range, false);
      curve_ = Curve::sampled(
          [one](double T) {
            double k = 0;
            one->conductivity(0, 0, {&T, 1}, {&k, 1}, {});
            return k;
          },
          range.low, range.high);
    }
  }

  void conductivity(std::size_t first, double t, std::span<const double> T, std::span<double> k,
                    std::span<double> dk_dT) const override {
    if (curve_) {
      curve_->values(T, k);
      if (!dk_dT.empty()) curve_->derivatives(T, dk_dT);
      return;
    }
    PhaseScratch k_phase, dk_phase, by_phase;
    for (std::size_t b = 0; b < T.size(); b += block) {
      const std::size_t n = std::min(block, T.size() - b);
      for (std::size_t p = 0; p < phases_.size(); ++p)
        phases_[p]->conductivity(first + b, t, T.subspan(b, n), {&k_phase[p * n], n},
                                 {&dk_phase[p * n], dk_dT.empty() ? 0 : n});
      mix(first + b, k_phase, k.subspan(b, n), by_phase);
      for (std::size_t i = 0; i < n && !dk_dT.empty(); ++i) {
        dk_dT[b + i] = 0;
        for (std::size_t p = 0; p < phases_.size(); ++p) dk_dT[b + i] += by_phase[p * n + i] * dk_phase[p * n + i];
      }
    }
  }

  void theta(std::span<const double> T, std::span<double> theta) const override {
    if (curve_) curve_->integrals(T, theta);
  }

  void enthalpy(std::size_t first, std::span<const double> T, std::span<double> H,
                std::span<double> rho_c) const override {
    Scratch H_phase, c_phase;
    std::ranges::fill(H, 0.0);
    std::ranges::fill(rho_c, 0.0);
    for (std::size_t b = 0; b < T.size(); b += block) {
      const std::size_t n = std::min(block, T.size() - b);
      const auto H_sum = part(H, b, n), c_sum = part(rho_c, b, n);
      for (std::size_t p = 0; p < phases_.size(); ++p) {
        phases_[p]->enthalpy(first + b, T.subspan(b, n), {H_phase.data(), H_sum.size()},
                             {c_phase.data(), c_sum.size()});
        add(p, first + b, H_phase, H_sum);
        add(p, first + b, c_phase, c_sum);
      }
    }
  }

  void density(std::size_t first, std::span<double> rho) const override {
    Scratch rho_phase;
    std::ranges::fill(rho, 0.0);
    for (std::size_t b = 0; b < rho.size(); b += block) {
      const auto sum = rho.subspan(b, std::min(block, rho.size() - b));
      for (std::size_t p = 0; p < phases_.size(); ++p) {
        phases_[p]->density(first + b, {rho_phase.data(), sum.size()});
        add(p, first + b, rho_phase, sum);
      }
    }
  }

  void volume_fraction(std::size_t ingredient, std::size_t first, std::span<double> v) const override {
    if (ingredients_.empty()) return PointProperties::volume_fraction(ingredient, first, v);
    std::size_t p = 0;
    for (; ingredient >= ingredients_[p]; ++p) ingredient -= ingredients_[p];
    phases_[p]->volume_fraction(ingredient, first, v);
    for (std::size_t i = 0; i < v.size(); ++i) v[i] *= volume(p, first + i);
  }

 private:
  double share(std::size_t phase, double second, double pores) const {
    return phase == 2 ? pores : (1 - pores) * (phase == 1 ? second : 1 - second);
  }
  double volume(std::size_t phase, std::size_t i) const { return share(phase, volume_fraction_[i], porosity_[i]); }

  void add(std::size_t phase, std::size_t first, const Scratch& value, std::span<double> sum) const {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += volume(phase, first + i) * value[i];
  }

  /// Conductivity of points first ... and its derivatives by those of the phases.
  void mix(std::size_t first, const PhaseScratch& k_phase, std::span<double> k, PhaseScratch& by_phase) const {
    const std::size_t n = k.size(), count = phases_.size();
    const bool in_two_steps = count == 3 && pores_ != Pores::third;
    const std::size_t at_once = in_two_steps ? 2 : count;
    PhaseScratch v;
    for (std::size_t p = 0; p < at_once; ++p)
      for (std::size_t i = 0; i < n; ++i)
        v[p * n + i] = share(p, fraction_[first + i], in_two_steps ? 0 : porosity_[first + i]);
    mix_({v.data(), at_once * n}, {k_phase.data(), at_once * n}, k, {by_phase.data(), at_once * n});
    if (!in_two_steps) return;
    if (pores_ == Pores::factor) {
      for (std::size_t i = 0; i < n; ++i) {
        const double f = factor_[first + i];
        k[i] *= f, by_phase[i] *= f, by_phase[n + i] *= f, by_phase[2 * n + i] = 0;
      }
      return;
    }

    PhaseScratch k_both, by_both;  // the solid, the pores
    for (std::size_t i = 0; i < n; ++i) {
      v[i] = 1 - porosity_[first + i], v[n + i] = porosity_[first + i];
      k_both[i] = k[i], k_both[n + i] = k_phase[2 * n + i];
    }
    mix_({v.data(), 2 * n}, {k_both.data(), 2 * n}, k, {by_both.data(), 2 * n});
    for (std::size_t i = 0; i < n; ++i) {
      by_phase[i] *= by_both[i], by_phase[n + i] *= by_both[i];
      by_phase[2 * n + i] = by_both[n + i];
    }
  }

  decltype(MixingRule::mix) mix_;
  Pores pores_;
  std::vector<std::unique_ptr<PointProperties>> phases_;
  std::vector<std::size_t> ingredients_;  // of every phase; none where the volumes are not known
  PointValues fraction_, volume_fraction_, porosity_, factor_;
  std::optional<Curve> curve_;  // k(T) where the phases, the fraction and the porosity allow it
};

class Mixture final : public Material {
 public:
  explicit Mixture(MixtureRecipe recipe) : Material(recipe.name), recipe_(std::move(recipe)) {}

  std::unique_ptr<PointProperties> at(std::span<const Vec3> x, const TemperatureRange& range) const override {
    return std::make_unique<MixturePointProperties>(recipe_, x, range, conductivity_of_T_alone());
  }
  bool conductivity_of_T_alone() const override {
    return recipe_.fraction.is_constant() && (!recipe_.porosity || recipe_.porosity->is_constant()) &&
           (!recipe_.factor || recipe_.factor->is_constant()) &&
           std::ranges::all_of(recipe_.phases, [](const auto& phase) { return phase->conductivity_of_T_alone(); });
  }
  bool conductivity_is_layered() const override {
    return recipe_.fraction.is_layered() || (recipe_.porosity && recipe_.porosity->is_layered()) ||
           (recipe_.factor && recipe_.factor->is_layered()) || some(&Material::conductivity_is_layered);
  }
  bool conductivity_depends_on_T() const override { return some(&Material::conductivity_depends_on_T); }
  bool conductivity_depends_on_time() const override { return some(&Material::conductivity_depends_on_time); }
  bool capacity_depends_on_T() const override { return has_capacity() && some(&Material::capacity_depends_on_T); }
  bool density_depends_on_T() const override { return some(&Material::density_depends_on_T); }
  bool has_capacity() const override { return calor::has_capacity(recipe_); }
  std::vector<std::string> ingredients() const override {
    if (!knows_volumes(recipe_)) return Material::ingredients();
    std::vector<std::string> names;
    for (const auto& phase : recipe_.phases)
      for (const std::string& name : phase->ingredients()) names.push_back(name);
    return names;
  }

 private:
  bool some(bool (Material::*is)() const) const {
    return std::ranges::any_of(recipe_.phases, [&](const auto& phase) { return ((*phase).*is)(); });
  }

  MixtureRecipe recipe_;
};

void refuse_all_but_place(const Function& f, const std::string& what) {
  if (f.depends_on_time() || f.depends_on_temperature())
    throw Error(Fault::bad_case, f.location(),
                fmt::format("the {} depends on {}", what, f.depends_on_time() ? "time" : "temperature"),
                "it is a number or a function of place");
}

std::shared_ptr<const Material> read_mixture(const std::string& name, const Table& table, Materials& others) {
  for (const Key& key : simple_keys())
    if (table.has(key.name))
      table.refuse(key.name, fmt::format("[{}] is a mixture and has a '{}' of its own", table.path(), key.name),
                   "write the properties of the phases");
  const auto phases = table.texts("phases");
  if (phases.size() != 2)
    table.refuse("phases", fmt::format("a mixture has two phases, not {}", phases.size()),
                 "write phases = [\"first\", \"second\"]");
  MixtureRecipe recipe{.name = name,
                       .rule = &mixing_rules().chosen(table, "mix"),
                       .basis = table.text("basis") == "mass" ? Basis::mass : Basis::volume,
                       .fraction = table.function("fraction")};
  for (const std::string& phase : phases) recipe.phases.push_back(others.get(phase, table.location("phases")));
  if (table.has("pores")) {
    const Table pores = table.sub("pores");
    recipe.phases.push_back(others.get(pores.text("material"), pores.location("material")));
    recipe.porosity = pores.function("porosity");
    recipe.pores = pores.text("as") == "third" ? Pores::third : Pores::sequential;
    if (pores.has("factor")) recipe.pores = Pores::factor, recipe.factor = pores.function("factor");
  }
  for (const auto& phase : recipe.phases)
    if (phase->anisotropy())
      table.refuse("phases", fmt::format("'{}', which conducts differently by direction, is mixed", phase->name),
                   "the rules know mixtures of materials that conduct alike in all directions");
  return make_mixture(std::move(recipe), table.location("basis"));
}

std::vector<std::string> phases_of(const Table& table) {
  std::vector<std::string> names = table.texts("phases");
  if (table.has("pores")) names.push_back(table.sub("pores").text("material"));
  return names;
}

void declare_mixture(Schema& schema) {
  const std::string sentence = "Mixes two other materials, the conductivity by a rule (docs/graded-materials.md).";
  schema.add(
      {.path = "material.*",
       .sentence = "A mixture of two other materials (docs/graded-materials.md).",
       .keys = {{"mix", Kind::choice, "", optional, sentence + mixing_rules().sentences(), mixing_rules().names()}}});
  schema.add({.path = "material.*",
              .sentence = "What is mixed, and how.",
              .keys = {{"phases", Kind::texts, "", required, "The two materials that are mixed."},
                       {"fraction", Kind::function, "", required,
                        "Fraction of the second phase in the solid, 0 to 1, a number or a function of place."},
                       {"basis",
                        Kind::choice,
                        "",
                        required,
                        "What the fraction is of. mass (with voigt alone): rho = 1/((1-a)/rho1 + a/rho2), "
                        "c = (1-a) c1 + a c2; volume: rho and rho c are volume averages. The conductivity takes the "
                        "fraction as it is.",
                        {"mass", "volume"}},
                       {"pores", Kind::table, "", optional, "Pores in the mixture; none where absent."}},
              .when_key = "mix"});
  schema.add({.path = "material.*.pores",
              .sentence = "Pores take the fraction P of the volume, the phases share the rest.",
              .keys = {{"material", Kind::text, "", required, "What fills the pores, e.g. \"air\"."},
                       {"porosity", Kind::function, "", required,
                        "P, from 0 to less than 1, a number or a function of place."},
                       {"as",
                        Kind::choice,
                        "",
                        "sequential",
                        "How pores enter the conductivity. sequential: the rule mixes the two phases, then the result "
                        "with the pores as second phase; third: it mixes all three at once; factor: the result of the "
                        "two phases times a factor.",
                        {"sequential", "third", "factor"}}}});
  schema.add({.path = "material.*.pores",
              .sentence = "Pores by a factor.",
              .keys = {{"factor", Kind::function, "", required,
                        "Of the conductivity of the two phases, 0 to 1, a number or a function of place, such as "
                        "{ formula = \"1 - 1.5*P\" } with [function.P] for the porosity."}},
              .when_key = "as",
              .when_value = "factor"});
}

}  // namespace

MaterialLaw mixture_law() {
  return {.name = "mix",
          .sentence = "two other materials mixed",
          .declare = declare_mixture,
          .make = read_mixture,
          .ingredients = phases_of};
}

std::unique_ptr<Material> make_mixture(MixtureRecipe recipe, const SourceLocation& location) {
  refuse_all_but_place(recipe.fraction, fmt::format("fraction in '{}'", recipe.name));
  if (recipe.porosity) refuse_all_but_place(*recipe.porosity, fmt::format("porosity of '{}'", recipe.name));
  if (recipe.factor) refuse_all_but_place(*recipe.factor, fmt::format("factor of the pores of '{}'", recipe.name));
  if (recipe.basis == Basis::mass && !recipe.rule->takes_mass)
    throw Error(Fault::bad_case, location,
                fmt::format("'{}' mixes by mass, but the rule '{}' takes fractions of the volume", recipe.name,
                            recipe.rule->name),
                "write basis = \"volume\" and the fraction of the volume");
  for (const auto& phase : {recipe.phases[0], recipe.phases[1]})
    if (recipe.basis == Basis::mass && phase->has_capacity() && phase->density_depends_on_T())
      throw Error(
          Fault::bad_case, location,
          fmt::format("'{}' mixes by mass, but the density of '{}' depends on temperature", recipe.name, phase->name),
          "give that phase a density that does not depend on temperature, or write basis = \"volume\"");
  return std::make_unique<Mixture>(std::move(recipe));
}

}  // namespace calor
