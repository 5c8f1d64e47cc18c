#pragma once
// The materials of a case by name: those of [material.*], then those of the library.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "case/registry.hpp"
#include "material/material.hpp"

namespace calor {

class Materials {
 public:
  /// The case must outlive this.
  explicit Materials(const Case& c) : case_(c) {}

  /// Throws Error(bad_case) at `location` for a name that is unknown, and at the material's own keys for what is wrong
  /// there.
  std::shared_ptr<const Material> get(const std::string& name, const SourceLocation& location);
  /// The one material that is not a phase of another; throws Error(bad_case) where there are none or several.
  std::string only_one() const;

 private:
  std::shared_ptr<const Material> make(const std::string& name, const Table& table);

  const Case& case_;
  std::map<std::string, std::shared_ptr<const Material>> made_;
  std::vector<std::string> making_;  // names on the way, to find a mixture of itself
};

/// How the properties of a [material.NAME] come about, other than by those that it names itself (simple.hpp).
struct MaterialLaw {
  std::string name;  ///< its key in [material.NAME]
  std::string sentence;
  void (*declare)(Schema& schema);
  /// `others`: for the materials it is made of.
  std::shared_ptr<const Material> (*make)(const std::string& name, const Table& table, Materials& others);
  /// Names of the materials it is made of; null where of none.
  std::vector<std::string> (*ingredients)(const Table& table) = nullptr;
};
Registry<MaterialLaw>& material_laws();

}  // namespace calor
