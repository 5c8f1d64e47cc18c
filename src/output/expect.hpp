#pragma once
// [[expect]]: a case checks itself against values, formulas and reference files.
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/cloud.hpp"
#include "material/material_field.hpp"
#include "output/probes.hpp"
#include "output/weld.hpp"

namespace calor {

struct Verdict {
  std::string what;  ///< "line y = 2 m at 0.5 s, reference fig3.csv"
  std::string norm;  ///< "max", "rms" or "value"
  std::string unit;
  double error = 0, tolerance = 0;
  bool passed = false;
  double value = 0, reference = 0;  ///< for probes and report entries
};

class Expectations {
 public:
  /// Checks names, times and files of all [[expect]] now, not at the end. Collective.
  /// `weld`: null where the case has no [weld].
  Expectations(const Case& c, const Cloud& cloud, const MaterialField& material, const Probes& probes,
               const WeldResults* weld, const std::string& folder);
  ~Expectations();

  /// Times the run has to land on.
  std::vector<double> times() const;
  /// Compares what is due at state.t (all that is left where `last`); writes compared points to
  /// expect-<n>.csv in the folder. T: temperatures of the owned points. Collective.
  void observe(const State& state, bool last, std::span<const double> T);
  /// Verdicts in the order of the case; `report` serves expectations on numbers of the report.
  std::vector<Verdict> finish(const std::map<std::string, double>& report);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

void declare_expect(Schema& schema);

}  // namespace calor
