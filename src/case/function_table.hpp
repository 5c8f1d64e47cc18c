#pragma once
// The sub-keys of one function value, { formula = ..., unit = ... }, for the readers of its forms.
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/values.hpp"

namespace calor {

/// Every reader throws Error(bad_case) at the value.
class FunctionTable {
 public:
  /// Refuses keys that are neither `form` nor one of `others`.
  FunctionTable(const Value& table, const Key& owner, const std::string& form, const std::vector<std::string>& others);

  const Value* find(const Key& key) const { return table_.find(key.name); }
  /// The value, or the default; refuses where there is none.
  Value get(const Key& key) const;
  /// A unit that converts to `si_unit`.
  std::string unit(const Key& key, const std::string& si_unit) const;
  /// The unit of the values: required unless the key has no dimension.
  std::string value_unit() const;
  /// A value of the function itself in SI: a quantity, or a number in the unit of the values.
  double value(const Value& v, const std::string& name) const;

  const Value& table() const { return table_; }
  const Key& owner() const { return owner_; }

 private:
  const Value& table_;
  const Key& owner_;
};

/// What the key takes and what it is for: for values whose form is wrong altogether.
std::string explained(const Key& key);

/// { grid = [[...], ...], along, from, to, unit }: values at the nodes of a grid, linear in between.
Function read_grid(const FunctionTable& parts);

}  // namespace calor
