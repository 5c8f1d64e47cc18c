#include "base/cache.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/parallel.hpp"
#include "base/simd.hpp"

namespace calor {
namespace {

namespace fs = std::filesystem;
using Digest = Fingerprint::Digest;

/// A hash of the file that holds this code: the program, or the module of Python that the library is part of.
Digest digest_of_program() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&digest_of_program), &info) == 0) return {};
  // A program that was started by its name alone has no path here.
  const bool is_program = std::string_view(info.dli_fname).find(".so") == std::string_view::npos;
  const File file(is_program ? "/proc/self/exe" : info.dli_fname, O_RDONLY);
  std::vector<char> bytes(file.size());
  file.read(bytes.data(), bytes.size(), 0);
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return {hash.low64, hash.high64};
}

/// What a file begins with; then come the lengths of the arrays and the arrays.
struct Head {
  std::array<char, 16> magic = {'c', 'a', 'l', 'o', 'r', ' ', 'r', 'e', 's', 'u', 'l', 't', 's', ' ', '1', '\n'};
  std::uint64_t arrays = 0;
  Digest from = {}, content = {};
  bool operator==(const Head&) const = default;
};

using Contents = std::vector<std::vector<double>>;
using Views = std::vector<std::span<const double>>;

std::vector<std::uint64_t> lengths_of(const Views& arrays) {
  std::vector<std::uint64_t> lengths;
  for (const auto& array : arrays) lengths.push_back(array.size());
  return lengths;
}

/// Size of a file with arrays of these lengths.
std::uint64_t size_with(const std::vector<std::uint64_t>& lengths) {
  return sizeof(Head) + sizeof(std::uint64_t) * lengths.size() +
         sizeof(double) * std::accumulate(lengths.begin(), lengths.end(), std::uint64_t{0});
}

Digest content_of(const Views& arrays) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_128bits_reset(state.get());
  const std::vector<std::uint64_t> lengths = lengths_of(arrays);
  XXH3_128bits_update(state.get(), lengths.data(), lengths.size() * sizeof(std::uint64_t));
  for (const auto& array : arrays) XXH3_128bits_update(state.get(), array.data(), array.size_bytes());
  const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
  return {hash.low64, hash.high64};
}

/// The arrays of a file; nothing where it is not whole, or not what it should be. Throws Error(file).
std::optional<Contents> read(const fs::path& path, const Digest& from, std::size_t count) {
  const File file(path, O_RDONLY);
  Head head;
  std::vector<std::uint64_t> lengths(count);
  const std::size_t bytes = lengths.size() * sizeof(std::uint64_t);
  if (file.read(&head, sizeof head, 0) < sizeof head) return {};
  if (head != Head{.arrays = count, .from = from, .content = head.content}) return {};
  if (file.read(lengths.data(), bytes, sizeof head) < bytes) return {};
  const auto size = static_cast<std::uint64_t>(file.size());
  if (std::ranges::any_of(lengths, [&](std::uint64_t n) { return n > size; }) || size_with(lengths) != size) return {};
  auto at = static_cast<std::int64_t>(sizeof head + bytes);
  Contents arrays;
  for (const std::uint64_t length : lengths) {
    std::vector<double>& array = arrays.emplace_back(length);
    const std::size_t wanted = array.size() * sizeof(double);
    if (file.read(array.data(), wanted, at) < wanted) return {};
    at += static_cast<std::int64_t>(wanted);
  }
  if (head.content != content_of(Views(arrays.begin(), arrays.end()))) return {};
  return arrays;
}

constexpr std::string_view suffix = ".kept";

/// Removes the files that were asked for longest ago, until the others fit. Other runs may do the same, and files may
/// vanish meanwhile.
void forget_oldest(const fs::path& folder) {
  struct Entry {
    fs::file_time_type used;
    std::uintmax_t size;
    fs::path path;
  };
  std::vector<Entry> entries;
  std::uintmax_t all = 0;
  std::error_code gone;
  for (const fs::directory_entry& file : fs::directory_iterator(folder, gone)) {
    if (file.path().filename().string().find(suffix) == std::string::npos) continue;
    const auto used = file.last_write_time(gone);
    if (gone) continue;
    const std::uintmax_t size = file.file_size(gone);
    if (gone) continue;
    entries.push_back({used, size, file.path()}), all += size;
  }
  std::ranges::sort(entries, {}, &Entry::used);
  for (const Entry& entry : entries) {
    if (all <= Cache::most_bytes) return;
    fs::remove(entry.path, gone);
    all -= entry.size;
  }
}

/// The file appears when it is complete and on the disk. Throws Error(file).
void write(const fs::path& path, const Digest& from, const Views& arrays) {
  const std::vector<std::uint64_t> lengths = lengths_of(arrays);
  if (size_with(lengths) > Cache::most_bytes)
    throw Error(Fault::file, SourceLocation{.file = path}, "more bytes than are kept in all", "leave keep out");
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) refuse_file(path.parent_path(), error.value());
  // Runs at once that make the same have a draft each; whose file comes last does not matter.
  const std::string draft = fmt::format("{}.{}.part", path.string(), getpid());
  try {
    File file(draft, O_WRONLY | O_CREAT | O_TRUNC);
    const Head head{.arrays = arrays.size(), .from = from, .content = content_of(arrays)};
    file.write(&head, sizeof head, 0);
    auto at = static_cast<std::int64_t>(sizeof head);
    const auto append = [&](const auto& values) {
      const std::size_t bytes = values.size() * sizeof(values[0]);
      file.write(values.data(), bytes, at);
      at += static_cast<std::int64_t>(bytes);
    };
    append(lengths);
    for (const auto& array : arrays) append(array);
    file.finish();
    if (std::rename(draft.c_str(), path.c_str()) != 0) refuse_file(path, errno);
  } catch (const Error&) {
    std::remove(draft.c_str());
    throw;
  }
  forget_oldest(path.parent_path());
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

}  // namespace

Fingerprint::Fingerprint() : state_(XXH3_createState(), [](XXH3_state_s* s) { return int{XXH3_freeState(s)}; }) {
  static const Digest program = digest_of_program();
  XXH3_128bits_reset(state_.get());
  add(program.low).add(program.high).add(static_cast<int>(best_instruction_set()));
}

void Fingerprint::add_bytes(const void* bytes, std::size_t count) { XXH3_128bits_update(state_.get(), bytes, count); }

Digest Fingerprint::digest() const {
  const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
  return {hash.low64, hash.high64};
}

fs::path Cache::users_folder() {
  if (const std::string named = environment("CALOR_CACHE"); !named.empty()) return named;
  // A path that is not absolute is to be ignored (XDG Base Directory Specification).
  if (const fs::path folder = environment("XDG_CACHE_HOME"); folder.is_absolute()) return folder / "calor";
  std::string home = environment("HOME");
  if (const passwd* user = getpwuid(getuid()); home.empty() && user) home = user->pw_dir;
  return fs::path(home) / ".cache" / "calor";
}

void Cache::get(MPI_Comm comm, const std::string& what, Owner owner, const Fingerprint& from, const Arrays& arrays,
                const std::function<void()>& make) {
  // Parts of ranks belong together: each carries what those of all ranks follow from.
  Fingerprint all;
  std::string part;
  if (owner == Owner::rank) {
    all.add(gather(comm, std::vector{from.digest()}));
    if (size_of(comm) > 1) part = fmt::format("-{}", rank_of(comm));
  } else {
    all.add(std::vector{from.digest()});
  }
  const Digest key = all.digest();
  const fs::path path = folder_ / fmt::format("{}-{:016x}{:016x}{}{}", what, key.high, key.low, part, suffix);

  std::error_code none;
  const bool exists = fs::exists(path, none);
  std::optional<Contents> kept;
  std::string problem = "is damaged";
  if (exists) {
    try {
      kept = read(path, key, arrays.size());
    } catch (const Error& e) {
      problem = e.problem();
    }
  }
  // `make` may start from what the arrays hold, so they change where all ranks read alone.
  if (!any(comm, !kept)) {
    auto found = kept->begin();
    for (auto* array : arrays) *array = std::move(*found++);
    fs::last_write_time(path, fs::file_time_type::clock::now(), none);  // it was of use
    notes_.push_back(fmt::format("{} read from {}", what, path.string()));
    return;
  }
  const auto note = [&](const std::function<void()>& work, const char* format) {
    try {
      collective_try(comm, work);
    } catch (const Error& e) {
      notes_.push_back(fmt::format(fmt::runtime(format), e.location().file, e.problem(), what));
    }
  };
  note(
      [&] {
        if (exists && !kept) throw Error(Fault::file, SourceLocation{.file = path}, problem, "");
      },
      "{0}: {1}, {2} made anew");
  make();
  note(
      [&] {
        if (owner != Owner::rank && rank_of(comm) != 0) return;
        Views made;
        for (const auto* array : arrays) made.emplace_back(*array);
        write(path, key, made);
      },
      "{0}: {1}, {2} not kept");
}

}  // namespace calor
