#include "output/files.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/compile.h>
#include <fmt/format.h>
#include <fnmatch.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "base/archive.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"

namespace calor {

void refuse_writing(const std::string& path, int error) {
  throw Error(Fault::file, SourceLocation{.file = path},
              fmt::format("cannot be written{}{}", error ? ": " : "", error ? std::strerror(error) : ""),
              "choose a folder that you may write to, on a disk with room left: -o FOLDER");
}

void make_folder(MPI_Comm comm, const std::string& folder) {
  collective_try(comm, [&] {
    if (rank_of(comm) != 0 || folder.empty()) return;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error || !std::filesystem::is_directory(folder)) refuse_writing(folder, error.value());
  });
}

void replace_file(const std::string& path, const std::string& text) {
  const std::string draft = path + ".part";
  std::FILE* file = std::fopen(draft.c_str(), "wb");
  if (!file) refuse_writing(path, errno);
  const bool is_written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (std::fclose(file) != 0 || !is_written || std::rename(draft.c_str(), path.c_str()) != 0)
    refuse_writing(path, errno);
}

void remove_files(MPI_Comm comm, const std::string& folder, const std::vector<std::string>& names) {
  namespace fs = std::filesystem;
  collective_try(comm, [&] {
    if (rank_of(comm) != 0 || folder.empty()) return;
    std::vector<fs::path> found;
    std::error_code none;
    for (const fs::path name : names)
      for (const auto& entry : fs::directory_iterator(fs::path(folder) / name.parent_path(), none))
        if (fnmatch(name.filename().c_str(), entry.path().filename().c_str(), 0) == 0) found.push_back(entry.path());
    for (const fs::path& file : found) {
      std::error_code error;
      if (!fs::is_directory(file, none)) fs::remove(file, error);
      if (error) refuse_writing(file, error.value());
    }
  });
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == text.npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

void write_in_turns(MPI_Comm comm, const std::string& path, const std::string& header,
                    const std::function<void(std::FILE*)>& rows) {
  const bool is_first = rank_of(comm) == 0;
  // The error travels with the turn: after a rank that failed nobody writes.
  const int error = in_turns(comm, 0, [&](int error) {
    if (error) return error;
    const auto failed = [&] { error = errno ? errno : EIO; };
    std::FILE* file = std::fopen(path.c_str(), is_first ? "w" : "a");
    if (!file) failed();
    try {
      if (file && is_first) fmt::print(file, "{}\n", header);
      if (file) rows(file);
    } catch (const std::exception&) {  // fmt throws where a disk is full
      failed();
    }
    if (file && std::fclose(file) != 0) failed();
    return error;
  });
  collective_try(comm, [&] {
    if (error) refuse_writing(path, error);
  });
}

void NumberLines::add(std::initializer_list<double> numbers) {
  constexpr std::size_t much = 1 << 16;
  columns_.resize(numbers.size(), {std::numeric_limits<double>::quiet_NaN(), ""});
  auto column = columns_.begin();
  for (const double number : numbers) {
    if (std::bit_cast<std::uint64_t>(column->number) != std::bit_cast<std::uint64_t>(number) || column->text.empty()) {
      column->number = number, column->text.clear();
      fmt::format_to(std::back_inserter(column->text), FMT_COMPILE("{}"), number);
    }
    text_ += (column++)->text;
    text_ += ',';
  }
  text_.back() = '\n';
  if (text_.size() > much) finish();
}

void NumberLines::finish() {
  if (std::fwrite(text_.data(), 1, text_.size(), file_) != text_.size())
    throw std::system_error(errno, std::generic_category());
  text_.clear();
}

void CsvLog::open() {
  if (path_.empty()) return;
  make_folder(comm_, std::filesystem::path(path_).parent_path());
  collective_try(comm_, [&] {
    if (rank_of(comm_) != 0) return;
    const bool is_new = length_ == 0;
    if (!is_new) {
      std::error_code error;
      const auto there = std::filesystem::file_size(path_, error);
      if (error) refuse_writing(path_, error.value());
      if (there < static_cast<std::uintmax_t>(length_))
        throw Error(Fault::file, SourceLocation{.file = path_}, "rows are missing that the checkpoint goes on from",
                    "put the file back as it was, or run without --restart");
      if (truncate(path_.c_str(), length_) != 0) refuse_writing(path_, errno);
    }
    file_ = {std::fopen(path_.c_str(), is_new ? "w" : "a"), [](std::FILE* f) { f ? std::fclose(f) : 0; }};
    if (!file_) refuse_writing(path_, errno);
    if (is_new) write(header_ + "\n");
  });
}

void CsvLog::row(std::span<const double> values) {
  if (path_.empty()) return;
  collective_try(comm_, [&] {
    if (!file_) return;
    std::string line;
    for (double value : values) line += fmt::format("{}{}", line.empty() ? "" : ",", value);
    write(line + "\n");
  });
}

void CsvLog::write(const std::string& line) {
  if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size() || std::fflush(file_.get()) != 0)
    refuse_writing(path_, errno);
  length_ += static_cast<std::int64_t>(line.size());
}

void CsvLog::exchange(Archive& archive) {
  if (path_.empty()) return;
  collective_try(comm_, [&] {
    if (file_ && fsync(fileno(file_.get())) != 0) refuse_writing(path_, errno);
  });
  length_ = static_cast<std::int64_t>(max(comm_, static_cast<double>(length_)));
  archive.value("bytes of " + std::filesystem::path(path_).filename().string(), length_);
}

namespace {

/// Does the name still lead to the open file?
bool is_in_place(int descriptor, const std::string& path) {
  struct stat opened {
  }, named{};
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

std::string holder_text() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  return fmt::format("process {} on {} since {:%Y-%m-%d %H:%M:%S}", getpid(), host.data(), fmt::localtime(now));
}

}  // namespace

void FolderLock::take() {
  if (path_.empty()) return;
  const std::string folder = std::filesystem::path(path_).parent_path();
  make_folder(comm_, folder);
  collective_try(comm_, [&] {
    if (rank_of(comm_) != 0 || descriptor_ >= 0) return;
    while (true) {
      descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
      if (descriptor_ < 0) refuse_writing(path_, errno);
      if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
        if (errno != EWOULDBLOCK) break;  // a disk without locks
        std::array<char, 512> holder{};
        const auto length = std::max<ssize_t>(0, read(descriptor_, holder.data(), holder.size()));
        close(std::exchange(descriptor_, -1));
        throw Error(Fault::file, SourceLocation{.file = folder},
                    "another run writes into this folder: " + std::string(holder.data(), length),
                    "wait until it has ended, or choose another folder: -o FOLDER");
      }
      if (is_in_place(descriptor_, path_)) break;
      close(descriptor_);  // the one who held it has just removed it
    }
    const std::string text = holder_text();
    if (ftruncate(descriptor_, 0) != 0 || pwrite(descriptor_, text.data(), text.size(), 0) < 0)
      refuse_writing(path_, errno);
  });
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  if (is_in_place(descriptor_, path_)) unlink(path_.c_str());
  close(descriptor_);
}

void FolderLock::require_folder() const {
  collective_try(comm_, [&] {
    if (descriptor_ < 0 || is_in_place(descriptor_, path_)) return;
    throw Error(Fault::file, SourceLocation{.file = std::filesystem::path(path_).parent_path()},
                "the folder has been removed or replaced while the run went on: its results are lost",
                "leave the folder of a run alone until it has ended");
  });
}

struct RunLog::Sinks {
  std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> early;
  spdlog::sink_ptr file;
};

namespace {

constexpr std::size_t most_early = 1000;

std::vector<spdlog::sink_ptr>& all_sinks() { return spdlog::default_logger()->sinks(); }

}  // namespace

RunLog::RunLog(MPI_Comm comm) : comm_(comm), sinks_(std::make_unique<Sinks>()) {
  if (rank_of(comm) != 0) return;
  sinks_->early = std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(most_early);
  all_sinks().push_back(sinks_->early);
}

RunLog::~RunLog() {
  std::erase(all_sinks(), sinks_->early);
  std::erase(all_sinks(), sinks_->file);
}

void RunLog::open(const std::string& folder, bool goes_on) {
  make_folder(comm_, folder);
  collective_try(comm_, [&] {
    if (!sinks_->early || folder.empty()) return;
    const std::string path = folder + "/run.log";
    try {
      sinks_->file = std::make_shared<spdlog::sinks::basic_file_sink_mt>(path, !goes_on);
    } catch (const spdlog::spdlog_ex&) {
      refuse_writing(path, errno);
    }
    sinks_->file->set_pattern("%Y-%m-%d %H:%M:%S  %v");
    for (const auto& message : sinks_->early->last_raw()) sinks_->file->log(message);
    std::ranges::replace(all_sinks(), spdlog::sink_ptr(sinks_->early), sinks_->file);
  });
}

}  // namespace calor
