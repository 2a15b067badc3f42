#pragma once
/// Return to a yield surface that is a polyhedron in principal stresses: Koiter's rule over sets of active planes.
/// docs/theory/plasticity.md, section "Polyhedral surfaces".

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>

#include "base/tensor.hpp"

namespace berm {

/// normal . s <= limit, with flow along `flow`; `..._rate`: derivatives by the hardening variable.
struct YieldPlane {
  Vec3 normal, flow;
  double limit;
  Vec3 normal_rate = Vec3::Zero(), flow_rate = Vec3::Zero();
  double limit_rate = 0.0;

  double excess(const Vec3& s) const { return normal.dot(s) - limit; }
};

/// Up to three planes that are active together.
struct ActiveSet {
  int n;
  int plane[3];
};

struct PolyhedralReturn {
  Vec3 stress = Vec3::Zero();
  Mat3 by_strain = Mat3::Zero();     ///< d stress / d trial strain at constant hardening variable [Pa]
  Vec3 by_hardening = Vec3::Zero();  ///< d stress / d hardening variable at constant trial strain [Pa]
  double violation = std::numeric_limits<double>::infinity();  ///< largest excess or negative multiplier [Pa]
  bool vertex = false;                                         ///< no stress can change at constant hardening variable
};

/// The stress on all planes of the set, eqs. (22)-(25). c: elastic stiffness in principal values.
template <std::size_t N>
PolyhedralReturn return_to_set(const std::array<YieldPlane, N>& planes, std::size_t n_planes, const ActiveSet& set,
                               const Mat3& c, const Vec3& trial) {
  Mat3 a = Mat3::Zero(), b = Mat3::Zero(), a_rate = Mat3::Zero(), b_rate = Mat3::Zero();
  Vec3 limit = Vec3::Zero(), limit_rate = Vec3::Zero();
  for (int k = 0; k < set.n; ++k) {
    const YieldPlane& p = planes[set.plane[k]];
    a.col(k) = p.normal;
    b.col(k) = p.flow;
    limit[k] = p.limit;
    a_rate.col(k) = p.normal_rate;
    b_rate.col(k) = p.flow_rate;
    limit_rate[k] = p.limit_rate;
  }
  const Mat3 cb = c * b;
  Mat3 m = a.transpose() * cb;
  const double stiffness = c(0, 0);
  for (int k = set.n; k < 3; ++k) m(k, k) = stiffness;  // fewer than three planes: the rest of the system is idle
  const Mat3 inverse = m.inverse();

  PolyhedralReturn r;
  const Vec3 multiplier = inverse * (a.transpose() * trial - limit);
  r.stress = trial - cb * multiplier;
  r.stress -= cb * (inverse * (a.transpose() * r.stress - limit));  // what rounding of a far trial stress left
  r.violation = -stiffness * multiplier.head(set.n).minCoeff();
  for (std::size_t k = 0; k < n_planes; ++k) {
    bool active = false;
    for (int i = 0; i < set.n; ++i) active = active || set.plane[i] == int(k);
    if (!active) r.violation = std::max(r.violation, planes[k].excess(r.stress));
  }
  r.vertex = set.n == 3;
  if (!r.vertex) r.by_strain = c - cb * inverse * (a.transpose() * c);
  const Vec3 flow_rate = c * (b_rate * multiplier);
  const Vec3 rate = inverse * (a_rate.transpose() * r.stress - limit_rate - a.transpose() * flow_rate);
  r.by_hardening = -cb * rate - flow_rate;
  return r;
}

}  // namespace berm
