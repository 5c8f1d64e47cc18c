#include "output/observer.hpp"

namespace calor {

Registry<ObserverKind>& observers() {
  // The weld looks before those that show its results.
  static Registry<ObserverKind> all{
      {.name = "progress", .sentence = "a line on the terminal", .make = make_progress},
      {.name = "weld", .sentence = "peaks, cooling times and extents of the melt", .make = make_weld_log},
      {.name = "energy", .sentence = "the heat stored and exchanged", .make = make_energy_log},
      {.name = "balance", .sentence = "heat flows, and temperatures of materials and faces", .make = make_balance_log},
      {.name = "stress", .sentence = "thermal stress", .make = make_stress_log},
      {.name = "probes", .sentence = "temperatures at the probes", .make = make_probe_log},
      {.name = "extremes", .sentence = "the lowest and the highest temperature", .make = make_extremes},
      {.name = "fields", .sentence = "fields for ParaView", .make = make_fields},
      {.name = "steady", .sentence = "ends a run that changes no more", .make = make_steady_stop},
      {.name = "final", .sentence = "all temperatures at the end", .make = make_final_state},
      {.name = "range",
       .sentence = "warns outside the range of a material of the library",
       .make = make_library_range}};
  return all;
}

Observers make_observers(const RunSetup& run) {
  Observers all;
  for (const ObserverKind& kind : observers())
    if (auto observer = kind.make(run)) all.push_back(std::move(observer));
  all.push_back(make_expectations(run));
  return all;
}

}  // namespace calor
