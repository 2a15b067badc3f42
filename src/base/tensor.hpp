#pragma once
/// Small fixed-size tensors. Conventions of the whole program: SI units, radians, tension positive.

#include <Eigen/Core>

namespace berm {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;
/// Places and displacements of plane and of solid models alike: z = 0 in the plane.
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// The plane in space, and back.
inline Vec3 in_space(const Vec2& x) { return {x.x(), x.y(), 0.0}; }
inline Vec2 in_plane(const Vec3& x) { return x.head<2>(); }

/// Symmetric second-order tensor in Voigt order xx, yy, zz, xy, yz, zx.
/// Strains carry engineering shear (gamma = 2 eps), stresses do not.
using Voigt = Eigen::Matrix<double, 6, 1>;
/// Stiffness: stress = Voigt66 * strain.
using Voigt66 = Eigen::Matrix<double, 6, 6>;

enum VoigtIndex { XX = 0, YY = 1, ZZ = 2, XY = 3, YZ = 4, ZX = 5 };

}  // namespace berm
