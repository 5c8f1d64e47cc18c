#include "base/file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "base/error.hpp"

namespace calor {

void refuse_file(const std::string& path, int error) {
  throw Error(Fault::file, SourceLocation{.file = path}, std::strerror(error), "look for room and rights");
}

File::File(const std::string& path, int flags) : path_(path), descriptor_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) refuse();
}

File::~File() {
  if (descriptor_ >= 0) close(descriptor_);
}

void File::write(const void* bytes, std::size_t count, std::int64_t offset) const {
  for (const char* from = static_cast<const char*>(bytes); count > 0;) {
    const ssize_t done = pwrite(descriptor_, from, count, offset);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) refuse();
    from += done, offset += done, count -= done;
  }
}

std::size_t File::read(void* bytes, std::size_t count, std::int64_t offset) const {
  std::size_t all = 0;
  for (char* to = static_cast<char*>(bytes); count > 0;) {
    const ssize_t done = pread(descriptor_, to, count, offset);
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) refuse();
    if (done == 0) break;
    to += done, offset += done, count -= done, all += done;
  }
  return all;
}

std::int64_t File::size() const { return lseek(descriptor_, 0, SEEK_END); }

void File::sync() const {
  if (fsync(descriptor_) != 0) refuse();
}

void File::finish() {
  sync();
  if (close(std::exchange(descriptor_, -1)) != 0) refuse();
}

void File::refuse() const { refuse_file(path_, errno); }

}  // namespace calor
