#pragma once
// Result folders for tests, and readers of what is in them, written without calor's own.
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <cctype>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/parallel.hpp"

namespace calor {

inline void write_file(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// A folder that lasts as long as the object; the same one on all ranks of `comm`. Collective.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(MPI_Comm comm = MPI_COMM_SELF) : comm_(comm) {
    static int count = 0;
    long name[2] = {getpid(), count++};
    MPI_Bcast(name, 2, MPI_LONG, 0, comm);
    path_ = std::filesystem::temp_directory_path() /
            ("calor-test-" + std::to_string(name[0]) + "-" + std::to_string(name[1]));
    if (rank_of(comm) == 0) std::filesystem::create_directories(path_);
    MPI_Barrier(comm);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    MPI_Barrier(comm_);
    if (rank_of(comm_) == 0) std::filesystem::remove_all(path_);
  }
  std::string path() const { return path_.string(); }
  std::string operator/(const std::string& file) const { return (path_ / file).string(); }
  /// Puts a file into it, which all ranks then see, and returns its path. Collective.
  std::string write(const std::string& file, const std::string& text) const {
    if (rank_of(comm_) == 0) write_file(*this / file, text);
    MPI_Barrier(comm_);
    return *this / file;
  }

 private:
  MPI_Comm comm_;
  std::filesystem::path path_;
};

inline std::string read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

struct CsvTable {
  std::vector<std::string> header;
  std::vector<std::vector<double>> rows;
};

inline CsvTable read_csv(const std::string& path) {
  CsvTable table;
  std::istringstream in(read_file(path));
  std::string line, cell;
  for (bool first = true; std::getline(in, line); first = false) {
    std::istringstream cells(line);
    if (!first) table.rows.emplace_back();
    while (std::getline(cells, cell, ',')) {
      if (first)
        table.header.push_back(cell);
      else
        table.rows.back().push_back(std::stod(cell));
    }
  }
  return table;
}

/// JSON as RFC 8259 has it; throws std::runtime_error for what is none.
struct Json {
  enum class Type { null, flag, number, text, list, object } type = Type::null;
  bool flag = false;
  double number = 0;
  std::string text;
  std::vector<Json> list;
  std::map<std::string, Json> members;

  const Json& operator[](const std::string& key) const {
    const auto found = members.find(key);
    if (found == members.end()) throw std::runtime_error("no member '" + key + "'");
    return found->second;
  }
  bool has(const std::string& key) const { return members.contains(key); }

  static Json parse(const std::string& text) {
    std::size_t at = 0;
    Json value = read(text, at);
    skip(text, at);
    if (at != text.size()) fail(at);
    return value;
  }

 private:
  [[noreturn]] static void fail(std::size_t at) { throw std::runtime_error("no JSON at byte " + std::to_string(at)); }
  static void skip(const std::string& s, std::size_t& at) {
    while (at < s.size() && std::strchr(" \t\r\n", s[at])) ++at;
  }
  static bool take(const std::string& s, std::size_t& at, const std::string& word) {
    skip(s, at);
    if (s.compare(at, word.size(), word) != 0) return false;
    at += word.size();
    return true;
  }
  static std::string read_text(const std::string& s, std::size_t& at) {
    if (!take(s, at, "\"")) fail(at);
    std::string out;
    for (; at < s.size() && s[at] != '"'; ++at) {
      if (static_cast<unsigned char>(s[at]) < 0x20) fail(at);
      if (s[at] != '\\') {
        out += s[at];
        continue;
      }
      ++at;
      const char* const from = "\"\\/bfnrt";
      const char* const to = "\"\\/\b\f\n\r\t";
      if (at < s.size() && s[at] == 'u') {
        out += static_cast<char>(std::stoi(s.substr(at + 1, 4), nullptr, 16));
        at += 4;
      } else if (const char* found = at < s.size() ? std::strchr(from, s[at]) : nullptr) {
        out += to[found - from];
      } else {
        fail(at);
      }
    }
    if (!take(s, at, "\"")) fail(at);
    return out;
  }
  static Json read(const std::string& s, std::size_t& at) {
    Json v;
    skip(s, at);
    if (at >= s.size()) fail(at);
    if (s[at] == '"') {
      v.type = Type::text;
      v.text = read_text(s, at);
    } else if (take(s, at, "{")) {
      v.type = Type::object;
      if (take(s, at, "}")) return v;
      do {
        skip(s, at);
        const std::string key = read_text(s, at);
        if (!take(s, at, ":") || v.members.contains(key)) fail(at);
        v.members[key] = read(s, at);
      } while (take(s, at, ","));
      if (!take(s, at, "}")) fail(at);
    } else if (take(s, at, "[")) {
      v.type = Type::list;
      if (take(s, at, "]")) return v;
      do v.list.push_back(read(s, at));
      while (take(s, at, ","));
      if (!take(s, at, "]")) fail(at);
    } else if (take(s, at, "true") || take(s, at, "false")) {
      v.type = Type::flag;
      v.flag = s[at - 2] == 'u';
    } else if (!take(s, at, "null")) {
      v.type = Type::number;
      std::size_t length = 0;
      while (at + length < s.size() &&
             (std::isdigit(static_cast<unsigned char>(s[at + length])) || std::strchr("+-.eE", s[at + length])))
        ++length;
      if (length == 0) fail(at);
      std::size_t used = 0;
      v.number = std::stod(s.substr(at, length), &used);
      if (used != length) fail(at);
      at += length;
    }
    return v;
  }
};

/// An element of an XML file and what is in it.
struct Xml {
  std::string name;
  std::map<std::string, std::string> attributes;
  std::string text;
  std::vector<Xml> children;

  /// The first element of that name at or below this one; throws where there is none.
  const Xml& find(const std::string& wanted, const std::string& name_attribute = "") const {
    if (const Xml* found = search(wanted, name_attribute)) return *found;
    throw std::runtime_error("no <" + wanted + " " + name_attribute + ">");
  }
  std::vector<const Xml*> all(const std::string& wanted) const {
    std::vector<const Xml*> found;
    if (name == wanted) found.push_back(this);
    for (const Xml& child : children)
      for (const Xml* x : child.all(wanted)) found.push_back(x);
    return found;
  }

  /// Throws where elements are not closed in turn.
  static Xml parse(const std::string& s) {
    std::size_t at = 0;
    if (s.starts_with("<?xml")) at = s.find("?>") + 2;
    Xml root = read(s, at);
    if (s.find_first_not_of(" \n", at) != s.npos) throw std::runtime_error("text after the root element");
    return root;
  }

 private:
  const Xml* search(const std::string& wanted, const std::string& name_attribute) const {
    const auto it = attributes.find("Name");
    if (name == wanted && (name_attribute.empty() || (it != attributes.end() && it->second == name_attribute)))
      return this;
    for (const Xml& child : children)
      if (const Xml* found = child.search(wanted, name_attribute)) return found;
    return nullptr;
  }
  static std::string unescaped(std::string s) {
    for (const auto& [code, plain] :
         {std::pair<std::string, std::string>{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&amp;", "&"}})
      for (auto at = s.find(code); at != s.npos; at = s.find(code, at + 1)) s.replace(at, code.size(), plain);
    return s;
  }
  static Xml read(const std::string& s, std::size_t& at) {
    Xml x;
    at = s.find_first_not_of(" \n", at);
    if (at == s.npos || s[at] != '<') throw std::runtime_error("no element");
    const auto end = s.find('>', at);
    if (end == s.npos) throw std::runtime_error("an element without end");
    std::string head = s.substr(at + 1, end - at - 1);
    at = end + 1;
    const bool is_empty = head.ends_with("/");
    if (is_empty) head.pop_back();
    auto from = head.find(' ');
    x.name = head.substr(0, from);
    while (from != head.npos && (from = head.find_first_not_of(" ", from)) != head.npos) {
      const auto equals = head.find("=\"", from), close = head.find('"', equals + 2);
      if (equals == head.npos || close == head.npos) throw std::runtime_error("an attribute of <" + x.name + ">");
      x.attributes[head.substr(from, equals - from)] = unescaped(head.substr(equals + 2, close - equals - 2));
      from = close + 1;
    }
    if (is_empty) return x;
    while (true) {
      const auto next = s.find('<', at);
      if (next == s.npos) throw std::runtime_error("<" + x.name + "> is not closed");
      x.text += s.substr(at, next - at);
      at = next;
      if (s[at + 1] != '/') {
        x.children.push_back(read(s, at));
        continue;
      }
      const std::string closing = "</" + x.name + ">";
      if (s.compare(at, closing.size(), closing) != 0) throw std::runtime_error("<" + x.name + "> is not closed");
      at += closing.size();
      return x;
    }
  }
};

/// A VTU or VTP file with compressed data in base64, read as VTK's documentation of the format describes it.
class Vtu {
 public:
  explicit Vtu(const std::string& path) : xml_(Xml::parse(read_file(path))) {
    EXPECT_EQ(xml_.name, "VTKFile");
    EXPECT_EQ(xml_.attributes.at("type"), path.ends_with(".vtp") ? "PolyData" : "UnstructuredGrid");
    EXPECT_EQ(xml_.attributes.at("header_type"), "UInt64");
    EXPECT_EQ(xml_.attributes.at("compressor"), "vtkZLibDataCompressor");
  }
  const Xml& xml() const { return xml_; }
  std::size_t points() const { return std::stoul(xml_.find("Piece").attributes.at("NumberOfPoints")); }
  /// Points of an unstructured grid, cells of a surface.
  std::size_t members() const {
    const auto& of_piece = xml_.find("Piece").attributes;
    for (const char* cells : {"NumberOfVerts", "NumberOfLines", "NumberOfPolys"})
      if (of_piece.contains(cells)) return std::stoul(of_piece.at(cells));
    return points();
  }

  /// The numbers of an array; checks type, size and that they lie inside the file. In a VTP file those of cells.
  template <class Number>
  std::vector<Number> values(const std::string& name, int components) const {
    const Xml& array = xml_.find("DataArray", name);
    const std::string type = std::is_same_v<Number, double>         ? "Float64"
                             : std::is_same_v<Number, std::int64_t> ? "Int64"
                                                                    : "UInt8";
    EXPECT_EQ(array.attributes.at("type"), type) << name;
    EXPECT_EQ(array.attributes.at("format"), "binary") << name;
    const auto given = array.attributes.find("NumberOfComponents");
    EXPECT_EQ(given == array.attributes.end() ? "1" : given->second, std::to_string(components)) << name;

    const std::string text = array.text.substr(1, array.text.size() - 2);  // between ends of lines
    // The header is padded by itself; its first number tells how long it is.
    const auto number = [](const std::string& bytes, std::size_t n) {
      std::uint64_t value = 0;
      std::memcpy(&value, bytes.data() + n * sizeof value, sizeof value);
      return value;
    };
    const std::uint64_t blocks = number(from_base64(text.substr(0, 12)), 0);
    const std::size_t letters = ((3 + blocks) * sizeof blocks + 2) / 3 * 4;
    const std::string header = from_base64(text.substr(0, letters)), data = from_base64(text.substr(letters));
    std::string bytes;
    std::size_t at = 0;
    for (std::uint64_t n = 0; n < blocks; ++n) {
      uLongf size = n + 1 == blocks && number(header, 2) > 0 ? number(header, 2) : number(header, 1);
      const uLongf expected = size;
      std::string block(size, 0);
      const std::uint64_t packed = number(header, 3 + n);
      if (at + packed > data.size()) throw std::runtime_error("data beyond the end of the array");
      const int code = uncompress(reinterpret_cast<unsigned char*>(block.data()), &size,
                                  reinterpret_cast<const unsigned char*>(data.data() + at), packed);
      EXPECT_EQ(code, Z_OK) << name;
      EXPECT_EQ(size, expected) << name;
      bytes += block, at += packed;
    }
    EXPECT_EQ(at, data.size()) << name;
    if (name != "Points" || xml_.attributes.at("type") == "UnstructuredGrid") {
      EXPECT_EQ(bytes.size(), members() * components * sizeof(Number)) << name;
    }
    std::vector<Number> numbers(bytes.size() / sizeof(Number));
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
  }

 private:
  static std::string from_base64(const std::string& text) {
    std::string bytes;
    std::uint32_t value = 0;
    int bits = 0;
    for (const char c : text) {
      const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
      if (c == '=') break;
      if (digits.find(c) == digits.npos) throw std::runtime_error("no letter of base64");
      value = value << 6 | static_cast<std::uint32_t>(digits.find(c)), bits += 6;
      if (bits >= 8) bits -= 8, bytes += static_cast<char>(value >> bits & 255);
    }
    return bytes;
  }

  Xml xml_;
};

}  // namespace calor
