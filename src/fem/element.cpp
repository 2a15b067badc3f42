#include "fem/element.hpp"

namespace berm::fem {
namespace {

void triangle(const Vec2& xi, bool quadratic, ElementShape& s) {
  const double L[3] = {1.0 - xi.x() - xi.y(), xi.x(), xi.y()};
  const Vec2 dL[3] = {Vec2(-1.0, -1.0), Vec2(1.0, 0.0), Vec2(0.0, 1.0)};
  s.n = quadratic ? 6 : 3;
  for (int i = 0; i < 3; ++i) {
    s.N[i] = quadratic ? L[i] * (2.0 * L[i] - 1.0) : L[i];
    s.dN[i] = quadratic ? Vec2((4.0 * L[i] - 1.0) * dL[i]) : dL[i];
    if (!quadratic) continue;
    const int j = (i + 1) % 3;
    s.N[3 + i] = 4.0 * L[i] * L[j];
    s.dN[3 + i] = 4.0 * (L[i] * dL[j] + L[j] * dL[i]);
  }
}

constexpr double corner_x[4] = {-1, 1, 1, -1};
constexpr double corner_y[4] = {-1, -1, 1, 1};

void quad4(const Vec2& xi, ElementShape& s) {
  s.n = 4;
  for (int i = 0; i < 4; ++i) {
    const double a = 1.0 + corner_x[i] * xi.x(), b = 1.0 + corner_y[i] * xi.y();
    s.N[i] = 0.25 * a * b;
    s.dN[i] = Vec2(0.25 * corner_x[i] * b, 0.25 * corner_y[i] * a);
  }
}

void quad8(const Vec2& xi, ElementShape& s) {
  s.n = 8;
  const double x = xi.x(), y = xi.y();
  for (int i = 0; i < 4; ++i) {
    const double cx = corner_x[i], cy = corner_y[i];
    const double a = 1.0 + cx * x, b = 1.0 + cy * y, c = cx * x + cy * y - 1.0;
    s.N[i] = 0.25 * a * b * c;
    s.dN[i] = Vec2(0.25 * cx * b * (c + a), 0.25 * cy * a * (c + b));
  }
  for (int i : {0, 2}) {  // mid-sides of the edges along x
    const double cy = corner_y[i];
    s.N[4 + i] = 0.5 * (1.0 - x * x) * (1.0 + cy * y);
    s.dN[4 + i] = Vec2(-x * (1.0 + cy * y), 0.5 * cy * (1.0 - x * x));
  }
  for (int i : {1, 3}) {  // mid-sides of the edges along y
    const double cx = corner_x[i];
    s.N[4 + i] = 0.5 * (1.0 - y * y) * (1.0 + cx * x);
    s.dN[4 + i] = Vec2(0.5 * cx * (1.0 - y * y), -y * (1.0 + cx * x));
  }
}

}  // namespace

ElementShape element_shape(CellKind kind, const Vec2& xi) {
  ElementShape s;
  switch (kind) {
    case CellKind::tri3:
      triangle(xi, false, s);
      break;
    case CellKind::tri6:
      triangle(xi, true, s);
      break;
    case CellKind::quad4:
      quad4(xi, s);
      break;
    case CellKind::quad8:
      quad8(xi, s);
      break;
  }
  return s;
}

std::vector<QuadraturePoint> element_rule(CellKind kind) {
  switch (kind) {
    case CellKind::tri3:
      return gauss_triangle(1);
    case CellKind::tri6:
      return gauss_triangle(3);
    default:
      return gauss_square(2);
  }
}

Vec2 edge_point(CellKind kind, int local, double s) {
  if (corners_of(kind) == 3) {
    const Vec2 corner[3] = {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)};
    return 0.5 * ((1.0 - s) * corner[local] + (1.0 + s) * corner[(local + 1) % 3]);
  }
  const int next = (local + 1) % 4;
  return 0.5 * ((1.0 - s) * Vec2(corner_x[local], corner_y[local]) + (1.0 + s) * Vec2(corner_x[next], corner_y[next]));
}

}  // namespace berm::fem
