#pragma once
// The only step that knows the method: cloud in, discretisation out. A new method is a new file and its name in
// method.cpp.
#include <map>
#include <memory>
#include <string>

#include "boundary/conditions.hpp"
#include "case/registry.hpp"
#include "cloud/cloud.hpp"
#include "cloud/neighbours.hpp"
#include "conduction/discretisation.hpp"
#include "material/material_field.hpp"

namespace calor {

/// What a method tells about itself for report.json: name -> value.
using MethodReport = std::map<std::string, double>;

struct Method {
  std::string name, sentence;
  void (*declare)(Schema& schema) = nullptr;  ///< its section; null where it has no options
  /// How far its points see at most: sizes the ghosts.
  Support (*support)(const Case& c);
  /// Cloud and conditions must outlive the discretisation. Collective; throws Error.
  Discretisation (*build)(const Case& c, const Cloud& cloud, const Conditions& conditions,
                          const MaterialField& material, MethodReport& report);
};

/// Counts pairs for the report and refuses points with too few neighbours. Collective.
void count_pairs(const Cloud& cloud, const Neighbours& neighbours, MethodReport& report);

Registry<Method>& methods();
/// The method that the case names.
const Method& chosen_method(const Case& c);

void declare_methods(Schema& schema);

}  // namespace calor
