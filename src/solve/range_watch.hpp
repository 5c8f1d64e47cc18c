#pragma once
// Temperatures that cannot be: below absolute zero, or, where nothing heats or cools from inside, outside the range of
// start, walls and surroundings (the maximum principle). They tell that a time step was too long.
#include <optional>
#include <span>
#include <vector>

#include "solve/heat_system.hpp"

namespace calor {

class Archive;

class RangeWatch {
 public:
  /// Takes in the body at the start of a run. Collective.
  void begin(HeatSystem& system, const State& state);
  /// Takes in walls and surroundings between two times. Collective.
  void see(HeatSystem& system, double t_old, double t_new);

  void exchange(Archive& archive);

  /// Of start, walls and surroundings so far, K.
  const ValueRange& range() const { return range_; }
  /// Largest distance of the temperatures of the points from where they can be, K; updates the ghosts of u. Collective.
  double excess(HeatSystem& system, std::span<double> u) const;
  /// Throws Error(numbers) that names the point farthest out where that is more than `allowed`, K; updates the ghosts
  /// of u. `t`: none in a steady state. Collective.
  void require(HeatSystem& system, std::optional<double> t, std::span<double> u, double allowed) const;

 private:
  /// Data that lie below absolute zero count temperatures from somewhere else.
  bool is_absolute() const { return range_.low >= 0; }
  double excess_of(const HeatSystem& system, double T) const;
  double excess_of(const HeatSystem& system, const ValueRange& body) const;

  ValueRange range_;
};

}  // namespace calor
