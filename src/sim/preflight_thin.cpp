/// Parts of bodies that have too few cells through their thickness to bend.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "bc/piece_bins.hpp"
#include "sim/advice.hpp"
#include "sim/preflight.hpp"
#include "sim/surfaces.hpp"

namespace berm {
namespace {

/// A linear element as long as it is high is 1 + 1/2 times too stiff in bending (Cook, Malkus, Plesha: parasitic shear, nu = 0);
/// n of them through the thickness, of which each has 1/n^2 of the bending stiffness by itself, 1 + 1/(2 n^2) times.
/// Triangles and tetrahedra, whose strain is constant: 1 + 3.5/n^2 (measured on the halves of squares, n = 2, 4, 8).
struct Bending {
  double enough;  ///< cells, for 3 %
  double excess;  ///< of the stiffness, of one cell
};
Bending bending_of(const World& w) { return is_simplex(w.discretisation->mesh().kinds[0]) ? Bending{10.0, 3.5} : Bending{4.0, 0.5}; }
constexpr double slender = 5.0;  ///< lengths of a thickness

/// Through the body at a piece of its surface, to a parallel piece; infinite if there is none within reach.
double thickness_at(const SurfacePoint& s, const std::vector<SurfacePoint>& surface, const PieceBins& bins, double reach) {
  constexpr double parallel = 0.996, beside = 0.75;  // cosine of 5 degrees; lengths of a piece
  double thickness = infinity;
  bins.for_near(s.X, [&](int k) {
    const SurfacePoint& t = surface[k];
    if (t.body != s.body || -t.normal.dot(s.normal) < parallel) return;
    const Vec3 way = t.X - s.X;
    const double through = -way.dot(s.normal);
    if (through > 0.0 && through < reach && (way + through * s.normal).norm() <= beside * std::max(s.size, t.size))
      thickness = std::min(thickness, through);
  });
  return thickness;
}

/// Pieces from which to look: of those of one body that face alike, one in every cube. All of a surface that is much finer than
/// the cells would look at each other (160000 triangles: 4 minutes).
std::vector<const SurfacePoint*> viewpoints(const std::vector<SurfacePoint>& surface, double width) {
  std::set<std::tuple<int, Cube, int>> seen;  // body, cube, side
  std::vector<const SurfacePoint*> chosen;
  for (const SurfacePoint& s : surface) {
    int axis = 0;
    const double along = s.normal.cwiseAbs().maxCoeff(&axis);
    const int side = 2 * axis + (s.normal[axis] == along);
    if (seen.insert({s.body, cube_of(s.X, width), side}).second) chosen.push_back(&s);
  }
  return chosen;
}

/// Of a cell along a direction [m].
double width_along(const World& w, const Vec3& direction) {
  const auto* grid = std::get_if<StructuredGrid>(&w.spec.grid);
  if (w.spec.method == Method::fem || !grid) return w.discretisation->cell_size();
  const Mat3 own = Eigen::AngleAxisd(-grid->angle, Vec3::UnitZ()).toRotationMatrix();
  return 1.0 / (own * direction).cwiseQuotient(grid->cell_size).head(w.spec.dimension()).norm();
}

/// Or its cells are not known one by one: in FEM of several bodies.
bool bends_as_it_should(const World& w, int body) {
  const Case& c = w.spec;
  if (c.method == Method::fem) return c.bodies[body].mesh.order == 2 || c.bodies.size() > 1;
  if (!std::holds_alternative<StructuredGrid>(c.grid)) return true;
  return c.shape_functions == ShapeFunctions::quadratic_bspline || c.shape_functions == ShapeFunctions::cubic_bspline || c.shape_functions == ShapeFunctions::b2gimp;
}

/// As far as they matter here: a few long elements, along a thin bar, would have its whole surface looked at from everywhere.
double width_of_cells(const World& w, const std::vector<SurfacePoint>& surface) {
  const double longer = 2.0 * surface_points_per_cell(w.spec);
  const double longest = longest_edge(w.discretisation->mesh());
  if (w.spec.method == Method::mpm || surface.empty()) return longest;
  std::vector<double> sizes;
  for (const SurfacePoint& s : surface) sizes.push_back(s.size);
  const auto middle = sizes.begin() + sizes.size() / 2;
  std::nth_element(sizes.begin(), middle, sizes.end());
  return std::min(longest, longer * *middle);
}

/// A place where a body is thin.
struct Thin {
  Vec3 at, normal;
  double thickness, cells;
};

/// A slice between planes of symmetry does not bend: most of it is held on both sides. Collective.
bool is_slice(const World& w, const std::vector<const Thin*>& part) {
  constexpr double along = 0.99;
  constexpr std::size_t samples = 20;
  const double reach = longest_edge(w.discretisation->mesh());
  const std::vector<BoundaryConditions::Hold> holds = w.boundary->holds(*w.discretisation);
  const auto is_held = [&](const Vec3& side, const Vec3& normal) {
    return w.comm.any(std::any_of(holds.begin(), holds.end(), [&](const BoundaryConditions::Hold& hold) {
      return std::abs(hold.direction.dot(normal)) > along && (hold.at - side).norm() < reach;
    }));
  };
  std::size_t looked_at = 0, held = 0;
  for (std::size_t k = 0; k < part.size(); k += 1 + part.size() / samples) {
    const Vec3 half = 0.5 * part[k]->thickness * part[k]->normal;
    const bool first = is_held(part[k]->at + half, part[k]->normal), second = is_held(part[k]->at - half, part[k]->normal);
    ++looked_at, held += first && second;
  }
  return 2 * held > looked_at;
}

}  // namespace

void note_thin_parts(World& w, const std::vector<SurfacePoint>& surface) {
  const auto [enough, excess] = bending_of(w);
  const double width = width_of_cells(w, surface), reach = enough * width;
  const double between = 0.5 / surface_points_per_cell(w.spec);  // every piece that was cut to fit the cells is a viewpoint
  const PieceBins bins(surface, reach);
  std::vector<std::vector<Thin>> thin(w.spec.bodies.size());
  for (const SurfacePoint* s : viewpoints(surface, between * width)) {
    if (bends_as_it_should(w, s->body)) continue;
    const double thickness = thickness_at(*s, surface, bins, reach), cells = thickness / width_along(w, s->normal);
    if (cells < enough - 0.01) thin[s->body].push_back({s->X - 0.5 * thickness * s->normal, s->normal, thickness, cells});
  }
  for (std::size_t b = 0; b < thin.size(); ++b) {
    if (thin[b].empty()) continue;
    std::vector<Vec3> places;
    for (const Thin& t : thin[b]) places.push_back(t.at);
    const BodyParts parts(places, reach);
    std::vector<std::vector<const Thin*>> of_part(parts.count());
    for (const Thin& t : thin[b]) of_part[parts.of(t.at)].push_back(&t);
    for (const std::vector<const Thin*>& part : of_part) {
      if (part.empty()) continue;
      Vec3 low = Vec3::Constant(infinity), high = -low;
      for (const Thin* t : part) low = low.cwiseMin(t->at), high = high.cwiseMax(t->at);
      const Thin* thinnest = *std::min_element(part.begin(), part.end(), [](const Thin* s, const Thin* t) { return s->cells < t->cells; });
      const double length = (high - low).norm();
      if (length < slender * thinnest->thickness || is_slice(w, part)) continue;
      w.thin_parts.push_back(fmt::format("body {} is {:.3g} cells thick near {} ({:.4g} m, over {:.4g} m): where it bends, linear functions make it about {:.0f} % too "
                                    "stiff; {:.0f} cells, or quadratic functions, do not",
                                    w.spec.bodies[b].name, thinnest->cells, place_text(w.spec, thinnest->at), thinnest->thickness, length,
                                    100.0 * excess / std::pow(thinnest->cells, 2), enough));
    }
  }
}

}  // namespace berm
