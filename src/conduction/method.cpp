#include "conduction/method.hpp"

#include "base/parallel.hpp"

namespace calor {

Method sph_method(), peridynamics_method(), mlpg_method();

Registry<Method>& methods() {
  static Registry<Method> all = {sph_method(), peridynamics_method(), mlpg_method()};
  return all;
}

void count_pairs(const Cloud& cloud, const Neighbours& neighbours, MethodReport& report) {
  require_neighbours(cloud, neighbours);
  const auto pairs = total(cloud.comm, static_cast<std::int64_t>(neighbours.column.size()));
  report["pairs"] = static_cast<double>(pairs);
  report["neighbours"] = static_cast<double>(pairs) / static_cast<double>(cloud.count);
}

const Method& chosen_method(const Case& c) { return methods().chosen(c.root(), "method"); }

void declare_methods(Schema& schema) {
  schema.add({.path = "",
              .sentence = "",
              .keys = {{"method", Kind::choice, "", required,
                        "How the heat equation is discretised." + methods().sentences(), methods().names()}}});
  methods().declare(schema);
}

}  // namespace calor
