#include "output/balance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/parallel.hpp"
#include "base/reduce.hpp"
#include "output/files.hpp"
#include "output/material_volumes.hpp"
#include "output/observer.hpp"

namespace calor {

Balance::Balance(HeatSystem& system) : system_(system) {
  add_materials();
  add_body();
  add_sections();
  add_faces();
  for (Zone& zone : zones_) zone.whole = sum(system_.cloud().comm, zone.weight);
}

void Balance::keep(Zone zone) {
  MPI_Comm comm = system_.cloud().comm;
  if (!any(comm, zone.inside > 0)) zone.inside = zone.point.size();
  if (any(comm, !zone.point.empty())) zones_.push_back(std::move(zone));
}

void Balance::add_materials() {
  const int owned = system_.cloud().owned;
  const Parts& parts = system_.material().parts();
  std::optional<MaterialVolumes> volumes;
  collective_try(system_.cloud().comm, [&] { volumes.emplace(system_); });
  for (int part = 0; part < parts.count(); ++part) {
    Zone zone{.name = parts[part].material};
    if (std::ranges::count(zones_, zone.name, &Zone::name)) continue;
    const auto [lies_in, volume] = volumes->of(zone.name);
    for (const bool inside : {true, false}) {
      for (int i = 0; i < owned; ++i) {
        if ((lies_in[i] != 0) != inside || !(inside || volume[i] > 0)) continue;
        zone.point.push_back(i);
        zone.weight.push_back(volume[i]);
      }
      if (inside) zone.inside = zone.point.size();
    }
    keep(std::move(zone));
  }
}

void Balance::add_body() {
  if (zones_.size() < 2 || std::ranges::count(zones_, "body", &Zone::name)) return;
  Zone body{.name = "body"};
  for (const Zone& material : zones_) {
    body.point.insert(body.point.end(), material.point.begin(), material.point.end());
    body.weight.insert(body.weight.end(), material.weight.begin(), material.weight.end());
  }
  keep(std::move(body));
}

void Balance::add_sections() {
  const Cloud& cloud = system_.cloud();
  const Conditions& conditions = system_.conditions();
  for (int account = 0; account < system_.boundary_accounts(); ++account) {
    Zone zone{.name = accounts()[account]};
    for (const PrescribedTerm& term : conditions.temperatures) {
      if (term.account != account) continue;
      zone.point = term.point;
      for (const Vec3& area : term.area) zone.weight.push_back(norm(area));
      for (const int facet : term.facet) {
        zone.point.push_back(cloud.owned + facet);
        zone.weight.push_back(cloud.facets[facet].area);
      }
    }
    for (const SurfaceTerm& term : conditions.fluxes) {
      if (term.account != account || (!zone.point.empty() && !term.is_plate)) continue;
      if (term.is_plate)
        zone.point.insert(zone.point.end(), term.point.begin(), term.point.end());
      else
        for (const int facet : term.facet) zone.point.push_back(cloud.owned + facet);
      zone.weight.insert(zone.weight.end(), term.area.begin(), term.area.end());
    }
    if (std::ranges::find(zones_, zone.name, &Zone::name) != zones_.end()) zone.name = "face " + zone.name;
    keep(std::move(zone));
  }
}

void Balance::add_faces() {
  const Cloud& cloud = system_.cloud();
  for (std::size_t face = 0; face < cloud.faces.size(); ++face) {
    Zone zone{.name = cloud.faces[face]};
    const auto is_taken = [&] { return std::ranges::count(zones_, zone.name, &Zone::name) > 0; };
    const bool is_section = std::ranges::count(accounts(), zone.name) > 0;
    if (is_taken() && is_section) continue;
    if (is_taken()) zone.name = "face " + zone.name;
    for (std::size_t n = 0; n < cloud.facets.size(); ++n) {
      if (cloud.facets[n].face != static_cast<int>(face)) continue;
      zone.point.push_back(cloud.owned + static_cast<int>(n));
      zone.weight.push_back(cloud.facets[n].area);
    }
    keep(std::move(zone));
  }
}

std::vector<double> Balance::heat_flows(double t, std::span<const double> u) const {
  std::vector<double> own(u.begin(), u.end());
  return system_.heat_flows(t, own);
}

std::vector<double> Balance::temperatures(double t, std::span<const double> u) const {
  std::vector<double> own(u.begin(), u.end());
  std::vector<double> T = system_.temperatures(own);
  const std::vector<double> walls = system_.wall_temperatures(t, own);
  T.insert(T.end(), walls.begin(), walls.end());
  return T;
}

Balance::Summary Balance::summary(const Zone& zone, std::span<const double> T) const {
  MPI_Comm comm = system_.cloud().comm;
  std::vector<double> values(zone.point.size());
  for (std::size_t n = 0; n < values.size(); ++n) values[n] = T[zone.point[n]];
  const ValueRange range = range_of(std::span(values).first(zone.inside));
  const double low = min(comm, range.low), high = max(comm, range.high);
  for (std::size_t n = 0; n < values.size(); ++n) values[n] *= zone.weight[n];
  const double total = sum(comm, values);
  return {.mean = zone.whole > 0 ? std::clamp(total / zone.whole, low, high) : 0.5 * (low + high),
          .minimum = low,
          .maximum = high};
}

std::vector<ReportNumber> Balance::listed() const {
  std::vector<ReportNumber> all;
  for (const std::string& account : accounts()) all.push_back({"heat_flow." + account, "W"});
  for (const Zone& zone : zones_)
    for (const char* what : {"mean", "minimum", "maximum"}) all.push_back({fmt::format("{}.{}", what, zone.name), "K"});
  return all;
}

std::vector<double> Balance::numbers(double t, std::span<const double> u) const {
  std::vector<double> numbers = heat_flows(t, u);
  const std::vector<double> T = temperatures(t, u);
  for (const Zone& zone : zones_) {
    const auto [mean, minimum, maximum] = summary(zone, T);
    numbers.insert(numbers.end(), {mean, minimum, maximum});
  }
  return numbers;
}

namespace {

/// balance.csv: a row a time; the last one is also in the report.
class BalanceLog : public Observer {
 public:
  explicit BalanceLog(const RunSetup& run) : balance_(run.system) {
    std::string header = "time [s]";
    int account = 0;
    for (const std::string& name : balance_.accounts()) {
      const bool is_boundary = account++ < run.system.boundary_accounts();
      header += "," + csv_field(fmt::format("heat flow {} {} [W]", is_boundary ? "through" : "from", name));
    }
    for (const Balance::Zone& zone : balance_.zones())
      for (const char* what : {"mean", "minimum", "maximum"})
        header += "," + csv_field(fmt::format("{} of {} [K]", what, zone.name));
    if (!run.folder.empty()) log_ = CsvLog(run.comm(), run.folder + "/balance.csv", header);
  }

  void begin() override { log_.open(); }
  void exchange(Archive& archive) override { log_.exchange(archive); }
  void record(const Moment& m) override {
    std::vector<double> row = balance_.numbers(m.state().t, m.u());
    row.insert(row.begin(), m.state().t);
    log_.row(row);
  }
  void finish(const Moment& m, RunResult& result) override {
    const std::vector<ReportNumber> listed = balance_.listed();
    const std::vector<double> last = balance_.numbers(m.state().t, m.u());
    for (std::size_t n = 0; n < last.size(); ++n) result.numbers[listed[n].name] = last[n];
  }
  std::vector<ReportNumber> numbers() const override { return balance_.listed(); }

 private:
  Balance balance_;
  CsvLog log_;
};

}  // namespace

std::unique_ptr<Observer> make_balance_log(const RunSetup& run) { return std::make_unique<BalanceLog>(run); }

}  // namespace calor
