#include "base/terminal.hpp"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace calor {

bool stderr_is_terminal() {
  const char* told = std::getenv("CALOR_TERMINAL");
  return told ? std::string_view(told) == "1" : isatty(STDERR_FILENO);
}

bool stdout_takes_colour() {
  if (const char* told = std::getenv("CALOR_COLOUR")) return std::string_view(told) == "1";
  const char *refused = std::getenv("NO_COLOR"), *kind = std::getenv("TERM");
  return isatty(STDOUT_FILENO) && !(refused && *refused) && kind && std::string_view(kind) != "dumb";
}

}  // namespace calor
