#pragma once
// Fields for ParaView: one appended-raw VTU per rank and time (with a PVTU over several ranks), and a PVD over the
// times.
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cloud/cloud.hpp"

namespace calor {

struct Field {
  std::string name;                ///< with unit, if it has one: "temperature [K]"
  int components = 1;              ///< 1 or 3
  std::span<const double> values;  ///< owned points, row-major
};

class FieldWriter {
 public:
  /// Writes below `folder`/fields and `folder`/fields.pvd. Throws Error(file). Collective.
  FieldWriter(const Cloud& cloud, std::string folder);
  /// Adds a time; ids and tags are written along. fields.pvd is complete after every call. Collective.
  void write(double t, const std::vector<Field>& fields);

 private:
  std::string collection() const;  // text of fields.pvd

  const Cloud& cloud_;
  std::string folder_;
  std::vector<std::pair<double, std::string>> written_;
};

}  // namespace calor
