#pragma once
// Runs a case given as text and checks its [[expect]]; every plug-in is tried by a case that names it.
#include <gtest/gtest.h>

#include <string>

#include "app/run.hpp"
#include "app/schema.hpp"

namespace calor {

/// A bar of 1 m; sections follow.
inline const std::string bar = R"toml(title = "bar"
method = "sph"
[cloud]
shape = "box"
size = "1 m"
points = 11
)toml";

inline void expect_passes(const std::string& text) {
  const RunResult result =
      run(Case::parse(text, "plugin.toml", schema()), MPI_COMM_SELF, {.folder = "", .quiet = true});
  EXPECT_FALSE(result.verdicts.empty());
  for (const Verdict& v : result.verdicts) EXPECT_TRUE(v.passed) << v.what << ": " << v.error << " of " << v.tolerance;
}

}  // namespace calor
