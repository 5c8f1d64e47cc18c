#pragma once
// Errors carry what went wrong, where, and the cure; the kind decides the exit code of the command.
#include <stdexcept>
#include <string>
#include <vector>

namespace calor {

/// What kind of thing went wrong; the value is the exit code of the command.
enum class Fault { command = 2, bad_case = 3, file = 4, numbers = 5 };

/// A location in a file; line and column count from 1, 0 means unknown.
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;

  /// "weld.toml:14:9", without the parts that are unknown.
  std::string text() const;
};

/// "location: what: cure" in one line, e.g. `weld.toml:14:9: 'conductivty' is not a key of
/// [material.steel]: did you mean 'conductivity'?`
class Error : public std::runtime_error {
 public:
  Error(Fault fault, SourceLocation location, std::string what, std::string cure);
  Error(Fault fault, std::string what, std::string cure);

  Fault fault() const { return fault_; }
  const SourceLocation& location() const { return location_; }
  const std::string& problem() const { return problem_; }
  const std::string& cure() const { return cure_; }

 private:
  Fault fault_;
  SourceLocation location_;
  std::string problem_, cure_;
};

/// Calls `work`. An Error that it throws without a location gets this one.
template <class Work>
auto located(const SourceLocation& location, const Work& work) {
  try {
    return work();
  } catch (const Error& e) {
    if (!e.location().file.empty()) throw;
    throw Error(e.fault(), location, e.problem(), e.cure());
  }
}

/// Nearest of `known` to `word` by edit distance, or "" when none is near: "did you mean ...?"
std::string nearest(const std::string& word, const std::vector<std::string>& known);

}  // namespace calor
