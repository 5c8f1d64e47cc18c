#include "boundary/surface_fluxes.hpp"

#include <fmt/format.h>

namespace calor {

SurfaceFluxKind prescribed_flux(), convection(), radiation();

Registry<SurfaceFluxKind>& surface_fluxes() {
  static Registry<SurfaceFluxKind> all = {prescribed_flux(), convection(), radiation()};
  return all;
}

void check_range(std::span<const double> values, double low, double high, const Function& f, const Arguments& args,
                 const std::string& what, const std::string& unit, const std::string& cure) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] >= low && values[i] <= high) continue;
    std::string where;
    if (f.depends_on_place())
      where += fmt::format(" at ({:.6g}, {:.6g}, {:.6g}) m", args.x[i].x, args.x[i].y, args.x[i].z);
    if (f.depends_on_temperature()) where += fmt::format(", T = {:.6g} K", args.T[i]);
    if (f.depends_on_time()) where += fmt::format(", t = {:.6g} s", args.t);
    const Fault fault = f.depends_on_temperature() || f.depends_on_time() ? Fault::numbers : Fault::bad_case;
    throw Error(fault, f.location(),
                fmt::format("the {} is {:.6g}{}{}", what, values[i], unit.empty() ? "" : " " + unit, where), cure);
  }
}

std::vector<double> events_of(const PointFunction& a, const PointFunction& b) {
  auto all = a.function().events();
  const auto more = b.function().events();
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::vector<double> values_of(const PointFunction& f, std::span<const Vec3> x, double t) {
  std::vector<double> values(x.size());
  f.evaluate({.x = x, .t = t}, values);
  return values;
}

}  // namespace calor
