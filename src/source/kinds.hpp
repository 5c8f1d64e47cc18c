#pragma once
// The kinds of source. A new kind is a new file and a line in sources.cpp.
#include <memory>
#include <string>

#include "source/source.hpp"

namespace calor {

struct SourceKind {
  std::string key;  ///< in [source.*]; the section has exactly one of these
  void (*declare)(Schema& schema);
  /// The cloud must outlive the source. Throws Error on some ranks only.
  std::unique_ptr<Source> (*make)(const std::string& name, const Table& table, const Cloud& cloud);
};

extern const SourceKind body_source;

}  // namespace calor
