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

/// The stress on all n planes of the set, eqs. (22)-(25), and if asked for its derivatives. c: elastic stiffness in
/// principal values.
template <int n, std::size_t N>
PolyhedralReturn return_to_planes(const std::array<YieldPlane, N>& planes, std::size_t n_planes, const int* set,
                                  const Mat3& c, const Vec3& trial, bool derivatives) {
  Eigen::Matrix<double, 3, n> a, b;
  Eigen::Matrix<double, n, 1> limit;
  for (int k = 0; k < n; ++k) {
    const YieldPlane& p = planes[set[k]];
    a.col(k) = p.normal;
    b.col(k) = p.flow;
    limit[k] = p.limit;
  }
  const Eigen::Matrix<double, 3, n> cb = c * b;
  const Eigen::Matrix<double, n, n> m = a.transpose() * cb, inverse = m.inverse();

  PolyhedralReturn r;
  const Eigen::Matrix<double, n, 1> multiplier = inverse * (a.transpose() * trial - limit);
  r.stress = trial - cb * multiplier;
  r.stress -= cb * (inverse * (a.transpose() * r.stress - limit));  // what rounding of a far trial stress left
  r.violation = -c(0, 0) * multiplier.minCoeff();
  for (std::size_t k = 0; k < n_planes; ++k)
    if (std::find(set, set + n, int(k)) == set + n) r.violation = std::max(r.violation, planes[k].excess(r.stress));
  r.vertex = n == 3;
  if (!derivatives) return r;
  if (!r.vertex) r.by_strain = c - cb * (inverse * (a.transpose() * c));
  Eigen::Matrix<double, n, 1> excess_rate;
  Vec3 flow_rate = Vec3::Zero();
  for (int k = 0; k < n; ++k) {
    const YieldPlane& p = planes[set[k]];
    excess_rate[k] = p.normal_rate.dot(r.stress) - p.limit_rate;
    flow_rate += multiplier[k] * (c * p.flow_rate);
  }
  r.by_hardening = -cb * (inverse * (excess_rate - a.transpose() * flow_rate)) - flow_rate;
  return r;
}

template <std::size_t N>
PolyhedralReturn return_to_set(const std::array<YieldPlane, N>& planes, std::size_t n_planes, const ActiveSet& set,
                               const Mat3& c, const Vec3& trial, bool derivatives) {
  const auto with = [&]<int n>() { return return_to_planes<n>(planes, n_planes, set.plane, c, trial, derivatives); };
  return set.n == 1   ? with.template operator()<1>()
         : set.n == 2 ? with.template operator()<2>()
                      : with.template operator()<3>();
}

}  // namespace berm
