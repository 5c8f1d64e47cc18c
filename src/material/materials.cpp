#include "material/materials.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <tuple>

#include "case/where.hpp"
#include "material/library.hpp"
#include "material/material_field.hpp"
#include "material/mixture.hpp"
#include "material/simple.hpp"

namespace calor {
namespace {

const std::vector<std::string> property_keys = {"conductivity", "density", "specific_heat", "library",
                                                "latent_heat",  "solidus", "liquidus"};

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

std::shared_ptr<const Material> make_simple(const std::string& name, const Table& table, bool transient) {
  std::optional<Function> k, rho, c;
  if (table.has("library")) {
    const SimpleProperties p = find_in_library(table.text("library"))->properties();
    k = p.conductivity, rho = p.density, c = p.specific_heat;
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
  return make_simple_material(name, {*k, rho, c, latent_heat(table)});
}

}  // namespace

std::shared_ptr<const Material> Materials::get(const std::string& name, const SourceLocation& location) {
  if (const auto found = made_.find(name); found != made_.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [other, table] : case_.section("material").children()) {
    known.push_back(other);
    if (other == name) return made_[name] = make(name, table);
  }
  if (const LibraryMaterial* m = find_in_library(name))
    return made_[name] = make_simple_material(name, m->properties());
  for (const auto& m : material_library()) known.push_back(m.name);
  const std::string near = nearest(name, known);
  throw Error(Fault::bad_case, location, fmt::format("there is no material '{}'", name),
              near.empty() ? fmt::format("add [material.{}]; known are {}", name, fmt::join(known, ", "))
                           : fmt::format("did you mean '{}'?", near));
}

std::shared_ptr<const Material> Materials::make(const std::string& name, const Table& table) {
  if (!table.has("mix")) return make_simple(name, table, case_.root().has("time"));
  for (const auto& key : property_keys)
    if (table.has(key))
      table.refuse(key, fmt::format("[{}] is a mixture and has a '{}' of its own", table.path(), key),
                   "write the properties of the phases");
  if (std::ranges::count(making_, name))
    table.refuse("phases", fmt::format("'{}' is a phase of itself", name), "name two other materials");
  const auto phases = table.texts("phases");
  if (phases.size() != 2)
    table.refuse("phases", fmt::format("a mixture has two phases, not {}", phases.size()),
                 "write phases = [\"first\", \"second\"]");
  making_.push_back(name);
  const auto first = get(phases[0], table.location("phases")), second = get(phases[1], table.location("phases"));
  std::shared_ptr<const Material> filling;
  if (table.has("pores")) filling = get(table.sub("pores").text("material"), table.sub("pores").location("material"));
  making_.pop_back();
  MixtureRecipe recipe{.name = name,
                       .rule = &*std::ranges::find(mixing_rules(), table.text("mix"), &MixingRule::name),
                       .basis = table.text("basis") == "mass" ? Basis::mass : Basis::volume,
                       .fraction = table.function("fraction"),
                       .phases = {first, second}};
  if (table.has("pores")) {
    const Table pores = table.sub("pores");
    recipe.phases.push_back(filling);
    recipe.porosity = pores.function("porosity");
    recipe.pores = pores.text("as") == "third" ? Pores::third : Pores::sequential;
  }
  return make_mixture(std::move(recipe), table.location("basis"));
}

std::string Materials::only_one() const {
  const auto materials = case_.section("material").children();
  if (materials.empty())
    throw Error(Fault::bad_case, case_.section("material").location(), "the case has no material",
                "add [material.NAME] with a conductivity, or library = \"...\" in it");
  std::vector<std::string> phases, bodies;
  for (const auto& [name, table] : materials)
    if (table.has("mix")) {
      for (const auto& phase : table.texts("phases")) phases.push_back(phase);
      if (table.has("pores")) phases.push_back(table.sub("pores").text("material"));
    }
  for (const auto& [name, table] : materials)
    if (!std::ranges::count(phases, name)) bodies.push_back(name);
  if (bodies.size() == 1) return bodies.front();
  throw Error(Fault::bad_case, case_.section("body").location(),
              bodies.empty() ? "every material is a phase of another"
                             : fmt::format("it is not said which of {} the body is made of", fmt::join(bodies, ", ")),
              "add [body] with material = \"...\", layers or regions");
}

void declare_materials(Schema& schema) {
  std::vector<std::string> rules, library;
  std::string rule_sentence = "Mixes two other materials, the conductivity by a rule (docs/graded-materials.md).";
  for (const auto& rule : mixing_rules()) {
    rules.push_back(rule.name);
    rule_sentence += fmt::format(" {}: {}.", rule.name, rule.sentence);
  }
  for (const auto& m : material_library()) library.push_back(m.name);

  schema.add(
      {.path = "material.*",
       .sentence = "A material. A value may depend on place (x, y, z, r) and temperature (T), the conductivity on "
                   "time (t) too. The conductivity is the same in all directions: one value, not a list.",
       .keys = {{"conductivity", Kind::function, "W/(m K)", optional,
                 "Conductivity, the same in all directions (anisotropic bodies are not supported)."},
                {"density", Kind::function, "kg/m^3", optional, "Density; a steady case does without."},
                {"specific_heat", Kind::function, "J/(kg K)", optional, "Specific heat; a steady case does without."},
                {"latent_heat", Kind::quantity, "J/kg", optional,
                 "Heat of melting, taken up evenly between solidus and liquidus."},
                {"solidus", Kind::quantity, "K", optional, "Temperature at which melting begins."},
                {"liquidus", Kind::quantity, "K", optional, "Temperature at which melting ends."},
                {"library", Kind::choice, "", optional,
                 "Takes the values of a built-in material; keys written beside it replace single values.", library},
                {"mix", Kind::choice, "", optional, rule_sentence, rules}}});
  schema.add({.path = "material.*",
              .sentence = "A mixture of two other materials (docs/graded-materials.md).",
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
                        "with the pores as second phase; third: it mixes all three at once.",
                        {"sequential", "third"}}}});
  const std::vector<std::string> axes = {"x", "y", "z"};
  schema.add(
      {.path = "body",
       .sentence = "What the body is made of; not needed where there is one material that is no phase of another.",
       .keys = {{"material", Kind::text, "", optional, "Material of all points that no region takes."},
                {"conductivity_mean",
                 Kind::choice,
                 "",
                 "automatic",
                 "How two points share a conductivity. automatic: integral for one material with k(T), harmonic "
                 "for layers and regions, arithmetic for the rest.",
                 {"automatic", "integral", "arithmetic", "harmonic"}},
                {"along", Kind::choice, "", optional, "Axis across the layers, from the low side up.", axes},
                {"start", Kind::quantity, "m", optional,
                 "Coordinate at which the first layer begins; default: the low side of the body."}}});
  schema.add({.path = "body.layer[]",
              .sentence = "A layer of the body; a point on an interface belongs to both layers, half and half.",
              .keys = {{"material", Kind::text, "", required, "Material of the layer."},
                       {"thickness", Kind::quantity, "m", required, "Thickness of the layer."}}});
  auto keys = where_keys("Formula in x, y, z, r that is true in the region.");
  keys.insert(keys.begin(), {"material", Kind::text, "", required, "Material of the region."});
  keys.push_back({"tag", Kind::text, "", optional, "Tag of the points of the region."});
  schema.add({.path = "body.region[]",
              .sentence = "A part of the body, by formula or tag; of two regions that overlap the later one counts.",
              .keys = keys});
}

}  // namespace calor
