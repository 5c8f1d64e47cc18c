#include "geometry/parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "base/parallel.hpp"
#include "geometry/point_tags.hpp"

namespace calor {

Parts::Parts(const Case& c, const Cloud& cloud, const std::string& only_material) : cloud_(cloud) {
  constexpr double skin = 1e-6;  // spacings
  double least = std::numeric_limits<double>::max();
  for (int i = 0; i < cloud.owned; ++i) least = std::min(least, cloud.spacing[i]);
  skin_ = skin * min(cloud.comm, least);
  const Table body = c.section("body");
  body_ = body.location();
  const auto layers = body.list("layer"), regions = body.list("region");
  if (!layers.empty() && body.has("material"))
    body.refuse("material", "[body] has a material for the rest of the body, but its layers leave no rest",
                "leave it out");
  if (!layers.empty()) read_layers(body);
  if (layers.empty() && (body.has("material") || regions.empty())) {
    rest_ = count();
    parts_.push_back({.material = body.has("material") ? body.text("material") : only_material,
                      .tag = "",
                      .location = body.location("material")});
    contacts_.push_back(nullptr);
  }
  for (const Table& region : regions) read_region(c, region);
  const bool by_tag = std::ranges::any_of(regions_, [](const Region& r) { return !r.where; });
  if (by_tag && !knows_solids()) {
    std::vector<int> tag = cloud.tag;
    for (int& t : tag)
      if (!std::ranges::count(regions_, t, &Region::tag)) t = -1;  // no interface between them
    point_tags_ = std::make_shared<const PointTags>(cloud, tag);
  }
  for (const Table& contact : body.list("contact")) read_contact(contact);
  if (rest_ < 0 && layers.empty()) {
    const std::span<const Vec3> x = cloud.owned_points();
    collective_try(cloud.comm, [&] { (void)at(x, std::span(cloud.tag).first(x.size())); });
  }
}

int Parts::add(const Table& table) {
  parts_.push_back({.material = table.text("material"),
                    .tag = table.has("tag") ? table.text("tag") : "",
                    .location = table.location("material")});
  contacts_.push_back(nullptr);
  if (table.has("contact")) {
    contacts_.back() = std::make_unique<Function>(table.function("contact"));
    has_contacts_ = true;
  }
  return count() - 1;
}

void Parts::read_layers(const Table& body) {
  if (!body.has("along"))
    body.refuse("", "[body] has layers, but not the axis across them", "add along = \"x\", \"y\" or \"z\"");
  const std::string along = body.text("along");
  const int axis = along[0] - 'x';
  if (axis >= cloud_.dimension)
    body.refuse("along", fmt::format("the body has no axis {}: it is {}D", along, cloud_.dimension),
                cloud_.dimension == 1 ? "write along = \"x\"" : "write along = \"x\" or \"y\"");
  for (const Table& layer : body.list("layer")) {
    const double d = layer.number("thickness");
    if (!(d > 0)) layer.refuse("thickness", fmt::format("the thickness is {:.6g} m", d), "it must be positive");
    if (layers_.top.empty() && layer.has("contact"))
      layer.refuse("contact", "the first layer has no layer before it", "give the contact to the layer above it");
    layers_.top.push_back((layers_.top.empty() ? 0 : layers_.top.back()) + d);
    add(layer);
  }

  double low = std::numeric_limits<double>::max(), high = -low;
  const bool is_box = static_cast<int>(cloud_.walls.size()) > 2 * axis + 1;
  for (int i = 0; i < cloud_.owned; ++i) {
    // Points in the middle of their cells stand half a spacing off the wall.
    const double wall = cloud_.points_on_walls ? 0 : cloud_.spacing[i] / 2;
    low = std::min(low, cloud_.x[i][axis] - wall);
    high = std::max(high, cloud_.x[i][axis] + wall);
  }
  low = min(cloud_.comm, low), high = max(cloud_.comm, high);
  if (is_box) low = cloud_.walls[2 * axis], high = cloud_.walls[2 * axis + 1];
  const double total = layers_.top.back(), excess = total - (high - low);
  // What is round ends a little short of where it would, as its facets lie within.
  constexpr double of_facets = 0.02;
  const bool is_round = cloud_.body && excess > 0 && excess < of_facets * (high - low);
  const double start = body.has("start") ? body.number("start") : is_round ? low - excess / 2 : low;
  const double slack = (is_box || cloud_.points_on_walls ? 1e-6 : 1e-2) * (high - low);
  const bool short_of = start > low + slack || start + total < high - slack;
  if (short_of || (!body.has("start") && !is_round && excess > slack))
    body.refuse(
        "layer",
        fmt::format("the layers are {:.6g} m thick together, from {} = {:.6g} m, the body reaches from {:.6g} m "
                    "to {:.6g} m ({:.6g} m)",
                    total, along, start, low, high, high - low),
        short_of ? "make them as thick as the body" : "make them as thick as the body, or say where they start");
  layers_.axis = axis, layers_.start = start;
}

void Parts::read_region(const Case& c, const Table& table) {
  if (table.has("where") == table.has("tag"))
    table.refuse("", table.has("tag") ? "the region has 'where' and 'tag'" : "the region says nothing of its points",
                 "give where = \"...\" or tag = \"...\"");
  Region region{.part = add(table)};
  std::vector<char> in(cloud_.owned);
  if (table.has("where")) {
    region.where = where_function(c, table);
    collective_try(cloud_.comm, [&] { in = where(c, table, off_walls(cloud_.owned_points())); });
  } else {
    const auto tag = std::ranges::find(cloud_.tags, table.text("tag"));
    if (tag == cloud_.tags.end())
      table.refuse("tag", fmt::format("no point has the tag '{}'", table.text("tag")),
                   fmt::format("the tags of the cloud are '{}'", fmt::join(cloud_.tags, "', '")));
    region.tag = static_cast<int>(tag - cloud_.tags.begin());
    for (std::size_t i = 0; i < in.size(); ++i) in[i] = cloud_.tag[i] == region.tag;
  }
  // A solid may lie between the points.
  const bool is_solid = region.tag >= 0 && knows_solids();
  if (!is_solid && !any(cloud_.comm, std::ranges::count(in, 1) > 0))
    table.refuse(table.has("where") ? "where" : "tag", "the region holds no point",
                 "change the selection, or leave the region out");
  regions_.push_back(std::move(region));
}

std::vector<int> Parts::parts_called(const std::string& name, const Table& contact) const {
  std::vector<int> by_tag, by_material;
  std::vector<std::string> known;
  for (int p = 0; p < count(); ++p) {
    if (parts_[p].tag == name) by_tag.push_back(p);
    if (parts_[p].material == name) by_material.push_back(p);
    for (const std::string& other : {parts_[p].tag, parts_[p].material})
      if (!other.empty() && !std::ranges::count(known, other)) known.push_back(other);
  }
  if (by_tag.empty() && by_material.empty())
    contact.refuse("between", fmt::format("no part of the body is called '{}'", name),
                   fmt::format("name a part by its tag or by its material: {}", fmt::join(known, ", ")));
  return by_tag.empty() ? by_material : by_tag;
}

void Parts::read_contact(const Table& table) {
  const std::vector<std::string> names = table.texts("between");
  if (names.size() != 2)
    table.refuse("between", fmt::format("a contact between {} parts", names.size()),
                 "name the two parts on either side of it");
  bool is_one = true;
  for (const int p : parts_called(names[0], table))
    for (const int q : parts_called(names[1], table)) {
      if (p == q) continue;
      is_one = false;
      between_.insert_or_assign(std::minmax(p, q), table.function("conductance"));
    }
  if (is_one)
    table.refuse("between", fmt::format("'{}' and '{}' are the same part", names[0], names[1]),
                 "name the two parts on either side of the contact");
  has_contacts_ = true;
}

const Function* Parts::contact(int part, int other) const {
  const auto [low, high] = std::minmax(part, other);
  if (low == high) return nullptr;
  if (const auto found = between_.find({low, high}); found != between_.end()) return &found->second;
  return contacts_[high]                               ? contacts_[high].get()
         : high < static_cast<int>(layers_.top.size()) ? nullptr
                                                       : contacts_[low].get();
}

bool Parts::has_formulas() const {
  return std::ranges::any_of(regions_, [](const Region& region) { return region.where.has_value(); });
}

std::vector<Vec3> Parts::off_walls(std::span<const Vec3> x) const {
  std::vector<Vec3> inside(x.begin(), x.end());
  if (has_formulas())
    for (Vec3& place : inside) place = cloud_.off_walls(place, skin_);
  return inside;
}

void Parts::find(std::span<const Vec3> x, std::span<const Vec3> inside, std::span<const int> tag,
                 std::span<int> part) const {
  std::vector<Solids::Known> known;
  find(x, inside, tag, part, known);
}

void Parts::find(std::span<const Vec3> x, std::span<const Vec3> inside, std::span<const int> tag, std::span<int> part,
                 std::vector<Solids::Known>& known) const {
  for (std::size_t i = 0; i < x.size(); ++i) {
    part[i] = rest_;
    if (layers_.axis < 0) continue;
    const double s = x[i][layers_.axis] - layers_.start;
    const auto layer = std::ranges::lower_bound(layers_.top, s) - layers_.top.begin();
    part[i] = static_cast<int>(std::min<std::ptrdiff_t>(layer, std::ssize(layers_.top) - 1));
  }
  std::vector<int> of_solids;
  if (knows_solids() && std::ranges::any_of(regions_, [](const Region& r) { return !r.where; })) {
    of_solids.resize(x.size());
    cloud_.solids->tags_at(x, of_solids, known);
    for (std::size_t i = 0; i < x.size(); ++i)
      if (of_solids[i] < 0) of_solids[i] = tag[i];
  }
  const std::span<const int> tags = of_solids.empty() ? tag : of_solids;
  std::vector<double> in(x.size());
  for (const Region& region : regions_) {
    if (region.where) region.where->evaluate({.x = inside}, in);
    for (std::size_t i = 0; i < x.size(); ++i)
      if (region.where ? in[i] != 0 : tags[i] == region.tag) part[i] = region.part;
  }
}

std::vector<int> Parts::at(std::span<const Vec3> x, std::span<const int> tag) const {
  std::vector<int> part(x.size(), 0);
  if (count() == 1) return part;
  find(x, off_walls(x), tag, part);
  for (std::size_t i = 0; i < x.size(); ++i)
    if (part[i] < 0)
      throw Error(Fault::bad_case, body_,
                  fmt::format("no region holds the point at ({:.6g}, {:.6g}, {:.6g}) m", x[i].x, x[i].y, x[i].z),
                  "give [body] a material for the points that no region takes");
  return part;
}

void declare_parts(Schema& schema) {
  const std::vector<std::string> axes = {"x", "y", "z"};
  schema.add(
      {.path = "body",
       .sentence = "What the body is made of; not needed where there is one material that is no phase of another.",
       .keys = {
           {"material", Kind::text, "", optional, "Material of all points that no region takes."},
           {"conductivity_mean",
            Kind::choice,
            "",
            "automatic",
            "How two points of one part share a conductivity. automatic: integral for one material with k or k(T), "
            "harmonic for values given in layers, arithmetic for the rest. Across an interface the parts conduct in "
            "series.",
            {"automatic", "integral", "arithmetic", "harmonic"}},
           {"along", Kind::choice, "", optional, "Axis across the layers, from the low side up.", axes},
           {"start", Kind::quantity, "m", optional,
            "Coordinate at which the first layer begins; default: the low side of the body; of a body with "
            "facets that layers stand over by up to 2 %, they do so on both sides alike."}}});
  schema.add({.path = "body.layer[]",
              .sentence = "A layer of the body. The interface lies where the thicknesses put it, on points or between.",
              .keys = {{"material", Kind::text, "", required, "Material of the layer."},
                       {"thickness", Kind::quantity, "m", required, "Thickness of the layer."},
                       {"contact", Kind::function, "W/(m^2 K)", optional,
                        "Conductance of the contact with the layer before it, of place, time and the mean temperature "
                        "of its faces; absent: they touch."}}});
  auto keys = where_keys("Formula in x, y, z, r that is true in the region.");
  keys.insert(keys.begin(), {"material", Kind::text, "", required, "Material of the region."});
  keys.push_back({"tag", Kind::text, "", optional,
                  "Tag of the points of the region; on a body of shape = \"surface\" the name of a part."});
  keys.push_back({"contact", Kind::function, "W/(m^2 K)", optional,
                  "Conductance of the contact with what is around it, of place, time and the mean temperature of its "
                  "faces; absent: they touch."});
  schema.add({.path = "body.region[]",
              .sentence = "A part of the body, by formula or tag; of two regions that overlap the later one counts.",
              .keys = keys});
  schema.add(
      {.path = "body.contact[]",
       .sentence = "A contact between two parts of the body, wherever they meet; it comes before the 'contact' of "
                   "either of them, and a later one before an earlier one.",
       .keys = {
           {"between", Kind::texts, "", required, "The two parts, each by the tag of its region or by its material."},
           {"conductance", Kind::function, "W/(m^2 K)", required,
            "Conductance of the contact, of place, time and the mean temperature of its faces; 0: no heat crosses "
            "it."}}});
}

}  // namespace calor
