#pragma once
// derivatives.csv against differences of whole runs.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "results.hpp"

namespace calor {

/// derivatives.csv: the readings' values at the end by number.
inline std::map<std::string, std::vector<double>> derivatives(const std::string& folder) {
  std::istringstream file(read_file(folder + "/derivatives.csv"));
  std::map<std::string, std::vector<double>> rows;
  std::string line, cell;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::string name;
    std::getline(cells, cell, ','), std::getline(cells, name, ',');
    rows[name].clear();
    while (std::getline(cells, cell, ',')) rows[name].push_back(std::stod(cell));
  }
  return rows;
}

/// Compares with fourth-order differences of `readings_at(values)` about `at`, steps `step` of the values.
inline void expect_derivatives(const std::map<std::string, std::vector<double>>& found,
                               const std::vector<std::string>& names, const std::vector<double>& at, double step,
                               double tolerance,
                               const std::function<std::vector<double>(const std::vector<double>&)>& readings_at) {
  for (std::size_t n = 0; n < names.size(); ++n) {
    const double h = step * at[n];
    const auto moved = [&](double steps) {
      std::vector<double> p = at;
      p[n] += steps * h;
      return readings_at(p);
    };
    const auto a = moved(-2), b = moved(-1), c = moved(1), d = moved(2);
    for (std::size_t m = 0; m < a.size(); ++m) {
      const double by_runs = (a[m] - 8 * b[m] + 8 * c[m] - d[m]) / (12 * h);
      EXPECT_NEAR(found.at(names[n])[m], by_runs, tolerance * std::abs(by_runs)) << names[n];
    }
  }
}

}  // namespace calor
