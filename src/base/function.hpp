#pragma once
// A number, formula, table or callback of place, time and temperature: what a case gives for every property, condition
// and source. Everything is SI here; units are converted when the case is read.
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/curve.hpp"
#include "base/error.hpp"
#include "base/profile.hpp"
#include "base/vec3.hpp"

namespace calor {

/// Where and when a function is asked for. `T` may be empty if the function does not depend on temperature.
struct Arguments {
  std::span<const Vec3> x;      ///< m
  double t = 0;                 ///< s
  std::span<const double> T{};  ///< K
};

/// Units in which a formula is written; values, lengths, times and temperatures are converted on the way in and out.
struct FormulaUnits {
  std::string value;  ///< unit of the result
  std::string si;     ///< SI unit the result is converted to
  std::string length = "m", time = "s", temperature = "K";
};

/// A length that depends on place and that formulas know by a name, such as the distance to a face. Cases are read
/// before there is a body: `at` is set when it is made, and whoever asks before gets an Error(bad_case).
struct LengthOfPlace {
  std::function<double(const Vec3& x)> at;  ///< m
};
using LengthsOfPlace = std::map<std::string, std::shared_ptr<LengthOfPlace>>;

/// The run that formulas of time are made for, known as late as the lengths above: before, `end` is 0.
struct Course {
  double end = 0;            ///< s
  std::vector<Vec3> places;  ///< some of the body, the same on all ranks
  double T = 300;            ///< a temperature of it, K
};

/// When something changes in time, ascending, s. Steps land on the events, at which it jumps or has a kink, begins to
/// change after it has stood still or comes to rest. From mark to mark it changes by a fiftieth of its range: steps
/// pass over a few of them at most, so that they do not miss what it does.
struct Changes {
  std::vector<double> events, marks;

  void add(const Changes& others) {
    events.insert(events.end(), others.events.begin(), others.events.end());
    marks.insert(marks.end(), others.marks.begin(), others.marks.end());
  }
};

/// Cheap to copy. Copies of a formula share its parser: not for several threads at once.
class Function {
 public:
  Function();  ///< zero
  static Function constant(double value, const SourceLocation& location = {});
  /// muparser expression in x, y, z, r, t, T, pi, e, named parameters and lengths. r = sqrt(x^2 + y^2); log is ln.
  /// Throws Error(bad_case, location, ...) for syntax errors and unknown symbols. `events`: see changes(), which finds
  /// them by itself if there are none and the course of the run is known.
  static Function formula(const std::string& expression, const FormulaUnits& units,
                          const std::map<std::string, double>& parameters = {}, const SourceLocation& location = {},
                          std::vector<double> events = {}, const LengthsOfPlace& lengths = {},
                          std::shared_ptr<const Course> course = {});
  static Function of_temperature(Curve curve, const SourceLocation& location = {});
  static Function of_time(Curve curve, const SourceLocation& location = {});
  /// Constant in layers stacked along axis 0..2 from coordinate `start` upwards. At an interface (within 1e-9 of the
  /// thinnest layer) the mean of the two layers; a point outside all layers is an Error(bad_case) when evaluated.
  static Function layers(int axis, double start, const std::vector<double>& thickness, std::vector<double> values,
                         const SourceLocation& location = {});
  /// Of one coordinate: 'x', 'y', 'z' or 'r' = sqrt(x^2 + y^2).
  static Function of_coordinate(char axis, Profile profile, const SourceLocation& location = {});
  struct Dependence {
    bool place = false, time = false, temperature = false;
  };
  /// A function of a program that links the library.
  struct Callback {
    std::function<void(const Arguments&, std::span<double>)> evaluate;  ///< out[i] of the arguments, SI units
    Dependence on;
  };
  static Function callback(Callback callback, const SourceLocation& location = {});

  bool depends_on_place() const;
  bool depends_on_time() const;
  bool depends_on_temperature() const;
  bool is_constant() const { return !depends_on_place() && !depends_on_time() && !depends_on_temperature(); }
  bool is_layered() const;  ///< piecewise constant in place
  /// May the function jump or bend from place to place? False for formulas without comparisons, abs, min, floor, ...
  bool may_jump() const;

  /// The same function, with times at which it jumps or has a kink as the case tells them.
  Function with_breaks(std::vector<double> times) const;

  /// out[i] = f(x[i], t, T[i]); out.size() == args.x.size(). A value that is not finite throws
  /// Error(bad_case|numbers) naming location in the case, point, time and temperature.
  void evaluate(const Arguments& args, std::span<double> out) const;
  /// d/dT: exact for curves, central difference of fourth order for formulas and callbacks; 0 where there is no
  /// dependence.
  void derivative(const Arguments& args, std::span<double> out) const;
  double operator()(const Vec3& x = {}, double t = 0, double T = 0) const;

  /// The temperatures over which a table of them reaches, see Curve::reach; all where the function is no such table.
  ValueRange reach() const;
  /// f(T) as a curve over [lo, hi]; only for functions of temperature alone (or constants).
  Curve curve(double lo, double hi) const;
  /// When a function of time changes. What a formula does is found from its values at 10,000 times of the run, unless
  /// it comes with events of its own.
  Changes changes() const;
  const SourceLocation& location() const;

  struct Kind;

 private:
  explicit Function(std::shared_ptr<const Kind> kind);
  Changes found_changes(const Course& course) const;
  std::shared_ptr<const Kind> kind_;
  std::vector<double> events_;
  std::shared_ptr<const Course> course_;
};

/// A function at fixed points: what depends on place alone is evaluated once and kept.
class PointFunction {
 public:
  /// The points must outlive this.
  PointFunction(Function f, std::span<const Vec3> x);

  /// Like Function::evaluate; quick where args.x is part of the points given at the start.
  void evaluate(const Arguments& args, std::span<double> out) const;
  /// d/dT.
  void derivative(const Arguments& args, std::span<double> out) const { function_.derivative(args, out); }
  const Function& function() const { return function_; }

 private:
  Function function_;
  std::span<const Vec3> x_;
  std::vector<double> kept_;
};

/// One value for every point, or a single one for all.
class PointValues {
 public:
  PointValues() = default;
  /// f at the points; f must depend on neither time nor temperature.
  PointValues(const Function& f, std::span<const Vec3> x);
  explicit PointValues(std::vector<double> values) : values_(std::move(values)), step_(values_.size() != 1) {}

  double operator[](std::size_t i) const { return values_[i * step_]; }
  std::span<const double> all() const { return values_; }
  bool is_uniform() const { return step_ == 0; }

 private:
  std::vector<double> values_ = {0};
  std::size_t step_ = 0;
};

}  // namespace calor
