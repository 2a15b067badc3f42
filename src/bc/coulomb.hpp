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

/// relative: increment of a against b over the step; normal: out of a, a unit vector; gap: what is left before they
/// touch. The tangential force follows the increment (stick) up to friction times the pressure (slip); it starts from zero in
/// every step.
inline CoulombForce coulomb(const Vec3& relative, const Vec3& normal, double gap, double stiffness, double friction) {
  CoulombForce out;
  const double approach = relative.dot(normal) - gap;
  if (approach <= 0.0) return out;
  out.touches = true;
  const double pressure = stiffness * approach;
  const Mat3 nn = normal * normal.transpose();
  const Vec3 slip = relative - nn * relative;
  const double length = slip.norm(), limit = friction * pressure;
  if (stiffness * length <= limit) {
    out.force = pressure * normal + stiffness * slip;
    out.stiffness = stiffness * (friction > 0.0 ? Mat3(Mat3::Identity()) : nn);
    return out;
  }
  const Vec3 direction = slip / length;
  out.force = pressure * normal + limit * direction;
  out.stiffness = stiffness * (nn + friction * direction * normal.transpose()) +
                  limit / length * (Mat3::Identity() - nn - direction * direction.transpose());
  return out;
}

}  // namespace berm
