#include "app/say.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "base/error.hpp"

namespace calor {
namespace {

int output_error = 0;  // errno of the first failure

void note_failure() {
  if (output_error == 0) output_error = errno != 0 ? errno : EIO;
}

}  // namespace

void open_standard_files() {
  int descriptor = open("/dev/null", O_RDWR);
  while (descriptor >= 0 && descriptor <= STDERR_FILENO) descriptor = dup(descriptor);
  if (descriptor >= 0) close(descriptor);
}

void say(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) < text.size()) note_failure();
}

void complain(const std::string& line) {
  std::fwrite((line + "\n").data(), 1, line.size() + 1, stderr);
  std::fflush(stderr);
}

int finish_output(int code) {
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) note_failure();
  if (output_error == 0) return code;
  complain(fmt::format("calor: standard output cannot be written: {}", std::strerror(output_error)));
  if (!std::freopen("/dev/null", "w", stdout)) std::clearerr(stdout);  // PETSc would fail by it
  return code != 0 ? code : static_cast<int>(Fault::file);
}

}  // namespace calor
