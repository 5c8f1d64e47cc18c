#include "output/final.hpp"

#include <fmt/format.h>

#include "output/files.hpp"

namespace calor {

void write_final(const Cloud& cloud, std::span<const double> T, const std::string& folder) {
  if (folder.empty()) return;
  make_folder(cloud.comm, folder);
  write_in_turns(cloud.comm, folder + "/final.csv", "id,x [m],y [m],z [m],T [K]", [&](std::FILE* file) {
    for (int i = 0; i < cloud.owned; ++i) {
      const Vec3& x = cloud.x[i];
      fmt::print(file, "{},{},{},{},{}\n", cloud.id[i], x.x, x.y, x.z, T[i]);
    }
  });
}

}  // namespace calor
