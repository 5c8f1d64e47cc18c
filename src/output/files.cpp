#include "output/files.hpp"

#include <fmt/format.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

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

CsvLog::CsvLog(MPI_Comm comm, const std::string& path, const std::string& header) : comm_(comm), path_(path) {
  make_folder(comm, std::filesystem::path(path).parent_path());
  collective_try(comm, [&] {
    if (rank_of(comm) != 0) return;
    file_ = {std::fopen(path.c_str(), "w"), [](std::FILE* f) { f ? std::fclose(f) : 0; }};
    if (!file_) refuse_writing(path, errno);
    fmt::print(file_.get(), "{}\n", header);
    if (std::fflush(file_.get()) != 0) refuse_writing(path, errno);
  });
}

void CsvLog::row(std::span<const double> values) {
  if (path_.empty()) return;
  collective_try(comm_, [&] {
    if (!file_) return;
    const char* comma = "";
    for (double value : values) fmt::print(file_.get(), "{}{}", std::exchange(comma, ","), value);
    std::fputc('\n', file_.get());
    if (std::fflush(file_.get()) != 0) refuse_writing(path_, errno);
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

void RunLog::open(const std::string& folder) {
  make_folder(comm_, folder);
  collective_try(comm_, [&] {
    if (!sinks_->early || folder.empty()) return;
    const std::string path = folder + "/run.log";
    try {
      sinks_->file = std::make_shared<spdlog::sinks::basic_file_sink_mt>(path, true);
    } catch (const spdlog::spdlog_ex&) {
      refuse_writing(path, errno);
    }
    sinks_->file->set_pattern("%Y-%m-%d %H:%M:%S  %v");
    for (const auto& message : sinks_->early->last_raw()) sinks_->file->log(message);
    std::ranges::replace(all_sinks(), spdlog::sink_ptr(sinks_->early), sinks_->file);
  });
}

}  // namespace calor
