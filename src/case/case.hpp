#pragma once
// A case file, checked against the schema when it is read: a getter never fails for a reason the user could have been
// told before.
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/function.hpp"
#include "case/schema.hpp"

namespace calor {

/// One table of a case. Getters take the name of a declared key; what is absent gives the declared default
/// (`has` tells whether it was written). Quantities come in SI.
class Table {
 public:
  bool has(const std::string& key) const;    ///< written in the file (or in an override), not defaulted
  bool given(const std::string& key) const;  ///< has a value, written or default

  std::string text(const std::string& key) const;
  bool flag(const std::string& key) const;
  long integer(const std::string& key) const;
  double number(const std::string& key) const;      ///< also quantity and difference
  Function function(const std::string& key) const;  ///< also for a plain quantity
  std::vector<std::string> texts(const std::string& key) const;
  std::vector<long> integers(const std::string& key) const;
  std::vector<double> numbers(const std::string& key) const;  ///< also quantities
  /// Number and unit of Kind::raw_quantities as written.
  std::vector<std::pair<double, std::string>> quantities_with_units(const std::string& key) const;
  /// One of them in `si`, as a difference (1 degC is 1 K). Refuses what has another dimension: it is no `what`.
  double in_si(const std::string& key, const std::pair<double, std::string>& written, const std::string& si,
               const std::string& what, const std::string& cure) const;

  /// Sub-table `key`; an empty one with all defaults where it is absent. Also the { NAME = "..." } forms that a
  /// function takes besides (Key::choices); `has(NAME)` tells which.
  Table sub(const std::string& key) const;
  /// Named sub-tables in the order of the file ([material.steel], ...).
  std::vector<std::pair<std::string, Table>> children() const;
  /// Names of the keys written in the table, in the order of the file ([probe], whose names the user gives).
  std::vector<std::string> keys() const;
  /// The functions that are written in this table and those within it.
  std::vector<Function> functions() const;
  /// Array of tables ([[expect]]).
  std::vector<Table> list(const std::string& key) const;

  /// Location of the key's value; of the table itself where the key is absent or empty.
  SourceLocation location(const std::string& key = {}) const;
  const std::string& path() const;  ///< "material.steel"
  /// The length of that name which formulas of the case know ([cloud.distance]).
  LengthOfPlace& length_of_place(const std::string& name) const;
  /// A file named in the case, relative to the case file.
  std::string file(const std::string& key) const;

  /// Throws Error(bad_case) at the key.
  [[noreturn]] void refuse(const std::string& key, const std::string& what, const std::string& cure) const;

  struct Node;
  explicit Table(std::shared_ptr<const Node> node) : node_(std::move(node)) {}
  const Node& node() const { return *node_; }

 private:
  std::shared_ptr<const Node> node_;
};

struct Context;

/// Functions of the program that reads a case, which the case names by { callback = "NAME" }.
using Callbacks = std::map<std::string, Function::Callback>;

class Case {
 public:
  /// Reads a case file and checks it against `keys` (schema() of app/schema.hpp has all of them). `overrides` are
  /// "key.path=value" as on the command line (value in TOML; a bare word is taken as a string). "variant=NAME" applies
  /// the [[variant]] of that name first. Throws Error.
  static Case read(const std::string& path, const Schema& keys, const std::vector<std::string>& overrides = {},
                   const Callbacks& callbacks = {});
  /// From text; `name` stands for the file in messages.
  static Case parse(const std::string& text, const std::string& name, const Schema& keys,
                    const std::vector<std::string>& overrides = {}, const Callbacks& callbacks = {});

  const Table& root() const { return root_; }
  Table section(const std::string& key) const { return root_.sub(key); }
  /// Name for the results: file name without extension, with "/VARIANT" when one was chosen.
  const std::string& name() const { return name_; }
  const std::string& path() const { return path_; }
  /// Names of the [[variant]] entries in order.
  const std::vector<std::string>& variants() const { return variants_; }
  /// [parameter], [function] and [cloud.distance], usable in every formula.
  const Context& context() const { return *context_; }
  /// The whole case with every default filled in, as JSON for report.json.
  std::string json() const;

 private:
  Case(Table root) : root_(std::move(root)) {}
  Table root_;
  std::string name_, path_;
  std::vector<std::string> variants_;
  std::shared_ptr<const Context> context_;
};

// Selections of points by formula: where = "x > 0.5 && r < 1", with length = "mm" beside it.

/// The formula of `table`'s key `where`: not 0 where it is true. Throws Error(bad_case) at the key for a formula that
/// is wrong or depends on more than place.
Function where_function(const Case& c, const Table& table);

/// 1 for every point at which the formula of `table`'s key `where` is true. Throws Error(bad_case) at the key for a
/// formula that is wrong, is not finite at a point, or depends on more than place.
std::vector<char> where(const Case& c, const Table& table, std::span<const Vec3> x);

/// The keys `where` and `length`, to be declared with the others of a section.
std::vector<Key> where_keys(const std::string& sentence);

/// title, method, [parameter], [[variant]] and [output] keys.
void declare_case(Schema& schema);

}  // namespace calor
