#include "material/simple.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/function.hpp"
#include "base/ramped_function.hpp"
#include "material/heat_by_point.hpp"
#include "material/library.hpp"

namespace calor {
namespace {

/// `least`: 0 where the property may vanish, as the conductivity of an insulator.
PointValues checked_values(const Function& f, std::span<const Vec3> x, const std::string& what, const std::string& unit,
                           double least = std::numeric_limits<double>::denorm_min()) {
  PointValues values(f, x);
  if (std::ranges::all_of(values.all(), [&](double v) { return v >= least && std::isfinite(v); })) return values;
  for (std::size_t i = 0; i < values.all().size(); ++i) {
    const double value = values.all()[i];
    if (value > 0 && std::isfinite(value)) continue;  // names the place from where on it is wrong
    const std::string where =
        values.is_uniform() ? "" : fmt::format(" at ({:.6g}, {:.6g}, {:.6g}) m", x[i].x, x[i].y, x[i].z);
    throw Error(Fault::bad_case, f.location(), fmt::format("the {} is {:.6g} {}{}", what, value, unit, where),
                "it must be positive everywhere");
  }
  return values;
}

bool of_place_alone(const Function& f) { return !f.depends_on_time() && !f.depends_on_temperature(); }

class Conductivity {
 public:
  Conductivity(const Function& k, std::span<const Vec3> x, const TemperatureRange& range, const std::string& what)
      : function_(k), ramped_(k), x_(x) {
    if (of_place_alone(k)) {
      values_.emplace(checked_values(k, x, what, "W/(m K)", 0));
    }
    if (!k.depends_on_place() && !k.depends_on_time()) curve_ = k.curve(range.low, range.high);
  }

  void evaluate(std::size_t first, double t, std::span<const double> T, std::span<double> k,
                std::span<double> dk_dT) const {
    if (values_) {
      for (std::size_t i = 0; i < k.size(); ++i) k[i] = (*values_)[first + i];
      std::ranges::fill(dk_dT, 0.0);
    } else if (curve_) {
      curve_->values(T, k);
      if (!dk_dT.empty()) curve_->derivatives(T, dk_dT);
    } else {
      const Arguments args{.x = x_.subspan(first, T.size()), .t = t, .T = T};
      // Only of formulas of place it is known that they do not jump.
      if (function_.may_jump() || !function_.depends_on_place()) {
        ramped_.evaluate(args, k);
        if (!dk_dT.empty()) ramped_.derivative(args, dk_dT);
      } else {
        function_.evaluate(args, k);
        if (!dk_dT.empty()) function_.derivative(args, dk_dT);
      }
    }
  }

  void integral(std::span<const double> T, std::span<double> theta) const { curve_->integrals(T, theta); }

 private:
  Function function_;
  RampedFunction ramped_;
  std::span<const Vec3> x_;
  std::optional<PointValues> values_;
  std::optional<Curve> curve_;
};

// H = integral of rho c dT from the reference temperature, by the simplest form that is exact.
class Capacity {
 public:
  Capacity(const Function& rho, const Function& c, const std::optional<LatentHeat>& latent, std::span<const Vec3> x,
           const TemperatureRange& range, const std::string& of)
      : latent_(latent), reference_(range.reference) {
    if (of_place_alone(rho)) density_.emplace(checked_values(rho, x, "density" + of, "kg/m^3"));
    if (of_place_alone(c)) specific_heat_.emplace(checked_values(c, x, "specific heat" + of, "J/(kg K)"));
    if (density_ && specific_heat_) return;
    if (density_ && !c.depends_on_place()) {
      curve_ = c.curve(range.low, range.high);
    } else if (!rho.depends_on_place() && !c.depends_on_place()) {
      // Both curves are copied into the product, which goes on sampling outside of the range.
      const Curve a = rho.curve(range.low, range.high), b = c.curve(range.low, range.high);
      curve_ = Curve::sampled([a, b](double T) { return a.value(T) * b.value(T); }, range.low, range.high);
      density_.emplace(std::vector<double>{1}), specific_heat_.reset();  // both are in the curve
    } else {
      by_point_.emplace(rho, c, x, range);
    }
    if (curve_) start_ = curve_->integral(reference_);
  }

  void enthalpy(std::size_t first, std::span<const double> T, std::span<double> H, std::span<double> rho_c) const {
    sensible(first, T, H, rho_c);
    if (!latent_) return;
    const double molten = latent_->liquid_fraction(reference_);
    for (std::size_t i = 0; i < H.size(); ++i)
      H[i] += (*density_)[first + i] * latent_->heat * (latent_->liquid_fraction(T[i]) - molten);
    for (std::size_t i = 0; i < rho_c.size(); ++i)
      rho_c[i] += (*density_)[first + i] * latent_->heat * latent_->slope(T[i]);
  }

  void density(std::size_t first, std::span<double> rho) const {
    for (std::size_t i = 0; i < rho.size(); ++i) rho[i] = (*density_)[first + i];
  }

 private:
  void sensible(std::size_t first, std::span<const double> T, std::span<double> H, std::span<double> rho_c) const {
    if (density_ && specific_heat_) {
      for (std::size_t i = 0; i < H.size(); ++i)
        H[i] = (*density_)[first + i] * (*specific_heat_)[first + i] * (T[i] - reference_);
      for (std::size_t i = 0; i < rho_c.size(); ++i) rho_c[i] = (*density_)[first + i] * (*specific_heat_)[first + i];
    } else if (curve_) {
      if (!H.empty()) curve_->integrals(T, H);
      for (std::size_t i = 0; i < H.size(); ++i) H[i] = (*density_)[first + i] * (H[i] - start_);
      if (!rho_c.empty()) curve_->values(T, rho_c);
      for (std::size_t i = 0; i < rho_c.size(); ++i) rho_c[i] *= (*density_)[first + i];
    } else {
      by_point_->evaluate(first, T, H, rho_c);
    }
  }

  std::optional<LatentHeat> latent_;
  double reference_, start_ = 0;
  std::optional<PointValues> density_, specific_heat_;
  std::optional<Curve> curve_;           // of c, or of rho c with density_ = 1
  std::optional<HeatByPoint> by_point_;  // of what depends on place and temperature
};

class SimplePointProperties final : public PointProperties {
 public:
  SimplePointProperties(const std::string& name, const SimpleProperties& p, std::span<const Vec3> x,
                        const TemperatureRange& range)
      : k_(p.conductivity, x, range, fmt::format("conductivity of '{}'", name)) {
    if (p.density && p.specific_heat)
      capacity_.emplace(*p.density, *p.specific_heat, p.latent, x, range, fmt::format(" of '{}'", name));
  }

  void conductivity(std::size_t first, double t, std::span<const double> T, std::span<double> k,
                    std::span<double> dk_dT) const override {
    k_.evaluate(first, t, T, k, dk_dT);
  }
  void theta(std::span<const double> T, std::span<double> theta) const override { k_.integral(T, theta); }
  void enthalpy(std::size_t first, std::span<const double> T, std::span<double> H,
                std::span<double> rho_c) const override {
    capacity_->enthalpy(first, T, H, rho_c);
  }
  void density(std::size_t first, std::span<double> rho) const override { capacity_->density(first, rho); }

 private:
  Conductivity k_;
  std::optional<Capacity> capacity_;
};

class SimpleMaterial final : public Material {
 public:
  SimpleMaterial(const std::string& name, SimpleProperties p) : Material(name), p_(std::move(p)) {}

  std::unique_ptr<PointProperties> at(std::span<const Vec3> x, const TemperatureRange& range) const override {
    return std::make_unique<SimplePointProperties>(name, p_, x, range);
  }
  bool conductivity_of_T_alone() const override {
    return !p_.conductivity.depends_on_place() && !p_.conductivity.depends_on_time();
  }
  bool conductivity_is_layered() const override { return p_.conductivity.is_layered(); }
  bool conductivity_depends_on_T() const override { return p_.conductivity.depends_on_temperature(); }
  bool conductivity_depends_on_time() const override { return p_.conductivity.depends_on_time(); }
  bool capacity_depends_on_T() const override {
    return has_capacity() &&
           (p_.latent || p_.density->depends_on_temperature() || p_.specific_heat->depends_on_temperature());
  }
  bool density_depends_on_T() const override { return p_.density && p_.density->depends_on_temperature(); }
  bool has_capacity() const override { return p_.density && p_.specific_heat; }
  const Anisotropy* anisotropy() const override { return p_.anisotropy ? &*p_.anisotropy : nullptr; }

 private:
  SimpleProperties p_;
};

std::optional<LatentHeat> latent_heat(const Table& table) {
  const std::vector<const char*> keys = {"latent_heat", "solidus", "liquidus"};
  const auto missing = std::ranges::find_if(keys, [&](const char* key) { return !table.has(key); });
  const auto given = std::ranges::find_if(keys, [&](const char* key) { return table.has(key); });
  if (given == keys.end()) return std::nullopt;
  if (missing != keys.end())
    table.refuse(*given, fmt::format("[{}] has a {} and no {}", table.path(), *given, *missing),
                 "melting takes latent_heat, solidus and liquidus");
  const LatentHeat latent{table.number("latent_heat"), table.number("solidus"), table.number("liquidus")};
  if (!(latent.heat > 0))
    table.refuse("latent_heat", fmt::format("a latent heat of {:g} J/kg is not positive", latent.heat),
                 "give the heat that melts one kilogram");
  if (!(latent.liquidus > latent.solidus))
    table.refuse("liquidus",
                 fmt::format("the liquidus, {:g} K, is not above the solidus, {:g} K", latent.liquidus, latent.solidus),
                 "melting takes a range of temperatures; of a pure substance take 1 K or less");
  return latent;
}

}  // namespace

std::unique_ptr<Material> make_simple_material(const std::string& name, SimpleProperties properties) {
  const auto refuse_time = [&](const std::optional<Function>& f, const char* what) {
    if (f && f->depends_on_time())
      throw Error(Fault::bad_case, f->location(), fmt::format("the {} of '{}' depends on time", what, name),
                  "the heat a body holds must be a function of its temperature: give a source for the rest");
  };
  refuse_time(properties.density, "density");
  refuse_time(properties.specific_heat, "specific heat");
  if (properties.latent && properties.density && properties.density->depends_on_temperature())
    throw Error(Fault::bad_case, properties.density->location(),
                fmt::format("the density of '{}', which melts, depends on temperature", name),
                "a cell holds the same mass before and after: give one density");
  return std::make_unique<SimpleMaterial>(name, std::move(properties));
}

std::unique_ptr<Material> read_simple_material(const std::string& name, const Table& table, bool transient) {
  std::optional<Function> k, rho, c;
  std::optional<LatentHeat> latent = latent_heat(table);
  if (table.has("library")) {
    const SimpleProperties p = find_in_library(table.text("library"))->properties();
    k = p.conductivity, rho = p.density, c = p.specific_heat;
    if (!latent) latent = p.latent;
  }
  if (table.has("conductivity")) k = table.function("conductivity");
  if (table.has("density")) rho = table.function("density");
  if (table.has("specific_heat")) c = table.function("specific_heat");
  if (!k)
    table.refuse("", fmt::format("[{}] has no conductivity", table.path()),
                 "add conductivity = \"... W/(m K)\", or library = \"...\"");
  for (const auto& [value, key, unit] : {std::tuple(&rho, "density", "kg/m^3"), {&c, "specific_heat", "J/(kg K)"}})
    if (transient && !*value)
      table.refuse("", fmt::format("[{}] has no {}, which a case with [time] needs", table.path(), key),
                   fmt::format("add {} = \"... {}\"", key, unit));
  return make_simple_material(name, {*k, rho, c, latent, read_anisotropy(table)});
}

std::vector<Key> simple_keys() {
  std::vector<std::string> library;
  for (const auto& m : material_library()) library.push_back(m.name);
  return {
      {"conductivity", Kind::function, "W/(m K)", optional,
       "Conductivity, the same in all directions unless `anisotropy` says otherwise."},
      {"anisotropy", Kind::table, "", optional, "How the conductivity depends on direction."},
      {"density", Kind::function, "kg/m^3", optional, "Density; a steady case does without."},
      {"specific_heat", Kind::function, "J/(kg K)", optional, "Specific heat; a steady case does without."},
      {"latent_heat", Kind::quantity, "J/kg", optional,
       "Heat of melting, taken up evenly between solidus and liquidus."},
      {"solidus", Kind::quantity, "K", optional, "Temperature at which melting begins."},
      {"liquidus", Kind::quantity, "K", optional, "Temperature at which melting ends."},
      {"library",
       Kind::choice,
       "",
       optional,
       "Takes the values of a built-in material; keys written beside it replace single values. A variant or KEY=VALUE "
       "that takes another drops them.",
       library,
       {"conductivity", "density", "specific_heat", "latent_heat", "solidus", "liquidus"}}};
}

}  // namespace calor
