#include "conduction/wall_layers.hpp"

#include "base/parallel.hpp"
#include "conduction/fibres.hpp"
#include "conduction/pair_directions.hpp"

namespace calor {

WallLayers::WallLayers(const Cloud& cloud, const Parts& parts, std::span<const Symmetric3> R)
    : runs_(cloud.facets.size()) {
  const auto add_piece = [&](const Facet& facet, const Fibre& f, double begin, const SegmentPiece& piece, Run& run) {
    const Vec3 way = f.segment.b - f.segment.a;
    const double length = (piece.end - begin) * norm(way);
    run.pieces.push_back({.end = static_cast<std::int32_t>(ends_.x.size()),
                          .length = R.empty() ? length : length / along(R[piece.part], facet.normal)});
    ends_.x.push_back(f.segment.a + 0.5 * (begin + piece.end) * way);
    ends_.tag.push_back(f.segment.tag_a);
    ends_.part.push_back(piece.part);
    ends_.phi.column.push_back(facet.point);
    ends_.phi.value.push_back(1);
    ends_.phi.close_row();
  };
  collective_try(cloud.comm, [&] {
    const auto fibres = fibres_to_walls(cloud, parts);
    for (std::size_t n = 0; n < fibres.size(); ++n) {
      for (const Fibre& f : fibres[n]) {
        Run& run = runs_[n].emplace_back();
        run.area = f.share * cloud.facets[n].area;
        double begin = 0;
        for (std::size_t p = 0; p < f.run.size(); ++p) {
          if (const Function* h = p > 0 ? parts.contact(f.run[p - 1].part, f.run[p].part) : nullptr)
            throw Error(Fault::bad_case, h->location(), "this contact lies between a wall and the points beside it",
                        "take at = \"walls\" in [cloud], or smaller spacings, so that both of its sides hold points");
          if (f.run[p].end > begin) add_piece(cloud.facets[n], f, begin, f.run[p], run);
          begin = f.run[p].end;
        }
      }
    }
  });
}

double WallLayers::Run::resistance(std::span<const double> k) const {
  double r = 0;
  for (const Piece& p : pieces) r += p.length / k[p.end];
  return r;
}

double WallLayers::conductance(int facet, std::span<const double> k) const {
  double G = 0;
  for (const Run& run : runs_[facet]) G += run.area / run.resistance(k);
  return G;
}

double WallLayers::derivative(int facet, std::span<const double> k, std::span<const double> dk_dT) const {
  double dG = 0;
  for (const Run& run : runs_[facet]) {
    const double r = run.resistance(k);
    for (const Piece& p : run.pieces) dG += run.area / (r * r) * p.length * dk_dT[p.end] / (k[p.end] * k[p.end]);
  }
  return dG;
}

std::unique_ptr<WallLayers> layers_before_walls(const Cloud& cloud, const Parts& parts, std::span<const Symmetric3> R) {
  if (cloud.points_on_walls || !cloud.lattice || parts.count() == 1) return nullptr;
  return std::make_unique<WallLayers>(cloud, parts, R);
}

}  // namespace calor
