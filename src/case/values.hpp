#pragma once
// What a written value means, given the declaration of its key. Every reader throws Error(bad_case) at the value.
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/function.hpp"
#include "case/schema.hpp"
#include "case/tree.hpp"

namespace calor {

/// What values refer to beyond themselves.
struct Context {
  std::string folder;                           ///< of the case file; names of files count from here
  std::map<std::string, double> parameters;     ///< of formulas
  std::map<std::string, std::string> formulas;  ///< [function], that others may use by name; complete in themselves
  LengthsOfPlace lengths;                       ///< of formulas: the names of [cloud.distance]
  std::shared_ptr<Course> course = std::make_shared<Course>();  ///< of formulas of time
  std::map<std::string, Function::Callback> callbacks;          ///< of the program that reads the case
  /// The formula with the text of those that it names in their place.
  std::string expanded(const std::string& formula) const;
  std::string path_of(const std::string& file) const;
};

std::string read_text(const Value& value, const Key& key);
bool read_flag(const Value& value, const Key& key);
long read_integer(const Value& value, const Key& key);
/// Refuses a temperature, in SI, below absolute zero; what is none passes.
double above_absolute_zero(double si, const Value& value, const Key& key);
/// number, quantity, difference or integer; SI.
double read_number(const Value& value, const Key& key);
std::vector<std::string> read_texts(const Value& value, const Key& key);
std::vector<long> read_integers(const Value& value, const Key& key);
std::vector<double> read_numbers(const Value& value, const Key& key);
std::vector<std::pair<double, std::string>> read_raw_quantities(const Value& value, const Key& key);
Function read_function(const Value& value, const Key& key, const Context& context);

/// Reads the value as its key says and drops the result.
void check_value(const Value& value, const Key& key, const Context& context);

/// The default of a key as if it had been written at `location`; only for keys that have one.
Value fallback_value(const Key& key, const SourceLocation& location);
bool has_fallback(const Key& key);

/// "a number with unit, e.g. \"1 m\"": what the key takes, for messages and the manual.
std::string wanted(const Key& key);

[[noreturn]] void refuse_value(const Value& value, const std::string& what, const std::string& cure);

}  // namespace calor
