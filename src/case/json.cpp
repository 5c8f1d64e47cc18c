#include "case/json.hpp"

#include <fmt/format.h>

#include <cmath>

namespace calor {

std::string json_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    switch (c) {
      case '"':
        out += "\\\"";
        break;
      case '\\':
        out += "\\\\";
        break;
      case '\n':
        out += "\\n";
        break;
      case '\t':
        out += "\\t";
        break;
      default:
        if (static_cast<unsigned char>(c) < 0x20)
          out += fmt::format("\\u{:04x}", static_cast<int>(c));
        else
          out += c;
    }
  }
  return out + '"';
}

std::string json_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

namespace {

class Members {
 public:
  explicit Members(const std::string& text) : text_(text) {}

  std::vector<std::pair<std::string, std::string>> all;

  void read(const std::string& path) {
    if (next() == '{') {
      each('}', [&](std::size_t) {
        const std::string key = string();
        skip(':');
        read(path.empty() ? key : path + "." + key);
      });
    } else if (text_.compare(at_, 2, "[{") == 0) {
      each(']', [&](std::size_t n) { read(fmt::format("{}[{}]", path, n)); });
    } else {
      const std::size_t begin = at_;
      pass();
      all.emplace_back(path, text_.substr(begin, at_ - begin));
    }
  }

 private:
  char next() {
    at_ = text_.find_first_not_of(" \n", at_);
    return text_[at_];
  }
  void skip(char c) {
    if (next() == c) ++at_;
  }
  template <class Read>
  void each(char end, const Read& read) {
    ++at_;
    for (std::size_t n = 1; next() != end; ++n) read(n), skip(',');
    ++at_;
  }
  std::string string() {
    const std::size_t begin = at_ + 1;
    pass();
    return text_.substr(begin, at_ - begin - 1);
  }
  /// Goes past one value.
  void pass() {
    int depth = 0;
    do {
      const char c = next();
      if (c == '"')
        for (++at_; text_[at_] != '"'; ++at_) at_ += text_[at_] == '\\';
      depth += (c == '[') - (c == ']');
      ++at_;
      if (c != '"' && c != '[' && c != ']' && c != ',') at_ = text_.find_first_of(",]}\n ", at_);
    } while (depth > 0);
  }

  const std::string& text_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<std::pair<std::string, std::string>> json_members(const std::string& object) {
  Members members(object);
  members.read("");
  return std::move(members.all);
}

}  // namespace calor
