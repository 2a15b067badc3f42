#include "mesh/solid_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.hpp"
#include "mesh/box_mesh.hpp"
#include "mesh/gmsh_solid.hpp"

namespace berm {

namespace {

using Lines = std::array<std::vector<double>, 3>;  ///< coordinates of mesh planes by direction
using Index = std::array<int, 3>;

/// Corners of a cell by direction, in VTK order.
constexpr int corner_bit[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                  {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

/// Collects cells of a lattice of planes; nodes are added on first use.
class LatticeMesh {
public:
  LatticeMesh(const Lines& lines, BodyMeshKind kind) : lines_(lines), kind_(kind) {
    number_.assign(lines[0].size() * lines[1].size() * lines[2].size(), -1);
  }

  void add(const Index& cell) {
    std::array<int, 8> cube;
    for (int c = 0; c < 8; ++c) cube[c] = node(corner(cell, c, {0, 0, 0}));
    if (kind_ == BodyMeshKind::hexahedra) {
      mesh_.add_cell(CellKind::hex8, cube.data());
      return;
    }
    // Cells with an odd index are mirrored: diagonals of neighbours meet, and the mesh is symmetric.
    const Index mirror = {cell[0] % 2, cell[1] % 2, cell[2] % 2};
    const bool turned = (mirror[0] + mirror[1] + mirror[2]) % 2 == 1;
    for (int c = 0; c < 8; ++c) cube[c] = node(corner(cell, c, mirror));
    for (const auto& t : kuhn_tetrahedra) {
      const int tetrahedron[4] = {cube[t[0]], cube[t[turned ? 2 : 1]], cube[t[turned ? 1 : 2]], cube[t[3]]};
      mesh_.add_cell(CellKind::tet4, tetrahedron);
    }
  }

  Mesh take() { return std::move(mesh_); }

private:
  static Index corner(const Index& cell, int c, const Index& mirror) {
    Index at;
    for (int d = 0; d < 3; ++d) at[d] = cell[d] + (corner_bit[c][d] ^ mirror[d]);
    return at;
  }

  int node(const Index& i) {
    int& number = number_[(i[2] * lines_[1].size() + i[1]) * lines_[0].size() + i[0]];
    if (number < 0) {
      number = mesh_.n_nodes();
      mesh_.nodes.emplace_back(lines_[0][i[0]], lines_[1][i[1]], lines_[2][i[2]]);
    }
    return number;
  }

  const Lines& lines_;
  BodyMeshKind kind_;
  Mesh mesh_;
  std::vector<int> number_;
};

/// Cells of the lattice whose centres the predicate accepts.
template <class Inside>
Mesh mesh_lattice(const Lines& lines, const BodyMeshOptions& options, Inside inside) {
  LatticeMesh lattice(lines, options.kind);
  const auto cells = [&](int d) { return static_cast<int>(lines[d].size()) - 1; };
  const auto middle = [&](int d, int i) { return 0.5 * (lines[d][i] + lines[d][i + 1]); };
  for (int k = 0; k < cells(2); ++k)
    for (int j = 0; j < cells(1); ++j)
      for (int i = 0; i < cells(0); ++i)
        if (inside(Vec3(middle(0, i), middle(1, j), middle(2, k)))) lattice.add({i, j, k});
  Mesh mesh = lattice.take();
  return options.order == 2 ? with_mid_sides(mesh) : mesh;
}

void check_count(double cells, double size) {
  if (!(cells < 2e7))
    throw InputError(fmt::format("mesh: size {:g} m gives too many cells (more than twenty million)", size));
}

void collect_boxes(const SolidShape& shape, std::vector<SolidBox>& boxes) {
  if (const SolidBox* box = std::get_if<SolidBox>(&shape.form)) {
    if (!((box->max - box->min).minCoeff() > 0.0))
      throw InputError(fmt::format("mesh: the box from ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}) has no volume",
                                   box->min.x(), box->min.y(), box->min.z(), box->max.x(), box->max.y(), box->max.z()));
    boxes.push_back(*box);
  } else {
    for (const SolidShape& part : std::get<SolidCombination>(shape.form).parts) collect_boxes(part, boxes);
  }
}

bool inside_boxes(const SolidShape& shape, const Vec3& x) {
  if (const SolidBox* box = std::get_if<SolidBox>(&shape.form))
    return (x - box->min).minCoeff() >= 0.0 && (box->max - x).minCoeff() >= 0.0;
  const SolidCombination& combination = std::get<SolidCombination>(shape.form);
  const auto holds = [&](const SolidShape& part) { return inside_boxes(part, x); };
  const auto begin = combination.parts.begin(), end = combination.parts.end();
  if (combination.kind == SolidCombination::Kind::join) return std::any_of(begin, end, holds);
  return begin != end && holds(*begin) && std::none_of(begin + 1, end, holds);
}

/// A box that the shape lies in: boxes that are only taken away do not count.
void extend(const SolidShape& shape, Vec3& low, Vec3& high) {
  if (const SolidBox* box = std::get_if<SolidBox>(&shape.form)) {
    low = low.cwiseMin(box->min);
    high = high.cwiseMax(box->max);
    return;
  }
  const SolidCombination& combination = std::get<SolidCombination>(shape.form);
  for (const SolidShape& part : combination.parts) {
    extend(part, low, high);
    if (combination.kind == SolidCombination::Kind::difference) return;
  }
}

/// Right-handed axes, the third along the given direction; the coordinate axes for z.
Mat3 axes_along(const Vec3& direction) {
  Mat3 axes;
  axes.col(2) = direction.normalized();
  int least = 0;
  for (int d = 1; d < 3; ++d)
    if (std::abs(axes(d, 2)) < std::abs(axes(least, 2)) - 1e-9) least = d;
  const Vec3 unit = Vec3::Unit(least);
  axes.col(0) = (unit - axes.col(2).dot(unit) * axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

Mesh convert(SolidMesh&& solid) {
  Mesh mesh;
  mesh.nodes = std::move(solid.nodes);
  const CellKind kind = solid.nodes_per_cell == 4 ? CellKind::tet4 : CellKind::tet10;
  for (std::size_t i = 0; i < solid.connectivity.size(); i += solid.nodes_per_cell)
    mesh.add_cell(kind, &solid.connectivity[i]);
  return mesh;
}

}  // namespace

bool only_boxes(const SolidShape& shape) {
  if (std::holds_alternative<SolidBox>(shape.form)) return true;
  const SolidCombination* combination = std::get_if<SolidCombination>(&shape.form);
  return combination && std::all_of(combination->parts.begin(), combination->parts.end(),
                                    [](const SolidShape& part) { return only_boxes(part); });
}

Mesh mesh_solid_boxes(const SolidShape& shape, const BodyMeshOptions& options) {
  std::vector<SolidBox> boxes;
  collect_boxes(shape, boxes);
  if (boxes.empty()) throw InputError("mesh: a shape without parts");
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Constant(infinity), high = -low;
  extend(shape, low, high);
  check_count(((high - low) / options.size).prod(), options.size);
  Lines lines;
  double cells = 1.0;
  for (int d = 0; d < 3; ++d) {
    std::vector<double> breaks;
    for (const SolidBox& box : boxes) breaks.insert(breaks.end(), {box.min[d], box.max[d]});
    lines[d] = mesh_lines(std::move(breaks), low[d], high[d], options.size);
    cells *= static_cast<double>(lines[d].size());
  }
  check_count(cells, options.size);
  Mesh mesh = mesh_lattice(lines, options, [&](const Vec3& x) { return inside_boxes(shape, x); });
  if (mesh.kinds.empty()) throw InputError("mesh: nothing is left of the shape");
  return mesh;
}

Mesh mesh_cylinder(const Cylinder& cylinder, const BodyMeshOptions& options) {
  const Vec3 axis = cylinder.to - cylinder.from;
  const double length = axis.norm();
  if (!(length > 0.0) || !(cylinder.radius > 0.0))
    throw InputError(fmt::format("mesh: a cylinder of length {:g} m and radius {:g} m (both must be positive)", length,
                                 cylinder.radius));
  const double across = std::sqrt(std::numbers::pi) * cylinder.radius / options.size, along = length / options.size;
  check_count((across + 1.0) * (across + 1.0) * (along + 1.0), options.size);
  const auto count = [](double cells) { return std::max(1, static_cast<int>(std::lround(cells))); };
  const int n = options.kind == BodyMeshKind::tetrahedra ? 2 * count(0.5 * across) : count(across);
  Lines lines;  // the square [-1, 1]^2 and the axis from 0 to 1
  lines[0] = lines[1] = mesh_lines({-1.0, 1.0}, -1.0, 1.0, 2.0 / n);
  lines[2] = mesh_lines({0.0, 1.0}, 0.0, 1.0, 1.0 / count(along));
  Mesh mesh = mesh_lattice(lines, options, [](const Vec3&) { return true; });
  const Mat3 axes = axes_along(axis);
  for (Vec3& x : mesh.nodes) {
    const double u = x.x(), v = x.y();
    const Vec2 disc = cylinder.radius * Vec2(u * std::sqrt(1.0 - 0.5 * v * v), v * std::sqrt(1.0 - 0.5 * u * u));
    x = cylinder.from + x.z() * axis + disc.x() * axes.col(0) + disc.y() * axes.col(1);
  }
  return mesh;
}

Mesh mesh_solid_shape(const SolidShape& shape, const BodyMeshOptions& options) {
  if (options.kind != BodyMeshKind::hexahedra && options.kind != BodyMeshKind::tetrahedra)
    throw InputError("mesh: quads and triangles are for plane shapes (a solid one takes hexahedra or tetrahedra)");
  if (options.structured) {
    if (const Cylinder* cylinder = std::get_if<Cylinder>(&shape.form)) return mesh_cylinder(*cylinder, options);
    if (only_boxes(shape)) return mesh_solid_boxes(shape, options);
    throw InputError("mesh: a structured mesh needs a cylinder or a shape that is made of boxes only");
  }
  if (options.kind == BodyMeshKind::hexahedra)
    throw InputError(
        "mesh: hexahedra are for structured meshes of boxes and cylinders (set structured = true, or take tetrahedra)");
  return convert(mesh_solid(shape, options.size, options.order));
}

}  // namespace berm
