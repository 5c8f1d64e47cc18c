#pragma once
// The kinds of source. A new kind is a new file and a line in sources.cpp.
#include <memory>
#include <string>

#include "source/source.hpp"

namespace calor {

struct SourceKind {
  std::string key;  ///< in [source.*]; the section has exactly one of these
  void (*declare)(Schema& schema);
  /// The cloud must outlive the source. Collective; throws Error on all ranks, or, before anything collective, on some.
  std::unique_ptr<Source> (*make)(const std::string& name, const Table& table, const Cloud& cloud);
};

extern const SourceKind body_source, line_source, column_source, surface_source, goldak_source;

}  // namespace calor
