#pragma once
// Every key of a case file is declared once: name, kind, unit, default, one sentence. Reading, error messages and
// the manual (`calor doc`) all come from these declarations. A module declares its own keys next to the code that uses
// them: see `declare_*` functions.
#include <string>
#include <vector>

namespace calor {

enum class Kind {
  text,    ///< any string
  choice,  ///< one of `choices`
  flag,    ///< true or false
  integer,
  number,      ///< without unit
  quantity,    ///< "15 mm": number with unit
  difference,  ///< a quantity whose affine unit takes no offset ("1 degC" is 1 K)
  function,    ///< a number with unit, { formula = ... }, { table = ... }, { layers = ... }, { power = ... } ...
  texts,       ///< list of strings; lists of one may go without brackets
  integers,
  numbers,
  quantities,      ///< list of numbers with units
  raw_quantities,  ///< one or a list of numbers with units of any dimension ("0.2 K", "0.02 %"), kept as written
  table            ///< a sub-table with a section of its own
};

struct Key {
  std::string name;
  Kind kind;
  std::string unit;      ///< SI unit of quantities and functions; "" for the others
  std::string fallback;  ///< the default as it would be written; `required` or `optional`
  std::string sentence;  ///< ends with a full stop
  /// Of a choice: its values. Of a function: other forms { NAME = "..." } that the key takes besides; read them by
  /// Table::sub(key).
  std::vector<std::string> choices = {};
  /// Keys of the same table in whose place this one stands: a variant or KEY=VALUE that writes it drops them.
  std::vector<std::string> instead_of = {};
};
inline const std::string required = "\x01required";
inline const std::string optional = "\x01optional";

/// A table of the case file. `path` is dotted, "" is the top of the file; "*" stands for a name the user gives
/// ("material.*"), "[]" at the end for an array of tables ("expect[]"). `when` limits the section to tables in which
/// key `when_key` has value `when_value` (for keys that go with one choice; "" for any value); several sections of one
/// path add up. A key named "*" stands for any names ([parameter]). A key of Kind::table says what its sub-table is for
/// and whether it is required; where no section is declared for it, it may hold anything.
struct Section {
  std::string path;
  std::string sentence;
  std::vector<Key> keys;
  std::string when_key = {}, when_value = {};
};

class Schema {
 public:
  void add(Section section) { sections_.push_back(std::move(section)); }
  const std::vector<Section>& sections() const { return sections_; }

 private:
  std::vector<Section> sections_;
};

}  // namespace calor
