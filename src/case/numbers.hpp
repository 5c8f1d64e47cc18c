#pragma once
// Numbers that stand in a case, and the same case with other numbers in their place.
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"

namespace calor {

class CaseNumbers {
 public:
  /// The number at a path, such as material.steel.conductivity or body.layer[1].contact. Of a list: all of its entries,
  /// the last index running fastest. `asked_at`: where the path is written. Throws Error(bad_case) where there is no
  /// number.
  CaseNumbers(const Case& c, const std::string& path, const SourceLocation& asked_at);

  /// As they are written, in the unit that stands there.
  const std::vector<double>& values() const { return values_; }
  /// Their paths.
  const std::vector<std::string>& names() const { return names_; }
  /// The case with other values. Throws Error(bad_case) where they do not fit.
  Case with(std::span<const double> values) const;

 private:
  const Case& case_;
  std::vector<std::string> keys_;  // see split_path
  std::vector<double> values_;
  std::vector<std::string> names_;
};

}  // namespace calor
