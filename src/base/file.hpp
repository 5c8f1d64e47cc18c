#pragma once
// A file that is open for reading or writing; whatever goes wrong is an Error(file) that names it.
#include <cstddef>
#include <cstdint>
#include <string>

namespace calor {

/// Throws the Error(file) of a system call: `error` is its errno.
[[noreturn]] void refuse_file(const std::string& path, int error);

class File {
 public:
  /// `flags`: those of open(2).
  File(const std::string& path, int flags);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void write(const void* bytes, std::size_t count, std::int64_t offset) const;
  /// Returns how much there was.
  std::size_t read(void* bytes, std::size_t count, std::int64_t offset) const;
  std::int64_t size() const;  ///< bytes
  /// Waits until it is on the disk.
  void sync() const;
  /// The same, and closes it.
  void finish();

 private:
  [[noreturn]] void refuse() const;

  std::string path_;
  int descriptor_;
};

}  // namespace calor
