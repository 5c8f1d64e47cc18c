#include "app/doc.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "base/error.hpp"
#include "case/case.hpp"

namespace calor {
namespace {

constexpr const char* introduction = R"md(# The case file

A case is one file in [TOML](https://toml.io). Every key is listed below; `calor doc KEY` shows one of them, or one
section. A key that calor does not know is an error, and so is a value of a wrong kind.

## Units

A quantity is a number with its unit in quotes: `"15 mm"`, `"350 W/(m^2 K)"`, `"20 degC"`. Any unit of that dimension
will do; a plain number where a unit is needed is an error. Results are in SI units. A difference (a tolerance) takes no offset:
`"1 degC"` is 1 K there. A relative one is a text with per cent: `"0.5 %"`. Where a list is wanted, a single value may
go without brackets.

z = 0 is the bottom of a body, and r = sqrt(x^2 + y^2) the distance from the z axis, in two dimensions from the origin. A
body of two dimensions has a thickness, one of one dimension a section: fluxes are in W/m^2, powers in W and energies in J
of the real body.

## Functions

Properties, conditions and sources may depend on place, time and temperature. A function is one of

| form | example |
|---|---|
| a quantity | `"1 W/(m K)"` |
| a formula | `{ formula = "exp(B*x)", unit = "W/(m K)", length = "m", time = "s", temperature = "K", breaks = ["1 s"] }` |
| a table | `{ table = [[300, 20.1], [400, 18]], of = "temperature", unit = "W/(m K)", temperature = "K", interpolation = "linear" }` |
| a table in a file | `{ file = "k.csv", of = "temperature", interpolation = "cubic" }` |
| a table along a coordinate | `{ table = [[0, 0.1], [10, 0.3]], along = "y", length = "mm" }` |
| a power law | `{ power = 2, along = "y", from = "0 mm", to = "10 mm", values = [0, 1] }` |
| an exponential law | `{ exponential = 3, along = "r", from = "0 mm", to = "10 mm", values = ["1 W/(m K)", "2 W/(m K)"] }` |
| a hump | `{ hump = [1, 1], factor = 0.4, along = "y", from = "0 mm", to = "10 mm" }` |
| layers | `{ layers = [0.2, 0.15], along = "z", thickness = ["1 mm", "2 mm"], start = "0 mm", unit = "W/(m K)" }` |

`unit` is the unit of the value; functions without dimension need none. A formula knows x, y, z, r, t, T, pi, e, the names
in `[parameter]`, the operators `+ - * / ^ < > <= >= == != && ||` and `condition ? yes : no`, and the functions sqrt, cbrt,
pow, exp, ln and log (both natural), log2, log10, sin, cos, tan, asin, acos, atan, atan2(y, x), sinh, cosh, tanh, asinh, acosh, atanh,
abs, sign, floor, ceil, rint (to the nearest whole number), mod (periodic in its first argument), erf, erfc, min, max, sum and avg
(of any number of arguments). `length`, `time` and `temperature` are the units of its variables (default m, s, K);
`breaks` are the times at which it jumps: steps land on them.

A table goes by temperature or by time: `of` tells. Without it the unit `temperature` or `time` of its rows does; otherwise
properties go by temperature and temperatures by time, and heat flows must tell. With `along` it goes by a coordinate x, y, z
or r in `length`. Rows ascend, and outside of them the value at the end holds. `interpolation` is `"linear"` or `"cubic"`
(monotone). A file has two columns with units in its header, `T [K],k [W/(m K)]`.

A law changes the value along x, y, z or r between two places, with s = (coordinate - from)/(to - from) and the values at
the ends outside: `power = M` means first + (last - first) s^M, `exponential = B` means
first + (last - first) (e^(B s) - 1)/(e^B - 1), both with `values = [first, last]` (default [0, 1] where there is no unit);
`hump = [n, z]` means factor s^n (1 - s)^z. A variant or KEY=VALUE may change one number of a law.

Layers lie on top of each other along an axis from `start` upwards; `thickness` is one for all or one a layer.

## Variants and changes

`calor run CASE.toml KEY=VALUE ...` changes keys for one run: `calor run disc.toml cloud.rings=40 "time.end=5 s"`. A `[[variant]]` gives a set
of changes a name: `calor run CASE.toml variant=NAME`; `calor verify` runs the case and all its variants.

## Sections
)md";

std::string code(const std::string& text) { return "`" + text + "`"; }

/// "[material.NAME]", "[[expect]]" or "top of the file".
std::string title(const Section& section) {
  std::string path = section.path;
  for (auto star = path.find('*'); star != path.npos; star = path.find('*')) path.replace(star, 1, "NAME");
  for (auto list = path.find("[]."); list != path.npos; list = path.find("[].")) path.erase(list, 2);
  const bool is_list = path.ends_with("[]");
  if (is_list) path.resize(path.size() - 2);
  std::string header = path.empty() ? "top of the file" : code((is_list ? "[[" : "[") + path + (is_list ? "]]" : "]"));
  if (!section.when_key.empty())
    header += fmt::format(" with {}", code(section.when_value.empty()
                                               ? section.when_key
                                               : fmt::format("{} = \"{}\"", section.when_key, section.when_value)));
  return header;
}

std::string kind(const Key& key) {
  const std::string unit = key.unit.empty() ? "" : ", " + key.unit;
  switch (key.kind) {
    case Kind::text:
      return "text";
    case Kind::choice:
      return fmt::format("`\"{}\"`", fmt::join(key.choices, "\"`, `\""));
    case Kind::flag:
      return "true or false";
    case Kind::integer:
      return "whole number";
    case Kind::number:
      return "number";
    case Kind::quantity:
      return "quantity" + unit;
    case Kind::difference:
      return "difference" + unit;
    case Kind::function: {
      std::string forms = "function" + unit;
      for (const std::string& other : key.choices) forms += fmt::format(", or `{{ {} = \"...\" }}`", other);
      return forms;
    }
    case Kind::texts:
      return "texts";
    case Kind::integers:
      return "whole numbers";
    case Kind::numbers:
      return "numbers";
    case Kind::quantities:
      return "quantities" + unit;
    case Kind::raw_quantities:
      return "quantities, relative or not";
    case Kind::table:
      return "section";
  }
  return {};
}

std::string fallback(const Key& key) {
  if (key.fallback == required) return "required";
  return key.fallback == optional || key.fallback.empty() ? "" : code(key.fallback);
}

/// A cell of a table must not hold the sign that ends it.
std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != text.npos; at = text.find('|', at + 2)) text.insert(at, 1, '\\');
  return text;
}

std::string describe(const Section& section, const std::vector<Key>& keys) {
  std::string out = fmt::format("\n### {}\n\n{}\n", title(section), section.sentence);
  if (keys.empty()) return out;
  out += "\n| key | kind | default | |\n|---|---|---|---|\n";
  for (const Key& key : keys)
    out += fmt::format("| {} | {} | {} | {} |\n", key.name == "*" ? "any name" : code(key.name), cell(kind(key)),
                       cell(fallback(key)), cell(key.sentence));
  return out;
}

/// The path as a user would write it: no brackets, so that doc expect.at finds [[expect]].
std::string plain(std::string path) {
  for (auto list = path.find("[]"); list != path.npos; list = path.find("[]")) path.erase(list, 2);
  return path;
}

/// Does `wanted` ("material.steel.density") fit a path of the schema ("material.*.density")? `whole`: all of it, or its
/// beginning.
bool fits(const std::string& path, const std::string& wanted, bool whole) {
  std::size_t p = 0, w = 0;
  while (true) {
    const auto p_end = std::min(path.find('.', p), path.size()), w_end = std::min(wanted.find('.', w), wanted.size());
    const std::string part = path.substr(p, p_end - p);
    if (part != wanted.substr(w, w_end - w) && part != "*") return false;
    if (w_end == wanted.size()) return !whole || p_end == path.size();
    if (p_end == path.size()) return false;
    p = p_end + 1, w = w_end + 1;
  }
}

}  // namespace

std::string manual(const Schema& schema, const std::string& key) {
  std::string out = key.empty() ? introduction : "";
  // Sections of one path belong together, in the order in which the paths come first.
  std::vector<const Section*> sections;
  for (const Section& first : schema.sections())
    for (const Section& section : schema.sections())
      if (section.path == first.path && !std::ranges::count(sections, &section)) sections.push_back(&section);

  std::vector<std::string> known;
  for (const Section* section : sections) {
    const std::string path = plain(section->path);
    if (!path.empty()) known.push_back(path);
    if (key.empty() || (!path.empty() && fits(path, key, false))) {
      out += describe(*section, section->keys);
      continue;
    }
    std::vector<Key> some;
    for (const Key& k : section->keys) {
      const std::string full = path.empty() ? k.name : path + "." + k.name;
      known.push_back(full);
      if (fits(full, key, true) && k.kind != Kind::table) some.push_back(k);
    }
    if (!some.empty()) out += describe(*section, some);
  }
  if (out.empty()) {
    std::string near = nearest(key, known);
    for (const std::string& path : known)  // the last name alone: radius instead of cloud.radius
      if (near.empty() && path.ends_with("." + key)) near = path;
    throw Error(Fault::command, fmt::format("'{}' is neither a section nor a key", key),
                near.empty() ? "calor doc lists all of them" : fmt::format("did you mean '{}'?", near));
  }
  if (out.front() == '\n') out.erase(0, 1);
  return out;
}

}  // namespace calor
