#include "conduction/faces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace calor {

namespace {

constexpr double pi = std::numbers::pi;

/// Gauss-Legendre on [0, 1].
struct Rule {
  std::vector<double> x, w;
};

Rule gauss(int n) {
  Rule rule{std::vector<double>(n), std::vector<double>(n)};
  for (int k = 0; k < n; ++k) {
    double x = std::cos(pi * (k + 0.75) / (n + 0.5)), slope = 1;
    for (int step = 0; step < 8; ++step) {  // Newton on the Legendre polynomial
      double p = 1, before = 0;
      for (int m = 1; m <= n; ++m) {
        const double next = ((2 * m - 1) * x * p - (m - 1) * before) / m;
        before = p, p = next;
      }
      slope = n * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    rule.x[k] = 0.5 * (1 - x);
    rule.w[k] = 1 / ((1 - x * x) * slope * slope);
  }
  return rule;
}

/// Calls use(direction, share of the surface) for a quarter or half circle, or the whole one.
template <class Use>
void for_each_direction_2d(const std::array<int, 3>& side, const Use& use) {
  constexpr int whole = 12;
  if (side[0] == 0 && side[1] == 0) {
    for (int k = 0; k < whole; ++k) {
      const double angle = 2 * pi * (k + 0.5) / whole;
      use(Vec3{std::cos(angle), std::sin(angle)}, 2 * pi / whole);
    }
    return;
  }
  const bool corner = side[0] != 0 && side[1] != 0;
  const double span = corner ? pi / 2 : pi;
  const Rule rule = gauss(corner ? whole / 4 + 1 : whole / 2 + 1);
  const double middle = std::atan2(side[1], side[0]);
  for (std::size_t k = 0; k < rule.x.size(); ++k) {
    const double angle = middle + span * (rule.x[k] - 0.5);
    use(Vec3{std::cos(angle), std::sin(angle)}, span * rule.w[k]);
  }
}

template <class Use>
void for_each_direction_3d(const std::array<int, 3>& side, int points, const Use& use) {
  const Rule rule = gauss(points);
  for (int octant = 0; octant < 8; ++octant) {
    const std::array<int, 3> sign = {octant & 1 ? 1 : -1, octant & 2 ? 1 : -1, octant & 4 ? 1 : -1};
    bool inside = true;
    for (int a = 0; a < 3; ++a) inside = inside && side[a] != -sign[a];
    if (!inside) continue;
    for (int m = 0; m < points; ++m) {
      for (int n = 0; n < points; ++n) {
        const double z = rule.x[m], r = std::sqrt(1 - z * z), angle = 0.5 * pi * rule.x[n];
        use(Vec3{sign[0] * r * std::cos(angle), sign[1] * r * std::sin(angle), sign[2] * z},
            0.5 * pi * rule.w[m] * rule.w[n]);
      }
    }
  }
}

/// On which side of point i the body lies, per axis: 0 both.
std::array<int, 3> sides(const Cloud& cloud, int i) {
  std::array<int, 3> side = {};
  for (std::size_t f = 0; f < cloud.faces.size(); ++f)
    if (cloud.on_faces[i] >> f & 1) side[cloud.faces[f][0] - 'x'] = cloud.faces[f].ends_with("min") ? 1 : -1;
  return side;
}

void require_box(const Cloud& cloud) {
  const auto is_wall = [](const std::string& face) {
    return face.size() == 4 && face[0] >= 'x' && face[0] <= 'z' && (face.ends_with("min") || face.ends_with("max"));
  };
  if (cloud.dimension == 1 || !std::ranges::all_of(cloud.faces, is_wall))
    throw Error(Fault::bad_case, "circles and spheres are made for boxes of two or three dimensions only",
                "use subdomain = \"tiles\", which fill any body");
}

}  // namespace

UnitSphere unit_sphere(int dimension, const std::array<int, 3>& side) {
  UnitSphere out;
  const auto on = [&](const Vec3& n, double w) {
    out.on.push_back(n);
    out.area.push_back(w);
  };
  const Rule radial = gauss(2);
  const auto inside = [&](const Vec3& n, double w) {
    for (int k = 0; k < 2; ++k) {
      out.inside.push_back(radial.x[k] * n);
      out.volume.push_back(w * radial.w[k] * std::pow(radial.x[k], dimension - 1));
    }
  };
  if (dimension == 2) {
    for_each_direction_2d(side, on);
    for_each_direction_2d(side, inside);
  } else {
    for_each_direction_3d(side, 4, on);
    for_each_direction_3d(side, 3, inside);
  }
  return out;
}

Subdomains sphere_subdomains(const Cloud& cloud, double radius) {
  require_box(cloud);
  const int D = cloud.dimension;
  Vec3 low, high;
  for (int a = 0; a < D; ++a) {
    low[a] = std::numeric_limits<double>::max(), high[a] = -low[a];
    for (int i = 0; i < cloud.owned; ++i)
      low[a] = std::min(low[a], cloud.x[i][a]), high[a] = std::max(high[a], cloud.x[i][a]);
    low[a] = min(cloud.comm, low[a]), high[a] = max(cloud.comm, high[a]);
  }
  std::vector<double> boundary(cloud.owned);
  for (const Facet& p : cloud.facets) boundary[p.point] += p.area;

  Subdomains out;
  for (int i = 0; i < cloud.owned; ++i) {
    const Vec3& x = cloud.x[i];
    const auto side = sides(cloud, i);
    const Vec3& s = cloud.metric[i];
    const double stretch = (D == 2 ? s.x * s.y : s.x * s.y * s.z) * cloud.cross_section;
    double R = radius, walls = 0, share = 1;
    for (int a = 0; a < D; ++a) {
      if (side[a] <= 0) R = std::min(R, (x[a] - low[a]) / s[a]);
      if (side[a] >= 0) R = std::min(R, (high[a] - x[a]) / s[a]);
      if (side[a] == 0) continue;
      share *= 0.5, walls += 2 / s[a];  // of the whole circle's section by the wall, halved by other walls
    }
    const UnitSphere sphere = unit_sphere(D, side);
    const double section = walls * share * (D == 2 ? 2 * R : pi * R * R) * stretch;
    const double whole = share * (D == 2 ? pi * R * R : 4 * pi / 3 * R * R * R) * stretch;
    const double scale = walls > 0 ? boundary[i] / section : cloud.volume[i] / whole;
    const double area = scale * std::pow(R, D - 1) * stretch, volume = area * R;
    for (std::size_t q = 0; q < sphere.on.size(); ++q) {
      out.faces.x.push_back(x + R * product(s, sphere.on[q]));
      out.faces.area.push_back(area * sphere.area[q] * quotient(sphere.on[q], s));
      out.faces.a.push_back(i);
      out.faces.b.push_back(-1);
    }
    for (std::size_t q = 0; q < sphere.inside.size(); ++q) {
      out.cells.x.push_back(x + R * product(s, sphere.inside[q]));
      out.cells.tag.push_back(cloud.tag[i]);
      out.cells.volume.push_back(volume * sphere.volume[q]);
    }
    out.cells.cell.push_back(static_cast<std::int64_t>(out.cells.x.size()));
  }
  return out;
}

}  // namespace calor
