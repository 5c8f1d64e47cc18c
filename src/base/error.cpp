#include "base/error.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace calor {
namespace {

std::string message(const SourceLocation& location, const std::string& problem, const std::string& cure) {
  std::string text = location.text();
  if (!text.empty()) text += ": ";
  text += problem;
  if (!cure.empty()) text += ": " + cure;
  return text;
}

/// Edit distance in which swapping two neighbouring letters counts once (optimal string alignment).
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before, last(b.size() + 1), now(b.size() + 1);
  std::iota(last.begin(), last.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) now[j] = std::min(now[j], before[j - 2] + 1);
    }
    before = std::exchange(last, now);
  }
  return last[b.size()];
}

}  // namespace

std::string SourceLocation::text() const {
  std::string text = file;
  if (line == 0) return text;
  if (!text.empty()) text += ':';
  text += std::to_string(line);
  if (column != 0) text += ':' + std::to_string(column);
  return text;
}

Error::Error(Fault fault, SourceLocation location, std::string what, std::string cure)
    : std::runtime_error(message(location, what, cure)),
      fault_(fault),
      location_(std::move(location)),
      problem_(std::move(what)),
      cure_(std::move(cure)) {}

Error::Error(Fault fault, std::string what, std::string cure)
    : Error(fault, SourceLocation{}, std::move(what), std::move(cure)) {}

std::string nearest(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;  // a third of the letters may be wrong
  for (const std::string& candidate : known) {
    const std::size_t d = distance(word, candidate);
    if (d < least) least = d, best = candidate;
  }
  return best;
}

}  // namespace calor
