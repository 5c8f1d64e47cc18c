#pragma once
// Results that take long, in files from which the next run takes them that asks for the same. A file is found by a hash
// of everything that its result follows from, so it never grows old: whatever changes asks for another file.
#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

struct XXH3_state_s;  // xxHash's name

namespace calor {

/// A hash (XXH3, 128 bits) of everything that a result follows from. The program itself and the instruction set that it
/// runs with are part of it from the start, so that a result is the one that this program would come to, to the last
/// bit.
class Fingerprint {
 public:
  Fingerprint();

  /// Plain data, without bytes that mean nothing.
  template <class T>
  requires std::is_trivially_copyable_v<T> Fingerprint& add(std::span<const T> values) {
    const std::uint64_t bytes = values.size_bytes();
    add_bytes(&bytes, sizeof bytes);  // two arrays must not pass for others with the border elsewhere
    add_bytes(values.data(), bytes);
    return *this;
  }
  template <class T>
  Fingerprint& add(const std::vector<T>& values) {
    return add(std::span<const T>(values));
  }
  template <class T>
  requires std::is_arithmetic_v<T> Fingerprint& add(T value) { return add(std::span<const T>(&value, 1)); }

  struct Digest {
    std::uint64_t low, high;
    bool operator==(const Digest&) const = default;
  };
  Digest digest() const;

 private:
  void add_bytes(const void* bytes, std::size_t count);

  std::unique_ptr<XXH3_state_s, int (*)(XXH3_state_s*)> state_;
};

class Cache {
 public:
  /// A folder holds no more: the results that were asked for longest ago give way.
  static constexpr std::uintmax_t most_bytes = std::uintmax_t{10} << 30;

  explicit Cache(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// What CALOR_CACHE in the environment names, else the user's: $XDG_CACHE_HOME/calor or ~/.cache/calor.
  static std::filesystem::path users_folder();

  /// Whose the result is: every rank has a part of its own, or all have the same.
  enum class Owner { rank, all };
  using Arrays = std::initializer_list<std::vector<double>*>;

  /// Sets `arrays` to what an earlier call with the same `from`, of this run or another, has made of them; where there
  /// was none, `make` sets them. `from`: all that this rank's arrays follow from. All ranks read, or all make. A file
  /// that is damaged is made anew; where none can be written, a note says so. Collective; throws what `make` throws.
  void get(MPI_Comm comm, const std::string& what, Owner owner, const Fingerprint& from, const Arrays& arrays,
           const std::function<void()>& make);

  /// What was read and what could not be written, the same on all ranks.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  std::filesystem::path folder_;
  std::vector<std::string> notes_;
};

}  // namespace calor
