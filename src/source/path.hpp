#pragma once
// Where a moving source is, and how strong: passes along straight lines, with pauses and dwells, or rows of a file.
#include <optional>
#include <vector>

#include "base/function.hpp"
#include "base/vec3.hpp"
#include "case/case.hpp"
#include "case/schema.hpp"

namespace calor {

/// A source at one time.
struct Pose {
  Vec3 place;      ///< m
  Vec3 direction;  ///< unit vector along the motion; of a source at rest, that of the motion before or after
  double power;    ///< W
};

class Path {
 public:
  /// A straight segment of the way, in time; place and power are linear in between.
  struct Segment {
    double begin, end;  ///< s
    Vec3 from, to;      ///< m
    double power_from, power_to;
  };

  /// Segments in order of time; where they leave gaps the source is off.
  explicit Path(std::vector<Segment> segments);
  /// A source at rest, whose power may be a function of time, W.
  Path(const Vec3& place, Function power);
  /// The path that a [source.NAME] gives by [[source.NAME.pass]], `path` or `at`. Throws Error(bad_case).
  static Path read(const Table& source, int dimension);

  /// Nothing while the source is off. Where two segments meet the later one counts.
  std::optional<Pose> at(double t) const;
  /// Energy given since t = 0, J; nothing where the power is a function of time.
  std::optional<double> energy(double t) const;
  /// Events are the times at which place, power or velocity jump.
  Changes changes() const;
  /// Largest speed between two times, m/s.
  double fastest(double begin, double end) const;
  const std::vector<Segment>& segments() const { return segments_; }
  /// Is there power on a segment, as far as is known without asking a function of time?
  bool is_heated(const Segment& p) const { return power_ || p.power_from > 0 || p.power_to > 0; }

 private:
  std::vector<Segment> segments_;
  std::vector<Vec3> direction_;    ///< of every segment
  std::optional<Function> power_;  ///< in place of the segments' own
};

/// Refuses the keys of power and path in a source that has no use for them.
void refuse_path(const Table& source);

/// The keys of power and path.
void declare_paths(Schema& schema);

}  // namespace calor
