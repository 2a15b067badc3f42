#pragma once
/// Deformable bodies that touch at the start and stay together: which they are, which nodes they need, and the tie on
/// their surface.   [docs/theory/contact.md]

#include <functional>
#include <map>
#include <set>

#include "bc/surface.hpp"

namespace berm {

/// Two deformable bodies that touch at the start and move together there.
struct Joint {
  int body = 0, other = 0;           ///< of the case
  int contact = -1;                  ///< of the case, kind tie; -1: no contact says anything about the two
  bool shared_nodes = false;         ///< of the grid; else a tie on the surface
  std::vector<SurfacePoint> pieces;  ///< of the surface of `body`, where it touches the other
  double area() const;
};

/// Surfaces that are less far apart count as closed; in the first step of a quasi-static stage those of bodies that are laid down
/// [cells].
inline constexpr double just_touching = 1e-12, still_touching = 0.01;

/// Deformable bodies beside each other at the start, by pairs of the case.
struct Neighbours {
  std::vector<Joint> joints;                          ///< that touch and have no contact that lets them part, and all ties
  std::set<std::pair<int, int>> touching;             ///< all that touch, also at a vertex, but for a hundredth of a cell
  std::set<std::pair<int, int>> apart;                ///< more than a tenth of a cell, and a contact names them
  std::set<std::pair<int, int>> in_a_corner;          ///< that touch at a corner or an edge only, and no contact names them
  std::set<std::pair<int, int>> parted;               ///< by a thin body that is tied to both: with nodes of their own (layers_of_bodies)
  std::map<std::pair<int, int>, double> nearly;       ///< less than a tenth of a cell apart, and no contact names them [m]
};

/// `size`: of the cells. Throws InputError if the bodies of a tie do not touch.
Neighbours find_neighbours(const Case& c, const std::vector<SurfacePoint>& surface, double size);

/// Layers of the grid's nodes, by body: those of fields_of_bodies(), and more for bodies that a tie must join. Joints
/// within a layer become shared nodes. `thin`: what the grid's functions do not tell apart [m]; `in_one_cell`: whether the material on both sides of a piece lies in one cell, so
/// that the grid's functions cannot follow both.   [contact, "Bodies that stay together"]
std::vector<int> layers_of_bodies(const Case& c, Neighbours& neighbours, double thin,
                                  const std::function<bool(const SurfacePoint&)>& in_one_cell);

/// A surface point of one body, tied to the place of the other that it touches at the start.
struct TiePoint {
  AnchorPair ends;
  int id = 0, joint = 0;
  double stiffness = 0.0;    ///< penalty times area [N/m]
  Vec3 gap = Vec3::Zero();   ///< displacement of b less that of a, since the tie began to act, t_n [m]
};
inline Anchor& place_of(TiePoint& p) { return p.ends.a; }
template <>
inline constexpr bool is_plain<TiePoint> = true;
template <>
inline constexpr bool is_plain<Anchor> = true;

class SurfaceTies {
public:
  /// Of the joints without shared nodes. Every process makes all points; process 0 keeps them until the first move.
  SurfaceTies(const Case& c, const std::vector<Joint>& joints, double size, const Comm& comm);

  /// Which joints act from now on; the gaps of those that begin to act are zero.
  void begin_stage(const std::function<bool(const Stages&)>& acts);
  /// Points travel to the owners of the cells of their first ends, and both ends' cells get an anchor. Collective.
  void move(const Discretisation& d);
  const std::vector<AnchorPair*>& pairs() const { return pairs_; }
  /// Anchors of the cells of this process in which ends lie: they are in use if none with material is near.
  std::vector<Anchor>& keepers() { return keepers_; }

  /// Forces that resist du, added to f; their matrix, if wanted.   [contact (10)]
  void add_forces(const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const;
  void commit(const NodalVector& du);
  std::vector<TiePoint>& points() { return points_; }
  const std::vector<TiePoint>& points() const { return points_; }
  /// Of the case; -1: bodies that touch without one.
  int contact_of(const TiePoint& p) const { return contact_[p.joint]; }

private:
  Vec3 gap(const TiePoint& p, const NodalVector& du) const;

  Comm comm_;
  int dimension_;
  std::vector<Stages> stages_;  ///< of the joints
  std::vector<char> acts_;      ///< of the joints
  std::vector<int> contact_;    ///< of the joints
  std::vector<TiePoint> points_;
  std::vector<AnchorPair*> pairs_;
  std::vector<Anchor> keepers_;
};

}  // namespace berm
