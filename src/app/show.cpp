// What others ask the command for rather than do it themselves, the Python package among them: a case with its variant
// and changes, and units.
#include <fmt/format.h>

#include <stdexcept>

#include "app/say.hpp"
#include "app/verbs.hpp"
#include "base/units.hpp"
#include "case/keys.hpp"
#include "case/tree.hpp"

namespace calor {

int show_case(const Case& c) {
  say(toml_of(*c.root().node().root));
  return 0;
}

int show_unit(const std::string& unit, const std::string& other) {
  try {
    say(fmt::format("a difference of 1 {0} is {1} {2}, 0 {0} is {3} {2}\n", unit, difference_to_si(1, unit, other),
                    other, to_si(0, unit, other)));
  } catch (const std::invalid_argument& e) {
    throw Error(Fault::command, e.what(), "take a unit of the same dimension");
  }
  return 0;
}

}  // namespace calor
