#include <fmt/format.h>
#include <gmsh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.hpp"
#include "mesh/boundary_curve.hpp"
#include "mesh/box_mesh.hpp"
#include "mesh/gmsh.hpp"
#include "mesh/gmsh_model.hpp"
#include "mesh/shape_bounds.hpp"
#include "mesh/solid_mesh.hpp"

namespace berm {

namespace {

namespace geo = gmsh::model::geo;

/// Points and lines of one side, appended to the loop; arcs in pieces of at most a quarter (Gmsh takes the shorter
/// way). `first` and `last` are Gmsh's tags of the side's ends.
void add_side(const BoundaryCurve& side, int first, int last, std::vector<int>& lines) {
  if (!side.arc) {
    lines.push_back(geo::addLine(first, last));
    return;
  }
  const int centre = geo::addPoint(side.centre.x(), side.centre.y(), 0.0);
  const int n = std::max(1, static_cast<int>(std::ceil(std::abs(side.sweep) / (0.5 * std::acos(-1.0)) - 1e-9)));
  for (int i = 0, from = first; i < n; ++i) {
    const Vec2 x = side.point((i + 1.0) / n);
    const int to = i + 1 < n ? geo::addPoint(x.x(), x.y(), 0.0) : last;
    lines.push_back(geo::addCircleArc(from, centre, to));
    from = to;
  }
}

int add_loop(const std::vector<BoundaryCurve>& loop) {
  std::vector<int> corners, lines;
  for (const BoundaryCurve& side : loop) {
    const Vec2 x = side.point(0.0);
    corners.push_back(geo::addPoint(x.x(), x.y(), 0.0));
  }
  for (std::size_t i = 0; i < loop.size(); ++i) add_side(loop[i], corners[i], corners[(i + 1) % loop.size()], lines);
  return geo::addCurveLoop(lines);
}

double signed_area(const Ring& ring) {
  double twice = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 a = ring[i] - ring[0], b = ring[(i + 1) % ring.size()] - ring[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

/// Hands the shape's true boundary to Gmsh: the booleans are ours (those of Gmsh 4.8 lose track of unified parts).
void build(const ShapeRings& shape) {
  const std::vector<std::vector<BoundaryCurve>> loops = boundary_loops(shape);
  for (std::size_t i = 0; i < loops.size();) {  // every outer ring is followed by its holes
    std::vector<int> tags = {add_loop(loops[i])};
    for (++i; i < loops.size() && signed_area(shape.rings[i]) < 0.0; ++i) tags.push_back(add_loop(loops[i]));
    geo::addPlaneSurface(tags);
  }
  geo::synchronize();
}

/// Gmsh's numbers for Mesh.Algorithm and Mesh.RecombinationAlgorithm. Its frontal algorithm for quads (8) crashes in
/// version 4.8, so quads are made from frontal (6) or Delaunay (5) triangles: matched in pairs on a mesh of twice the
/// size, then each cell is split in four (3: matching by Blossom, 2: simple matching). Only this leaves no triangles.
struct Recipe {
  int algorithm, recombination;
};

/// Generates the mesh of the shape with edges of about `size`. No value: triangles are left in a mesh of quads.
std::optional<Mesh> generate_mesh(const ShapeRings& shape, const BodyMeshOptions& options, const Recipe& recipe,
                                  double size, const std::string& subject) {
  const bool quads = options.kind == BodyMeshKind::quads;
  const std::pair<const char*, double> settings[] = {
      {"Mesh.MeshSizeMin", size},
      {"Mesh.MeshSizeMax", size},
      {"Mesh.MeshSizeFromPoints", 0},
      {"Mesh.MeshSizeFromCurvature", 0},
      {"Mesh.MeshSizeExtendFromBoundary", 0},
      {"Mesh.Algorithm", recipe.algorithm},
      {"Mesh.RecombineAll", quads},
      {"Mesh.RecombinationAlgorithm", recipe.recombination},
      {"Mesh.ElementOrder", options.order},
      {"Mesh.SecondOrderIncomplete", 1},
      {"Mesh.RandomSeed", 1},
  };
  gmsh::clear();
  for (const auto& [name, value] : settings) gmsh::option::setNumber(name, value);
  gmsh::model::add("body");
  build(shape);
  gmsh::model::mesh::generate(2);
  Mesh mesh = current_gmsh_mesh(subject);
  const bool triangles_left =
      std::any_of(mesh.kinds.begin(), mesh.kinds.end(), [](CellKind k) { return corners_of(k) == 3; });
  if (quads && triangles_left) return std::nullopt;
  return mesh;
}

double worst_corner(const Mesh& mesh) {
  double worst = std::numeric_limits<double>::infinity();
  for (int c = 0; c < mesh.n_cells(); ++c) worst = std::min(worst, smallest_corner_jacobian(mesh, c));
  return worst;
}

/// Full-quad recombination makes about a quarter more cells than area / size^2: a second pass corrects the size.
std::optional<Mesh> generate_quads(const ShapeRings& shape, const BodyMeshOptions& options, const Recipe& recipe,
                                   double area, const std::string& subject) {
  try {
    const std::optional<Mesh> trial = generate_mesh(shape, options, recipe, options.size, subject);
    if (!trial) return trial;
    const double ratio = std::sqrt(trial->n_cells() * options.size * options.size / area);
    return generate_mesh(shape, options, recipe, options.size * std::clamp(ratio, 0.8, 1.5), subject);
  } catch (const InputError&) {  // a degenerate cell: the next recipe may do without
    return std::nullopt;
  }
}

Mesh best_quads(const ShapeRings& shape, const BodyMeshOptions& options, double area, const std::string& subject) {
  constexpr double good = 0.5, acceptable = 0.2;  // sine of the sharpest corner
  std::optional<Mesh> best;
  double best_corner = acceptable;
  for (const Recipe& recipe : {Recipe{6, 3}, Recipe{6, 2}, Recipe{5, 2}, Recipe{5, 3}}) {
    std::optional<Mesh> mesh = generate_quads(shape, options, recipe, area, subject);
    if (!mesh) continue;
    const double corner = worst_corner(*mesh);
    if (corner <= best_corner) continue;
    best_corner = corner;
    best = std::move(mesh);
    if (corner >= good) break;
  }
  if (!best)
    throw InputError(
        fmt::format("{}: no good mesh of quads was found (take a smaller size, or kind = \"triangles\")", subject));
  return std::move(*best);
}

Mesh mesh_plane_shape(const PlaneShape& shape, const BodyMeshOptions& options) {
  if (options.kind != BodyMeshKind::quads && options.kind != BodyMeshKind::triangles)
    throw InputError("mesh: hexahedra and tetrahedra are for solid shapes (a plane one takes quads or triangles)");
  if (options.structured) {
    if (const Disc* disc = std::get_if<Disc>(&shape.form)) return mesh_disc(*disc, options);
    if (only_boxes(shape)) return mesh_boxes(shape, options);
    throw InputError("mesh: a structured mesh needs a disc or a shape that is made of boxes only");
  }
  const ShapeRings rings = evaluate_shape(shape, 720);
  double area = 0.0;
  for (const Ring& ring : rings.rings) area += signed_area(ring);
  if (area / (options.size * options.size) > 2e6)
    throw InputError(fmt::format("mesh: size {:g} m gives too many cells (more than two million)", options.size));
  const std::string subject = fmt::format("mesh of size {:g} m", options.size);
  return with_gmsh(subject, [&] {
    if (options.kind == BodyMeshKind::quads) return best_quads(rings, options, area, subject);
    return *generate_mesh(rings, options, {6, 0}, options.size, subject);
  });
}

}  // namespace

Mesh mesh_shape(const Shape& shape, const BodyMeshOptions& options) {
  if (!(options.size > 0.0)) throw InputError(fmt::format("mesh: size {:g} m (it must be positive)", options.size));
  if (options.order != 1 && options.order != 2)
    throw InputError(fmt::format("mesh: order {} (1 and 2 are possible)", options.order));
  constexpr double tell_apart = 1e12;  // Gmsh ends the process where its points fall together
  const SolidBox around = bounds_of(shape);
  const double farthest = std::max(around.min.cwiseAbs().maxCoeff(), around.max.cwiseAbs().maxCoeff());
  if (!(farthest < tell_apart * options.size))
    throw InputError(fmt::format("mesh: the body reaches {:.3g} m from the corner of the grid, or from the origin: no cells of {:g} m there", farthest, options.size));
  if (const PlaneShape* plane = std::get_if<PlaneShape>(&shape)) return mesh_plane_shape(*plane, options);
  return mesh_solid_shape(std::get<SolidShape>(shape), options);
}

bool has_structured_mesh(const Shape& shape) {
  if (const PlaneShape* plane = std::get_if<PlaneShape>(&shape))
    return std::holds_alternative<Disc>(plane->form) || only_boxes(*plane);
  const SolidShape& solid = std::get<SolidShape>(shape);
  return std::holds_alternative<Cylinder>(solid.form) || only_boxes(solid);
}

}  // namespace berm
