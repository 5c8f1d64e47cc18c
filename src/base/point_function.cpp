#include "base/point_function.hpp"

#include <algorithm>
#include <functional>

namespace calor {

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
