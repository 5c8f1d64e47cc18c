#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "app/starter.hpp"
#include "app/verbs.hpp"

namespace calor {

int new_case(const std::string& name) {
  const std::filesystem::path path = name.ends_with(".toml") ? name : name + ".toml";
  if (std::filesystem::exists(path))
    throw Error(Fault::file, {path.string()}, "exists already", "choose another name, or remove the file first");
  std::ofstream out(path);
  out << starter_case;
  out.close();
  if (!out) throw Error(Fault::file, {path.string()}, "cannot be written", "choose a folder that you may write to");
  fmt::print("{0} written; try: calor run {0}\n", path.string());
  return 0;
}

}  // namespace calor
