#pragma once
/// Unilateral contact with Coulomb friction by penalty, over one step.   [contact (4) - (6)]

#include "base/tensor.hpp"

namespace berm {

/// Force that resists the relative increment, and its derivative.
struct CoulombForce {
  Vec3 force = Vec3::Zero();
  Mat3 stiffness = Mat3::Zero();
  bool touches = false;
};

/// relative: increment of a against b over the step; carried: the force at t_n; normal: out of a, a unit vector; gap: what
/// is left before they touch. Bodies that just touch count as closed, so that one that is laid on another is held from the
/// first guess on.
inline CoulombForce coulomb(const Vec3& relative, const Vec3& carried, const Vec3& normal, double gap, double stiffness,
                            double friction) {
  CoulombForce out;
  const Vec3 trial = carried + stiffness * relative;
  const double pressure = trial.dot(normal) - stiffness * gap;
  if (pressure < 0.0) return out;
  out.touches = true;
  const Mat3 nn = normal * normal.transpose();
  const Vec3 shear = trial - nn * trial;
  const double size = shear.norm(), limit = friction * pressure;
  if (friction > 0.0 && size <= limit) {
    out.force = pressure * normal + shear;
    out.stiffness = stiffness * Mat3::Identity();
    return out;
  }
  out.force = pressure * normal;
  out.stiffness = stiffness * nn;
  if (limit == 0.0 || size == 0.0) return out;
  const Vec3 direction = shear / size;
  out.force += limit * direction;
  out.stiffness += stiffness * friction * direction * normal.transpose() +
                   stiffness * limit / size * (Mat3::Identity() - nn - direction * direction.transpose());
  return out;
}

}  // namespace berm
