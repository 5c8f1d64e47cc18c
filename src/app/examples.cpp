#include "app/examples.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "app/say.hpp"
#include "app/verbs.hpp"
#include "base/fold.hpp"
#include "case/tree.hpp"

namespace calor {
namespace {

/// Beside the command as it is installed, or in the source tree of its build.
std::filesystem::path cases_folder() {
  namespace fs = std::filesystem;
  const fs::path command = fs::read_symlink("/proc/self/exe").parent_path();
  for (const fs::path& place : {command / "../share/calor/cases", command / "../../cases"})
    if (std::error_code none; fs::is_directory(place, none)) return fs::canonical(place);
  throw Error(Fault::command, "the cases that come with calor are not beside the command",
              "install calor as a whole (cmake --install), or run the command of a build in its source tree");
}

/// The comment at the head of a case as one line.
std::string head_of(const std::string& text) {
  std::istringstream lines(text);
  std::string head;
  for (std::string line; std::getline(lines, line) && line.size() > 2 && line[0] == '#';) head += line.substr(1);
  return head;
}

std::string sentence_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  std::string head = head_of(text.str());
  head.erase(0, head.find_first_not_of(' '));
  // A sentence ends before a capital: neither "Fig. 2" nor "x. y" does.
  for (auto stop = head.find(". "); stop != head.npos; stop = head.find(". ", stop + 1))
    if (const char next = head[stop + 2]; next >= 'A' && next <= 'Z') return head.substr(0, stop + 1);
  if (!head.empty()) return head;
  const Value root = read_toml(text.str(), file.string());
  const Value* title = root.find("title");
  return title ? title->text : "";
}

}  // namespace

std::vector<Example> examples() {
  std::vector<Example> all;
  const std::filesystem::path folder = cases_folder();
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".toml")
      all.push_back({std::filesystem::relative(entry.path(), folder).replace_extension().string(), entry.path(),
                     sentence_of(entry.path())});
  std::ranges::sort(all, {}, &Example::name);
  return all;
}

Example find_example(const std::string& name) {
  std::vector<Example> matches;
  std::vector<std::string> names;
  for (const Example& example : examples()) {
    if (example.name == name || example.name == "start/" + name) return example;
    names.push_back(example.name);
    if (example.file.stem() == name) matches.push_back(example);
  }
  if (matches.size() == 1) return matches.front();
  if (matches.empty()) {
    std::string near = nearest(name, names);
    if (near.empty()) near = nearest(name, starters());
    throw Error(Fault::command, fmt::format("there is no example '{}'", name),
                near.empty() ? "calor examples lists them" : fmt::format("did you mean '{}'?", near));
  }
  names.clear();
  for (const Example& example : matches) names.push_back(example.name);
  throw Error(Fault::command, fmt::format("there are several examples '{}'", name),
              fmt::format("take one of {}", fmt::join(names, ", ")));
}

const std::vector<std::string>& starters() {
  static const std::vector<std::string> names{"plate", "rod", "disc", "weld", "coating", "shock", "crack"};
  return names;
}

int list_examples(const std::string& word) {
  bool is_any = false;
  for (const Example& example : examples()) {
    if (!word.empty() && (example.name + " " + example.sentence).find(word) == std::string::npos) continue;
    is_any = true;
    for (const std::string& line : folded(example.sentence, fmt::format("{:<29} ", example.name), 30)) say(line + "\n");
  }
  if (!is_any)
    throw Error(Fault::command, fmt::format("no example speaks of '{}'", word), "calor examples lists all of them");
  say("\ncalor new NAME --from EXAMPLE copies one.\n");
  return 0;
}

}  // namespace calor
