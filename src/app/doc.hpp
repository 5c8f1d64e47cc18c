#pragma once
// The manual of case files, made from the declarations of the keys.
#include <string>

#include "case/schema.hpp"

namespace calor {

/// All of it, in Markdown.
std::string manual(const Schema& schema);

/// What the manual says on a word, for a terminal of 80 columns: a section with what is below it ("cloud"), a key
/// ("cloud.radius"), whatever is called so anywhere ("radiation", "conductivity"), a chapter ("units"); or the keys
/// whose sentences speak of it. `in_colour`: names stand out. Throws Error(command) for a word that nothing knows, with
/// the nearest one.
std::string manual_on(const Schema& schema, const std::string& word, bool in_colour);

}  // namespace calor
