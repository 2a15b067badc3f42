#include "shape/grid_basis.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "mesh/cell_map.hpp"
#include "shape/linear.hpp"
#include "shape/quadrature.hpp"

namespace berm {
namespace {

/// Calls set(k, product) for the products of the functions 0 ... `last` of every direction, the first direction fastest; z
/// has one factor in the plane.
template <class Set>
void multiply(int last, int dimension, const std::array<double, 4>& x, const std::array<double, 4>& y,
              const std::array<double, 4>& z, Set set) {
  int at = 0;
  for (int c = 0; c <= (dimension == 3 ? last : 0); ++c)
    for (int b = 0; b <= last; ++b)
      for (int a = 0; a <= last; ++a) set(at++, x[a] * y[b] * z[c]);
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
              nodes_.push_back(node(i + a, j + b, k + c));
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
  multiply_all(degree_, value, slope, out);
  return true;
}

/// Values and gradients from those in every direction, with the functions 0 ... `last` of each; the third value of the
/// plane is 1.
void GridBasis::multiply_all(int last, const std::array<Factors, 3>& value, const std::array<Factors, 3>& slope,
                             BasisAt& out) const {
  const auto& [x, y, z] = value;
  multiply(last, dimension_, x, y, z, [&](int k, double N) { out.N[k] = N; });
  multiply(last, dimension_, slope[0], y, z, [&](int k, double dN) { out.grad[k].x() = dN; });
  multiply(last, dimension_, x, slope[1], z, [&](int k, double dN) { out.grad[k].y() = dN; });
  multiply(last, dimension_, x, y, slope[2], [&](int k, double dN) { out.grad[k].z() = dN; });
  if (grid_->structure->angle != 0.0)
    for (int k = 0; k < out.n; ++k) out.grad[k] = (back_.transpose() * out.grad[k]).eval();
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

namespace {

constexpr double rounding = 1e-9;  ///< of places in units of cells

/// Ends that are outside of the grid are cut off.
int first_span(double low, int cells) { return std::clamp(static_cast<int>(std::clamp(low, 0.0, cells - 2.0 * rounding) + rounding), 0, cells - 1); }

}  // namespace

/// Over [low, high] in units of cells, in at most two spans; two Gauss points are exact up to cubic functions.
GridBasis::Reach GridBasis::means(int direction, double low, double high, Factors& value, Factors& slope) const {
  static const auto rule = gauss_line(2);
  const int last = cells_[direction] - 1;
  const int first = first_span(low, cells_[direction]);
  low = std::clamp(low, 0.0, last + 1.0 - 2.0 * rounding);
  high = std::clamp(high, low + rounding, last + 1.0);
  const double line = first + 1.0;
  low = std::max(low, double(first));
  if (high < line + rounding || first == last) high = std::min(high, line);
  const auto add = [&](int span, double a, double b) {
    for (const auto& [xi, weight] : rule) {
      Spans s{};
      s.cell[direction] = span;
      s.at[direction] = 0.5 * (a + b) + 0.5 * xi * (b - a);
      const double share = 0.5 * weight * (b - a) / (high - low);
      for (int k = 0; k <= degree_; ++k) {
        value[span - first + k] += share * spline(direction, span + k, degree_, 0, s);
        slope[span - first + k] +=
            share * spline(direction, span + k, degree_, 1, s) / grid_->structure->cell_size[direction];
      }
    }
  };
  add(first, low, std::min(high, line));
  if (!(high > line)) return {first, 0.0};
  add(first + 1, line, high);
  return {first, (high - line) / (high - low)};
}

int GridBasis::lowest_cell(const Vec3& x, const Vec3& edges) const {
  const StructuredGrid& s = *grid_->structure;
  const Vec3 y = back_ * x - s.origin;
  std::array<int, 3> first{};
  for (int d = 0; d < dimension_; ++d) first[d] = first_span((y[d] - 0.5 * edges[d]) / s.cell_size[d], cells_[d]);
  return (first[2] * cells_[1] + first[1]) * cells_[0] + first[0];
}

Cover GridBasis::average_box(const Vec3& x, const Vec3& edges, BasisAt& out) const {
  const StructuredGrid& s = *grid_->structure;
  const Vec3 y = back_ * x - s.origin;
  std::array<Factors, 3> value{}, slope{};
  std::array<Reach, 3> reach{};
  for (int d = 0; d < dimension_; ++d)
    reach[d] = means(d, (y[d] - 0.5 * edges[d]) / s.cell_size[d], (y[d] + 0.5 * edges[d]) / s.cell_size[d], value[d],
                     slope[d]);
  if (dimension_ == 2) value[2][0] = 1.0;
  const int wide = degree_ + 2;
  const auto& [i, j, k] = reach;
  out.n = 0;
  for (int c = 0; c < (dimension_ == 3 ? wide : 1); ++c)
    for (int b = 0; b < wide; ++b)
      for (int a = 0; a < wide; ++a) out.nodes[out.n++] = node(i.first + a, j.first + b, k.first + c);
  multiply_all(wide - 1, value, slope, out);
  Cover cover;
  for (int c = 0; c <= (k.beyond > 0.0); ++c)
    for (int b = 0; b <= (j.beyond > 0.0); ++b)
      for (int a = 0; a <= (i.beyond > 0.0); ++a)
        cover.add(((k.first + c) * cells_[1] + j.first + b) * cells_[0] + i.first + a,
                  (a ? i.beyond : 1.0 - i.beyond) * (b ? j.beyond : 1.0 - j.beyond) * (c ? k.beyond : 1.0 - k.beyond));
  return cover;
}

Cover GridBasis::average_corners(const Vec3& x, const Mat3& edges, int hint, BasisAt& out) const {
  // Corners on a line belong to the cell that the domain lies in. A triangle or tetrahedron beyond may touch the body at a vertex
  // only: a corner a hair's breadth inside would give it nodes that hang on nothing else.
  const bool simplex = static_cast<int>(nodes_of(hint).size()) == dimension_ + 1;
  const double inward = simplex ? 1.0 - 1e-3 : 1.0 - 1e-9;
  const int n_corners = 1 << dimension_;
  const auto corner = [&](int c, double size) {
    Vec3 place = x;
    for (int d = 0; d < dimension_; ++d) place += 0.5 * size * corner_sign[c][d] * edges.col(d);
    return place;
  };
  std::array<int, 8> cell;
  cell.fill(std::numeric_limits<int>::max());
  const auto inside = [&](double size) {
    for (int c = 0; c < n_corners; ++c)
      if ((cell[c] = grid_->locator->locate(corner(c, size * inward), hint)) < 0) return false;
    return true;
  };
  double size = 1.0;
  if (!inside(size)) {
    double low = 0.0, high = 1.0;
    for (int k = 0; k < 30; ++k) (inside(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    size = low;
    if (size < 1e-3 || !inside(size)) return {};
  }
  Cover cover;
  std::array<int, 8> sorted = cell;
  std::sort(sorted.begin(), sorted.end());
  for (int c = 0; c < n_corners; ++c) cover.add(sorted[c], 1.0 / n_corners);
  out.n = 0;
  const auto position = [&out](int node) {
    return std::find(out.nodes.begin(), out.nodes.begin() + out.n, node) - out.nodes.begin();
  };
  for (int c = 0; c < cover.n; ++c)
    for (const int node : nodes_of(cover.cell[c])) {
      const auto at = position(node);
      if (at < out.n) continue;
      out.nodes[at] = node;
      out.N[at] = 0.0;
      out.grad[at].setZero();
      ++out.n;
    }
  Mat3 E = Mat3::Identity();
  E.topLeftCorner(dimension_, dimension_) = size * edges.topLeftCorner(dimension_, dimension_);
  const Mat3 by_edges = 2.0 / n_corners * E.inverse().transpose();
  BasisAt here;
  for (int c = 0; c < n_corners; ++c) {
    if (!evaluate(cell[c], corner(c, size), here)) return {};
    Vec3 outward = Vec3::Zero();
    for (int d = 0; d < dimension_; ++d) outward[d] = corner_sign[c][d];
    const Vec3 weight = by_edges * outward;
    for (int k = 0; k < here.n; ++k) {
      const auto at = position(here.nodes[k]);
      out.N[at] += here.N[k] / n_corners;
      out.grad[at] += here.N[k] * weight;
    }
  }
  return cover;
}

/// By its place in every direction; -1 beyond the last one.
int GridBasis::node(int i, int j, int k) const {
  const int nx = cells_[0] + degree_, ny = cells_[1] + degree_, nz = dimension_ == 3 ? cells_[2] + degree_ : 1;
  return i < nx && j < ny && k < nz ? (k * ny + j) * nx + i : -1;
}

}  // namespace berm
