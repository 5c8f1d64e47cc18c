#pragma once
// A plate whose conditions and sources are tested.
#include <numeric>
#include <string>

#include "boundary/conditions.hpp"
#include "case_models.hpp"
#include "cloud/points.hpp"

namespace calor {

/// A lattice of 5 x 3 points in 4 m x 2 m, 0.1 m thick. The first line of `rest` is line 14.
inline std::string plate(const std::string& rest) {
  return box_case({"4 m", "2 m"}, {5, 3}) + R"toml(thickness = "0.1 m"
[material.m]
library = "iron"
[initial]
temperature = "400 K"
[time]
end = "1 s"
)toml" + rest;
}

inline double total_area(const SurfaceTerm& term) { return std::accumulate(term.area.begin(), term.area.end(), 0.0); }

/// Conditions of a case on a cloud of its own.
struct Bound {
  Case description;
  Cloud cloud;
  Conditions conditions;
  explicit Bound(const std::string& text, MPI_Comm comm = MPI_COMM_SELF)
      : description(parse_case(text)),
        cloud(make_cloud(comm, description, 2)),
        conditions(make_conditions(description, cloud)) {}
};

}  // namespace calor
