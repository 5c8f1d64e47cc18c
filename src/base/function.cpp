#include "base/function.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "base/formula.hpp"

namespace calor {

/// The ways to give a function; asked for whole arrays, so that the virtual call costs nothing.
struct Function::Kind {
  Kind(Dependence on, SourceLocation location) : on(on), location(std::move(location)) {}
  virtual ~Kind() = default;
  virtual void evaluate(const Arguments& args, std::span<double> out) const = 0;
  virtual void derivative(const Arguments& args, std::span<double> out) const;
  virtual const Curve* of_temperature() const { return nullptr; }
  virtual std::string name() const { return "a function"; }
  virtual bool layered() const { return false; }
  virtual bool may_jump() const { return on.place; }
  virtual Fault fault() const { return Fault::bad_case; }  ///< of a value that is not finite

  Dependence on;
  SourceLocation location;
};

void Function::Kind::derivative(const Arguments& args, std::span<double> out) const {
  // (8 (f(T+h) - f(T-h)) - (f(T+2h) - f(T-2h))) / 12 h; this h balances truncation h^4 against rounding 1/h.
  constexpr double relative_step = 0x1p-11;
  const auto step = [](double T) { return relative_step * std::max(std::abs(T), 1.0); };
  const std::size_t n = args.x.size();
  std::vector<double> T(n), f(n);
  std::fill(out.begin(), out.end(), 0.0);
  for (const auto& [steps, weight] : {std::pair{1., 8.}, {-1., -8.}, {2., -1.}, {-2., 1.}}) {
    for (std::size_t i = 0; i < n; ++i) T[i] = args.T[i] + steps * step(args.T[i]);
    evaluate({.x = args.x, .t = args.t, .T = T}, f);
    for (std::size_t i = 0; i < n; ++i) out[i] += weight * f[i] / (12 * step(args.T[i]));
  }

  // Beside the end of what the function is defined for, from one side.
  const auto at = [&](std::size_t i, double temperature) {
    double value = 0;
    evaluate({.x = args.x.subspan(i, 1), .t = args.t, .T = {&temperature, 1}}, {&value, 1});
    return value;
  };
  for (std::size_t i = 0; i < n; ++i) {
    for (const double sign : {1., -1.}) {
      if (std::isfinite(out[i])) break;
      const double h = sign * step(args.T[i]);
      out[i] = (-3 * at(i, args.T[i]) + 4 * at(i, args.T[i] + h) - at(i, args.T[i] + 2 * h)) / (2 * h);
    }
  }
}

namespace {

class Constant final : public Function::Kind {
 public:
  Constant(double value, const SourceLocation& location) : Kind({}, location), value_(value) {}
  void evaluate(const Arguments&, std::span<double> out) const override { std::fill(out.begin(), out.end(), value_); }

 private:
  double value_;
};

class OfPlaceTimeTemperature final : public Function::Kind {
 public:
  OfPlaceTimeTemperature(std::unique_ptr<Formula> formula, const SourceLocation& location)
      : Kind({.place = formula->uses_place(), .time = formula->uses("t"), .temperature = formula->uses("T")}, location),
        formula_(std::move(formula)) {}

  void evaluate(const Arguments& args, std::span<double> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = (*formula_)(args.x[i], args.t, on.temperature ? args.T[i] : 0);
    }
  }
  std::string name() const override { return "formula '" + formula_->expression() + "'"; }
  bool may_jump() const override { return on.place && formula_->may_jump(); }

 private:
  std::unique_ptr<Formula> formula_;
};

class OfTemperature final : public Function::Kind {
 public:
  OfTemperature(Curve curve, const SourceLocation& location)
      : Kind({.temperature = !curve.is_constant()}, location), curve_(std::move(curve)) {}
  void evaluate(const Arguments& args, std::span<double> out) const override {
    if (on.temperature) return curve_.values(args.T, out);
    std::fill(out.begin(), out.end(), curve_.value(0));
  }
  void derivative(const Arguments& args, std::span<double> out) const override { curve_.derivatives(args.T, out); }
  const Curve* of_temperature() const override { return &curve_; }
  std::string name() const override { return "a table"; }

 private:
  Curve curve_;
};

class OfTime final : public Function::Kind {
 public:
  OfTime(Curve curve, const SourceLocation& location)
      : Kind({.time = !curve.is_constant()}, location), curve_(std::move(curve)) {}
  void evaluate(const Arguments& args, std::span<double> out) const override {
    std::fill(out.begin(), out.end(), curve_.value(args.t));
  }
  std::string name() const override { return "a table"; }

 private:
  Curve curve_;
};

class Layers final : public Function::Kind {
 public:
  Layers(int axis, double start, const std::vector<double>& thickness, std::vector<double> values,
         const SourceLocation& location)
      : Kind({.place = true}, location), axis_(axis), values_(std::move(values)), faces_{start} {
    if (thickness.empty() || thickness.size() != values_.size()) {
      throw Error(Fault::bad_case, location,
                  fmt::format("{} layers have {} thicknesses", values_.size(), thickness.size()),
                  "give one thickness a layer");
    }
    for (const double d : thickness) {
      if (!(d > 0 && std::isfinite(d))) {
        throw Error(Fault::bad_case, location, fmt::format("a layer is {} m thick", d), "give a positive thickness");
      }
      faces_.push_back(faces_.back() + d);
    }
    tolerance_ = 1e-9 * *std::min_element(thickness.begin(), thickness.end());
  }

  void evaluate(const Arguments& args, std::span<double> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = at(args.x[i][axis_]);
  }
  std::string name() const override { return "layers"; }
  bool layered() const override { return true; }

 private:
  double at(double s) const {
    if (!(s >= faces_.front() - tolerance_ && s <= faces_.back() + tolerance_)) {
      const char axis = "xyz"[axis_];
      throw Error(Fault::bad_case, location,
                  fmt::format("the layers reach from {0} = {1:.6g} m to {2:.6g} m, but a point lies at {0} = {3:.6g} m",
                              axis, faces_.front(), faces_.back(), s),
                  "let the layers fill the body: check their number, thickness and start");
    }
    // Layers of the points a tolerance below and above: different ones at an interface.
    const auto layer = [this](double place) {
      const auto inner_begin = faces_.begin() + 1, inner_end = faces_.end() - 1;
      return values_[std::upper_bound(inner_begin, inner_end, place) - inner_begin];
    };
    return 0.5 * (layer(s - tolerance_) + layer(s + tolerance_));
  }

  int axis_;
  std::vector<double> values_, faces_;
  double tolerance_ = 0;
};

class OfCoordinate final : public Function::Kind {
 public:
  OfCoordinate(char axis, Profile profile, const SourceLocation& location)
      : Kind({.place = true}, location), axis_(axis), profile_(std::move(profile)) {}

  void evaluate(const Arguments& args, std::span<double> out) const override {
    std::vector<double> coordinate(out.size());
    for (std::size_t i = 0; i < out.size(); ++i)
      coordinate[i] = axis_ == 'r' ? std::hypot(args.x[i].x, args.x[i].y) : args.x[i][axis_ - 'x'];
    profile_(coordinate, out);
  }
  std::string name() const override { return std::string("the law along ") + axis_; }

 private:
  char axis_;
  Profile profile_;
};

class OfProgram final : public Function::Kind {
 public:
  OfProgram(Function::Callback callback, const SourceLocation& location)
      : Kind(callback.on, location), callback_(std::move(callback)) {}
  void evaluate(const Arguments& args, std::span<double> out) const override { callback_.evaluate(args, out); }
  std::string name() const override { return "the callback"; }
  Fault fault() const override { return Fault::numbers; }

 private:
  Function::Callback callback_;
};

/// Throws where a value is not finite.
void check_finite(const Function::Kind& kind, const Arguments& args, std::span<const double> out, const char* what) {
  const auto bad = std::find_if_not(out.begin(), out.end(), [](double value) { return std::isfinite(value); });
  if (bad == out.end()) return;
  const std::size_t i = bad - out.begin();
  std::string where;
  if (i < args.x.size())
    where = fmt::format("(x, y, z) = ({:.6g}, {:.6g}, {:.6g}) m, ", args.x[i].x, args.x[i].y, args.x[i].z);
  where += fmt::format("t = {:.6g} s", args.t);
  if (i < args.T.size()) where += fmt::format(", T = {:.6g} K", args.T[i]);
  // A temperature that is not finite comes from the run, not from the case.
  const bool argument_finite = i >= args.T.size() || std::isfinite(args.T[i]);
  throw Error(argument_finite ? kind.fault() : Fault::numbers, kind.location,
              fmt::format("{}{} is {} at {}", kind.name(), what, std::isnan(*bad) ? NAN : *bad, where),
              argument_finite ? "a division by zero or a value out of range: make it finite there"
                              : "the temperatures went wrong before: look for the first point where they did");
}

std::vector<double> sorted(std::vector<double> times) {
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

}  // namespace

Function::Function() : Function(constant(0)) {}

Function::Function(std::shared_ptr<const Kind> kind) : kind_(std::move(kind)) {}

Function Function::constant(double value, const SourceLocation& location) {
  return Function(std::make_shared<Constant>(value, location));
}

Function Function::formula(const std::string& expression, const FormulaUnits& units,
                           const std::map<std::string, double>& parameters, const SourceLocation& location,
                           std::vector<double> events, const LengthsOfPlace& lengths,
                           std::shared_ptr<const Course> course) {
  auto formula = std::make_unique<Formula>(expression, units, parameters, location, lengths);
  Function function(std::make_shared<OfPlaceTimeTemperature>(std::move(formula), location));
  function.events_ = sorted(std::move(events));
  if (function.depends_on_time()) function.course_ = std::move(course);
  return function;
}

Function Function::of_temperature(Curve curve, const SourceLocation& location) {
  return Function(std::make_shared<OfTemperature>(std::move(curve), location));
}

Function Function::of_time(Curve curve, const SourceLocation& location) {
  std::vector<double> events = curve.kinks();
  Function function(std::make_shared<OfTime>(std::move(curve), location));
  function.events_ = std::move(events);
  return function;
}

Function Function::layers(int axis, double start, const std::vector<double>& thickness, std::vector<double> values,
                          const SourceLocation& location) {
  return Function(std::make_shared<Layers>(axis, start, thickness, std::move(values), location));
}

Function Function::of_coordinate(char axis, Profile profile, const SourceLocation& location) {
  return Function(std::make_shared<OfCoordinate>(axis, std::move(profile), location));
}

Function Function::callback(Callback callback, const SourceLocation& location) {
  return Function(std::make_shared<OfProgram>(std::move(callback), location));
}

Function Function::with_breaks(std::vector<double> times) const {
  Function function = *this;
  times.insert(times.end(), events_.begin(), events_.end());
  function.events_ = sorted(std::move(times));
  return function;
}

Changes Function::changes() const {
  return events_.empty() && course_ && course_->end > 0 ? found_changes(*course_)
                                                        : Changes{.events = events_, .marks = {}};
}

bool Function::depends_on_place() const { return kind_->on.place; }
bool Function::depends_on_time() const { return kind_->on.time; }
bool Function::depends_on_temperature() const { return kind_->on.temperature; }
bool Function::may_jump() const { return kind_->may_jump(); }
bool Function::is_layered() const { return kind_->layered(); }
const SourceLocation& Function::location() const { return kind_->location; }

void Function::evaluate(const Arguments& args, std::span<double> out) const {
  if (out.size() != args.x.size() || (depends_on_temperature() && args.T.size() != out.size())) {
    throw std::logic_error("Function::evaluate: as many points, temperatures and results are needed");
  }
  if (out.empty()) return;
  if (depends_on_place() || depends_on_temperature()) {
    kind_->evaluate(args, out);
    check_finite(*kind_, args, out, "");
  } else {  // the same everywhere
    const Arguments first{.x = args.x.first(1), .t = args.t};
    kind_->evaluate(first, out.first(1));
    check_finite(*kind_, first, out.first(1), "");
    std::fill(out.begin() + 1, out.end(), out[0]);
  }
}

void Function::derivative(const Arguments& args, std::span<double> out) const {
  if (!depends_on_temperature()) {
    std::fill(out.begin(), out.end(), 0.0);
    return;
  }
  if (out.size() != args.x.size() || args.T.size() != out.size()) {
    throw std::logic_error("Function::derivative: as many points, temperatures and results are needed");
  }
  kind_->derivative(args, out);
  check_finite(*kind_, args, out, ": its derivative by T");
}

double Function::operator()(const Vec3& x, double t, double T) const {
  double value = 0;
  evaluate({.x = {&x, 1}, .t = t, .T = {&T, 1}}, {&value, 1});
  return value;
}

ValueRange Function::reach() const {
  const Curve* table = kind_->of_temperature();
  return table ? table->reach() : Curve().reach();
}

Curve Function::curve(double lo, double hi) const {
  if (is_constant()) return Curve::constant((*this)());
  if (depends_on_place() || depends_on_time()) {
    throw std::logic_error("Function::curve: only for functions of temperature alone");
  }
  if (const Curve* curve = kind_->of_temperature()) return *curve;
  return Curve::sampled([f = *this](double T) { return f({}, 0, T); }, lo, hi);
}

PointFunction::PointFunction(Function f, std::span<const Vec3> x) : function_(std::move(f)), x_(x) {
  if (!function_.depends_on_place() || function_.depends_on_time() || function_.depends_on_temperature()) return;
  kept_.resize(x.size());
  function_.evaluate({.x = x}, kept_);
}

void PointFunction::evaluate(const Arguments& args, std::span<double> out) const {
  const bool ours = std::less_equal<>{}(x_.data(), args.x.data()) &&
                    std::less_equal<>{}(args.x.data() + args.x.size(), x_.data() + x_.size());
  if (!kept_.empty() && ours) {
    std::copy_n(kept_.begin() + (args.x.data() - x_.data()), out.size(), out.begin());
  } else if (!function_.depends_on_place() && !function_.depends_on_temperature() && !out.empty()) {
    std::ranges::fill(out, function_({}, args.t));
  } else {
    function_.evaluate(args, out);
  }
}

PointValues::PointValues(const Function& f, std::span<const Vec3> x) {
  if (f.is_constant()) {
    values_ = {f()};
    return;
  }
  values_.resize(x.size());
  step_ = 1;
  f.evaluate({.x = x}, values_);
}

}  // namespace calor
