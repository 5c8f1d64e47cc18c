#include "base/error.hpp"

namespace calor {
namespace {

std::string message(const SourceLocation& location, const std::string& problem, const std::string& cure) {
  std::string text = location.text();
  if (!text.empty()) text += ": ";
  text += problem;
  if (!cure.empty()) text += ": " + cure;
  return text;
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

}  // namespace calor
