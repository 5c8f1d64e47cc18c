#pragma once
// The only step that knows the method: cloud in, flux sites out. A new method is a new file and a line in method.cpp.
#include <map>
#include <memory>
#include <string>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/cloud.hpp"
#include "method/flux_sites.hpp"

namespace calor {

/// What a method tells about itself for report.json: name -> value.
using MethodReport = std::map<std::string, double>;

struct Method {
  std::string name;
  /// Support radius over spacing: sizes the ghosts.
  double (*reach)(const Case& c);
  std::unique_ptr<FluxSites> (*build)(const Case& c, const Cloud& cloud, MethodReport& report);
};

/// The method that the case names.
const Method& chosen_method(const Case& c);

void declare_methods(Schema& schema);

}  // namespace calor
