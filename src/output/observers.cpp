#include "output/observer.hpp"

namespace calor {

Observers make_observers(const RunSetup& run) {
  // In the order in which they look: the weld before those that show its results, the verdicts after all numbers.
  Observers all;
  for (const auto make :
       {make_progress, make_weld_log, make_energy_log, make_balance_log, make_probe_log, make_extremes, make_fields,
        make_steady_stop, make_final_state, make_library_range, make_expectations})
    if (auto observer = make(run)) all.push_back(std::move(observer));
  return all;
}

}  // namespace calor
