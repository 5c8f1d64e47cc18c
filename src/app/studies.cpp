// What a case says of many runs of itself. calor run does without; the Python package reads it (python/calor/fit.py,
// study.py and optimise.py), and here it is known, so that the manual has it and misspelled keys are told.
#include "app/schema.hpp"

namespace calor {

void declare_studies(Schema& schema) {
  schema.add({.path = "fit",
              .sentence = "What `calor fit` finds out from measurements; a run takes no notice of it.",
              .keys = {{"iterations", Kind::integer, "", "20", "Most steps towards the best values."}}});
  schema.add(
      {.path = "fit.unknown[]",
       .sentence = "A number of the case that is not known.",
       .keys = {{"key", Kind::text, "", required,
                 "Where it stands, such as \"material.coating.conductivity\" or \"body.layer[0].contact\": [0] is the "
                 "first entry of "
                 "a list."},
                {"start", Kind::raw_quantities, "", required, "Where the search begins, with the unit of the key."},
                {"from", Kind::raw_quantities, "", optional, "It is at least this."},
                {"to", Kind::raw_quantities, "", optional, "It is at most this."},
                {"expected", Kind::raw_quantities, "", optional, "What is known about it without the measurements ..."},
                {"within", Kind::raw_quantities, "", optional, "... as a standard deviation."}}});
  schema.add(
      {.path = "fit.field[]",
       .sentence = "The values of a grid that are not known; of a steady case, from readings of probes.",
       .keys = {{"key", Kind::text, "", required, "Where it stands, such as \"material.plate.conductivity.grid\"."},
                {"expected", Kind::raw_quantities, "", required, "What they are expected to be on average ..."},
                {"within", Kind::raw_quantities, "", required, "... with this standard deviation."},
                {"length", Kind::quantity, "m", required,
                 "How far apart values differ: their correlation has fallen to a half at this distance."},
                {"from", Kind::raw_quantities, "", optional, "They are at least this."},
                {"to", Kind::raw_quantities, "", optional, "They are at most this."}}});
  schema.add(
      {.path = "fit.data[]",
       .sentence = "Measurements: a column of a CSV file, or one value.",
       .keys = {
           {"probe", Kind::text, "", optional, "The probe that measured it; or"},
           {"report", Kind::text, "", optional,
            "a number of report.json at the end of the run, such as \"heat_flow.air\", W, or \"largest_width\", m."},
           {"file", Kind::text, "", optional,
            "A CSV file, relative to the case, with a column time, such as \"time [s]\"; of a steady case, without "
            "'probe', with a column probe and one of temperatures."},
           {"column", Kind::text, "", optional,
            "Its column with the measurements, such as \"tc1 [degC]\"; without it the only other one."},
           {"value", Kind::raw_quantities, "", optional, "One value in place of a file."},
           {"at", Kind::quantity, "s", optional, "Its time; the end of the run if absent."},
           {"noise", Kind::raw_quantities, "", required, "Standard deviation of a measurement."}}});
  schema.add({.path = "optimise",
              .sentence = "What `calor optimise` searches for; a run takes no notice of it.",
              .keys = {{"minimise", Kind::text, "", optional,
                        "The number of report.json that is to be small, such as \"largest_stress\"; or"},
                       {"maximise", Kind::text, "", optional, "that is to be large."},
                       {"iterations", Kind::integer, "", "40", "Most runs."}}});
  schema.add({.path = "optimise.unknown[]",
              .sentence = "A number of the case that may be chosen.",
              .keys = {{"key", Kind::text, "", required, "Where it stands, as in [[fit.unknown]]."},
                       {"start", Kind::raw_quantities, "", required, "Where the search begins, with its unit."},
                       {"from", Kind::raw_quantities, "", required, "It is at least this."},
                       {"to", Kind::raw_quantities, "", required, "It is at most this."}}});
  schema.add({.path = "optimise.limit[]",
              .sentence = "A limit that a result has to keep.",
              .keys = {{"report", Kind::text, "", required,
                        "A number of report.json at the end of the run, such as \"maximum.steel\"."},
                       {"at_most", Kind::raw_quantities, "", optional, "It is at most this; or"},
                       {"at_least", Kind::raw_quantities, "", optional, "at least this."}}});
  schema.add({.path = "study",
              .sentence = "What `calor study` runs; a run takes no notice of it.",
              .keys = {{"values", Kind::table, "", optional,
                        "Keys in quotes and lists of their values: every combination is run."},
                       {"rows", Kind::flag, "", "false",
                        "The lists are columns of a table, of which every row is run, in place of every combination."},
                       {"range", Kind::table, "", optional,
                        "Keys in quotes and [low, high]: samples in between, so that each key is spread evenly."},
                       {"samples", Kind::integer, "", "20", "How many samples of the ranges."},
                       {"seed", Kind::integer, "", "1", "Chooses them."}}});
}

}  // namespace calor
