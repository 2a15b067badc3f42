/// Pressures and tractions on surfaces.
#include <fmt/format.h>

#include <cmath>

#include "base/findings.hpp"
#include "bc/boundary.hpp"
#include "bc/case_lookup.hpp"

namespace berm {

void BoundaryConditions::read_pressures(const Case& c, const std::vector<SurfacePoint>& surface) {
  Findings found;
  for (std::size_t k = 0; k < c.pressures.size(); ++k) {
    const Pressure& spec = c.pressures[k];
    const int body = body_index(c, spec.body);
    std::vector<SurfacePart> parts;
    found.look([&] { parts = caught_surface("pressure." + spec.name, spec.where, body, spec.body, surface, dimension_); });
    for (const auto& [s, share] : without_strips(parts)) {
      PressurePoint point;
      point.anchor = anchor_at(body, s.X, s.normal);
      point.id = static_cast<int>(pressures_.size());
      point.load = static_cast<int>(k);
      point.area = -share * s.area * s.normal;
      pressures_.push_back(point);
    }
    double area = 0.0;
    for (const auto& [s, share] : parts) area += share * s.area;
    if (!parts.empty() && !(area > 0.0))
      warnings_.push_back(fmt::format("[pressure.{}] acts on no area: its places lie on the axis of rotation", spec.name));
  }
  found.throw_if_any();
}

bool BoundaryConditions::follows(const Pressure& spec) const {
  return !spec.traction && case_.kinematics == Kinematics::finite && spec.direction == Pressure::Direction::following;
}

/// a = J F^-T A, Nanson's formula; the cofactors of F are polynomials and have a value for every F.   [boundaries (6)]
BoundaryConditions::PressureForce BoundaryConditions::pressure_force(const PressurePoint& point, double time,
                                                                     const NodalVector& du) const {
  const Pressure& spec = case_.pressures[point.load];
  PressureForce p{0.0, point.area, point.anchor.x};
  if (!acts(spec.stages)) return p;
  if (spec.traction) return {1.0, spec.traction->at(time, point.anchor.x) * point.area.norm(), p.place};  // [(6a)]
  if (case_.kinematics == Kinematics::finite) p.place += point.anchor.stencil->interpolate(du);
  p.value = spec.value.at(time, p.place);
  if (!follows(spec)) return p;
  const Mat3 F = point.anchor.trial_F(du);
  Mat3 cofactor;
  for (int i = 0; i < 3; ++i) cofactor.row(i) = F.row((i + 1) % 3).cross(F.row((i + 2) % 3));
  p.area = cofactor * point.area;
  return p;
}

void BoundaryConditions::add_pressure(double time, const NodalVector& du, double factor, NodalVector& f,
                                      BlockAssembler* matrix) const {
  for (const PressurePoint& point : pressures_) {
    const PressureForce p = pressure_force(point, time, du);
    const Stencil& s = *point.anchor.stencil;
    for (int k = 0; k < s.n; ++k) f[s.node[k]] += factor * p.value * s.N[k] * p.area;
    if (matrix) add_pressure_matrix(point, time, du, factor, *matrix);
  }
}

/// d(p a)/d(u_J) = p (a (x) g_J - g_J (x) a) + a (x) grad p N_J   [boundaries (12)]
void BoundaryConditions::add_pressure_matrix(const PressurePoint& point, double time, const NodalVector& du,
                                             double factor, BlockAssembler& matrix) const {
  const Pressure& spec = case_.pressures[point.load];
  if (!acts(spec.stages) || spec.traction) return;
  const bool follows_face = follows(spec);
  const bool by_place = case_.kinematics == Kinematics::finite && spec.value.depends_on_place();
  if (!follows_face && !by_place) return;
  const PressureForce p = pressure_force(point, time, du);
  const Stencil& s = *point.anchor.stencil;
  Vec3 slope = Vec3::Zero();
  if (by_place)
    for (int i = 0; i < dimension_; ++i) {
      const Vec3 h = 1e-4 * cell_size_ * Vec3::Unit(i);
      slope[i] = (spec.value.at(time, p.place + h) - spec.value.at(time, p.place - h)) / (2.0 * h[i]);
    }
  const Mat3 push = point.anchor.push(du);
  const int d = dimension_, width = d * s.n;
  std::vector<double> K(std::size_t(width) * width);
  for (int J = 0; J < s.n; ++J) {
    Mat3 change = p.area * slope.transpose() * s.N[J];
    if (follows_face) {
      const Vec3 g = push * s.gradient[J];
      Vec3 dilation = g;  // around an axis the ring grows too
      dilation.x() += push(2, 2) * s.hoop[J];
      change += p.value * (p.area * dilation.transpose() - g * p.area.transpose());
    }
    for (int I = 0; I < s.n; ++I)
      for (int i = 0; i < d; ++i)
        for (int j = 0; j < d; ++j) K[(d * I + i) * width + d * J + j] = -factor * s.N[I] * change(i, j);
  }
  matrix.add(point.anchor.block, K.data());
}

std::vector<BoundaryConditions::LoadSum> BoundaryConditions::load_sums(double time, const NodalVector& du) const {
  constexpr int width = 8;
  std::vector<double> rows(width * case_.pressures.size(), 0.0);
  comm_.agree([&] {
    for (const PressurePoint& point : pressures_) {
      const PressureForce p = pressure_force(point, time, du);
      const Vec3 force = p.value * p.area, moment = p.place.cross(force);
      double* row = &rows[width * point.load];
      row[0] += 1.0;
      row[1] += point.area.norm();
      for (int i = 0; i < 3; ++i) row[2 + i] += force[i], row[5 + i] += moment[i];
    }
  });
  comm_.sum(rows);
  std::vector<LoadSum> sums;
  for (std::size_t k = 0; k < rows.size(); k += width)
    sums.push_back({std::lround(rows[k]), rows[k + 1], Vec3(&rows[k + 2]), Vec3(&rows[k + 5])});
  return sums;
}

std::vector<Vec3> BoundaryConditions::pressure_forces(double time, const NodalVector& du) const {
  std::vector<Vec3> forces;
  for (const LoadSum& sum : load_sums(time, du)) forces.push_back(sum.force);
  return forces;
}

}  // namespace berm
