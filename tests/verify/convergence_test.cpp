// Convergence orders of whole cases, by three resolutions of the shipped case files.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "app/run.hpp"
#include "app/schema.hpp"

namespace calor {
namespace {

/// Error of expectation `which` of a shipped case, with some keys changed.
double error_of(const std::string& file, const std::vector<std::string>& changes, std::size_t which) {
  const Case c = Case::read(CALOR_SOURCE_DIR "/cases/rong-kisu/" + file, schema(), changes);
  return run(c, MPI_COMM_SELF, {.folder = "", .quiet = true}).verdicts.at(which).error;
}

/// Order between the two finest of three runs whose spacing halves.
void expect_second_order(const std::string& file, const std::vector<std::vector<std::string>>& resolutions,
                         std::size_t which) {
  std::vector<double> errors;
  for (const auto& changes : resolutions) errors.push_back(error_of(file, changes, which));
  for (std::size_t n = 1; n < errors.size(); ++n)
    EXPECT_GE(std::log2(errors[n - 1] / errors[n]), 1.75) << file << ": " << errors[n - 1] << " -> " << errors[n];
}

TEST(ShippedCases, Fig4ConvergesWithSecondOrder) {
  expect_second_order("fig4.toml", {{"cloud.points=[21,21]"}, {"cloud.points=[41,41]"}, {"cloud.points=[81,81]"}}, 0);
}

TEST(ShippedCases, Fig7ConvergesWithSecondOrder) {
  // Four seconds after the start: the boundary layer is resolved on all three.
  expect_second_order("fig7-fig8.toml", {{"cloud.points=[21,21]"}, {"cloud.points=[41,41]"}, {"cloud.points=[81,81]"}},
                      2);
}

TEST(ShippedCases, TheDiscOfFig9ConvergesWithSecondOrder) {
  // Root mean square after 5 s: the largest error sits at the centre, where six points meet one.

  expect_second_order("fig9.toml", {{"cloud.rings=10"}, {"cloud.rings=20"}, {"cloud.rings=40"}}, 7);
}

}  // namespace
}  // namespace calor
