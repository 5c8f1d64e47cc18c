#include "cloud/face_distance.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <memory>

namespace calor {
namespace {

Surface only_faces(const Surface& body, const Table& table, const std::string& key) {
  std::vector<char> wanted(body.faces.size());
  for (const std::string& name : table.texts(key)) {
    const auto face = std::ranges::find(body.faces, name);
    if (face == body.faces.end())
      table.refuse(key, fmt::format("'{}' is not a face of the body", name),
                   fmt::format("its faces are {}", fmt::join(body.faces, ", ")));
    wanted[face - body.faces.begin()] = 1;
  }
  Surface faces = body;
  std::erase_if(faces.facets, [&](const Surface::Triangle& f) { return !wanted[f.face]; });
  return faces;
}

/// Distances by place, those asked for last being remembered: a material asks at the same places in every step.
class RememberedDistances {
 public:
  explicit RememberedDistances(std::shared_ptr<const FaceDistance> from) : from_(std::move(from)) {}

  double operator()(const Vec3& x) {
    constexpr std::size_t remembered = 1 << 16;
    known_.resize(remembered);
    Known& known = known_[hash(x) % remembered];
    if (!known.is_set || !(known.x == x))
      known = {.x = x, .distance = *from_->within(x, std::numeric_limits<double>::infinity()), .is_set = true};
    return known.distance;
  }

 private:
  struct Known {
    Vec3 x;
    double distance = 0;
    bool is_set = false;
  };
  static std::uint64_t hash(const Vec3& x) {
    std::uint64_t h = 0;
    for (const double c : {x.x, x.y, x.z}) {  // Fibonacci hashing, Knuth, vol. 3, 6.4
      h = (h ^ std::bit_cast<std::uint64_t>(c)) * 0x9E3779B97F4A7C15;
      h ^= h >> 32;
    }
    return h;
  }

  std::shared_ptr<const FaceDistance> from_;
  std::vector<Known> known_;
};

}  // namespace

FaceDistance::FaceDistance(const Surface& body, const Table& table, const std::string& key)
    : faces_(only_faces(body, table, key)), tree_(faces_) {
  if (faces_.facets.empty()) table.refuse(key, "nothing is left of these faces", "name others");
}

std::optional<double> FaceDistance::within(const Vec3& x, double bound) const {
  const auto near = tree_.closest(x, bound);
  return near ? std::optional(near->distance) : std::nullopt;
}

void set_distances(const Table& cloud, const Surface& body) {
  const Table distances = cloud.sub("distance");
  for (const std::string& name : distances.keys())
    distances.length_of_place(name).at =
        RememberedDistances(std::make_shared<const FaceDistance>(body, distances, name));
}

void declare_distances(Schema& schema) {
  schema.add({.path = "cloud.distance",
              .sentence = "Distances to faces of a body of shape = \"surface\", for the formulas of the case.",
              .keys = {{"*", Kind::texts, "", optional,
                        "NAME = \"face\", or a list of faces: formulas know the distance to the next of them by this "
                        "name, as they know x, in their unit of length."}}});
}

}  // namespace calor
