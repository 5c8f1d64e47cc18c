// A warning where temperatures lie outside those that the values of a library material are good for.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>

#include "base/archive.hpp"
#include "base/parallel.hpp"
#include "material/library.hpp"
#include "output/observer.hpp"

namespace calor {
namespace {

/// The library material behind a material of the body, or null: one of the case may stand on one of the library.
const LibraryMaterial* behind(const Case& c, const std::string& material) {
  for (const auto& [name, table] : c.section("material").children())
    if (name == material) return table.has("library") ? find_in_library(table.text("library")) : nullptr;
  return find_in_library(material);
}

class LibraryRange : public Observer {
 public:
  LibraryRange(const RunSetup& run) : comm_(run.comm()) {
    const MaterialField& material = run.system.material();
    for (const std::string& name : material.ingredients()) {
      const LibraryMaterial* library = behind(run.description, name);
      if (!library) continue;
      std::vector<double> share(run.system.cloud().owned);
      material.volume_fraction(name, share);
      watched_.push_back({library, std::move(share)});
    }
  }
  bool has_any() const { return !watched_.empty(); }

  void exchange(Archive& archive) override {
    for (Watched& w : watched_) {
      w.low = min(comm_, w.low), w.high = max(comm_, w.high);
      archive.value("lowest temperature of " + w.material->name, w.low);
      archive.value("highest temperature of " + w.material->name, w.high);
    }
  }
  void record(const Moment& m) override {
    const std::span<const double> T = m.temperatures();
    for (Watched& w : watched_) {
      for (std::size_t i = 0; i < T.size(); ++i)
        if (w.share[i] > 0) w.low = std::min(w.low, T[i]), w.high = std::max(w.high, T[i]);
    }
  }
  void finish(const Moment&, RunResult&) override {
    for (const Watched& w : watched_) {
      const double low = min(comm_, w.low), high = max(comm_, w.high);
      const LibraryMaterial& l = *w.material;
      constexpr double rounding = 6;  // K: what has been measured from 25 degC on is good from 20 degC on
      if ((low < l.low - rounding || high > l.high + rounding) && rank_of(comm_) == 0)
        spdlog::warn(
            "the library's '{}' is good for {:g} to {:g} K; here it was between {:.4g} and {:.4g} K: give "
            "properties for these temperatures",
            l.name, l.low, l.high, low, high);
    }
  }

 private:
  struct Watched {
    const LibraryMaterial* material;
    std::vector<double> share;  ///< of the owned points' volume
    double low = std::numeric_limits<double>::infinity(), high = -low;
  };
  MPI_Comm comm_;
  std::vector<Watched> watched_;
};

}  // namespace

std::unique_ptr<Observer> make_library_range(const RunSetup& run) {
  auto watch = std::make_unique<LibraryRange>(run);
  if (!watch->has_any()) return nullptr;
  return watch;
}

}  // namespace calor
