#include "output/thermal_stress.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.hpp"
#include "cloud/cracks.hpp"

namespace calor {
namespace {

/// Gauss's rule with five places in [-1, 1]: place and weight.
const std::array<std::pair<double, double>, 5> gauss{{{-0.906179845938664, 0.236926885056189},
                                                      {-0.538469310105683, 0.478628670499366},
                                                      {0, 0.568888888888889},
                                                      {0.538469310105683, 0.478628670499366},
                                                      {0.906179845938664, 0.236926885056189}}};

/// A strain component at a place as a sum over degrees of freedom.
struct StrainRow {
  std::array<int, 10> dof{};
  std::array<double, 10> value{};
  int count = 0;

  void add(int d, double v) { dof[count] = d, value[count++] = v; }
  double times(std::span<const double> d) const {
    double sum = 0;
    for (int n = 0; n < count; ++n) sum += value[n] * d[dof[n]];
    return sum;
  }
};

/// How the strain follows from the degrees of freedom, and the stress from the strain.
class Kinematics {
 public:
  virtual ~Kinematics() = default;
  std::vector<std::string> components = {"stress"};
  std::vector<char> is_fixed;  ///< the degrees of freedom that the support holds at 0
  virtual StrainRow strain(std::size_t component, double s, double r) const = 0;
  /// Stress over strain, one row and column a component.
  virtual Eigen::Matrix2d stiffness(double E, double nu) const = 0;
  /// Strain and curvature for people.
  virtual std::pair<double, double> middle(std::span<const double> d, double thickness) const = 0;
  /// Where to look along the radius, and the weights of an integral.
  virtual std::vector<std::pair<double, double>> radii() const { return {{0, 1}}; }
};

/// A beam or a plate: strain d0 + s d1. A plate bends alike in all directions.
class Plate final : public Kinematics {
 public:
  Plate(bool is_beam, const std::string& support) : is_beam_(is_beam) {
    is_fixed = {support == "clamped", support != "free"};
  }
  StrainRow strain(std::size_t, double s, double) const override {
    return {.dof = {0, 1}, .value = {1, s}, .count = 2};
  }
  Eigen::Matrix2d stiffness(double E, double nu) const override {
    return Eigen::Vector2d(is_beam_ ? E : E / (1 - nu), 0).asDiagonal();
  }
  std::pair<double, double> middle(std::span<const double> d, double thickness) const override {
    return {d[0] + 0.5 * thickness * d[1], d[1]};
  }

 private:
  bool is_beam_;
};

/// A round plate whose temperature depends on radius and thickness: displacement and slope by elements of fourth order
/// along the radius; radial strain u' + s phi', hoop strain (u + s phi)/r.
class Disc final : public Kinematics {
 public:
  Disc(double radius, const std::string& support) : width_(radius / elements) {
    components = {"radial stress", "hoop stress"};
    is_fixed.assign(2 * nodes, support == "flat");
    for (int node = 0; node < nodes; ++node) is_fixed[2 * node] = false;
    is_fixed[0] = is_fixed[1] = true;
    if (support == "clamped") is_fixed[2 * nodes - 2] = is_fixed[2 * nodes - 1] = true;
  }
  StrainRow strain(std::size_t component, double s, double r) const override {
    const int element = std::clamp(static_cast<int>(r / width_), 0, elements - 1);
    const double xi = order * (r / width_ - element);  // 0, 1, ... at the nodes of the element
    StrainRow row;
    for (int a = 0; a <= order; ++a) {
      double shape = 1, slope = 0;
      for (int b = 0; b <= order; ++b)
        if (b != a) slope = (slope * (xi - b) + shape) / (a - b), shape *= (xi - b) / (a - b);
      slope *= order / width_;
      const int node = order * element + a;
      const double value = component == 0 || r == 0 ? slope : shape / r;  // on the axis both are the same
      row.add(2 * node, value);
      row.add(2 * node + 1, s * value);
    }
    return row;
  }
  Eigen::Matrix2d stiffness(double E, double nu) const override {
    return E / (1 - nu * nu) * (Eigen::Matrix2d() << 1, nu, nu, 1).finished();
  }
  std::pair<double, double> middle(std::span<const double> d, double thickness) const override {
    return {strain(0, 0.5 * thickness, 0).times(d), strain(0, 1, 0).times(d) - strain(0, 0, 0).times(d)};
  }
  std::vector<std::pair<double, double>> radii() const override {
    std::vector<std::pair<double, double>> all{{0, 0}};
    for (int e = 0; e < elements; ++e)
      for (const auto& [xi, weight] : gauss) {
        const double r = (e + 0.5 + 0.5 * xi) * width_;
        all.emplace_back(r, 0.5 * weight * width_ * r);
      }
    all.emplace_back(elements * width_, 0);
    return all;
  }

 private:
  static constexpr int elements = 12, order = 4, nodes = order * elements + 1;
  double width_;
};

/// Tags of the points next to the places, the same on all ranks. Collective.
std::vector<int> tags_at(const Cloud& cloud, std::span<const Vec3> places) {
  std::vector<int> tag(places.size(), 0);
  if (cloud.tags.size() < 2) return tag;
  std::vector<double> nearest(places.size(), std::numeric_limits<double>::infinity());
  for (std::size_t n = 0; n < places.size(); ++n)
    for (int i = 0; i < cloud.owned; ++i)
      if (const double d = norm(cloud.x[i] - places[n]); d < nearest[n]) nearest[n] = d, tag[n] = cloud.tag[i];
  std::vector<double> least = nearest;
  lowest(cloud.comm, least);
  std::vector<double> owner(places.size());
  for (std::size_t n = 0; n < places.size(); ++n)
    owner[n] = nearest[n] == least[n] ? tag[n] : std::numeric_limits<double>::infinity();
  lowest(cloud.comm, owner);
  std::ranges::transform(owner, tag.begin(), [](double t) { return static_cast<int>(t); });
  return tag;
}

std::unique_ptr<Kinematics> read_kinematics(const Table& table, const Cloud& cloud, const Vec3& along) {
  const std::string body = table.text("body"), support = table.text("support");
  if (body != "disc") {
    if (table.has("radius")) table.refuse("radius", "'radius' goes with body = \"disc\"", "leave it out");
    return std::make_unique<Plate>(body == "beam", support);
  }
  if (!table.has("radius")) table.refuse("body", "a disc has a radius", "add radius = \"10 mm\"");
  if (cloud.dimension == 1 || (cloud.dimension == 2 && !cloud.axisymmetric))
    table.refuse("body", "a disc has a thickness and a radius", "take a body in 3D, or an axisymmetric one");
  if (cloud.axisymmetric && along.x != 0)
    table.refuse("to", "the line is not parallel to the axis of the body", "give from = [0, ...] and to = [0, ...]");
  const double radius = table.number("radius");
  if (!(radius > 0)) table.refuse("radius", fmt::format("a radius of {:g} m", radius), "give a length above 0");
  return std::make_unique<Disc>(radius, support);
}

}  // namespace

struct ThermalStress::Impl {
  Impl(const Case& c, const HeatSystem& system, const Probes& probes);

  std::pair<double, double> s_and_r(const Vec3& x) const {
    const double s_here = dot(x - from, along);
    return {s_here, norm(x - from - s_here * along)};
  }
  void add_line(const Parts& parts, double radius, double weight, int tag_from, int tag_to, int pieces_a_part);
  void add_place(double s_here, double r_here, double w);
  std::vector<double> stress(const Deformation& d, std::size_t component, const Elasticity& elasticity,
                             std::span<const Vec3> x, std::span<const double> T) const;
  double largest(std::span<const double> of_section, double sign) const;

  Vec3 from, along, outwards;
  double thickness;
  std::unique_ptr<Kinematics> kinematics;
  // The section.
  std::vector<Vec3> x;
  std::vector<double> s, r, weight;
  std::unique_ptr<Probes> line;
  std::unique_ptr<Elasticity> of_section, of_points, of_probes;
  std::span<const Vec3> points, probe_places;
};

void ThermalStress::Impl::add_place(double s_here, double r_here, double w) {
  x.push_back(from + s_here * along + r_here * outwards);
  s.push_back(s_here), r.push_back(r_here), weight.push_back(w);
}

/// Places of an integral through the thickness, part by part, and the ends of every part.
void ThermalStress::Impl::add_line(const Parts& parts, double radius, double w, int tag_from, int tag_to,
                                   int pieces_a_part) {
  const Vec3 a = from + radius * outwards;
  const Parts::Segment segment{a, a + thickness * along, tag_from, tag_to};
  const Parts::Pieces pieces = parts.along({&segment, 1});
  const double aside = 1e-9 * thickness;
  double begin = 0;
  for (const SegmentPiece& piece : pieces.piece) {
    const bool is_first = begin == 0, is_last = &piece == &pieces.piece.back();
    const double end = is_last ? thickness : piece.end * thickness, h = (end - begin) / pieces_a_part;
    add_place(is_first ? 0 : begin + aside, radius, 0);
    for (int n = 0; n < pieces_a_part; ++n)
      for (const auto& [xi, share] : gauss) add_place(begin + (n + 0.5 + 0.5 * xi) * h, radius, 0.5 * share * h * w);
    add_place(is_last ? thickness : end - aside, radius, 0);
    begin = end;
  }
}

ThermalStress::Impl::Impl(const Case& c, const HeatSystem& system, const Probes& probes) {
  const Table table = c.section("stress");
  const Cloud& cloud = system.cloud();
  const Parts& parts = system.material().parts();
  if (has_cracks(c))
    c.root().refuse("stress", "the cross-section of a cracked body does not stay plane", "leave [stress] out");
  from = place_of(table, "from", cloud);
  const Vec3 to = place_of(table, "to", cloud);
  if (from == to) table.refuse("to", "the line ends where it begins", "give the two faces of the body");
  thickness = norm(to - from);
  along = (1 / thickness) * (to - from);
  kinematics = read_kinematics(table, cloud, along);
  // Towards x, or y where the line goes along x.
  outwards = std::abs(along.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  outwards -= dot(outwards, along) * along;
  outwards *= 1 / norm(outwards);

  const bool is_disc = kinematics->components.size() > 1;
  const int pieces_a_part =
      std::clamp(static_cast<int>(std::ceil(thickness / finest_spacing(cloud))), 4, is_disc ? 8 : 256);
  const std::vector<int> tags = tags_at(cloud, std::array{from, to});
  for (const auto& [radius, w] : kinematics->radii()) add_line(parts, radius, w, tags[0], tags[1], pieces_a_part);

  try {
    line = std::make_unique<Probes>(cloud, std::vector<std::string>(x.size(), "on the line of [stress]"), x,
                                    &system.dofs(), &parts);
  } catch (const Error& e) {
    throw Error(e.fault(), table.location("to"), e.problem(), e.cure());
  }
  const ElasticRule& rule = elastic_rules().chosen(table, "mix");
  const double free_at = table.number("free_at");
  const auto elasticity = [&](std::span<const Vec3> places, std::span<const int> tag) {
    return std::make_unique<Elasticity>(c, cloud.comm, system.material(), places, tag, rule, free_at);
  };
  points = cloud.owned_points(), probe_places = probes.places();
  of_section = elasticity(x, tags_at(cloud, x));
  of_points = elasticity(points, std::span(cloud.tag).first(cloud.owned));
  of_probes = elasticity(probe_places, tags_at(cloud, probe_places));
}

std::vector<double> ThermalStress::Impl::stress(const Deformation& deformation, std::size_t component,
                                                const Elasticity& elasticity, std::span<const Vec3> places,
                                                std::span<const double> T) const {
  const ElasticState state = elasticity.at(T);
  std::vector<double> out(places.size(), 0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [s_here, r_here] = s_and_r(places[i]);
    const Eigen::Matrix2d D = kinematics->stiffness(state.E[i], state.nu[i]);
    for (std::size_t other = 0; other < kinematics->components.size(); ++other)
      out[i] += D(static_cast<int>(component), static_cast<int>(other)) *
                (kinematics->strain(other, s_here, r_here).times(deformation.d) - state.thermal_strain[i]);
  }
  return out;
}

/// Of sign times a stress over the section; between its places it is that of the parabola through three of them.
double ThermalStress::Impl::largest(std::span<const double> of_section, double sign) const {
  const auto f = [&](std::size_t i) { return sign * of_section[i]; };
  double largest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < of_section.size(); ++i) {
    largest = std::max(largest, f(i));
    if (i == 0 || i + 1 == of_section.size() || f(i) < f(i - 1) || f(i) < f(i + 1)) continue;
    // Parts and lines end in two places that are next to each other.
    const double below = s[i] - s[i - 1], above = s[i + 1] - s[i], apart = 1e-6 * thickness;
    if (below < apart || above < apart) continue;
    const double slope_below = (f(i) - f(i - 1)) / below, slope_above = (f(i + 1) - f(i)) / above;
    const double curvature = (slope_above - slope_below) / (below + above), slope = slope_below + curvature * below;
    if (curvature < 0) largest = std::max(largest, f(i) - slope * slope / (4 * curvature));
  }
  return largest;
}

ThermalStress::ThermalStress(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ThermalStress::~ThermalStress() = default;

std::shared_ptr<const ThermalStress> ThermalStress::make(const Case& c, const HeatSystem& system,
                                                         const Probes& probes) {
  if (!c.root().has("stress")) return nullptr;
  return std::shared_ptr<const ThermalStress>(new ThermalStress(std::make_unique<Impl>(c, system, probes)));
}

const std::vector<std::string>& ThermalStress::components() const { return impl_->kinematics->components; }
std::span<const double> ThermalStress::s() const { return impl_->s; }
std::span<const double> ThermalStress::r() const { return impl_->r; }

/// The deformation of least energy: sum of weight (strain - thermal strain) D (strain - thermal strain).
Deformation ThermalStress::deformation(std::span<const double> u) const {
  const Impl& p = *impl_;
  Deformation out;
  out.T = p.line->temperatures(u);
  const ElasticState state = p.of_section->at(out.T);
  const auto n = static_cast<int>(p.kinematics->is_fixed.size());
  const std::size_t components = p.kinematics->components.size();
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < p.x.size(); ++i) {
    if (p.weight[i] == 0) continue;
    const Eigen::Matrix2d D = p.weight[i] * p.kinematics->stiffness(state.E[i], state.nu[i]);
    std::array<StrainRow, 2> row;
    for (std::size_t a = 0; a < components; ++a) row[a] = p.kinematics->strain(a, p.s[i], p.r[i]);
    for (std::size_t a = 0; a < components; ++a)
      for (std::size_t b = 0; b < components; ++b) {
        const double D_ab = D(static_cast<int>(a), static_cast<int>(b));
        for (int k = 0; k < row[a].count; ++k) {
          const double test = row[a].value[k] * D_ab;
          f[row[a].dof[k]] += test * state.thermal_strain[i];
          for (int m = 0; m < row[b].count; ++m) K(row[a].dof[k], row[b].dof[m]) += test * row[b].value[m];
        }
      }
  }
  for (int d = 0; d < n; ++d)
    if (p.kinematics->is_fixed[d]) K.row(d).setZero(), K.col(d).setZero(), K(d, d) = 1, f[d] = 0;
  // Displacements and slopes differ by a length: scaled, all diagonal entries are 1.
  const Eigen::VectorXd scale = K.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::VectorXd d =
      scale.cwiseProduct((scale.asDiagonal() * K * scale.asDiagonal()).ldlt().solve(scale.cwiseProduct(f)));
  out.d.assign(d.begin(), d.end());
  std::tie(out.strain, out.curvature) = p.kinematics->middle(out.d, p.thickness);
  out.lowest = std::numeric_limits<double>::infinity(), out.highest = -out.lowest;
  for (std::size_t a = 0; a < components; ++a) {
    out.stress.push_back(p.stress(out, a, *p.of_section, p.x, out.T));
    out.lowest = std::min(out.lowest, -p.largest(out.stress.back(), -1));
    out.highest = std::max(out.highest, p.largest(out.stress.back(), 1));
  }
  return out;
}

std::vector<double> ThermalStress::at_points(const Deformation& d, std::size_t component,
                                             std::span<const double> T) const {
  return impl_->stress(d, component, *impl_->of_points, impl_->points, T);
}

std::vector<double> ThermalStress::at_probes(const Deformation& d, std::size_t component,
                                             std::span<const double> T) const {
  return impl_->stress(d, component, *impl_->of_probes, impl_->probe_places, T);
}

void declare_stress(Schema& schema) {
  const ElasticRule* first = &*elastic_rules().begin();
  schema.add(
      {.path = "stress",
       .sentence = "Thermal stress of a thin body whose cross-sections stay plane (docs/thermal-stress.md): fields, "
                   "stress.csv over time, section.csv at the end.",
       .keys = {{"body",
                 Kind::choice,
                 "",
                 required,
                 "What the body is. beam: stress along it alone; plate: alike in all directions of its plane; disc: "
                 "round, with a radius. The temperature of beam and plate varies along the line alone, that of a disc "
                 "also with the distance from it.",
                 {"beam", "plate", "disc"}},
                {"from", Kind::quantities, "m", required,
                 "Where the line through the thickness begins; of a disc on its axis."},
                {"to", Kind::quantities, "m", required, "Where it ends, on the other face."},
                {"radius", Kind::quantity, "m", optional, "Radius of a disc."},
                {"support",
                 Kind::choice,
                 "",
                 "free",
                 "free: it lengthens and bends; flat: it lengthens and cannot bend; clamped: its edge does not move.",
                 {"free", "flat", "clamped"}},
                {"free_at", Kind::quantity, "K", required, "Temperature at which there is no stress."},
                {"mix", Kind::choice, "", first->name,
                 "Elastic constants of mixtures from those of their phases; pores have no stiffness." +
                     elastic_rules().sentences(),
                 elastic_rules().names()}}});
  declare_elasticity(schema);
}

}  // namespace calor
