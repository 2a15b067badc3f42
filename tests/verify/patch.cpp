/// Patch test: affine displacement on the boundary must give that displacement and a constant stress everywhere.
/// Exact for every finite element, and in MPM for points at Gauss positions on every kind of grid and for points
/// anywhere in a body of known outline; the error of points from a mesh file is reported.

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <set>

#include "driver.hpp"

namespace berm::verify {
namespace {

// Literature values for this test do not exist: the field is the reference. E = 1e6 Pa, nu = 0.3, plane strain.
const Mat2 gradient = (Mat2() << 1e-3, 2e-4, 1e-4, -5e-4).finished();

std::string case_text(const std::string& method, const std::string& parts) {
  return fmt::format("method = \"{}\"\n", method) + R"(
[model]
kinematics = "small"
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e6
poisson_ratio = 0.3
[boundary.placeholder]
where.box = { min = [-9.0, -9.0], max = [9.0, 9.0] }
ux = 0.0
[steps]
count = 1
adaptive = false
[solver]
relative_tolerance = 1e-11
absolute_tolerance = 1e-16
[body.b]
material = "m"
)" + parts;
}

void prescribe(Case& c, const Vec3& node) {
  const Vec3 d(1e-7, 1e-7, 1.0);
  NodeBoundary b;
  b.name = fmt::format("node{}", c.boundaries.size());
  b.where.min = node - d;
  b.where.max = node + d;
  const Vec2 u = gradient * in_plane(node);
  b.u[0] = u.x();
  b.u[1] = u.y();
  c.boundaries.push_back(b);
}

/// All nodes on the boundary of the mesh.
std::set<int> boundary_nodes(const Mesh& mesh) {
  std::set<int> nodes;
  for (const CellFace& e : boundary_faces(mesh)) {
    const int n = corners_of(mesh.kinds[e.cell]);
    nodes.insert(mesh.cell(e.cell)[e.local]);
    nodes.insert(mesh.cell(e.cell)[(e.local + 1) % n]);
    if (nodes_of(mesh.kinds[e.cell]) > n) nodes.insert(mesh.cell(e.cell)[n + e.local]);
  }
  return nodes;
}

/// Nodes within one cell of the sides of the unit square: those of the cells that its boundary cuts.
std::set<int> outer_nodes(const Mesh& mesh, double h) {
  std::set<int> nodes;
  for (int k = 0; k < mesh.n_nodes(); ++k)
    if ((in_plane(mesh.nodes[k]).array() - 0.5).abs().maxCoeff() > 0.5 - h) nodes.insert(k);
  return nodes;
}

struct Errors {
  double displacement;  ///< largest |u - u_exact| / largest |u_exact|
  double stress;        ///< sum V |s - s_exact| / (|s_exact| sum V)
  long free;            ///< unknowns
};

Errors patch(const std::string& method, const std::string& parts, bool cut = false) {
  const std::string text = case_text(method, parts);
  Model model(text);
  const Mesh& mesh = model.world->discretisation->mesh();
  const std::set<int> held = cut ? outer_nodes(mesh, model.world->discretisation->cell_size()) : boundary_nodes(mesh);
  Case c = case_of(text);
  c.boundaries.clear();
  c.allow_glued = cut;  // nodes beside the body are to hold it here
  for (int node : held) prescribe(c, mesh.nodes[node]);

  Model loaded(c);
  loaded.advance(1.0);
  const std::vector<Vec3> X = loaded.world->discretisation->point_origins();
  const double E = 1e6, nu = 0.3, mu = E / (2.0 * (1.0 + nu)), lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
  const double tr = lambda * gradient.trace();
  Voigt exact;
  exact << tr + 2.0 * mu * gradient(0, 0), tr + 2.0 * mu * gradient(1, 1), tr, mu * (gradient(0, 1) + gradient(1, 0)),
      0.0, 0.0;

  const std::vector<Vec3> u = loaded.world->discretisation->point_displacements();
  Errors e{0.0, 0.0, loaded.step.unknowns()};
  double size = 0.0, volume = 0.0;
  for (std::size_t p = 0; p < X.size(); ++p) {
    const Vec2 exact_u = gradient * in_plane(X[p]);
    size = std::max(size, exact_u.norm());
    e.displacement = std::max(e.displacement, (in_plane(u[p]) - exact_u).norm());
    e.stress += loaded.material().volume[p] * (loaded.material().stress[p] - exact).norm();
    volume += loaded.material().volume[p];
  }
  e.displacement /= size;
  e.stress /= exact.norm() * volume;
  return e;
}

/// `name` starts with the method.
void expect_exact(const std::string& name, const std::string& parts, bool cut = false) {
  SCOPED_TRACE(name);
  const Errors e = patch(name.substr(0, 3), parts, cut);
  EXPECT_GT(e.free, 20);
  EXPECT_LT(e.displacement, 1e-10);
  EXPECT_LT(e.stress, 1e-10);
  record({"Patch test", name + ": larger error of displacement and stress", std::max(e.displacement, e.stress), "0",
          "1e-10", "constant strain is exact"});
}

void report(const std::string& name, const std::string& parts, double bound) {
  SCOPED_TRACE(name);
  const Errors e = patch("mpm", parts, true);
  EXPECT_GT(e.free, 20);
  EXPECT_LT(e.stress, bound);  // a bound against blunders; the size of the error is the method's
  record({"Patch test", name + ": error of the stress", e.stress, "0", fmt::format("reported, < {}", bound),
          "integration error of points that are no Gauss points of the cells"});
}

const std::string square = "shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }\n";

/// A square of n x n quads whose inner nodes are moved by up to 25 % of an edge; written as Gmsh 2.2 text. `triangles`:
/// every quad halved; `quadratic`: with mid-side nodes.
std::string distorted_mesh(bool triangles, bool quadratic) {
  constexpr int n = 6;
  std::mt19937 random(7);
  std::vector<Vec2> nodes;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      auto shift = [&] { return 0.5 * (random() / double(std::mt19937::max()) - 0.5) / n; };
      const double dx = shift(), dy = shift();
      const bool inner = i > 0 && j > 0 && i < n && j < n;
      nodes.emplace_back(double(i) / n + (inner ? dx : 0.0), double(j) / n + (inner ? dy : 0.0));
    }
  std::vector<std::vector<int>> cells;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      if (!triangles)
        cells.push_back({a, b, c, d});
      else if ((i + j) % 2)
        cells.insert(cells.end(), {{a, b, c}, {a, c, d}});
      else
        cells.insert(cells.end(), {{a, b, d}, {b, c, d}});
    }
  if (quadratic) {
    std::map<std::pair<int, int>, int> middle;
    for (auto& cell : cells) {
      const std::size_t corners = cell.size();
      for (std::size_t k = 0; k < corners; ++k) {
        const int a = cell[k], b = cell[(k + 1) % corners];
        const auto [at, is_new] = middle.try_emplace({std::min(a, b), std::max(a, b)}, int(nodes.size()));
        if (is_new) nodes.push_back(0.5 * (nodes[a] + nodes[b]));
        cell.push_back(at->second);
      }
    }
  }
  const std::string path = scratch_file(fmt::format("distorted_{}{}.msh", int(triangles), int(quadratic)));
  std::ofstream out(path);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << nodes.size() << "\n";
  for (std::size_t k = 0; k < nodes.size(); ++k) out << fmt::format("{} {} {} 0\n", k + 1, nodes[k].x(), nodes[k].y());
  out << "$EndNodes\n$Elements\n" << cells.size() << "\n";
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const std::map<std::size_t, int> type = {{3, triangles && !quadratic ? 2 : 0}, {4, 3}, {6, 9}, {8, 16}};
    out << fmt::format("{} {} 2 1 1", k + 1, type.at(cells[k].size()));
    for (int node : cells[k]) out << " " << node + 1;
    out << "\n";
  }
  out << "$EndElements\n";
  return path;
}

std::string structured(const std::string& kind, const std::string& more = "") {
  return fmt::format("[grid]\nkind = \"{}\"\ncells = [6, 6]\nsize = [1.0, 1.0]\n{}", kind, more);
}

TEST(Patch, GaussPointsOnEveryStructuredGrid) {
  for (const std::string kind : {"quads", "triangles_right", "triangles_left", "union_jack"})
    for (int n : {1, 2, 3}) {
      if (n == 1 && kind == "quads") continue;  // one point a quad does not hold its hourglass modes
      expect_exact(fmt::format("mpm, {}, {} points per direction", kind, n),
                   square + fmt::format("points = {{ per_direction = {} }}\n", n) + structured(kind));
    }
}

TEST(Patch, GaussPointsOnRotatedQuads) {
  // The unit square turned by 30 degrees about the origin, and a grid that fits it.
  const double c = std::sqrt(0.75), s = 0.5;
  expect_exact(
      "mpm, quads rotated by 30 deg",
      fmt::format("shape.polygon = [[0.0, 0.0], [{0}, {1}], [{2}, {3}], [{4}, {0}]]\n", c, s, c - s, c + s, -s) +
          structured("quads", "angle = \"30 deg\"\n"));
}

TEST(Patch, GaussPointsOnUnstructuredGrids) {
  for (const bool triangles : {false, true})
    expect_exact(fmt::format("mpm, distorted {}", triangles ? "triangles" : "quads"),
                 square + fmt::format("[grid]\nfile = \"{}\"\n", distorted_mesh(triangles, false)));
}

TEST(Patch, FiniteElementsOnDistortedMeshes) {
  for (const bool quadratic : {false, true})
    for (const bool triangles : {false, true})
      expect_exact(
          fmt::format("fem, distorted {}", triangles ? (quadratic ? "tri6" : "tri3") : (quadratic ? "quad8" : "quad4")),
          fmt::format("file = \"{}\"\npoints = {{ per_element = 4 }}\n", distorted_mesh(triangles, quadratic)) +
              "[grid]\ncells = [1, 1]\ncell_size = 1.0\n");
}

TEST(Patch, PointsAwayFromGaussPositions) {
  expect_exact("mpm, quads, quarter positions",
               square + "points = { per_direction = 2, placement = \"uniform\" }\n" + structured("quads"));
  // The grid is moved by (-0.13, -0.37) h under the body: its outer cells are cut.
  const double h = 1.0 / 8.0;
  const std::string shifted =
      fmt::format("[grid]\ncells = [9, 9]\ncell_size = {}\norigin = [{}, {}]\n", h, -0.13 * h, -0.37 * h);
  for (const int n : {4, 9})
    expect_exact(
        fmt::format("mpm, quads, {} points in every quad of a body mesh shifted by (0.13, 0.37) h", n),
        square +
            fmt::format("points = {{ mesh = \"quads\", size = {}, structured = true, per_element = {} }}\n", h, n) +
            shifted,
        true);
  for (const int n : {3, 6, 12})
    expect_exact(
        fmt::format("mpm, quads, {} points in every triangle of a body mesh", n),
        square + fmt::format("points = {{ mesh = \"triangles\", size = {}, per_element = {} }}\n", h, n) + shifted,
        true);
  // The outline of a body from a file is not known to the quadrature: its points are taken as they are.
  for (const int n : {3, 6, 12})
    report(fmt::format("mpm, quads, {} points in every triangle of a mesh file", n),
           fmt::format("file = \"{}\"\npoints = {{ per_element = {} }}\n", distorted_mesh(true, false), n) + shifted,
           0.3);
}

/// On triangles too the domains are those of the boxes that were cut in two: they fill the body, but the means of functions
/// with kinks inside of them are not exact.
TEST(Patch, DomainsOnTriangles) {
  for (const char* kind : {"triangles_right", "triangles_left", "union_jack"})
    report(fmt::format("mpm, cpdi, {}", kind), square + structured(kind) + "shape_functions = \"cpdi\"\n", 0.05);
}

/// Domains that fill the body integrate its constant stress exactly, whether the grid fits it or cuts it.
TEST(Patch, Domains) {
  const double h = 1.0 / 8.0;
  const std::string moved = fmt::format("[grid]\ncells = [9, 9]\ncell_size = {}\norigin = [{}, {}]\n", h, -0.13 * h, -0.37 * h);
  for (const char* functions : {"ugimp", "cpgimp", "cpdi"}) {
    const std::string choice = fmt::format("shape_functions = \"{}\"\n", functions);
    expect_exact(fmt::format("mpm, {}, quarter positions", functions), square + structured("quads") + choice);
    expect_exact(fmt::format("mpm, {}, grid shifted by (0.13, 0.37) h", functions), square + moved + choice, true);
    report(fmt::format("mpm, {}, 6 points in every triangle of a mesh file", functions),
           fmt::format("file = \"{}\"\npoints = {{ per_element = 6 }}\n", distorted_mesh(true, false)) + moved + choice, 0.3);
  }
}

}  // namespace
}  // namespace berm::verify
