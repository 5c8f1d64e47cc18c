#include "base/formula.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/units.hpp"

namespace calor {
namespace {

void define_functions(mu::Parser& parser) {
  // muparser has sin, cos, tan, asin, ..., exp, ln, log (= ln), log10, log2, sqrt, abs, sign, rint, min, max, sum, avg.
  parser.DefineFun(
      "floor", +[](double a) { return std::floor(a); });
  parser.DefineFun(
      "ceil", +[](double a) { return std::ceil(a); });
  parser.DefineFun(
      "cbrt", +[](double a) { return std::cbrt(a); });
  parser.DefineFun(
      "erf", +[](double a) { return std::erf(a); });
  parser.DefineFun(
      "erfc", +[](double a) { return std::erfc(a); });
  parser.DefineFun(
      "pow", +[](double a, double b) { return std::pow(a, b); });
  parser.DefineFun(
      "mod", +[](double a, double b) { return a - b * std::floor(a / b); });  // of b's sign: periodic in a
}

/// What muparser would take silently, or refuse without saying what is known.
class Reader {
 public:
  Reader(const std::string& expression, const mu::Parser& parser, const SourceLocation& location)
      : text_(expression), parser_(parser), location_(location) {}

  void check() const {
    std::vector<bool> call;  // one entry for each open parenthesis: is it a function's?
    bool after_function = false;
    for (std::size_t i = 0; i < text_.size();) {
      const char c = text_[i];
      if (starts_number(i)) {
        i = number_end(i);
      } else if (is_letter(c)) {
        const std::size_t begin = i;
        while (i < text_.size() && (is_letter(text_[i]) || is_digit(text_[i]))) ++i;
        after_function = known(text_.substr(begin, i - begin), begin);
        continue;
      } else if (c == '=' || ((c == '<' || c == '>' || c == '!') && i + 1 < text_.size() && text_[i + 1] == '=')) {
        if (c == '=' && (i + 1 == text_.size() || text_[i + 1] != '=')) {
          refuse(i, "a single '=' has no meaning", "compare with '=='");
        }
        i += 2;
      } else {
        if (c == '(') call.push_back(after_function);
        if (c == ')' && !call.empty()) call.pop_back();
        if (c == ',' && (call.empty() || !call.back())) {
          refuse(i, "a comma outside the arguments of a function", "decimals follow a point");
        }
        ++i;
        if (std::isspace(static_cast<unsigned char>(c))) continue;
      }
      after_function = false;
    }
  }

  [[noreturn]] void refuse(std::size_t position, const std::string& what, const std::string& cure) const {
    throw Error(Fault::bad_case, location_, fmt::format("formula '{}': {} (character {})", text_, what, position + 1),
                cure);
  }

 private:
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }
  static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
  char at(std::size_t i) const { return i < text_.size() ? text_[i] : '\0'; }

  bool starts_number(std::size_t i) const { return is_digit(at(i)) || (at(i) == '.' && is_digit(at(i + 1))); }

  /// Behind digits, point and exponent.
  std::size_t number_end(std::size_t i) const {
    while (is_digit(at(i)) || at(i) == '.') ++i;
    if (at(i) == 'e' || at(i) == 'E') {
      const std::size_t exponent = at(i + 1) == '+' || at(i + 1) == '-' ? i + 2 : i + 1;
      if (is_digit(at(exponent))) {
        i = exponent;
        while (is_digit(at(i))) ++i;
      }
    }
    return i;
  }

  /// Refuses unknown names; true for a function.
  bool known(const std::string& name, std::size_t position) const {
    if (parser_.GetFunDef().contains(name)) return true;
    if (parser_.GetVar().contains(name) || parser_.GetConst().contains(name)) return false;
    std::vector<std::string> values, functions;
    for (const auto& [variable, address] : parser_.GetVar()) values.push_back(variable);
    for (const auto& [constant, value] : parser_.GetConst()) {
      if (constant[0] != '_') values.push_back(constant);  // _pi and _e are muparser's own
    }
    for (const auto& [function, callback] : parser_.GetFunDef()) functions.push_back(function);
    std::vector<std::string> all = values;
    all.insert(all.end(), functions.begin(), functions.end());
    const std::string near = nearest(name, all);
    refuse(
        position, fmt::format("unknown symbol '{}'", name),
        fmt::format("{}known are {} and the functions {}", near.empty() ? "" : fmt::format("did you mean '{}'? ", near),
                    fmt::join(values, ", "), fmt::join(functions, ", ")));
  }

  const std::string& text_;
  const mu::Parser& parser_;
  const SourceLocation& location_;
};

/// muparser's sentence to go on after ours.
std::string plain(std::string message) {
  if (!message.empty() && message.back() == '.') message.pop_back();
  if (!message.empty()) message[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(message[0])));
  return message;
}

}  // namespace

Formula::Scale Formula::scale(const std::string& unit, const std::string& si) {
  return {.factor = difference_to_si(1, unit, si), .shift = to_si(0, unit, si)};
}

Formula::Formula(std::string expression, const FormulaUnits& units, const std::map<std::string, double>& parameters,
                 const SourceLocation& location, const LengthsOfPlace& lengths)
    : expression_(std::move(expression)), location_(location) {
  try {
    value_ = scale(units.value, units.si);
    length_ = scale(units.length, "m");
    time_ = scale(units.time, "s");
    temperature_ = scale(units.temperature, "K");
  } catch (const std::invalid_argument& e) {
    throw Error(Fault::bad_case, location, fmt::format("formula '{}': {}", expression_, e.what()), "correct the unit");
  }

  define_functions(parser_);
  const std::map<std::string, double*> variables = {{"x", &x_}, {"y", &y_}, {"z", &z_},
                                                    {"r", &r_}, {"t", &t_}, {"T", &T_}};
  for (const auto& [name, address] : variables) parser_.DefineVar(name, address);
  for (const auto& [name, length] : lengths) {
    lengths_.push_back({name, length});
    parser_.DefineVar(name, &lengths_.back().value);
  }
  parser_.DefineConst("pi", std::numbers::pi);
  parser_.DefineConst("e", std::numbers::e);
  for (const auto& [name, value] : parameters) {
    if (parser_.GetVar().contains(name) || parser_.GetConst().contains(name) || parser_.GetFunDef().contains(name)) {
      throw Error(Fault::bad_case, location, fmt::format("the parameter '{}' hides a name that formulas know", name),
                  "give it another name");
    }
    try {
      parser_.DefineConst(name, value);
    } catch (const mu::ParserError&) {
      throw Error(Fault::bad_case, location, fmt::format("the parameter '{}' cannot be used in formulas", name),
                  "name it with letters, digits and '_' only");
    }
  }

  const Reader reader(expression_, parser_, location);
  reader.check();
  try {
    parser_.SetExpr(expression_);
    for (const auto& [name, address] : parser_.GetUsedVar()) used_.emplace(name, address);
    std::erase_if(lengths_, [&](const NamedLength& n) { return !used_.contains(n.name); });
    parser_.Eval();  // compiles
  } catch (const mu::ParserError& e) {
    throw Error(Fault::bad_case, location, fmt::format("formula '{}': {}", expression_, plain(e.GetMsg())),
                "check operators, arguments and parentheses");
  }
}

bool Formula::uses_place() const { return uses("x") || uses("y") || uses("z") || uses("r") || !lengths_.empty(); }

bool Formula::may_jump() const {
  if (!lengths_.empty()) return true;  // distances bend where two places are equally near
  if (expression_.find_first_of("<>=!?&|") != std::string::npos) return true;
  for (const char* function : {"abs", "sign", "rint", "min", "max", "floor", "ceil", "mod"})
    if (expression_.find(function) != std::string::npos) return true;
  return false;
}

double Formula::operator()(const Vec3& x, double t, double T) {
  x_ = x.x / length_.factor;
  y_ = x.y / length_.factor;
  z_ = x.z / length_.factor;
  r_ = std::sqrt(x_ * x_ + y_ * y_);
  t_ = t / time_.factor;
  T_ = (T - temperature_.shift) / temperature_.factor;
  for (NamedLength& n : lengths_) {
    if (!n.length->at)
      throw Error(Fault::bad_case, location_,
                  fmt::format("formula '{}': '{}' is not known before the body is made", expression_, n.name),
                  "write it without");
    n.value = n.length->at(x) / length_.factor;
  }
  return value_.factor * parser_.Eval() + value_.shift;
}

}  // namespace calor
