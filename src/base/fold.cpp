#include "base/fold.hpp"

#include <sstream>
#include <utility>

namespace calor {

std::vector<std::string> folded(std::string_view text, std::string head, std::size_t indent, std::size_t width) {
  std::vector<std::string> lines{std::move(head)};
  std::istringstream words{std::string(text)};
  bool is_first = true;
  for (std::string word; words >> word; is_first = false) {
    if (!is_first && lines.back().size() + 1 + word.size() > width) {
      lines.emplace_back(indent, ' ');
      is_first = true;
    }
    lines.back() += (is_first ? "" : " ") + word;
  }
  return lines;
}

}  // namespace calor
