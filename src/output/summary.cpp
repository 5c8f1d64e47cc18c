// What a run says to people.
#include <fmt/color.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/fold.hpp"
#include "output/report.hpp"

namespace calor {
namespace {

/// Decimals that show one digit more than a difference that counts.
int decimals_for(double difference) {
  return difference > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(difference))), 1, 9) : 1;
}

/// A value of a verdict, with its unit; temperatures with so many decimals.
std::string quantity(double value, const Verdict& v, const TemperatureUnit& unit, int decimals) {
  if (v.value_unit == "K") return fmt::format("{:.{}f} {}", unit.value(value), decimals, unit.name());
  return fmt::format("{:.6g}{}{}", value, v.value_unit.empty() ? "" : " ", v.value_unit);
}

std::string place_text(const std::vector<double>& x) {
  return x.size() == 1 ? fmt::format("x = {:.4g} m", x[0]) : fmt::format("({:.4g}) m", fmt::join(x, ", "));
}

/// "28.8 kJ": with the prefix that leaves one to three digits before the point.
std::string with_prefix(double value, const char* unit) {
  constexpr const char* prefixes[] = {"p", "n", "u", "m", "", "k", "M", "G", "T"};
  constexpr int none = 4;
  if (value == 0) return fmt::format("0 {}", unit);
  const int power = std::clamp(static_cast<int>(std::floor(std::log10(std::abs(value)) / 3)), -none, none);
  return fmt::format("{:.4g} {}{}", value / std::pow(1000., power), prefixes[none + power], unit);
}

/// "label        text"; further lines are indented below the text.
void add_folded(std::vector<std::string>& lines, const std::string& label, const std::string& text) {
  constexpr std::size_t indent = 13;
  std::ranges::move(folded(text, fmt::format("{:<{}}", label, indent), indent), std::back_inserter(lines));
}

double number(const RunResult& result, const std::string& name) {
  const auto found = result.numbers.find(name);
  return found == result.numbers.end() ? 0 : found->second;
}

/// "out by air 12 kJ, in by heater 28.8 kJ": the numbers PREFIX.NAME of the report.
std::vector<std::string> exchanged(const RunResult& result, const std::string& prefix, const char* unit) {
  std::vector<std::string> parts;
  for (auto n = result.numbers.lower_bound(prefix); n != result.numbers.end() && n->first.starts_with(prefix); ++n)
    parts.push_back(fmt::format("{} by {} {}", n->second < 0 ? "out" : "in", n->first.substr(prefix.size()),
                                with_prefix(std::abs(n->second), unit)));
  return parts;
}

std::string bare_sentence(const Verdict& v, const TemperatureUnit& unit) {
  if (std::isnan(v.error)) return fmt::format("{}: there is no number to compare", v.what);
  if (v.norm == "at most" || v.norm == "at least")
    return fmt::format("{}: {:.6g}, allowed {} {:.6g}", v.what, v.value, v.norm, v.tolerance);

  const bool is_kelvin = v.unit == "K";
  const auto difference = [&](double d) { return fmt::format("{:.3g}", is_kelvin ? unit.difference(d) : d); };
  const std::string difference_unit = is_kelvin ? unit.difference_name() : v.unit;
  const std::string allowed = fmt::format("allowed {}{}{}{}", v.least > 0 ? difference(v.least) + " to " : "",
                                          difference(v.tolerance), difference_unit.empty() ? "" : " ", difference_unit);
  const std::string off =
      fmt::format("{}{}{}", difference(v.error), difference_unit.empty() ? "" : " ", difference_unit);
  const double counts = v.unit == "%" ? v.tolerance / 100 * std::abs(v.reference) : v.tolerance;
  const int decimals = decimals_for(unit.difference(counts));
  const auto shown = [&](double value) { return quantity(value, v, unit, decimals); };
  if (v.norm == "value")
    return fmt::format("{}: {}, expected {}, off by {}, {}", v.what, shown(v.value), shown(v.reference), off, allowed);
  const std::string over_points =
      fmt::format("{}: off by {}{}, {}", v.what, v.norm == "rms" ? "a root mean square of " : "", off, allowed);
  if (v.passed || v.worst_place.empty()) return over_points;
  return fmt::format("{}; most at {}: {}, expected {}", over_points, place_text(v.worst_place), shown(v.value),
                     shown(v.reference));
}

}  // namespace

std::string sentence(const Verdict& v, const TemperatureUnit& unit) {
  return bare_sentence(v, unit) + (v.source.empty() ? "" : fmt::format(" ({})", v.source));
}

std::string status(const Verdict& v, bool in_colour) {
  const char* word = v.passed ? "ok  " : "FAIL";
  if (!in_colour) return word;
  return fmt::format(
      v.passed ? fmt::fg(fmt::terminal_color::green) : fmt::emphasis::bold | fmt::fg(fmt::terminal_color::red), "{}",
      word);
}

std::string line(const Verdict& v, const TemperatureUnit& unit, bool in_colour) {
  return status(v, in_colour) + "  " + sentence(v, unit);
}

std::vector<std::string> summary(const RunResult& result, const TemperatureUnit& unit) {
  const bool is_steady = result.texts.at("integrator") == "steady";
  std::vector<std::string> lines;
  add_folded(lines, "points",
             fmt::format("{:.0f} in {:.0f}D, {}", number(result, "points"), number(result, "dimension"),
                         result.texts.at("method")));
  if (is_steady) {
    const double iterations = number(result, "newton_iterations");
    add_folded(lines, "solver",
               fmt::format("Newton's method: steady after {:.0f} iteration{}, residual {:.1e}", iterations,
                           iterations == 1 ? "" : "s", number(result, "residual")));
  } else {
    add_folded(lines, "integrator",
               fmt::format("{}: {}", result.texts.at("integrator"), result.texts.at("integrator_why")));
    const std::string shortest = fmt::format("{:.3g} s", number(result, "smallest_step")),
                      longest = fmt::format("{:.3g} s", number(result, "largest_step"));
    const double rejected = number(result, "rejected_steps");
    add_folded(lines, "steps",
               fmt::format("{:.0f} of {}{}", number(result, "steps"),
                           shortest == longest ? longest : shortest + " to " + longest,
                           rejected > 0 ? fmt::format(", and {:.0f} rejected", rejected) : ""));
  }
  const int decimals = decimals_for(unit.difference(result.highest.T - result.lowest.T) / 1000);
  const auto extreme = [&](const Extreme& e) {
    return fmt::format("{:.{}f} {} at {}{}", unit.value(e.T), decimals, unit.name(), place_text(e.x),
                       is_steady ? "" : fmt::format(", {:.6g} s", e.t));
  };
  add_folded(lines, "lowest", extreme(result.lowest));
  add_folded(lines, "highest", extreme(result.highest));
  if (is_steady) {
    add_folded(lines, "heat flow", fmt::format("{}", fmt::join(exchanged(result, "heat_flow.", "W"), ", ")));
  } else {
    std::vector<std::string> heat = exchanged(result, "heat.", "J");
    heat.push_back("stored " + with_prefix(number(result, "stored"), "J"));
    add_folded(lines, "heat",
               fmt::format("{}; imbalance {:.1e}", fmt::join(heat, ", "), number(result, "energy_imbalance")));
  }
  const double ranks = number(result, "ranks");
  add_folded(lines, "time",
             fmt::format("{:.3g} s{}", result.wall, ranks > 1 ? fmt::format(" on {:.0f} processes", ranks) : ""));
  if (result.is_cut_short())
    add_folded(lines, "interrupted",
               fmt::format("at {:.6g} s, by {}", number(result, "end"),
                           result.is_out_of_time ? "its time limit" : fmt::format("signal {}", result.interrupted_by)));
  return lines;
}

}  // namespace calor
