/// Patch test in space: affine displacement on the surface of the unit cube must give that displacement and a constant
/// stress everywhere, in small and in logarithmic strain.

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include "driver.hpp"
#include "mesh/gmsh_solid.hpp"

namespace berm::verify {
namespace {

constexpr double youngs = 1e6, poisson = 0.3;

/// Of the displacement at time 1: strains of 1e-3, or of some per cent with finite kinematics.
Mat3 gradient(const std::string& kinematics) {
  const Mat3 small = (Mat3() << 1e-3, 2e-4, -3e-4, 1e-4, -5e-4, 4e-4, 2e-4, -1e-4, 7e-4).finished();
  return kinematics == "finite" ? Mat3(50.0 * small) : small;
}

/// Cauchy stress of the field.
Voigt exact_stress(const std::string& kinematics) {
  const Mat3 G = gradient(kinematics);
  Mat3 strain = 0.5 * (G + G.transpose());
  double J = 1.0;
  if (kinematics == "finite") {
    const Mat3 F = Mat3::Identity() + G;
    const Eigen::SelfAdjointEigenSolver<Mat3> b(F * F.transpose());
    strain =
        b.eigenvectors() * (0.5 * b.eigenvalues().array().log()).matrix().asDiagonal() * b.eigenvectors().transpose();
    J = F.determinant();
  }
  const double mu = youngs / (2.0 * (1.0 + poisson)), lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
  const Mat3 s = (lambda * strain.trace() * Mat3::Identity() + 2.0 * mu * strain) / J;
  Voigt out;
  out << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0);
  return out;
}

std::string case_text(const std::string& method, const std::string& kinematics, const std::string& parts) {
  return fmt::format("method = \"{}\"\n[model]\ndimension = 3\nkinematics = \"{}\"\n", method, kinematics) +
         fmt::format(
             "[material.m]\nlaw = \"linear_elastic\"\ndensity = 1000.0\nyoungs_modulus = {}\npoisson_ratio = {}\n",
             youngs, poisson) +
         R"(
[boundary.placeholder]
where.box = { min = [-9.0, -9.0, -9.0], max = [9.0, 9.0, 9.0] }
ux = 0.0
[steps]
count = 1
adaptive = false
[solver]
relative_tolerance = 1e-11
absolute_tolerance = 1e-16
linear = "direct"
[body.b]
material = "m"
)" + parts;
}

NodeBoundary held_node(int node, const Vec3& x, const Vec3& u) {
  NodeBoundary b;
  b.name = fmt::format("node{}", node);
  b.where.min = x - Vec3::Constant(1e-7);
  b.where.max = x + Vec3::Constant(1e-7);
  for (int i = 0; i < 3; ++i) b.u[i] = u[i];
  return b;
}

/// All nodes on the boundary of the mesh.
std::set<int> boundary_nodes(const Mesh& mesh) {
  std::set<int> nodes;
  for (const CellFace& face : boundary_faces(mesh)) {
    const CellKind kind = mesh.kinds[face.cell];
    const int* list = mesh.cell(face.cell);
    const FaceCorners& f = faces_of(kind)[face.local];
    const auto on_face = [&](int corner) {
      return std::find(f.corner.begin(), f.corner.begin() + f.n, corner) != f.corner.begin() + f.n;
    };
    for (int i = 0; i < f.n; ++i) nodes.insert(list[f.corner[i]]);
    if (nodes_of(kind) == corners_of(kind)) continue;
    const auto edges = edges_of(kind);
    for (std::size_t e = 0; e < edges.size(); ++e)
      if (on_face(edges[e][0]) && on_face(edges[e][1])) nodes.insert(list[corners_of(kind) + e]);
  }
  return nodes;
}

/// Nodes within one cell of the sides of the unit cube: those of the cells that its surface cuts.
std::set<int> outer_nodes(const Mesh& mesh, double h) {
  std::set<int> nodes;
  for (int k = 0; k < mesh.n_nodes(); ++k)
    if ((mesh.nodes[k].array() - 0.5).abs().maxCoeff() > 0.5 - h) nodes.insert(k);
  return nodes;
}

struct Errors {
  double displacement;  ///< largest |u - u_exact| / largest |u_exact|
  double stress;        ///< sum V |s - s_exact| / (|s_exact| sum V)
  long free;            ///< unknowns
};

/// cut: edge of the cells if the grid does not fit the body, else 0.
Errors patch(const std::string& method, const std::string& kinematics, const std::string& parts, double cut) {
  Case c = case_of(case_text(method, kinematics, parts));
  const Mat3 G = gradient(kinematics);
  {
    const Model model(c);
    const Mesh& mesh = model.world->discretisation->mesh();
    c.boundaries.clear();
    c.allow_glued = cut > 0.0;  // nodes beside the body are to hold it here
    for (int node : cut > 0.0 ? outer_nodes(mesh, cut) : boundary_nodes(mesh))
      c.boundaries.push_back(held_node(node, mesh.nodes[node], G * mesh.nodes[node]));
  }
  Model loaded(c);
  loaded.advance(1.0);
  const std::vector<Vec3> X = loaded.world->discretisation->point_origins();
  const std::vector<Vec3> u = loaded.world->discretisation->point_displacements();
  const Voigt exact = exact_stress(kinematics);
  Errors e{0.0, 0.0, loaded.step.unknowns()};
  double size = 0.0, volume = 0.0;
  for (std::size_t p = 0; p < X.size(); ++p) {
    size = std::max(size, (G * X[p]).norm());
    e.displacement = std::max(e.displacement, (u[p] - G * X[p]).norm());
    e.stress += loaded.material().volume[p] * (loaded.material().stress[p] - exact).norm();
    volume += loaded.material().volume[p];
  }
  e.displacement /= size;
  e.stress /= exact.norm() * volume;
  return e;
}

/// `name` starts with the method. Both kinematics.
void expect_exact(const std::string& name, const std::string& parts, double cut = 0.0) {
  SCOPED_TRACE(name);
  double worst = 0.0;
  for (const std::string kinematics : {"small", "finite"}) {
    const Errors e = patch(name.substr(0, 3), kinematics, parts, cut);
    EXPECT_GT(e.free, 20);
    EXPECT_LT(e.displacement, 1e-10) << kinematics;
    EXPECT_LT(e.stress, 1e-10) << kinematics;
    worst = std::max({worst, e.displacement, e.stress});
  }
  record({"Patch test in space", name + ": larger error of displacement and stress", worst, "0", "1e-10",
          "constant strain is exact"});
}

void report(const std::string& name, const std::string& parts, double cut, double bound, const std::string& source) {
  SCOPED_TRACE(name);
  const Errors e = patch(name.substr(0, 3), "small", parts, cut);
  EXPECT_GT(e.free, 20);
  EXPECT_LT(e.stress, bound);  // a bound against blunders; the size of the error is the method's
  record({"Patch test in space", name + ": error of the stress", e.stress, "0", fmt::format("reported, < {}", bound),
          source});
}

const std::string cube = "shape.box = { min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] }\n";

std::string structured(const std::string& kind, const std::string& more = "") {
  return fmt::format("[grid]\nkind = \"{}\"\ncells = [4, 4, 4]\nsize = [1.0, 1.0, 1.0]\n{}", kind, more);
}

struct GmshCells {
  int type = 0;  ///< number of the kind of element in Gmsh's files
  std::vector<Vec3> nodes;
  std::vector<std::vector<int>> cells;  ///< nodes in Gmsh's order
};

/// As Gmsh 2.2 text.
std::string write(const GmshCells& m, const std::string& name) {
  const std::string path = scratch_file(name);
  std::ofstream out(path);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << m.nodes.size() << "\n";
  for (std::size_t k = 0; k < m.nodes.size(); ++k)
    out << fmt::format("{} {} {} {}\n", k + 1, m.nodes[k].x(), m.nodes[k].y(), m.nodes[k].z());
  out << "$EndNodes\n$Elements\n" << m.cells.size() << "\n";
  for (std::size_t k = 0; k < m.cells.size(); ++k) {
    out << fmt::format("{} {} 2 1 1", k + 1, m.type);
    for (int node : m.cells[k]) out << " " << node + 1;
    out << "\n";
  }
  out << "$EndElements\n";
  return path;
}

/// The unit cube in hexahedra whose inner nodes are moved by up to 20 % of an edge, or in six tetrahedra for each;
/// `quadratic`: with mid-side nodes.
std::string distorted_mesh(bool tetrahedra, bool quadratic) {
  constexpr int n = 4;
  using Edge = std::array<int, 2>;
  static const std::vector<Edge> tet_edges = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {2, 3}, {1, 3}};  // Gmsh's order
  static const std::vector<Edge> hex_edges = {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3},
                                              {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}};
  std::mt19937 random(7);
  GmshCells m;
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        Vec3 shift;
        for (double& s : shift) s = 0.4 * (random() / double(std::mt19937::max()) - 0.5) / n;
        const bool inner = std::min({i, j, k}) > 0 && std::max({i, j, k}) < n;
        m.nodes.push_back(Vec3(i, j, k) / n + (inner ? shift : Vec3::Zero()));
      }
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto at = [&](int x, int y, int z) { return ((k + z) * (n + 1) + j + y) * (n + 1) + i + x; };
        const std::vector<int> c = {at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0),
                                    at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)};
        if (!tetrahedra)
          m.cells.push_back(c);
        else
          for (const auto& [a, b] : {Edge{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}})
            m.cells.push_back({c[0], c[a], c[b], c[6]});
      }
  if (quadratic) {
    std::map<std::pair<int, int>, int> middle;
    for (auto& cell : m.cells)
      for (const auto& [i, j] : tetrahedra ? tet_edges : hex_edges) {
        const int a = cell[i], b = cell[j];
        const auto [found, is_new] = middle.try_emplace({std::min(a, b), std::max(a, b)}, int(m.nodes.size()));
        if (is_new) m.nodes.push_back(0.5 * (m.nodes[a] + m.nodes[b]));
        cell.push_back(found->second);
      }
  }
  m.type = tetrahedra ? (quadratic ? 11 : 4) : (quadratic ? 17 : 5);
  return write(m, fmt::format("distorted_solid_{}{}.msh", int(tetrahedra), int(quadratic)));
}

/// The unit cube in tetrahedra of Gmsh, as a file.
std::string gmsh_tetrahedra() {
  const SolidMesh mesh = mesh_solid({SolidBox{Vec3::Zero(), Vec3::Ones()}}, 0.25, 1);
  GmshCells m{4, mesh.nodes, {}};
  for (std::size_t k = 0; k < mesh.connectivity.size(); k += 4)
    m.cells.emplace_back(mesh.connectivity.begin() + k, mesh.connectivity.begin() + k + 4);
  return write(m, "gmsh_tetrahedra.msh");
}

TEST(SolidPatch, GaussPointsOnStructuredGrids) {
  for (int n : {2, 3})
    expect_exact(fmt::format("mpm, hexahedra, {} points per direction", n),
                 cube + fmt::format("points = {{ per_direction = {} }}\n", n) + structured("hexahedra"));
  for (int n : {1, 2})
    expect_exact(fmt::format("mpm, tetrahedra, {} points", n == 1 ? 1 : 4),
                 cube + fmt::format("points = {{ per_direction = {} }}\n", n) + structured("tetrahedra"));
}

TEST(SolidPatch, GaussPointsOnARotatedGrid) {
  // The unit cube turned by 30 degrees about the z axis, and a grid that fits it.
  const double c = std::sqrt(0.75), s = 0.5;
  expect_exact(
      "mpm, hexahedra rotated by 30 deg",
      fmt::format(
          "shape.extrusion = {{ polygon = [[0.0, 0.0], [{0}, {1}], [{2}, {3}], [{4}, {0}]], from = 0.0, to = 1.0 }}\n",
          c, s, c - s, c + s, -s) +
          structured("hexahedra", "angle = \"30 deg\"\n"));
}

TEST(SolidPatch, GaussPointsOnUnstructuredGrids) {
  const auto grid = [](const std::string& file) { return cube + fmt::format("[grid]\nfile = \"{}\"\n", file); };
  expect_exact("mpm, distorted hexahedra", grid(distorted_mesh(false, false)));
  expect_exact("mpm, distorted tetrahedra", grid(distorted_mesh(true, false)));
  expect_exact("mpm, tetrahedra of Gmsh", grid(gmsh_tetrahedra()));
}

TEST(SolidPatch, FiniteElementsOnDistortedMeshes) {
  for (const bool quadratic : {false, true})
    for (const bool tetrahedra : {false, true})
      expect_exact(fmt::format("fem, distorted {}",
                               tetrahedra ? (quadratic ? "tet10" : "tet4") : (quadratic ? "hex20" : "hex8")),
                   fmt::format("file = \"{}\"\npoints = {{ per_element = {} }}\n",
                               distorted_mesh(tetrahedra, quadratic), tetrahedra ? 4 : 8));
  for (int order : {1, 2})
    expect_exact(fmt::format("fem, tet{} of Gmsh", order == 1 ? 4 : 10),
                 cube + fmt::format("mesh = {{ kind = \"tetrahedra\", size = 0.25, order = {} }}\n", order));
}

// The grid is moved by (-0.13, -0.37, -0.61) h under the body: its outer cells are cut.
constexpr double h = 0.2;
std::string shifted(const std::string& kind) {
  return fmt::format("[grid]\nkind = \"{}\"\ncells = [7, 7, 7]\ncell_size = {}\norigin = [{}, {}, {}]\n", kind, h,
                     -0.13 * h, -0.37 * h, -0.61 * h);
}
std::string body_mesh(const std::string& kind, int n) {
  return cube + fmt::format("points = {{ mesh = \"{}\", size = {}, per_element = {} }}\n", kind, h, n);
}

TEST(SolidPatch, BodiesThatTheGridCuts) {
  for (const std::string kind : {"hexahedra", "tetrahedra"})
    expect_exact(fmt::format("mpm, {}, points of the cells, body shifted by (0.13, 0.37, 0.61) h", kind),
                 cube + shifted(kind), h);
}

TEST(SolidPatch, PointsAwayFromGaussPositions) {
  expect_exact("mpm, hexahedra, quarter positions",
               cube + "points = { per_direction = 2, placement = \"uniform\" }\n" + structured("hexahedra"));
  const std::string place = "of a body mesh shifted by (0.13, 0.37, 0.61) h";
  for (const std::string grid : {"tetrahedra", "hexahedra"}) {
    expect_exact(fmt::format("mpm, {}, 8 points in every hexahedron {}", grid, place),
                 body_mesh("hexahedra", 8) + shifted(grid), h);
    expect_exact(fmt::format("mpm, {}, 4 points in every tetrahedron {}", grid, place),
                 body_mesh("tetrahedra", 4) + shifted(grid), h);
  }
  // The surface of a body from a file is not known to the quadrature: its points are taken as they are.
  report("mpm, hexahedra, 4 points in every tetrahedron of a mesh file",
         fmt::format("file = \"{}\"\npoints = {{ per_element = 4 }}\n", gmsh_tetrahedra()) + shifted("hexahedra"), h,
         0.5, "integration error of points that are no Gauss points of the cells");
}

}  // namespace
}  // namespace berm::verify
