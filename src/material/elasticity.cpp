#include "material/elasticity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/parallel.hpp"
#include "material/materials.hpp"

namespace calor {
namespace {

std::optional<Table> table_of(const Case& c, const std::string& material) {
  for (const auto& [name, table] : c.section("material").children())
    if (name == material) return table;
  return std::nullopt;
}

bool fills_pores(const Case& c, const std::string& material) {
  return std::ranges::any_of(c.section("material").children(), [&](const auto& entry) {
    return entry.second.has("pores") && entry.second.sub("pores").text("material") == material;
  });
}

/// In a mixture spheres sit in its first phase: the medium resists like that.
Moduli around_spheres(const Moduli& m) { return {4 * m.G / 3, m.G * (9 * m.K + 8 * m.G) / (6 * (m.K + 2 * m.G))}; }

Moduli moduli(double E, double nu) { return {E / (3 * (1 - 2 * nu)), E / (2 * (1 + nu))}; }

}  // namespace

Registry<ElasticRule>& elastic_rules() {
  static Registry<ElasticRule> all{{"mori-tanaka", "spheres in the first phase", 1, around_spheres},
                                   {"kerner", "the same as mori-tanaka", 1, around_spheres},
                                   {"voigt", "all phases have the same strain, the upper bound", 0,
                                    [](const Moduli&) {
                                      return Moduli{1, 1};
                                    }},
                                   {"reuss", "all phases have the same stress, the lower bound", 1, [](const Moduli&) {
                                      return Moduli{0, 0};
                                    }}};
  return all;
}

Elasticity::Phase Elasticity::read_phase(const Case& c, const std::string& name) const {
  Phase phase{.name = name, .fraction = {}};
  const std::optional<Table> table = table_of(c, name);
  if (!table || !table->has("youngs_modulus")) {
    phase.is_pore = fills_pores(c, name);
    if (phase.is_pore) return phase;
    const std::string cure = fmt::format("add youngs_modulus, poisson_ratio and expansion to [material.{}]", name);
    if (table) table->refuse("", fmt::format("[material.{}] has no youngs_modulus, which [stress] needs", name), cure);
    c.root().refuse("stress", fmt::format("'{}' of the library has no youngs_modulus", name),
                    cure + fmt::format(", beside library = \"{}\"", name));
  }
  for (const char* key : {"poisson_ratio", "expansion"})
    if (!table->has(key))
      table->refuse("youngs_modulus", fmt::format("[material.{}] has a stiffness and no {}", name, key),
                    fmt::format("add {}", key));
  phase.E = table->function("youngs_modulus");
  phase.nu = table->function("poisson_ratio");
  phase.expansion = table->function("expansion");
  phase.expansion_from = table->number("expansion_from");
  for (const Function* f : {&phase.E, &phase.nu, &phase.expansion})
    if (f->depends_on_time())
      throw Error(Fault::bad_case, f->location(), "an elastic constant depends on time",
                  "write it as a function of place and temperature");
  return phase;
}

Elasticity::Elasticity(const Case& c, MPI_Comm comm, const MaterialField& body, std::span<const Vec3> x,
                       std::span<const int> tag, const ElasticRule& rule, double free_at)
    : x_(x), rule_(&rule), free_at_(free_at), matrix_(x.size(), 0) {
  const MaterialField here(body, x, tag, {});
  for (const std::string& name : body.ingredients()) {
    if (const auto table = table_of(c, name); table && table->has("mix"))
      table->refuse("basis", fmt::format("it is not known what volume the phases of '{}' take", name),
                    "give the densities of both phases, or basis = \"volume\"");
    phases_.push_back(read_phase(c, name));
  }
  collective_try(comm, [&] {
    for (Phase& phase : phases_) {
      phase.fraction.resize(x.size());
      here.volume_fraction(phase.name, phase.fraction);
    }
    find_matrix(c, body, tag);
  });
}

void Elasticity::find_matrix(const Case& c, const MaterialField& body, std::span<const int> tag) {
  Materials materials(c);
  std::vector<int> matrix_of_part;
  for (int p = 0; p < body.parts().count(); ++p) {
    const Part& part = body.parts()[p];
    const std::string first = materials.get(part.material, part.location)->ingredients().front();
    matrix_of_part.push_back(static_cast<int>(std::ranges::find(phases_, first, &Phase::name) - phases_.begin()));
  }
  const std::vector<int> part = body.parts().at(x_, tag);
  for (std::size_t i = 0; i < x_.size(); ++i) matrix_[i] = matrix_of_part[part[i]];
}

ElasticState Elasticity::at(std::span<const double> T) const {
  const std::size_t n = x_.size();
  std::vector<std::vector<Moduli>> m(phases_.size(), std::vector<Moduli>(n, {0, 0}));
  std::vector<std::vector<double>> strain(phases_.size(), std::vector<double>(n, 0));
  std::vector<double> E(n), nu(n), alpha(n), alpha_free(n);
  const std::vector<double> T_free(n, free_at_);
  for (std::size_t p = 0; p < phases_.size(); ++p) {
    const Phase& phase = phases_[p];
    if (phase.is_pore) continue;
    phase.E.evaluate({.x = x_, .T = T}, E);
    phase.nu.evaluate({.x = x_, .T = T}, nu);
    phase.expansion.evaluate({.x = x_, .T = T}, alpha);
    phase.expansion.evaluate({.x = x_, .T = T_free}, alpha_free);
    for (std::size_t i = 0; i < n; ++i) {
      if (!(E[i] > 0 && nu[i] > -1 && nu[i] < 0.5))
        throw Error(Fault::numbers, phase.E.location(),
                    fmt::format("'{}' has a stiffness of {:g} Pa and a Poisson's ratio of {:g} at {:g} K", phase.name,
                                E[i], nu[i], T[i]),
                    "a stiffness is positive, and Poisson's ratio lies between -1 and 0.5");
      m[p][i] = moduli(E[i], nu[i]);
      // The mean coefficients count from where they were measured, the strain from the temperature without stress.
      strain[p][i] = alpha[i] * (T[i] - phase.expansion_from) - alpha_free[i] * (free_at_ - phase.expansion_from);
    }
  }
  ElasticState out{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    const Moduli medium = rule_->medium(m[matrix_[i]][i]);
    double K = 0, G = 0, K_weight = 0, G_weight = 0, expands = 0;
    for (std::size_t p = 0; p < phases_.size(); ++p) {
      if (phases_[p].fraction[i] == 0) continue;
      const double K_strain = phases_[p].fraction[i] / (rule_->a * m[p][i].K + medium.K);
      const double G_strain = phases_[p].fraction[i] / (rule_->a * m[p][i].G + medium.G);
      K += K_strain * m[p][i].K, K_weight += K_strain;
      G += G_strain * m[p][i].G, G_weight += G_strain;
      expands += K_strain * m[p][i].K * strain[p][i];  // Levin, Mech. Solids 2 (1967) 58
    }
    out.thermal_strain[i] = expands / K;
    K /= K_weight, G /= G_weight;
    out.E[i] = 9 * K * G / (3 * K + G);
    out.nu[i] = (3 * K - 2 * G) / (2 * (3 * K + G));
  }
  return out;
}

void declare_elasticity(Schema& schema) {
  schema.add({.path = "material.*",
              .sentence = "Elastic constants, for [stress]; of a mixture those of its phases count.",
              .keys = {{"youngs_modulus", Kind::function, "Pa", optional, "Young's modulus, of place and temperature."},
                       {"poisson_ratio", Kind::function, "", optional, "Poisson's ratio."},
                       {"expansion", Kind::function, "1/K", optional,
                        "Mean coefficient of thermal expansion between `expansion_from` and T."},
                       {"expansion_from", Kind::quantity, "K", "20 degC",
                        "Temperature from which mean coefficients of expansion count."}}});
}

}  // namespace calor
