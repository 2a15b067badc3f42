#pragma once
/// Material points of a body's surface: they carry pressure and contact, move with the body, and work alike on the grid
/// (mpm) and on element faces (fem).   [docs/theory/boundaries.md]

#include <array>
#include <string>
#include <vector>

#include "bc/where.hpp"
#include "method/discretisation.hpp"

namespace berm {

/// A piece of a body's surface in the reference state, as the method that meshes or samples the body gives it.
struct SurfacePoint {
  int body = 0;
  Vec3 X = Vec3::Zero();
  Vec3 normal = Vec3::Zero();       ///< outward
  double area = 0.0;                ///< [m2], with the thickness of the plane or around the axis
  double size = 0.0;                ///< edge length [m]
  int n_corners = 0;                ///< in space: of the triangle or quadrilateral that the piece is
  std::array<Vec3, 4> corner;
  std::vector<std::string> groups;  ///< physical curves (surfaces) of a body mesh
};

Vec3 closest_on_piece(const Vec3& x, const SurfacePoint& s);

/// Calls work with the middle and the ends of a piece.
template <class Work>
void look_at_piece(const SurfacePoint& s, Work work) {
  work(s.X);
  for (int k = 0; k < s.n_corners; ++k) work(s.corner[k]);
  if (s.n_corners > 0) return;
  const Vec3 half = 0.5 * s.size * Vec3(-s.normal.y(), s.normal.x(), 0.0);
  work(s.X + half), work(s.X - half);
}

/// Part of a piece that lies inside `where` [-]: the edges of a loaded region seldom are edges of pieces.
double share_inside(const Where& where, const SurfacePoint& s, int dimension);

bool in_group(const SurfacePoint& s, const std::string& group);

struct SurfacePart {
  const SurfacePoint& piece;
  double share;  ///< of the piece
};
/// Pieces of that body's surface, or parts of them, that `where` catches. `table`: of the case, "pressure.NAME". Throws
/// InputError if there are none.
std::vector<SurfacePart> caught_surface(const std::string& table, const Where& where, int body,
                                        const std::string& body_name, const std::vector<SurfacePoint>& surface,
                                        int dimension);

/// Whether some place is in both: a piece on the border of two regions has a part in each.
bool overlap(const std::vector<SurfacePart>& a, const std::vector<SurfacePart>& b);

/// The parts without strips that the border of a region cuts off other faces where it lies a little beyond a corner: narrower than a
/// piece, and less than a tenth of all.
std::vector<SurfacePart> without_strips(const std::vector<SurfacePart>& parts);

/// A place of a body that has not moved yet.
inline Anchor anchor_at(int body, const Vec3& x, const Vec3& normal = Vec3::Zero()) {
  Anchor a;
  a.body = body;
  a.X = a.x = x;
  a.inward = -normal;
  return a;
}

// What of the surface has something to do, and so is followed. Each is a place of its own that travels with the cell that
// holds it; `id` is its number among its kind, the same on every process.

/// A surface point that carries a pressure.
struct PressurePoint {
  Anchor anchor;
  int id = 0, load = 0;        ///< load: index into the case's pressures
  Vec3 area = Vec3::Zero();    ///< times the direction into the body, at reference [m2]
};

/// A surface point with dashpots.
struct DashpotPoint {
  Anchor anchor;
  int id = 0, absorbing = 0;      ///< absorbing: index into the case's absorbing boundaries
  Mat3 damping = Mat3::Zero();    ///< [N s/m]
};

/// A surface point whose displacement is prescribed.
struct HeldPoint {
  Anchor anchor;
  int id = 0, boundary = 0;     ///< boundary: index into the case's
  bool slides = false;          ///< only the displacement along the normal is prescribed
  Vec3 normal = Vec3::Zero();
  double stiffness = 0.0;       ///< penalty times area [N/m]
  Vec3 missing = Vec3::Zero();  ///< prescribed less actual displacement at t_n [m]
};

/// A surface point against a rigid body.
struct ContactPoint {
  Anchor anchor;
  int id = 0, contact = 0;     ///< contact: index into the case's contacts
  double stiffness = 0.0;      ///< penalty times area [N/m]
  Vec3 beside = Vec3::Zero();  ///< from the place on a mesh to that of the shape that was meshed, at the start [m]
  Vec3 slip = Vec3::Zero();    ///< relative displacement since touch, with friction its elastic part, t_n [m]
  Vec3 normal = Vec3::Zero();  ///< outward normal of the rigid body, frozen in the step
  double gap = 0.0;            ///< at t_n, frozen normal [m]
};

/// A point of a rigid body whose cell moves with it (shared nodes).
struct RigidPoint {
  Anchor anchor;
  int id = 0, contact = 0;
};

/// A held spot of a body.
struct PinPoint {
  Anchor anchor;
  int id = 0, pin = 0;  ///< pin: index into the case's pins
  Vec3 stiffness = Vec3::Zero();  ///< by direction; 0: free [N/m]
  Vec3 start = Vec3::Zero();      ///< displacement when it began to act [m]
};

template <>
inline constexpr bool is_plain<PressurePoint> = true;
template <>
inline constexpr bool is_plain<DashpotPoint> = true;
template <>
inline constexpr bool is_plain<HeldPoint> = true;
template <>
inline constexpr bool is_plain<ContactPoint> = true;
template <>
inline constexpr bool is_plain<RigidPoint> = true;
template <>
inline constexpr bool is_plain<PinPoint> = true;

/// Known to every process; each end is carried by the process that owns its cell.
struct GaugeLine {
  std::string name;
  Anchor from, to;
  bool from_here = false, to_here = false;  ///< does this process carry the end?
  Vec3 direction = Vec3::Zero();
  double elongation() const { return direction.dot(to.u - from.u); }
};

}  // namespace berm
