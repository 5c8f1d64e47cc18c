#include "source/path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/csv.hpp"
#include "source/source_profile.hpp"

namespace calor {
namespace {

Vec3 place_of(const Table& table, const std::string& key, int dimension) {
  const std::vector<double> x = table.numbers(key);
  if (static_cast<int>(x.size()) != dimension)
    table.refuse(key,
                 fmt::format("a place of {} coordinate{} in a body of {} dimensions", x.size(),
                             x.size() == 1 ? "" : "s", dimension),
                 fmt::format("give {}", dimension));
  Vec3 place;
  for (int axis = 0; axis < dimension; ++axis) place[axis] = x[axis];
  return place;
}

double positive(const Table& table, const std::string& key, const std::string& unit) {
  const double value = table.number(key);
  if (!(value > 0))
    table.refuse(key, fmt::format("{} = {:g} {} is not positive", key, value, unit), "give a positive one");
  return value;
}

double positive_power(const Table& table, double power) {
  if (power < 0) table.refuse("power", fmt::format("a power of {:g} W is negative", power), "give a positive one");
  return power;
}
double power_of_pass(const Table& pass) { return positive_power(pass, pass.number("power")); }
double power_of(const Table& source) {
  const Function power = source.function("power");
  if (!power.is_constant())
    source.refuse("power", "the power of a moving source is a number",
                  "let it change from pass to pass, or give a column 'power' to the file of the path");
  return positive_power(source, power());
}

std::vector<Path::Segment> read_passes(const Table& source, const std::vector<Table>& passes, int dimension) {
  std::vector<Path::Segment> segments;
  double t = 0;
  std::optional<Vec3> place;
  for (const Table& pass : passes) {
    if (pass.has("start") && pass.has("pause"))
      pass.refuse("pause", "the pass has a start and a pause", "keep one of the two");
    const double start = pass.has("start") ? pass.number("start") : t + (pass.has("pause") ? pass.number("pause") : 0);
    if (start < t * (1 - 1e-12))
      pass.refuse(pass.has("start") ? "start" : "pause",
                  fmt::format("the pass starts at {:g} s, before the pass before it ends, at {:g} s", start, t),
                  "start later; two sources at a time are two [source.*]");
    t = start;
    if (pass.has("from")) place = place_of(pass, "from", dimension);
    if (!place) pass.refuse("", "the first pass does not say where it begins", "add from = [...]");
    if (!pass.has("power") && !source.has("power"))
      source.refuse("", fmt::format("[{}] has no power", source.path()), "add power = \"2 kW\"");
    const double power = pass.has("power") ? power_of_pass(pass) : power_of(source);
    const auto go = [&](double duration, const Vec3& to) {
      segments.push_back({t, t + duration, *place, to, power, power});
      t += duration, place = to;
    };
    if (!pass.has("to") && !pass.has("dwell"))
      pass.refuse("", "the pass neither goes anywhere nor dwells", "add to = [...] and speed, or dwell = \"2 s\"");
    if (pass.has("to")) {
      if (!pass.has("speed")) pass.refuse("to", "the pass has no speed", "add speed = \"10 mm/s\"");
      const Vec3 to = place_of(pass, "to", dimension);
      if (to == *place)
        pass.refuse("to", "the pass ends where it begins", "give another end, or dwell = \"2 s\" in place of 'to'");
      go(norm(to - *place) / positive(pass, "speed", "m/s"), to);
    } else if (pass.has("speed")) {
      pass.refuse("speed", "the pass has a speed but no end", "add to = [...]");
    }
    if (pass.has("dwell")) go(positive(pass, "dwell", "s"), *place);
  }
  return segments;
}

std::vector<Path::Segment> read_file(const Table& source, int dimension) {
  std::optional<CsvReader> csv;
  try {
    csv.emplace(source.file("path"));
  } catch (const Error& e) {
    if (e.fault() != Fault::file) throw;
    throw Error(Fault::file, source.location("path"),
                fmt::format("the file \"{}\" {}", source.file("path"), e.problem()), e.cure());
  }
  const int t = csv->require("t", "s"), power = csv->find("power") >= 0 ? csv->require("power", "W") : -1;
  if (power >= 0 && source.has("power"))
    source.refuse("power", "the power is given here and in the file of the path", "keep one of the two");
  std::vector<int> axis;
  axis.reserve(dimension);
  for (int a = 0; a < dimension; ++a) axis.push_back(csv->require(std::string(1, "xyz"[a]), "m"));
  if (power < 0 && !source.has("power"))
    source.refuse("", fmt::format("[{}] has no power", source.path()),
                  "add power = \"2 kW\", or a column power [W] to the file of the path");
  std::vector<Path::Segment> segments;
  double last_t = 0, last_power = 0;
  Vec3 last;
  for (long row = 1; csv->next(); ++row) {
    Vec3 x;
    for (int a = 0; a < dimension; ++a) x[a] = csv->number(axis[a]);
    const double now = csv->number(t), p = power >= 0 ? csv->number(power) : power_of(source);
    if (p < 0) throw Error(Fault::bad_case, csv->location(power), "the power is negative", "give a positive one, or 0");
    if (row > 1 && now < last_t)
      throw Error(Fault::bad_case, csv->location(t), fmt::format("{:g} s after {:g} s", now, last_t),
                  "sort the rows by time; two rows of one time are a jump");
    if (row > 1 && now > last_t) segments.push_back({last_t, now, last, x, last_power, p});
    last_t = now, last = x, last_power = p;
  }
  if (segments.empty())
    source.refuse("path", "the file has fewer than two times", "give at least two rows: the path is what lies between");
  return segments;
}

bool same_time(double a, double b) { return std::abs(a - b) <= 1e-12 * std::max(std::abs(a), std::abs(b)); }

Vec3 velocity(const Path::Segment& p) { return 1 / (p.end - p.begin) * (p.to - p.from); }

}  // namespace

Path::Path(std::vector<Segment> segments) : segments_(std::move(segments)), direction_(segments_.size()) {
  const auto moves = [&](std::size_t n) { return !(segments_[n].from == segments_[n].to); };
  const auto unit = [&](std::size_t n) { return 1 / norm(velocity(segments_[n])) * velocity(segments_[n]); };
  std::optional<Vec3> direction;
  for (std::size_t n = 0; n < segments_.size() && !direction; ++n)
    if (moves(n)) direction = unit(n);
  for (std::size_t n = 0; n < segments_.size(); ++n) {
    if (moves(n)) direction = unit(n);
    direction_[n] = direction.value_or(Vec3{1, 0, 0});
  }
}

Path::Path(const Vec3& place, Function power) : Path({{0, std::numeric_limits<double>::max(), place, place, 0, 0}}) {
  power_ = std::move(power);
}

Path Path::read(const Table& source, int dimension) {
  const std::vector<Table> passes = source.list("pass");
  const int given = !passes.empty() + source.has("path") + source.has("at");
  if (given != 1)
    source.refuse(given > 1 ? (source.has("at") ? "at" : "path") : "",
                  given > 1 ? fmt::format("[{}] has more than one of 'at', 'path' and passes", source.path())
                            : fmt::format("[{}] does not say where it is", source.path()),
                  given > 1 ? "keep one of them"
                            : fmt::format("add at = [...], path = \"FILE.csv\", or [[{}.pass]]", source.path()));
  if (!passes.empty()) return Path(read_passes(source, passes, dimension));
  if (source.has("path")) return Path(read_file(source, dimension));
  if (!source.has("power")) source.refuse("", fmt::format("[{}] has no power", source.path()), "add power = \"2 kW\"");
  const Vec3 place = place_of(source, "at", dimension);
  const Function power = source.function("power");
  if (power.depends_on_place() || power.depends_on_temperature())
    source.refuse("power", "the power of a source with a profile depends on place or temperature",
                  "give a number, or a function of time alone");
  if (power.depends_on_time()) return {place, power};
  const double constant = positive_power(source, power());
  return Path({{0, std::numeric_limits<double>::max(), place, place, constant, constant}});
}

std::optional<Pose> Path::at(double t) const {
  const auto next = std::ranges::upper_bound(segments_, t, {}, &Segment::begin);
  if (next == segments_.begin()) return std::nullopt;
  const Segment& p = *std::prev(next);
  if (t > p.end) return std::nullopt;
  const double s = (t - p.begin) / (p.end - p.begin);
  if (power_) {
    const double power = (*power_)({}, t);
    if (power < 0)
      throw Error(Fault::numbers, power_->location(), fmt::format("the power is {:.6g} W at t = {:.6g} s", power, t),
                  "give a positive one, or 0");
    return Pose{.place = p.from, .direction = direction_[0], .power = power};
  }
  return Pose{.place = p.from + s * (p.to - p.from),
              .direction = direction_[&p - segments_.data()],
              .power = p.power_from + s * (p.power_to - p.power_from)};
}

std::optional<double> Path::energy(double t) const {
  if (power_) return std::nullopt;
  double energy = 0;
  for (const Segment& p : segments_) {
    const double begin = std::max(p.begin, 0.0), end = std::min(p.end, t);
    if (end <= begin) continue;
    const auto power = [&](double time) {
      return p.power_from + (time - p.begin) / (p.end - p.begin) * (p.power_to - p.power_from);
    };
    energy += 0.5 * (power(begin) + power(end)) * (end - begin);
  }
  return energy;
}

Changes Path::changes() const {
  if (power_) return power_->changes();
  std::vector<double> times;
  for (std::size_t n = 0; n < segments_.size(); ++n) {
    const Segment& p = segments_[n];
    const bool follows = n > 0 && same_time(segments_[n - 1].end, p.begin);
    bool smooth = follows;
    if (follows) {
      const Segment& before = segments_[n - 1];
      const Vec3 v = velocity(before), w = velocity(p);
      // The bends of a finely sampled path are no jumps.
      const double bend = norm(w - v), speed = std::max(norm(v), norm(w));
      smooth = before.to == p.from && before.power_to == p.power_from && bend <= 0.3 * speed;
    }
    if (!smooth) times.push_back(p.begin);
    const bool ends = n + 1 == segments_.size() || !same_time(p.end, segments_[n + 1].begin);
    if (ends && p.end < std::numeric_limits<double>::max()) times.push_back(p.end);
  }
  return {.events = times, .marks = {}};
}

double Path::fastest(double begin, double end) const {
  double speed = 0;
  for (const Segment& p : segments_)
    if (p.begin < end && p.end > begin) speed = std::max(speed, norm(velocity(p)));
  return speed;
}

void refuse_path(const Table& source) {
  for (const char* key : {"power", "efficiency", "half", "normalise", "at", "path", "pass"})
    if (source.has(key))
      source.refuse(key, fmt::format("'{}' goes with a {}", key, source_profiles().listed()), "leave it out");
}

void declare_paths(Schema& schema) {
  schema.add(
      {.path = "source.*",
       .sentence = "Power and place of a concentrated source: at rest ('at'), along passes or by a file.",
       .keys = {
           {"power", Kind::function, "W", optional,
            "Power of the whole source, before the efficiency; of a source that does not move it may depend on time."},
           {"efficiency", Kind::number, "", "1", "Part of the power that reaches the body, above 0 to 1."},
           {"half", Kind::flag, "", "false",
            "The body is one half of a symmetric one and the source moves on the cut: half of the power goes in."},
           {"normalise", Kind::flag, "", "true",
            "What goes into the body is exactly the power asked for, at edges too. Otherwise heat that falls beside "
            "the body is lost; energy.csv shows it."},
           {"at", Kind::quantities, "m", optional, "Place of a source at rest."},
           {"path", Kind::text, "", optional,
            "CSV file with columns t, x, y, z and perhaps power, linear in between; off before the first and "
            "after the last row. Two rows of one time are a jump."}}});
  schema.add({.path = "source.*.pass[]",
              .sentence =
                  "A pass of the source along a straight line, then perhaps a stop. One pass begins when the one "
                  "before ends, and where it ended unless 'from' says otherwise: a polyline is a chain of passes.",
              .keys = {{"from", Kind::quantities, "m", optional, "Where the pass begins."},
                       {"to", Kind::quantities, "m", optional, "Where it ends."},
                       {"speed", Kind::quantity, "m/s", optional, "Speed on the way."},
                       {"start", Kind::quantity, "s", optional, "Time at which the pass begins."},
                       {"pause", Kind::quantity, "s", optional, "Time without power before the pass begins."},
                       {"dwell", Kind::quantity, "s", optional, "Time at rest, with power, at the end of the pass."},
                       {"power", Kind::quantity, "W", optional, "Power of this pass, in place of the source's."}}});
}

}  // namespace calor
