#include "output/log.hpp"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <vector>

#include "base/parallel.hpp"
#include "output/files.hpp"

namespace calor {

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
