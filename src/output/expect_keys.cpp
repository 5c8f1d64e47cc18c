// The keys of [[expect]].
#include <fmt/format.h>

#include "output/expect.hpp"

namespace calor {

void declare_expect(Schema& schema) {
  std::vector<Key> keys{
      {"name", Kind::text, "", optional, "What the verdict is called; made from the other keys where absent."},
      {"source", Kind::text, "", optional, "Where the expected number comes from."},
      {"probe", Kind::text, "", optional, "Compare at this probe."},
      {"field", Kind::flag, "", "false", "Compare at all points."},
      {"report", Kind::text, "", optional, "Compare this number of report.json, by at_most and at_least."},
      {"quantity", Kind::choice, "", "temperature",
       "What is compared. May be left out where a key of that name says of what: heat_flow = \"inside\".",
       quantities().names()},
      {"at", Kind::quantities, "s", optional, "Time or times of the comparison; the end where absent."},
      {"reference", Kind::text, "", optional,
       "CSV file with expected values, beside the case. With one column of coordinates (x, y, z or r) its rows "
       "are "
       "interpolated by cubics, with more they are matched to the points; a column t gives their times."},
      {"column", Kind::text, "", "T", "Column of the reference file that holds the values."},
      {"within", Kind::raw_quantities, "", optional,
       "Allowed difference in the unit of the quantity or %: one, or one a time. One for several times is judged at "
       "the worst of them."},
      {"norm",
       Kind::choice,
       "",
       "max",
       "Over the points compared: the largest difference or the root of its mean square.",
       {"max", "rms"}},
      {"of",
       Kind::choice,
       "",
       "value",
       "What a difference in % is relative to: the reference at the point, the largest reference, or the span of the "
       "references.",
       {"value", "maximum", "range"}},
      {"at_most", Kind::raw_quantities, "", optional, "Upper bound of a number of the report; without a unit in SI."},
      {"at_least", Kind::raw_quantities, "", optional,
       "Lower bound of a number of the report, or of the difference, for errors that are known: like 'within'."},
  };
  for (Key& key : where_keys("Compare at the points where this formula of x, y, z and r is true."))
    keys.push_back(std::move(key));
  schema.add({.path = "expect[]", .sentence = "What the result is compared with.", .keys = std::move(keys)});
  for (const Quantity& q : quantities()) {
    std::vector<Key> own{{"value", Kind::function, q.unit, optional, "Expected value, a function of place and time."}};
    own.insert(own.end(), q.keys.begin(), q.keys.end());
    schema.add({.path = "expect[]",
                .sentence = fmt::format("A comparison of {}.", q.plural),
                .keys = std::move(own),
                .when_key = "quantity",
                .when_value = q.name});
  }
  schema.add({.path = "expect[].filter",
              .sentence = "Rows of the reference file in which these columns have these values.",
              .keys = {{"*", Kind::number, "", optional, "Name of a column and its value, as written in the file."}}});
}

}  // namespace calor
