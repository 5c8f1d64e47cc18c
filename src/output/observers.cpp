#include <algorithm>
#include <iterator>

#include "output/field_writer.hpp"
#include "output/files.hpp"
#include "output/observer.hpp"

namespace calor {

Registry<ObserverKind>& observers() {
  // The weld looks before those that show its results.
  static Registry<ObserverKind> all{
      {.name = "progress", .sentence = "a line on the terminal", .make = make_progress},
      {.name = "weld",
       .sentence = "peaks, cooling times and extents of the melt",
       .make = make_weld_log,
       .files = {"weld.csv", "cooling.csv"}},
      {.name = "energy", .sentence = "the heat stored and exchanged", .make = make_energy_log, .files = {"energy.csv"}},
      {.name = "balance",
       .sentence = "heat flows, and temperatures of materials and faces",
       .make = make_balance_log,
       .files = {"balance.csv"}},
      {.name = "stress", .sentence = "thermal stress", .make = make_stress_log, .files = {"stress.csv", "section.csv"}},
      {.name = "probes", .sentence = "temperatures at the probes", .make = make_probe_log, .files = {"probes.csv"}},
      {.name = "extremes", .sentence = "the lowest and the highest temperature", .make = make_extremes},
      {.name = "fields", .sentence = "fields for ParaView", .make = make_fields},
      {.name = "steady", .sentence = "ends a run that changes no more", .make = make_steady_stop},
      {.name = "final", .sentence = "all temperatures at the end", .make = make_final_state, .files = {"final.csv"}},
      {.name = "range",
       .sentence = "warns outside the temperatures that a material of the library or a table is known for",
       .make = make_known_range}};
  return all;
}

Observers make_observers(const RunSetup& run) {
  Observers all;
  for (const ObserverKind& kind : observers())
    if (auto observer = kind.make(run)) all.push_back(std::move(observer));
  all.push_back(make_expectations(run));
  return all;
}

void remove_earlier_results(MPI_Comm comm, const std::string& folder) {
  std::vector<std::string> files = {"expect-*.csv", "derivatives.csv"};  // of observers that are no entries
  for (const ObserverKind& kind : observers()) std::ranges::copy(kind.files, std::back_inserter(files));
  for (const FieldFormat& format : field_formats()) std::ranges::copy(format.files, std::back_inserter(files));
  remove_files(comm, folder, files);
}

void declare_output(Schema& schema) {
  schema.add(
      {.path = "output",
       .sentence = "What is written, and when.",
       .keys = {
           {"times", Kind::quantities, "s", optional, "Fields are written at these times and at the end."},
           {"every", Kind::quantity, "s", optional, "Fields are written at all multiples of this time."},
           {"fields", Kind::flag, "", "true", "Whether fields for ParaView are written at all."},
           {"format", Kind::choice, "", "vtu", "Of the fields." + field_formats().sentences(), field_formats().names()},
           {"samples", Kind::integer, "", "200",
            "About how many rows probes.csv, energy.csv and balance.csv get, evenly spaced, besides the times "
            "of the fields."},
           {"probes", Kind::text, "", optional,
            "\"every 1 s\": probes.csv has a row at the start and at all multiples of this time, and no others, so "
            "that rows of two runs can be subtracted. Steps land on these times."},
           {"checkpoint", Kind::quantity, "s", "10 min",
            "How often, by the clock, a run is stored so that `calor run CASE --restart` can go on from there; "
            "0 s: only when it is interrupted or its --time-limit is over."},
           {"checkpoint_steps", Kind::integer, "", optional, "The run is stored every so many steps as well."},
           {"derivatives", Kind::texts, "", optional,
            "Numbers of the case, such as \"material.steel.conductivity\" or, entry by entry, "
            "\"material.steel.conductivity.grid\": derivatives.csv has the derivatives of the temperatures of all "
            "probes by them: of a steady state by its tangent or its adjoint, whichever takes fewer solutions, of a "
            "run "
            "by tr-bdf2 by the tangents of its steps."},
           {"derivatives_of", Kind::texts, "", optional,
            "Numbers of report.json that derivatives.csv has besides: of the balance heat_flow.NAME, mean.NAME, "
            "minimum.NAME, maximum.NAME; of a weld largest_NAME and peak_NAME of its extents, peak.NAME of the "
            "probes; lowest_stress, highest_stress, largest_stress."},
           {"temperature", Kind::text, "", "K",
            "Unit of the temperatures that people read, on the terminal and in run.log: K, degC or degF; on the "
            "command line --units degC. Files of numbers keep to K."},
       }});
}

}  // namespace calor
