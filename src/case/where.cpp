#include "case/where.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "base/units.hpp"

namespace calor {

std::vector<char> where(const Case& c, const Table& table, std::span<const Vec3> x) {
  try {
    to_si(1, table.text("length"), "m");
  } catch (const std::invalid_argument& e) {
    table.refuse("length", fmt::format("'length' = \"{}\": {}", table.text("length"), e.what()),
                 "write a unit of length, such as \"mm\"");
  }
  const Function f = Function::formula(table.text("where"), {.value = "", .si = "", .length = table.text("length")},
                                       c.parameters(), table.location("where"));
  if (f.depends_on_time() || f.depends_on_temperature())
    table.refuse("where",
                 fmt::format("'where' = \"{}\" depends on {}", table.text("where"),
                             f.depends_on_time() ? "time" : "temperature"),
                 "use x, y, z and r only");
  std::vector<double> value(x.size());
  f.evaluate({.x = x}, value);
  std::vector<char> selected(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) selected[i] = value[i] != 0;
  return selected;
}

std::vector<Key> where_keys(const std::string& sentence) {
  return {{"where", Kind::text, "", optional, sentence},
          {"length", Kind::text, "", "m", "Unit of x, y, z and r in 'where'."}};
}

}  // namespace calor
