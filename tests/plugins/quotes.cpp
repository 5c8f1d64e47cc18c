// docs/extending.md quotes the plug-ins as they are.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

namespace calor {
namespace {

const std::string root = CALOR_SOURCE_DIR;

std::string read(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(root + "/" + file).rdbuf();
  return text.str();
}

TEST(Extending, QuotesThePluginsAsTheyAre) {
  std::istringstream manual(read("docs/extending.md"));
  std::string code, line;
  int blocks = 0;
  while (std::getline(manual, line)) {
    if (line.starts_with("`tests/plugins/")) code = read(line.substr(1, line.size() - 2));
    if (line != "```cpp") continue;
    std::string block;
    while (std::getline(manual, line) && line != "```") block += line + "\n";
    ++blocks;
    EXPECT_NE(code.find(block), code.npos) << "no plug-in has this code:\n" << block;
  }
  EXPECT_EQ(blocks, 20) << "two of each kind";
}

}  // namespace
}  // namespace calor
