#pragma once
// A formula as text, compiled by muparser.
#include <muParser.h>

#include <list>
#include <map>
#include <memory>
#include <string>

#include "base/error.hpp"
#include "base/function.hpp"
#include "base/vec3.hpp"

namespace calor {

/// An expression in x, y, z, r, t, T, pi, e, named parameters and lengths that depend on place.
class Formula {
 public:
  /// Throws Error(bad_case, location) for everything that is not one arithmetic expression of known symbols.
  Formula(std::string expression, const FormulaUnits& units, const std::map<std::string, double>& parameters,
          const SourceLocation& location, const LengthsOfPlace& lengths = {});
  Formula(const Formula&) = delete;  // the parser points to the variables

  /// Value in SI of arguments in SI. Not finite where the formula is not.
  double operator()(const Vec3& x, double t, double T);

  bool uses(const std::string& variable) const { return used_.contains(variable); }
  bool uses_place() const;
  bool may_jump() const;  ///< or bend: does it compare, or use a function that jumps?
  const std::string& expression() const { return expression_; }

 private:
  /// SI = factor * number + shift.
  struct Scale {
    double factor = 1, shift = 0;
  };
  static Scale scale(const std::string& unit, const std::string& si);
  /// One of the lengths that the expression uses.
  struct NamedLength {
    std::string name;
    std::shared_ptr<const LengthOfPlace> length;
    double value = 0;  // the parser points to it
  };

  std::string expression_;
  Scale value_, length_, time_, temperature_;
  double x_ = 0, y_ = 0, z_ = 0, r_ = 0, t_ = 0, T_ = 0;
  mu::Parser parser_;
  std::map<std::string, double*> used_;
  std::list<NamedLength> lengths_;
  SourceLocation location_;
};

}  // namespace calor
