#include "boundary/surface_fluxes.hpp"

#include <fmt/format.h>

#include "base/ramped_function.hpp"

namespace calor {

namespace {

/// Prescribed heat flux: k dT/dn = q, n outward; q > 0 heats.
class PrescribedFlux final : public SurfaceFlux {
 public:
  explicit PrescribedFlux(RampedFunction q) : q_(std::move(q)) {}

  void evaluate(const Arguments& args, std::span<double> q, std::span<double> dq_dT) const override {
    q_.evaluate(args, q);
    if (!dq_dT.empty()) q_.derivative(args, dq_dT);
  }
  bool depends_on_temperature() const override { return q_.function().depends_on_temperature(); }
  bool depends_on_place() const override { return q_.function().depends_on_place(); }
  bool linear_in_temperature() const override { return !depends_on_temperature(); }
  Changes changes() const override { return q_.function().changes(); }
  std::vector<double> ambient(std::span<const Vec3>, double) const override { return {}; }

 private:
  RampedFunction q_;
};

SurfaceFluxKind prescribed_flux() {
  return {
      .name = "flux",
      .sentence = "a prescribed heat flux",
      .declare =
          [](Schema& schema) {
            schema.add({.path = "boundary.*",
                        .sentence = "Prescribed heat flux.",
                        .keys = {{"flux", Kind::function, "W/m^2", optional, "Heat flux into the body; > 0 heats."}}});
          },
      .make = [](const Table& boundary, std::span<const Vec3> x) -> std::unique_ptr<SurfaceFlux> {
        return std::make_unique<PrescribedFlux>(RampedFunction(boundary.function("flux"), x));
      }};
}

}  // namespace

SurfaceFluxKind convection(), radiation();

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

Function ambient_of(const Table& table) {
  const Function ambient = table.function("ambient");
  if (ambient.depends_on_temperature())
    table.refuse("ambient", "'ambient' depends on T, the temperature of the wall",
                 "use place and time only: x, y, z, r, t; what follows the wall belongs into h, or into a flux");
  if (ambient.is_constant() && ambient() < 0)
    table.refuse("ambient", fmt::format("'ambient' is {:.6g} K, below absolute zero", ambient()),
                 "check the number and its unit");
  return ambient;
}

Changes changes_of(const Function& a, const Function& b) {
  Changes all = a.changes();
  all.add(b.changes());
  return all;
}

std::vector<double> values_of(const PointFunction& f, std::span<const Vec3> x, double t) {
  std::vector<double> values(x.size());
  f.evaluate({.x = x, .t = t}, values);
  return values;
}

}  // namespace calor
