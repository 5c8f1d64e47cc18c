#include "app/doc.hpp"

#include <fmt/color.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

#include "base/error.hpp"
#include "base/fold.hpp"
#include "case/case.hpp"
#include "material/library.hpp"

namespace calor {
namespace {

constexpr const char* introduction = R"md(# The case file

A case is one file in [TOML](https://toml.io). Every key is listed below; `calor doc WORD` shows on a terminal
a section, a key, a chapter, or what speaks of a word: `calor doc cloud`, `calor doc cloud.rings`, `calor doc radiation`, `calor doc units`. A key that calor does not know is an error, and so is a value of a wrong kind.

## Units

A quantity is a number with its unit in quotes: `"15 mm"`, `"350 W/(m^2 K)"`, `"20 degC"`. Any unit of that dimension
will do (`calor units degF K` says how one converts); a plain number where a unit is needed is an error. Results are in SI units. A difference (a tolerance) takes no offset:
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
| a callback | `{ callback = "my law" }` |
| a grid | `{ grid = [[20, 22], [19, 25]], along = ["x", "y"], from = ["0 mm", "0 mm"], to = ["100 mm", "80 mm"], unit = "W/(m K)" }` |

`unit` is the unit of the value; functions without dimension need none. A formula knows x, y, z, r, t, T, pi, e, the names
in `[parameter]` and `[function]`, the operators `+ - * / ^ < > <= >= == != && ||` and `condition ? yes : no`, and the functions sqrt, cbrt,
pow, exp, ln and log (both natural), log2, log10, sin, cos, tan, asin, acos, atan, atan2(y, x), sinh, cosh, tanh, asinh, acosh, atanh,
abs, sign, floor, ceil, rint (to the nearest whole number), mod (periodic in its first argument), erf, erfc, min, max, sum and avg
(of any number of arguments). `length`, `time` and `temperature` are the units of its variables (default m, s, K);
`breaks` are the times at which it jumps: steps land on them. A formula without them is looked at 10,000 times over the
run: its jumps, and where it begins to change after standing still or comes to rest, are found, if they last longer than
that, and steps that calor chooses pass over an eighth of its range at most (explicit Euler over a twenty-fifth).

A table goes by temperature or by time: `of` tells. Without it the unit `temperature` or `time` of its rows does; otherwise
properties go by temperature and temperatures by time, and heat flows must tell. With `along` it goes by a coordinate x, y, z
or r in `length`. Rows ascend, and outside of them the value at the end holds; the end of a run
tells where a table of temperature did not reach far enough and does not end level. `interpolation` is `"linear"` or `"cubic"`
(monotone). A file has two columns with units in its header, `T [K],k [W/(m K)]`.

A law changes the value along x, y, z or r between two places, with s = (coordinate - from)/(to - from) and the values at
the ends outside: `power = M` means first + (last - first) s^M, `exponential = B` means
first + (last - first) (e^(B s) - 1)/(e^B - 1), both with `values = [first, last]` (default [0, 1] where there is no unit);
`hump = [n, z]` means factor s^n (1 - s)^z. A variant or KEY=VALUE may change one number of a law.

Layers lie on top of each other along an axis from `start` upwards; `thickness` is one for all or one a layer.

A callback is a function of the program that reads the case, in SI units, such as one in Python (docs/core.md); the command has none.

A grid has values at evenly spaced nodes from `from` to `to`, one list for every node along the first axis of `along`, and is linear
in between along every axis. It must cover the body.

## Variants and changes

`calor run CASE.toml KEY=VALUE ...` changes keys for one run: `calor run disc.toml cloud.rings=40 "time.end=5 s"`. A `[[variant]]` gives a set
of changes a name: `calor run CASE.toml variant=NAME`; `calor verify` runs the case and all its variants. A change drops what it
replaces: `cloud.points=41` a spacing, `cloud.shape=box` the keys that went with the old shape. `calor show CASE.toml variant=NAME KEY=VALUE`
prints what comes out, as a file.

## Sections
)md";

std::string code(const std::string& text) { return "`" + text + "`"; }

/// NAME for the names that a user gives.
std::string with_name(std::string path) {
  for (auto star = path.find('*'); star != path.npos; star = path.find('*')) path.replace(star, 1, "NAME");
  return path;
}

/// "[material.NAME]", "[[expect]]" or "top of the file".
std::string title(const Section& section) {
  std::string path = with_name(section.path);
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

/// Sections of one path belong together, in the order in which the paths come first.
std::vector<const Section*> in_order(const Schema& schema) {
  std::vector<const Section*> sections;
  for (const Section& first : schema.sections())
    for (const Section& section : schema.sections())
      if (section.path == first.path && !std::ranges::count(sections, &section)) sections.push_back(&section);
  return sections;
}

std::string full_name(const Section& section, const Key& key) {
  const std::string path = plain(section.path);
  return path.empty() ? key.name : path + "." + key.name;
}

std::string last_name(const std::string& path) { return path.substr(path.rfind('.') + 1); }

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// The library of materials, in Markdown.
std::string material_table() {
  std::string text =
      "\nThe library holds these; a case takes one by `library = \"NAME\"` in `[material.*]`, or by its name alone. "
      "Each figure "
      "has its source; T in K, t in degC.\n\n| material | conductivity, density, specific heat |\n|---|---|\n";
  for (const LibraryMaterial& m : material_library()) {
    const auto value = [](const char* name, const LibraryValue& v) {
      return fmt::format("{} {}{}{} ({})", name, v.value, v.unit.empty() ? "" : " ", v.unit, v.source);
    };
    text += fmt::format("| {} | {}; {}; {}; ", m.name, value("k", m.conductivity), value("rho", m.density),
                        value("c", m.specific_heat));
    if (m.melting)
      text += fmt::format("melts from {:g} to {:g} K, {:g} J/kg ({}); ", m.melting->latent.solidus,
                          m.melting->latent.liquidus, m.melting->latent.heat, m.melting->source);
    text += fmt::format("good for {:g} to {:g} K |\n", m.low, m.high);
  }
  return text;
}

/// A chapter of the manual that is no list of keys.
struct Chapter {
  std::string title, text;
};

std::vector<Chapter> chapters() {
  std::vector<Chapter> all;
  const std::string text = introduction;
  for (auto at = text.find("\n## "); at != text.npos;) {
    const auto begin = text.find('\n', at + 1), end = text.find("\n## ", begin);
    if (const std::string title = text.substr(at + 4, begin - at - 4); end != text.npos)
      all.push_back({title, text.substr(begin, end - begin)});
    at = end;
  }
  all.push_back({"Materials", material_table()});
  return all;
}

// On a terminal ------------------------------------------------------------------------------------------------------

std::string without_backticks(std::string text) {
  std::erase(text, '`');
  return text;
}

class Page {
 public:
  explicit Page(bool in_colour) : in_colour_(in_colour) {}

  void heading(const std::string& text) {
    if (!out_.empty()) out_ += '\n';
    out_ += (in_colour_ ? fmt::format(fmt::emphasis::bold, "{}", text) : text) + "\n";
  }
  void blank() { out_ += '\n'; }
  void paragraph(const std::string& text, std::size_t indent = 0) {
    for (const std::string& line : folded(without_backticks(text), std::string(indent, ' '), indent))
      out_ += line + "\n";
  }
  /// A name, what goes with it, and below it a sentence.
  void entry(const std::string& name, const std::string& what, const std::string& sentence = "") {
    std::vector<std::string> lines = folded(without_backticks(what), "  " + name + (what.empty() ? "" : "  "), 6);
    if (in_colour_) lines[0].replace(2, name.size(), fmt::format(fmt::fg(fmt::terminal_color::cyan), "{}", name));
    for (const std::string& line : lines) out_ += line + "\n";
    if (!sentence.empty()) paragraph(sentence, 6);
  }
  const std::string& text() const { return out_; }

 private:
  bool in_colour_;
  std::string out_;
};

void show(Page& page, const Section& section, const std::vector<Key>& keys) {
  page.heading(without_backticks(title(section)));
  page.paragraph(section.sentence);
  for (const Key& key : keys) {
    const std::string otherwise = fallback(key);
    page.entry(key.name == "*" ? "any name" : key.name,
               kind(key) + (otherwise.empty()         ? ""
                            : otherwise == "required" ? "; required"
                                                      : "; default " + otherwise),
               key.sentence);
  }
}

/// Markdown as the chapters have it: paragraphs, and tables of two columns.
void show(Page& page, const Chapter& chapter) {
  page.heading(chapter.title);
  std::istringstream lines(chapter.text);
  std::string paragraph;
  bool is_first = true;
  const auto end_paragraph = [&] {
    if (paragraph.empty()) return;
    if (!is_first) page.blank();
    page.paragraph(paragraph);
    paragraph.clear();
    is_first = false;
  };
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("|--") || line.starts_with("| form") || line.starts_with("| material |")) continue;
    if (const auto bar = line.find(" | "); line.starts_with("| ") && bar != line.npos) {
      end_paragraph();
      page.entry(line.substr(2, bar - 2), "");
      std::istringstream parts(line.substr(bar + 3, line.size() - bar - 5));
      for (std::string part; std::getline(parts, part, ';');) page.paragraph(part, 6);
    } else if (line.empty()) {
      end_paragraph();
    } else {
      paragraph += line + " ";
    }
  }
  end_paragraph();
}

[[noreturn]] void refuse_word(const std::string& word, const std::vector<std::string>& known) {
  std::string near = nearest(word, known);
  std::vector<std::string> last_names;
  last_names.reserve(known.size());
  for (const std::string& path : known) last_names.push_back(last_name(path));
  if (near.empty()) near = nearest(word, last_names);
  throw Error(Fault::command, fmt::format("'{}' is nowhere in the manual", word),
              near.empty() ? "calor doc shows all of it" : fmt::format("did you mean '{}'?", near));
}

}  // namespace

std::string manual(const Schema& schema) {
  std::string out = introduction;
  for (const Section* section : in_order(schema)) out += describe(*section, section->keys);
  return out + "\n## Materials\n" + material_table();
}

std::string manual_on(const Schema& schema, const std::string& word, bool in_colour) {
  const std::vector<const Section*> sections = in_order(schema);
  const std::string wanted = lower(word);
  Page page(in_colour);
  std::vector<std::string> known;
  // What has this path, or else what has this name anywhere.
  const auto show_where = [&](const auto& is_section, const auto& is_key) {
    for (const Section* section : sections) {
      const std::string path = plain(section->path);
      if (!path.empty() && is_section(path)) {
        show(page, *section, section->keys);
        continue;
      }
      std::vector<Key> some;
      for (const Key& key : section->keys)
        if (key.kind != Kind::table && is_key(full_name(*section, key))) some.push_back(key);
      if (!some.empty()) show(page, *section, some);
    }
  };
  show_where([&](const std::string& path) { return fits(path, word, false); },
             [&](const std::string& path) { return fits(path, word, true); });
  if (page.text().empty())
    show_where([&](const std::string& path) { return last_name(path) == wanted; },
               [&](const std::string& path) { return last_name(path) == wanted; });
  for (const Chapter& chapter : chapters()) {
    known.push_back(lower(chapter.title));
    if (page.text().empty() && lower(chapter.title).find(wanted) != std::string::npos) show(page, chapter);
  }
  if (!page.text().empty()) return page.text();

  for (const Section* section : sections) {
    if (const std::string path = plain(section->path); !path.empty()) known.push_back(path);
    for (const Key& key : section->keys) known.push_back(full_name(*section, key));
  }
  if (wanted.size() > 2)
    for (const Section* section : sections)
      for (const Key& key : section->keys)
        if (const std::string about = lower(full_name(*section, key) + " " + kind(key) + " " + key.sentence);
            about.find(wanted) != about.npos) {
          if (page.text().empty()) page.heading(fmt::format("Keys that speak of \"{}\"", word));
          page.entry(with_name(full_name(*section, key)), "", key.sentence);
        }
  if (page.text().empty()) refuse_word(word, known);
  return page.text();
}

}  // namespace calor
