#pragma once
// What an [[expect]] asks for, as read from its table.
#include <mpi.h>

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/function.hpp"
#include "case/case.hpp"
#include "cloud/cloud.hpp"
#include "output/quantities.hpp"
#include "output/reference.hpp"
#include "output/report.hpp"

namespace calor {

struct Tolerance {
  double value;  // in the unit of the quantity, or percent
  bool is_relative;
};

struct Result {
  double error, value, reference;  // error in the unit of the tolerance; the others where they differ most
  std::vector<double> place = {};  // m, of points
};

/// One [[expect]] on temperatures or properties.
struct Comparison {
  Table table;
  const Quantity* quantity;
  Measure measure;
  int number;  // place in the case, from 1
  std::string name;
  bool is_steady;
  std::vector<double> times;        // s; one without meaning where steady
  std::vector<Tolerance> within;    // one, or one a time
  std::vector<Tolerance> at_least;  // none, or as many
  int probe = -1;
  std::vector<int> points{};  // owned, unless a probe
  std::optional<Function> value{};
  std::optional<PointReference> reference{};
  std::vector<double> probe_reference{};
  std::vector<std::optional<Result>> results{};  // one a time

  const Tolerance& tolerance(std::size_t k) const { return within[within.size() == 1 ? 0 : k]; }
  double least(std::size_t k) const { return at_least.empty() ? 0 : at_least[at_least.size() == 1 ? 0 : k].value; }
  bool passes(double error, std::size_t k) const { return error >= least(k) && error <= tolerance(k).value; }
};

/// One [[expect]] on a number of the report.
struct ReportBound {
  Table table;
  std::string key;  ///< at_most or at_least
  std::string number, name;
};

/// One verdict for every tolerance; where one holds for several times, the worst of them counts.
std::vector<Verdict> verdicts_of(const Comparison& comparison);
/// `numbers`: of the report, and the SI units of those that have one.
Verdict verdict_of(const ReportBound& bound, const std::map<std::string, double>& numbers,
                   const std::map<std::string, std::string>& units);

/// Exactly one of the keys is written; returns it.
std::string one_of(const Table& table, const std::vector<std::string>& keys, const std::string& purpose);
/// None of the keys goes with the subject.
void refuse_others(const Table& table, const std::string& subject, const std::vector<std::string>& keys);
/// Times of the comparison, s; a single one without meaning in a steady case.
std::vector<double> read_times(const Case& c, const Table& table);
/// `within` or `at_least`: one difference for all times, or one a time.
std::vector<Tolerance> read_differences(const Table& table, const std::string& key, const Quantity& quantity,
                                        std::size_t times);
/// A bound or a value of a number of the report, in its SI `unit`; without a unit it is written so.
double read_report_bound(const Table& table, const std::string& key, const std::string& unit);

/// The points at which values and references differ most: `by_value` relative to the reference, of equal ones that of
/// the lowest number. Its error is NaN. Collective.
Result worst_point(const Cloud& cloud, std::span<const int> point, std::span<const double> values,
                   std::span<const double> reference, bool by_value);

/// Largest or root-mean-square difference of distributed values, NaN where one is not finite. Collective.
double difference(MPI_Comm comm, std::span<const double> T, std::span<const double> reference, const std::string& norm,
                  const std::string& of, bool is_relative);

}  // namespace calor
