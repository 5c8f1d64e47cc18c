#include "conduction/method.hpp"

#include <vector>

#include "base/parallel.hpp"
#include "conduction/mlpg.hpp"
#include "conduction/peridynamics.hpp"
#include "conduction/sph.hpp"

namespace calor {

namespace {

/// One line per method.
const std::vector<Method>& methods() {
  static const std::vector<Method> all = {sph_method(), peridynamics_method(), mlpg_method()};
  return all;
}

}  // namespace

void count_pairs(const Cloud& cloud, const Neighbours& neighbours, MethodReport& report) {
  require_neighbours(cloud, neighbours);
  const auto pairs = total(cloud.comm, static_cast<std::int64_t>(neighbours.column.size()));
  report["pairs"] = static_cast<double>(pairs);
  report["neighbours"] = static_cast<double>(pairs) / static_cast<double>(cloud.count);
}

const Method& chosen_method(const Case& c) {
  const std::string name = c.root().text("method");
  for (const Method& method : methods()) {
    if (method.name == name) return method;
  }
  c.root().refuse("method", "'" + name + "' is not a method",
                  "choose one of the methods that `calor doc method` lists");
}

void declare_methods(Schema& schema) {
  std::vector<std::string> names;
  for (const Method& method : methods()) names.push_back(method.name);
  schema.add({.path = "",
              .sentence = "",
              .keys = {{"method", Kind::choice, "", required, "How the heat equation is discretised.", names}}});
  declare_sph(schema);
  declare_peridynamics(schema);
  declare_mlpg(schema);
}

}  // namespace calor
