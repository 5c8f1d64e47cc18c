// A warning where temperatures lie outside those that a material of the library or a table of temperature is known for.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
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

/// The tables of temperature in [SECTION.NAME] that do not end level.
std::vector<Function> tables_of(const Case& c, const std::string& section, const std::string& name) {
  std::vector<Function> found;
  for (const auto& [child, table] : c.section(section).children())
    if (child == name) found = table.functions();
  std::erase_if(found, [](const Function& f) { return std::isinf(f.reach().low) && std::isinf(f.reach().high); });
  return found;
}

class KnownRange : public Observer {
 public:
  KnownRange(const RunSetup& run) : comm_(run.comm()) {
    const std::size_t n = run.system.cloud().owned;
    const MaterialField& material = run.system.material();
    for (const std::string& name : material.ingredients()) {
      Watched w{.name = "material." + name,
                .from_library = behind(run.description, name),
                .tables = tables_of(run.description, "material", name)};
      if (!w.knows_an_end()) continue;
      w.share.resize(n);
      material.volume_fraction(name, w.share);
      watched_.push_back(std::move(w));
    }
    const Conditions& conditions = run.system.conditions();
    for (std::size_t account = 0; account < conditions.accounts.size(); ++account) {
      const std::string& name = conditions.accounts[account];
      Watched w{.name = "boundary." + name, .tables = tables_of(run.description, "boundary", name)};
      if (!w.knows_an_end()) continue;
      w.share.resize(n);
      for (const SurfaceTerm& term : conditions.fluxes)
        if (term.account == static_cast<int>(account))
          for (const int i : term.point) w.share[i] = 1;
      watched_.push_back(std::move(w));
    }
  }
  bool has_any() const { return !watched_.empty(); }

  void exchange(Archive& archive) override {
    for (Watched& w : watched_) {
      w.low = min(comm_, w.low), w.high = max(comm_, w.high);
      archive.value("lowest temperature of " + w.name, w.low);
      archive.value("highest temperature of " + w.name, w.high);
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
    for (Watched& w : watched_) {
      w.low = min(comm_, w.low), w.high = max(comm_, w.high);
      if (rank_of(comm_) == 0) warn(w);
    }
  }

 private:
  struct Watched {
    std::string name;  ///< "material.steel"
    const LibraryMaterial* from_library = nullptr;
    std::vector<Function> tables;
    std::vector<double> share{};  ///< of the owned points' volume, or 1 for those of a face
    double low = std::numeric_limits<double>::infinity(), high = -low;

    bool knows_an_end() const { return from_library || !tables.empty(); }
  };

  static void warn(const Watched& w) {
    constexpr double rounding = 6;  // K: what has been measured from 25 degC on is good from 20 degC on
    if (const LibraryMaterial* l = w.from_library; l && (w.low < l->low - rounding || w.high > l->high + rounding))
      spdlog::warn(
          "the library's '{}' is good for {:g} to {:g} K; here it was between {:.4g} and {:.4g} K: give "
          "properties for these temperatures",
          l->name, l->low, l->high, w.low, w.high);
    for (const Function& table : w.tables) {
      const ValueRange known = table.reach();
      if (w.low < known.low - rounding)
        spdlog::warn("{}: this table begins at {:g} K, and {} was at {:.4g} K, with the value of its first row",
                     table.location().text(), known.low, w.name, w.low);
      if (w.high > known.high + rounding)
        spdlog::warn("{}: this table ends at {:g} K, and {} was at {:.4g} K, with the value of its last row",
                     table.location().text(), known.high, w.name, w.high);
    }
  }

  MPI_Comm comm_;
  std::vector<Watched> watched_;
};

}  // namespace

std::unique_ptr<Observer> make_known_range(const RunSetup& run) {
  auto watch = std::make_unique<KnownRange>(run);
  if (!watch->has_any()) return nullptr;
  return watch;
}

}  // namespace calor
