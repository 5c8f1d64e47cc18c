#pragma once
// [[expect]]: a case checks itself against values, formulas and reference files.
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/schema.hpp"
#include "output/observer.hpp"
#include "output/quantities.hpp"

namespace calor {

class Expectations : public Observer {
 public:
  /// Checks names, times and files of all [[expect]] now, not at the end. Collective.
  Expectations(const Case& c, const Results& results, const std::string& folder);
  ~Expectations() override;

  std::vector<double> times() const override;
  void at_stop(const Moment& m) override;
  void exchange(Archive& archive) override;
  void finish(const Moment& m, RunResult& result) override;

  /// Compares what is due at state.t (all that is left where `last`); writes compared points to
  /// expect-<n>.csv in the folder. T: temperatures of the owned points. Collective.
  void observe(const State& state, bool last, std::span<const double> T);
  /// Verdicts in the order of the case; `numbers` of the report and their `units` serve expectations on these.
  std::vector<Verdict> verdicts(const std::map<std::string, double>& numbers,
                                const std::map<std::string, std::string>& units) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Refuses what a case asks of the report, to compare, to fit or to optimise, that is none of its `numbers`, and bounds
/// in other units: that is told before the run. Throws Error(bad_case).
void require_numbers(const Case& c, const std::vector<ReportNumber>& numbers);

void declare_expect(Schema& schema);

}  // namespace calor
