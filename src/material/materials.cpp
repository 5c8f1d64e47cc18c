#include "material/materials.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "geometry/parts.hpp"
#include "material/library.hpp"
#include "material/material_field.hpp"
#include "material/simple.hpp"

namespace calor {

MaterialLaw mixture_law();

Registry<MaterialLaw>& material_laws() {
  static Registry<MaterialLaw> all = {mixture_law()};
  return all;
}

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
  const auto laws = material_laws().given(table);
  if (laws.empty()) return read_simple_material(name, table, case_.root().has("time"));
  if (laws.size() > 1)
    table.refuse(laws[1]->name, fmt::format("[{}] has '{}' and '{}'", table.path(), laws[0]->name, laws[1]->name),
                 "keep one of them");
  if (std::ranges::count(making_, name))
    table.refuse("phases", fmt::format("'{}' is a phase of itself", name), "name two other materials");
  making_.push_back(name);
  const auto made = laws.front()->make(name, table, *this);
  making_.pop_back();
  return made;
}

std::string Materials::only_one() const {
  const auto materials = case_.section("material").children();
  if (materials.empty())
    throw Error(Fault::bad_case, case_.section("material").location(), "the case has no material",
                "add [material.NAME] with a conductivity, or library = \"...\" in it");
  std::vector<std::string> phases, bodies;
  for (const auto& [name, table] : materials)
    for (const MaterialLaw* law : material_laws().given(table))
      if (law->ingredients)
        for (const std::string& phase : law->ingredients(table)) phases.push_back(phase);
  for (const auto& [name, table] : materials)
    if (!std::ranges::count(phases, name)) bodies.push_back(name);
  if (bodies.size() == 1) return bodies.front();
  throw Error(Fault::bad_case, case_.section("body").location(),
              bodies.empty() ? "every material is a phase of another"
                             : fmt::format("it is not said which of {} the body is made of", fmt::join(bodies, ", ")),
              "add [body] with material = \"...\", layers or regions");
}

void declare_materials(Schema& schema) {
  schema.add({.path = "material.*",
              .sentence =
                  "A material. A value may depend on place (x, y, z, r) and temperature (T), the conductivity on "
                  "time (t) too.",
              .keys = simple_keys()});
  declare_anisotropy(schema);
  material_laws().declare(schema);
  declare_parts(schema);
}

}  // namespace calor
