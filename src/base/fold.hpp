#pragma once
// Text for a terminal.
#include <string>
#include <string_view>
#include <vector>

namespace calor {

/// The words of `text` in lines: the first begins with `head`, further ones with as many blanks as `indent`. No line is
/// longer than `width` unless one word is.
std::vector<std::string> folded(std::string_view text, std::string head, std::size_t indent, std::size_t width = 80);

}  // namespace calor
