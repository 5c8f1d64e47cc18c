#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/examples.hpp"
#include "app/say.hpp"
#include "app/verbs.hpp"
#include "base/fold.hpp"
#include "case/tree.hpp"

namespace calor {
namespace {

std::string contents(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// Every text in a case that is the name of a file beside it.
void find_files(const Value& value, const std::filesystem::path& folder, std::vector<std::string>& names) {
  if (value.type == Value::Type::text && !std::ranges::count(names, value.text)) {
    std::error_code error;  // texts need not be fit for a name
    if (std::filesystem::is_regular_file(folder / value.text, error)) names.push_back(value.text);
  }
  for (const Value& element : value.list) find_files(element, folder, names);
  for (const Entry& entry : value.entries) find_files(entry.value, folder, names);
}

/// Writes a file that is not there yet, or has this text already.
void write_new(const std::filesystem::path& path, const std::string& text) {
  if (std::filesystem::exists(path)) {
    if (contents(path) == text) return;
    throw Error(Fault::file, {path.string()}, "exists already", "choose another name, or remove the file first");
  }
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw Error(Fault::file, {path.string()}, "cannot be written", "choose a folder that you may write to");
}

int offer_starters() {
  for (const std::string& name : starters())
    for (const std::string& line : folded(find_example(name).sentence, fmt::format("calor new {:<10}", name), 20))
      say(line + "\n");
  say("\nAny other NAME begins as a plate. calor new NAME --from EXAMPLE copies one of calor examples.\n");
  return 0;
}

}  // namespace

int new_case(const std::string& name, const std::string& from) {
  if (name.empty()) return offer_starters();
  const std::filesystem::path path = name.ends_with(".toml") ? name : name + ".toml";
  if (std::filesystem::exists(path))
    throw Error(Fault::file, {path.string()}, "exists already", "choose another name, or remove the file first");
  const bool is_starter = std::ranges::count(starters(), path.stem().string()) > 0;
  const Example example = find_example(!from.empty() ? from : is_starter ? path.stem().string() : "plate");

  std::string text = contents(example.file);
  const std::filesystem::path there = example.file.parent_path();
  std::vector<std::string> files;
  find_files(read_toml(text, example.file.string()), there, files);
  for (const std::string& file : files) {
    // What lies above the case comes to lie beside the new one.
    std::string here = file;
    while (here.starts_with("../")) here.erase(0, 3);
    for (auto at = text.find('"' + file + '"'); at != text.npos && here != file; at = text.find('"' + file + '"'))
      text.replace(at + 1, file.size(), here);
    write_new(path.parent_path() / here, contents(there / file));
  }
  write_new(path, text);
  say(fmt::format("{} written{}; try: calor run {}\n", path.string(),
                  files.empty()      ? ""
                  : files.size() > 1 ? fmt::format(" with {} files that it names", files.size())
                                     : ", and " + files.front(),
                  path.string()));
  return 0;
}

}  // namespace calor
