#include "fem/element.hpp"

#include "shape/quadrature.hpp"

namespace berm::fem {
namespace {

/// Ends of the edges with a mid-side node; a triangle has the first three.
constexpr int simplex_edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// Triangles and tetrahedra, by barycentric coordinates.
void simplex(int dimension, bool quadratic, const Vec3& xi, ElementShape& s) {
  const int corners = dimension + 1;
  double L[4] = {1.0 - xi.head(dimension).sum(), xi.x(), xi.y(), xi.z()};
  Vec3 dL[4] = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  dL[0].head(dimension).setConstant(-1.0);
  s.n = corners;
  for (int i = 0; i < corners; ++i) {
    s.N[i] = quadratic ? L[i] * (2.0 * L[i] - 1.0) : L[i];
    s.dN[i] = quadratic ? Vec3((4.0 * L[i] - 1.0) * dL[i]) : dL[i];
  }
  if (!quadratic) return;
  for (int e = 0; e < (dimension == 2 ? 3 : 6); ++e) {
    const int i = simplex_edges[e][0], j = simplex_edges[e][1];
    s.N[s.n] = 4.0 * L[i] * L[j];
    s.dN[s.n++] = 4.0 * (L[i] * dL[j] + L[j] * dL[i]);
  }
}

/// Local coordinates of the nodes: corners, then mid-sides. The first four corners and mid-sides of the cube lie at its
/// lower end; the square has them without z.
constexpr signed char square_nodes[8][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0},
                                            {0, -1, 0},  {1, 0, 0},  {0, 1, 0}, {-1, 0, 0}};
constexpr signed char cube_nodes[20][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1},
                                           {1, -1, 1},   {1, 1, 1},   {-1, 1, 1}, {0, -1, -1}, {1, 0, -1},
                                           {0, 1, -1},   {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},   {0, 1, 1},
                                           {-1, 0, 1},   {-1, -1, 0}, {1, -1, 0}, {1, 1, 0},   {-1, 1, 0}};

/// Product of the factors f_i over all directions but `skip`.
double product(int dimension, const double* f, int skip) {
  double p = 1.0;
  for (int i = 0; i < dimension; ++i)
    if (i != skip) p *= f[i];
  return p;
}

/// Squares and cubes: prod (1 + c_i x_i) / 2^d at corners, times (sum c_i x_i - d + 1) if there are mid-sides; these
/// have 1 - x_m^2 in the direction m of their edge.
void box(int dimension, bool serendipity, const Vec3& xi, ElementShape& s) {
  const auto* nodes = dimension == 2 ? square_nodes : cube_nodes;
  const int corners = 1 << dimension;
  const double share = 1.0 / corners;
  s.n = serendipity ? (dimension == 2 ? 8 : 20) : corners;
  for (int k = 0; k < s.n; ++k) {
    const signed char* c = nodes[k];
    double f[3], df[3], sum = 1.0 - dimension;
    for (int i = 0; i < dimension; ++i) {
      const bool along = c[i] == 0;
      f[i] = along ? 1.0 - xi[i] * xi[i] : 1.0 + c[i] * xi[i];
      df[i] = along ? -2.0 * xi[i] : c[i];
      sum += c[i] * xi[i];
    }
    const bool corner = k < corners;
    const double factor = !corner ? 2.0 * share : serendipity ? share * sum : share;
    const double all = product(dimension, f, -1);
    s.N[k] = factor * all;
    s.dN[k].setZero();
    for (int i = 0; i < dimension; ++i) {
      s.dN[k][i] = factor * df[i] * product(dimension, f, i);
      if (corner && serendipity) s.dN[k][i] += share * c[i] * all;
    }
  }
}

std::vector<QuadraturePoint> rule_of(CellKind kind) {
  switch (kind) {
    case CellKind::tri3:
      return gauss_triangle(1);
    case CellKind::tri6:
      return gauss_triangle(3);
    case CellKind::tet4:
      return gauss_tetrahedron(1);
    case CellKind::tet10:
      return gauss_tetrahedron(4);
    default:
      return dimension_of(kind) == 2 ? gauss_square(2) : gauss_cube(2);
  }
}

std::array<std::vector<RulePoint>, 8> all_rules() {
  std::array<std::vector<RulePoint>, 8> rules;
  for (std::size_t k = 0; k < rules.size(); ++k) {
    const CellKind kind = static_cast<CellKind>(k);
    for (const QuadraturePoint& q : rule_of(kind)) rules[k].push_back({q.xi, q.weight, element_shape(kind, q.xi)});
  }
  return rules;
}

}  // namespace

ElementShape element_shape(CellKind kind, const Vec3& xi) {
  ElementShape s;
  const bool quadratic = nodes_of(kind) > corners_of(kind);
  if (is_simplex(kind))
    simplex(dimension_of(kind), quadratic, xi, s);
  else
    box(dimension_of(kind), quadratic, xi, s);
  return s;
}

const std::vector<RulePoint>& element_rule(CellKind kind) {
  static const std::array<std::vector<RulePoint>, 8> rules = all_rules();
  return rules[static_cast<int>(kind)];
}

}  // namespace berm::fem
