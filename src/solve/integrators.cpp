#include "solve/stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

namespace calor {

IntegratorKind euler_integrator(), rkl2_integrator(), backward_euler_integrator(), crank_nicolson_integrator(),
    tr_bdf2_integrator();

Registry<IntegratorKind>& integrators() {
  static Registry<IntegratorKind> all = {euler_integrator(), rkl2_integrator(), backward_euler_integrator(),
                                         crank_nicolson_integrator(), tr_bdf2_integrator()};
  return all;
}

namespace {

struct Choice {
  std::string name, why;
};

/// Lines factorise cheaply; elsewhere super-time-stepping needs no matrix and wins until the problem is very stiff.
Choice automatic(const Table& time, HeatSystem& system, State& start) {
  if (system.has_massless_points()) return {"euler", "the points on the walls hold no heat"};
  // With parameters an explicit stage takes a solution too: it pays where Newton's method would take many.
  const bool explicit_pays =
      system.dofs().are_temperatures() || (system.capacity_is_lumped() && system.material().capacity_depends_on_T());
  if (system.cloud().dimension == 1) return {"tr-bdf2", "implicit steps are cheap on a line"};
  if (!explicit_pays) return {"tr-bdf2", "an explicit step would take a linear system, too"};
  constexpr double many = 1e5;
  const double euler_steps = time.number("end") * system.explicit_rate_bound(start.t, start.T) / 2;
  return {euler_steps > many ? "tr-bdf2" : "rkl2",
          fmt::format("explicit Euler would take {:.3g} steps", std::ceil(euler_steps))};
}

/// Euler's stability at the start; the integrator goes on to watch it as the state changes.
/// Returns a note where the step is stable, but temperatures may overshoot.
std::vector<std::string> check_step(const Table& time, HeatSystem& system, State& start, double step) {
  const double bound = system.explicit_rate_bound(start.t, start.T);
  if (step * bound <= 2 * (1 + 1e-9)) return {};
  const double limit = system.euler_limit(start.t, start.T);
  if (step > limit * (1 + 1e-9))
    time.refuse("step",
                fmt::format("a step of {:.6g} s is unstable: the limit of explicit Euler is {:.6g} s", step, limit),
                fmt::format("take at most {:.3g} s, leave the step out, or choose another integrator", 2 / bound));
  return {fmt::format(
      "{}: the step of {:.6g} s is above the Gershgorin bound of {:.6g} s (but below the true limit of {:.6g} s): "
      "stable, but temperatures may overshoot",
      time.location("step").text(), step, 2 / bound, limit)};
}

/// Refuses what would take steps without end: by a source that is too fast, or by the limit of explicit steps.
void refuse_endless(const Table& time, HeatSystem& system, State& start, const IntegratorKind& kind, double longest) {
  constexpr double most = 1e9, most_of_super_steps = 1e12;  // Euler's steps; rkl2 makes hundreds of them one
  const double end = time.number("end");
  if (end / longest > most)
    time.refuse("end",
                fmt::format("a moving source that is resolved takes {:.3g} steps of {:.3g} s", end / longest, longest),
                "check its speed and size, or end earlier");
  if (!kind.is_explicit || time.has("step")) return;
  const double steps = end * system.explicit_rate_bound(start.t, start.T) / 2;
  if (steps > (kind.name == "euler" ? most : most_of_super_steps))
    time.refuse("integrator", fmt::format("to its end the run takes {:.3g} stable steps of explicit Euler", steps),
                "take integrator = \"tr-bdf2\", and look for properties or heat transfer of an absurd size");
}

}  // namespace

std::unique_ptr<Integrator> make_integrator(const Case& c, HeatSystem& system, State& start) {
  const Table time = c.section("time");
  if (!(time.number("end") > 0))
    time.refuse("end", fmt::format("an end of {} s is not after the start", time.number("end")),
                "give a positive time");
  if (!system.material().has_capacity())
    c.root().refuse("time", "a transient case needs density and specific_heat of every material",
                    "add them, or take [steady] instead of [time]");
  const bool is_automatic = !time.has("integrator") || time.text("integrator") == "automatic";
  const Choice choice =
      is_automatic ? automatic(time, system, start) : Choice{time.text("integrator"), "the case asks for it"};
  const IntegratorKind& kind = *integrators().find(choice.name);
  if (system.has_massless_points() && kind.name == "rkl2")
    time.refuse("integrator",
                fmt::format("{} does not know the algebraic wall points of correction = \"paper\"", kind.name),
                "take integrator = \"euler\" or an implicit one, or correction = \"consistent\"");

  if (kind.is_explicit && !system.capacity_is_lumped())
    time.refuse("integrator",
                fmt::format("{} needs points that hold their own heat; those of this method share it", kind.name),
                "take integrator = \"tr-bdf2\" or \"crank-nicolson\", mlpg.capacity = \"one-point\", or mlpg.flux = "
                "\"edge-stabilised\"");

  StepOptions options;
  for (const char* key : {"step", "tolerance"}) {
    if (!time.has(key)) continue;
    if (!(time.number(key) > 0))
      time.refuse(key, fmt::format("a {} of {} is not positive", key, time.number(key)), "give a positive one");
    (key == std::string("step") ? options.step : options.tolerance) = time.number(key);
  }
  const double longest = system.longest_step(0, time.number("end"));
  refuse_endless(time, system, start, kind, longest);
  std::vector<std::string> notes;
  if (options.step && *options.step > longest * (1 + 1e-9))
    notes.push_back(
        fmt::format("{}: a step of {:.3g} s does not resolve the moving source: 0.3 of its sigma take {:.3g} s",
                    time.location("step").text(), *options.step, longest));
  if (!options.step && !kind.is_adaptive && longest < time.number("end")) options.step = longest;
  if (!options.step && !kind.is_adaptive)
    time.refuse("integrator", fmt::format("{} takes fixed steps, and no step is given", kind.name),
                "add step = \"0.1 s\", or take integrator = \"tr-bdf2\", which chooses its own");
  options.safety = time.number("safety");
  if (!(options.safety > 0 && options.safety <= 1))
    time.refuse("safety", fmt::format("a safety of {} does not lie between 0 and 1", options.safety), "take 0.9");
  if (kind.name == "euler" && options.step)
    std::ranges::copy(check_step(time, system, start, *options.step), std::back_inserter(notes));
  std::unique_ptr<Integrator> integrator = kind.make(options);
  integrator->notes = std::move(notes);
  integrator->why = choice.why;
  return integrator;
}

void declare_time(Schema& schema) {
  std::vector<std::string> names = integrators().names();
  names.insert(names.begin(), "automatic");
  schema.add(
      {.path = "time",
       .sentence = "A transient run from t = 0. Steps land on output times and on jumps and kinks of tables in time.",
       .keys = {{"end", Kind::quantity, "s", required, "End of the run."},
                {"integrator", Kind::choice, "", "automatic",
                 "automatic: euler for correction = \"paper\"; tr-bdf2 for lines, very stiff problems and parameters "
                 "of MLPG "
                 "with a constant heat capacity; otherwise rkl2." +
                     integrators().sentences(),
                 names},
                {"step", Kind::quantity, "s", optional,
                 "Fixed step. Without it euler takes the stable step; rkl2 and tr-bdf2 control their error; and no "
                 "integrator steps over more than 0.3 sigma of a moving source."},
                {"tolerance", Kind::difference, "K", optional,
                 "Error allowed to one step of rkl2 and tr-bdf2 where no step is given; default: 1e-4 of the span of "
                 "temperatures."},
                {"safety", Kind::number, "", "0.9", "Part of the stable step that euler takes."},
                {"steady_below", Kind::quantity, "K/s", optional,
                 "The run ends when no temperature changes faster than this."}}});
  schema.add({.path = "steady",
              .sentence = "The steady state instead of a transient run, by Newton's method; functions of time are "
                          "taken as they are at t = 0.",
              .keys = {{"tolerance", Kind::number, "", "1e-11",
                        "Largest imbalance of a point, relative to the largest heat flow through one."},
                       {"iterations", Kind::integer, "", "50", "Most iterations of Newton's method."}}});
}

}  // namespace calor
