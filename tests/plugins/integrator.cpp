// An integrator: Heun's explicit method of second order, with fixed steps.
#include "run_case.hpp"
#include "solve/stepper.hpp"

namespace calor {
namespace {

class Heun final : public Stepper {
 public:
  using Stepper::Stepper;
  std::string name() const override { return "heun"; }

 private:
  void enter(HeatSystem&, State&, const SmoothInterval&, bool /*fresh*/) override {}
  void exchange_own(Archive&, HeatSystem&) override {}  // nothing is carried from step to step

  double step(HeatSystem& system, State& state, const SmoothInterval& interval) override {
    const auto [dt, t_new] = equal_step(interval);
    const double t = state.t;
    const std::vector<double> E = state.E, heat = state.cumulative_heat;
    std::vector<double> F(E.size()), power(heat.size());
    // Two steps of Euler's method; their end and the start are averaged.
    for (const double time : {t, t_new}) {
      system.rate(interval.data_time(time), state.T, F, power);
      ++counts.rate_evaluations;
      for (std::size_t i = 0; i < F.size(); ++i) state.E[i] += dt * F[i];
      for (std::size_t a = 0; a < power.size(); ++a) state.cumulative_heat[a] += dt * power[a];
      if (time == t) system.temperature(state.E, state.T);
      if (time == t) system.impose(interval.data_time(t_new), state.T, state.E, state.cumulative_heat);
    }
    for (std::size_t i = 0; i < E.size(); ++i) state.E[i] = 0.5 * (E[i] + state.E[i]);
    for (std::size_t a = 0; a < power.size(); ++a)
      state.cumulative_heat[a] = 0.5 * (heat[a] + state.cumulative_heat[a]);
    state.t = t_new;
    system.temperature(state.E, state.T);
    system.impose(interval.data_time(t_new), state.T, state.E, state.cumulative_heat);
    return dt;
  }
};

std::unique_ptr<Integrator> make_heun(const StepOptions& options) { return std::make_unique<Heun>(options); }

TEST(Plugin, IsAnIntegrator) {
  integrators().add(
      {.name = "heun", .sentence = "explicit, of second order, fixed steps", .make = make_heun, .is_explicit = true});
  // dT/dt = (300 K - T) / s everywhere: ten steps of 0.1 s of Heun's method multiply the difference by
  // (1 - 0.1 + 0.1^2/2)^10 = 0.36854098.
  expect_passes(bar + R"toml(
[material.m]
conductivity = "1e-9 W/(m K)"
density = "1 kg/m^3"
specific_heat = "1 J/(kg K)"
[initial]
temperature = "400 K"
[source.sink]
power_density = { formula = "300 - T", unit = "W/m^3" }
[time]
end = "1 s"
step = "0.1 s"
integrator = "heun"
[[expect]]
field = true
value = "336.854098 K"
within = "1e-5 K"
)toml");
}

}  // namespace
}  // namespace calor
