#include "shape/grid_basis.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "shape/linear.hpp"

namespace berm {
namespace {

using Factors = std::array<double, 4>;  ///< of the functions of a cell in one direction

/// Calls set(k, product) for every function k of a cell, the first direction fastest; z has one factor in the plane.
template <class Set>
void multiply(int degree, int dimension, const Factors& x, const Factors& y, const Factors& z, Set set) {
  int at = 0;
  for (int c = 0; c <= (dimension == 3 ? degree : 0); ++c)
    for (int b = 0; b <= degree; ++b)
      for (int a = 0; a <= degree; ++a) set(at++, x[a] * y[b] * z[c]);
}

}  // namespace

GridBasis::GridBasis(const Grid& grid, int degree) : grid_(&grid), degree_(degree), dimension_(grid.dimension()) {
  const Mesh& mesh = grid.mesh;
  const StructuredGrid* s = grid.structure.get();
  const bool boxes = s && (s->kind == GridKind::quads || s->kind == GridKind::hexahedra);
  if (boxes) {
    cells_ = {s->nx, s->ny, dimension_ == 3 ? s->nz : 1};
    back_.topLeftCorner<2, 2>() << std::cos(s->angle), std::sin(s->angle), -std::sin(s->angle), std::cos(s->angle);
  }
  if (degree == 1) {
    places_ = mesh.nodes;
    for (const CellKind kind : mesh.kinds) most_nodes_ = std::max(most_nodes_, berm::nodes_of(kind));
    return;
  }
  if (!boxes)
    throw InputError(
        "[grid] shape_functions: B-splines need a structured grid of quads or hexahedra (kind = \"quads\" or "
        "\"hexahedra\")");
  const std::array<int, 3> functions = {s->nx + degree, s->ny + degree, dimension_ == 3 ? s->nz + degree : 1};
  // Greville's abscissae: means of `degree` knots in a row.
  const auto greville = [&](int direction, int i) {
    double sum = 0.0;
    for (int k = 1; k <= degree; ++k) sum += std::clamp(i + k - degree, 0, cells_[direction]);
    return sum / degree;
  };
  for (int k = 0; k < functions[2]; ++k)
    for (int j = 0; j < functions[1]; ++j)
      for (int i = 0; i < functions[0]; ++i) {
        const Vec3 at(greville(0, i), greville(1, j), dimension_ == 3 ? greville(2, k) : 0.0);
        places_.push_back(back_.transpose() * Vec3(s->origin + at.cwiseProduct(s->cell_size)));
      }
  most_nodes_ = dimension_ == 3 ? (degree + 1) * (degree + 1) * (degree + 1) : (degree + 1) * (degree + 1);
  for (int k = 0; k < cells_[2]; ++k)
    for (int j = 0; j < cells_[1]; ++j)
      for (int i = 0; i < cells_[0]; ++i)
        for (int c = 0; c <= (dimension_ == 3 ? degree : 0); ++c)
          for (int b = 0; b <= degree; ++b)
            for (int a = 0; a <= degree; ++a)
              nodes_.push_back(((k + c) * functions[1] + j + b) * functions[0] + i + a);
}

std::span<const int> GridBasis::nodes_of(int cell) const {
  if (degree_ == 1) return grid_->mesh.nodes_of_cell(cell);
  return {nodes_.data() + std::size_t(cell) * most_nodes_, static_cast<std::size_t>(most_nodes_)};
}

GridBasis::Spans GridBasis::spans(int cell, const Vec3& x) const {
  const StructuredGrid& s = *grid_->structure;
  const Vec3 y = back_ * x - s.origin;
  Spans out;
  out.cell = {cell % cells_[0], cell / cells_[0] % cells_[1], cell / (cells_[0] * cells_[1])};
  for (int d = 0; d < 3; ++d) out.at[d] = d < dimension_ ? y[d] / s.cell_size[d] : 0.0;
  return out;
}

/// Derivative of function i of the given order (degree) on the knots of the basis, by the coordinate in units of cells
/// (Cox and de Boor).   [formulation (55), (56)]
double GridBasis::spline(int direction, int i, int order, int derivative, const Spans& s) const {
  if (order == 0) return i == s.cell[direction] + degree_ ? 1.0 : 0.0;
  const auto knot = [&](int j) { return double(std::clamp(j - degree_, 0, cells_[direction])); };
  const double left = knot(i + order) - knot(i), right = knot(i + order + 1) - knot(i + 1);
  double value = 0.0;
  if (derivative > 0) {
    if (left > 0.0) value += order / left * spline(direction, i, order - 1, derivative - 1, s);
    if (right > 0.0) value -= order / right * spline(direction, i + 1, order - 1, derivative - 1, s);
    return value;
  }
  const double x = s.at[direction];
  if (left > 0.0) value += (x - knot(i)) / left * spline(direction, i, order - 1, 0, s);
  if (right > 0.0) value += (knot(i + order + 1) - x) / right * spline(direction, i + 1, order - 1, 0, s);
  return value;
}

bool GridBasis::evaluate(int cell, const Vec3& x, BasisAt& out) const {
  if (degree_ == 1) {
    Shape8 shape;
    if (!linear_shape(grid_->mesh, cell, x, shape)) return false;
    out.n = shape.n;
    std::copy_n(shape.nodes.begin(), shape.n, out.nodes.begin());
    std::copy_n(shape.N.begin(), shape.n, out.N.begin());
    std::copy_n(shape.grad.begin(), shape.n, out.grad.begin());
    return true;
  }
  const Spans s = spans(cell, x);
  std::array<Factors, 3> value{}, slope{};
  for (int d = 0; d < dimension_; ++d)
    for (int a = 0; a <= degree_; ++a) {
      value[d][a] = spline(d, s.cell[d] + a, degree_, 0, s);
      slope[d][a] = spline(d, s.cell[d] + a, degree_, 1, s) / grid_->structure->cell_size[d];
    }
  if (dimension_ == 2) value[2][0] = 1.0;
  out.n = most_nodes_;
  std::copy_n(nodes_of(cell).begin(), out.n, out.nodes.begin());
  const auto& [fx, fy, fz] = value;
  multiply(degree_, dimension_, fx, fy, fz, [&](int k, double N) { out.N[k] = N; });
  multiply(degree_, dimension_, slope[0], fy, fz, [&](int k, double dN) { out.grad[k].x() = dN; });
  multiply(degree_, dimension_, fx, slope[1], fz, [&](int k, double dN) { out.grad[k].y() = dN; });
  multiply(degree_, dimension_, fx, fy, slope[2], [&](int k, double dN) { out.grad[k].z() = dN; });
  if (grid_->structure->angle != 0.0)
    for (int k = 0; k < out.n; ++k) out.grad[k] = (back_.transpose() * out.grad[k]).eval();
  return true;
}

bool GridBasis::highest_derivative(int cell, const Vec3& x, const Vec3& normal, BasisAt& out) const {
  if (degree_ == 1) {
    if (!evaluate(cell, x, out)) return false;
    for (int k = 0; k < out.n; ++k) out.N[k] = out.grad[k].dot(normal);
    return true;
  }
  const Spans s = spans(cell, x);
  int along = 0;
  const Vec3 own = back_ * normal;
  own.cwiseAbs().maxCoeff(&along);
  const double scale = std::pow(own[along] / grid_->structure->cell_size[along], degree_);
  std::array<Factors, 3> value{};
  for (int d = 0; d < dimension_; ++d)
    for (int a = 0; a <= degree_; ++a)
      value[d][a] = d == along ? scale * spline(d, s.cell[d] + a, degree_, degree_, s)
                               : spline(d, s.cell[d] + a, degree_, 0, s);
  if (dimension_ == 2) value[2][0] = 1.0;
  out.n = most_nodes_;
  std::copy_n(nodes_of(cell).begin(), out.n, out.nodes.begin());
  multiply(degree_, dimension_, value[0], value[1], value[2], [&](int k, double N) { out.N[k] = N; });
  return true;
}

/// Of the functions that a segment sees in one direction.
struct GridBasis::Means {
  int first;  ///< span of its lower end
  Factors value{}, slope{};
};

/// Over [low, high] in units of cells, in at most two spans; two Gauss points are exact up to cubic functions.
GridBasis::Means GridBasis::means(int direction, double low, double high) const {
  constexpr double rounding = 1e-9, gauss = 0.57735026918962576;
  const int last = cells_[direction] - 1;
  low = std::clamp(low, 0.0, last + 1.0 - 2.0 * rounding);
  high = std::clamp(high, low + rounding, last + 1.0);
  Means out{std::clamp(static_cast<int>(low + rounding), 0, last)};
  const double line = out.first + 1.0;
  low = std::max(low, double(out.first));
  if (high < line + rounding || out.first == last) high = std::min(high, line);
  const auto add = [&](int span, double a, double b) {
    for (const double xi : {-gauss, gauss}) {
      Spans s{};
      s.cell[direction] = span;
      s.at[direction] = 0.5 * (a + b) + 0.5 * xi * (b - a);
      const double share = 0.5 * (b - a) / (high - low);
      for (int k = 0; k <= degree_; ++k) {
        out.value[span - out.first + k] += share * spline(direction, span + k, degree_, 0, s);
        out.slope[span - out.first + k] += share * spline(direction, span + k, degree_, 1, s);
      }
    }
  };
  add(out.first, low, std::min(high, line));
  if (high > line) add(out.first + 1, line, high);
  return out;
}

int GridBasis::average(const Vec3& x, const Vec3& edges, BasisAt& out) const {
  const StructuredGrid& s = *grid_->structure;
  const Vec3 y = back_ * x - s.origin;
  std::array<Means, 3> m{};
  m[2].value[0] = 1.0;
  for (int d = 0; d < dimension_; ++d)
    m[d] = means(d, (y[d] - 0.5 * edges[d]) / s.cell_size[d], (y[d] + 0.5 * edges[d]) / s.cell_size[d]);
  for (int d = 0; d < dimension_; ++d)
    for (double& slope : m[d].slope) slope /= s.cell_size[d];

  const int wide = degree_ + 2;
  out.n = 0;
  for (int c = 0; c < (dimension_ == 3 ? wide : 1); ++c)
    for (int b = 0; b < wide; ++b)
      for (int a = 0; a < wide; ++a) {
        const std::array<int, 3> at = {m[0].first + a, m[1].first + b, m[2].first + c};
        bool there = true;
        for (int d = 0; d < dimension_; ++d) there = there && at[d] < cells_[d] + degree_;
        out.nodes[out.n++] =
            there ? (at[2] * (cells_[1] + degree_) + at[1]) * (cells_[0] + degree_) + at[0] : -1;
      }
  multiply(wide - 1, dimension_, m[0].value, m[1].value, m[2].value, [&](int k, double N) { out.N[k] = N; });
  for (int i = 0; i < 3; ++i) {
    if (i >= dimension_) {
      for (int k = 0; k < out.n; ++k) out.grad[k][i] = 0.0;
      continue;
    }
    std::array<const Factors*, 3> f = {&m[0].value, &m[1].value, &m[2].value};
    f[i] = &m[i].slope;
    multiply(wide - 1, dimension_, *f[0], *f[1], *f[2], [&](int k, double dN) { out.grad[k][i] = dN; });
  }
  if (s.angle != 0.0)
    for (int k = 0; k < out.n; ++k) out.grad[k] = (back_.transpose() * out.grad[k]).eval();
  return (m[2].first * cells_[1] + m[1].first) * cells_[0] + m[0].first;
}

}  // namespace berm
