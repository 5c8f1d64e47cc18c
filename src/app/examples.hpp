#pragma once
// The cases that come with calor.
#include <filesystem>
#include <string>
#include <vector>

namespace calor {

struct Example {
  std::string name;  ///< "start/weld": the file below the folder of cases, without .toml
  std::filesystem::path file;
  std::string sentence;  ///< the first one of the comment that it begins with, or its title
};

/// All of them by name. Throws Error(command) where their folder is missing.
std::vector<Example> examples();

/// By name, "start/weld", or by its last part where that is one case's alone, "weld"; one of cases/start goes first.
/// Throws Error(command).
Example find_example(const std::string& name);

/// What new cases start from when they are not told otherwise: the names of cases/start that `calor new` offers.
const std::vector<std::string>& starters();

}  // namespace calor
