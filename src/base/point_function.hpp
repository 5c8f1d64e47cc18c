#pragma once
// A function at fixed points: what depends on place alone is evaluated once and kept.
#include <span>
#include <vector>

#include "base/function.hpp"

namespace calor {

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
