#pragma once
// Heat sources inside the body. A new kind is a new file and its name in sources.cpp.
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/function.hpp"
#include "case/registry.hpp"
#include "cloud/cell_samples.hpp"
#include "cloud/cloud.hpp"

namespace calor {

class Source {
 public:
  explicit Source(std::string name) : name(std::move(name)) {}
  virtual ~Source() = default;
  /// Heat goes in as integrals over these samples of all owned points: for methods whose subdomains are not the cells
  /// of the points. They must outlive the source; to be called before anything else, on all ranks.
  virtual void integrate_over(const CellSamples& subdomains) = 0;
  /// What needs all ranks, at time t: called before add_power. Collective.
  virtual void prepare(double /*t*/) {}
  /// P[i] += power into owned point i at time t, W. `T`: owned points. Returns the sum of what it added.
  virtual double add_power(double t, std::span<const double> T, std::span<double> P) const = 0;
  /// dP_i/dT_i, W/K, added; sources without dependence add nothing.
  virtual void add_derivative(double t, std::span<const double> T, std::span<double> dP_dT) const = 0;
  virtual bool depends_on_temperature() const = 0;
  virtual Changes changes() const = 0;
  /// Power that the case asks for at time t, W, and its integral from 0, J; nothing where what goes in is by itself
  /// what was asked for.
  virtual std::optional<double> asked(double /*t*/) const { return {}; }
  virtual std::optional<double> energy_asked(double /*t*/) const { return {}; }
  /// Longest time step that resolves the motion of the source between two times, s.
  virtual double longest_step(double /*begin*/, double /*end*/) const {
    return std::numeric_limits<double>::infinity();
  }

  const std::string name;          ///< its account in energy.csv
  std::vector<std::string> notes;  ///< what a user should know about it
};

struct SourceKind {
  std::string name;  ///< its key in [source.*], which has exactly one of them
  std::string sentence;
  void (*declare)(Schema& schema);
  /// `table`: [source.NAME]. The cloud must outlive the source. Collective; throws Error on all ranks, or, before
  /// anything collective, on some.
  std::unique_ptr<Source> (*make)(const std::string& name, const Table& table, const Cloud& cloud);
};
Registry<SourceKind>& source_kinds();

/// Sources of [source.*] on the cloud. Collective; throws Error.
std::vector<std::unique_ptr<Source>> make_sources(const Case& c, const Cloud& cloud);

void declare_sources(Schema& schema);

}  // namespace calor
