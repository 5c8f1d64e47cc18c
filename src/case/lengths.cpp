#include "case/lengths.hpp"

#include <fmt/format.h>

namespace calor {

double positive_length(const Table& table, const std::string& key) {
  const double length = table.number(key);
  if (!(length > 0))
    table.refuse(key, fmt::format("{} = {:g} m is not positive", key, length), "give a positive length");
  return length;
}

}  // namespace calor
