#pragma once
/// What the step driver asks of a space discretisation. MPM (transfer/) and FEM (fem/) answer with kernels of their
/// own: the reference must be able to disagree.
///
/// Every process holds the points of the cells that it owns, and nodal vectors over its *local nodes*: those that it owns,
/// then ghosts, which it touches but another owns (`halo`). Kernels add what this process has to say; the driver adds
/// ghosts to owners.

#include <Eigen/LU>
#include <functional>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "comm/halo.hpp"
#include "mesh/region.hpp"
#include "method/csr.hpp"
#include "method/material_state.hpp"
#include "shape/stencil.hpp"

namespace berm {

/// A material spot that is no integration point: a surface point, a pin, the end of a gauge.
struct Anchor {
  int body = 0;
  Vec3 X = Vec3::Zero();       ///< reference position [m]
  Vec3 x = Vec3::Zero();       ///< current position [m]; stays at X in small strain
  Vec3 u = Vec3::Zero();       ///< displacement since the start [m]
  const Stencil* stencil = nullptr;  ///< nodes of the step that carry it; of the discretisation, from begin_step on
  int block = -1;              ///< block (cell) that contains those nodes
  int cell = -1;               ///< last known cell, a hint
  Mat3 F = Mat3::Identity();   ///< deformation gradient since the start; stays I in small strain
  bool by_reference = false;   ///< the stencil's gradients are by the coordinates of the start, not by those at t_n
  bool rigid = false;          ///< belongs to a rigid body: its cell needs no stabilisation
  Vec3 inward = Vec3::Zero();  ///< surface points: unit vector into the body; on a cell's edge, that side's cell counts

  /// Deformation gradient after the increment du.   [formulation (5), (11), (25)]
  template <class Field>
  Mat3 trial_F(const Field& du) const {
    const Mat3 grad = stencil->gradient_of(du);
    return by_reference ? Mat3(F + grad) : Mat3((Mat3::Identity() + grad) * F);
  }
  /// From the stencil's gradients to those of the configuration after du: F^-T or dF^-T.
  template <class Field>
  Mat3 push(const Field& du) const {
    const Mat3 grad = stencil->gradient_of(du);
    return (by_reference ? Mat3(F + grad) : Mat3(Mat3::Identity() + grad)).inverse().transpose();
  }
};

/// Two places at which two bodies push at each other: one block has the nodes of both, those of `a` first. The process that
/// owns the cell of `a` has the pair; the cell of `b` may be another's, which then keeps it in use.
struct AnchorPair {
  Anchor a, b;
  int block = -1;  ///< of the step
};

/// A place of the grid where two fields have a node each: there their bodies may touch.   [contact (1) - (4)]
struct Interface {
  int field_a = 0, field_b = 0;  ///< a < b
  int a = 0, b = 0;              ///< local nodes, both owned by this process
  int block = -1;
  Vec3 normal = Vec3::Zero();  ///< of the step, out of a; zero if there is none
  double area = 0.0;           ///< of the step: of the surface that the node stands for [m2]
  double gap = 0.0;            ///< of the step, along the normal; not negative [m]
  double scatter = 0.0;        ///< of the step: how far apart the places are that the gap is a mean of [m]
};

/// Nodal vectors: one Vec3 a local node; z = 0 in the plane.
using NodalVector = std::vector<Vec3>;

class Discretisation {
public:
  virtual ~Discretisation() = default;

  /// The mesh of cells, whole on every process: background grid (mpm), meshes of all bodies (fem).
  virtual const Mesh& mesh() const = 0;
  int dimension() const { return mesh().dimension(); }
  /// Where the nodes are that the unknowns belong to: of the mesh, unless the shape functions have others.
  virtual const std::vector<Vec3>& node_places() const { return mesh().nodes; }
  /// Fields that a node may belong to; ids of the halo are numbers of node_places() plus field times how many there are.
  virtual int n_fields() const { return 1; }
  /// Where fields meet in this step: those that this process owns.
  virtual const std::vector<Interface>& interfaces() const {
    static const std::vector<Interface> none;
    return none;
  }
  /// Normals, areas and gaps of the interfaces of the step that has begun. `held`: by component of the nodes that this
  /// process owns, those whose displacement is prescribed. Collective.
  virtual void look_at_interfaces(const std::vector<char>& /*held*/) {}
  /// Local nodes with a single unknown, the first one: pressures.
  virtual const std::vector<int>& scalar_nodes() const {
    static const std::vector<int> none;
    return none;
  }
  const Comm& comm() const { return comm_; }
  int n_nodes() const { return halo.size(); }
  double most_loaded() const { return most_loaded_; }

  /// Points find their cells and travel to the processes that own them; the cells are shared out anew if the most loaded
  /// process has more than `rebalance` times the mean. Collective. Throws RunError with position and remedy if a point
  /// lies outside the grid.
  virtual void move_points(double rebalance) = 0;
  /// Finds an anchor's cell and returns the process that owns it. Throws RunError if it lies outside.
  virtual int locate(Anchor& anchor) const = 0;
  /// Fixes the connectivity of the coming step: cells of points and of this process's anchors, local nodes, blocks,
  /// stencils, those of the pairs too. It stays as it is until the next begin_step. Collective.
  virtual void begin_step(const std::vector<Anchor*>& anchors) = 0;

  /// Trial state for the increment du of the step.
  virtual Status evaluate(const NodalVector& du, const LawSettings& settings) = 0;
  /// Internal force of the trial state, added to f (tension pulls nodes inwards: positive = resists).
  virtual void add_internal_force(NodalVector& f) const = 0;
  /// Tangent of the trial state last evaluated.
  virtual void add_tangent(const LawSettings& settings, BlockAssembler& matrix) const = 0;
  /// Stabilisation of cut cells (linear in du): force and matrix. Nothing for FEM.
  virtual void add_stabilisation(const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const = 0;
  /// Mass of the material times an acceleration, which depends on the body of the case and the place at the start, added
  /// to f.
  virtual void add_body_force(const std::function<Vec3(int body, const Vec3& X)>& acceleration, NodalVector& f) const = 0;

  // Motion: what dynamic analyses ask for.   [dynamics]
  /// Velocities of all places at the start of the motion; accelerations are zero.
  virtual void start_motion(const std::function<Vec3(int body, const Vec3& X)>& velocity) = 0;
  /// Lumped mass, momentum and mass times acceleration of the material, added to the nodes.   [(1), (2)]
  virtual void add_motion(std::vector<double>& mass, NodalVector& momentum, NodalVector& inertia) const = 0;
  /// Consistent mass times a, added to f, and `factor` times the mass, added to the matrix, if wanted.
  virtual void add_inertia(double factor, const NodalVector& a, NodalVector& f, BlockAssembler* matrix) const = 0;
  /// The material takes the accelerations with which a motion begins from the nodes.   [(10)]
  virtual void start_accelerations(const NodalVector& a) = 0;
  /// The material takes its motion from the nodes: v0, a0 at the beginning of the step, v1, a1 at its end. Before
  /// commit().
  virtual void commit_motion(const NodalVector& v0, const NodalVector& a0, const NodalVector& v1, const NodalVector& a1,
                             const Dynamics& how) = 0;
  /// Of the material of this process [J].
  virtual double kinetic_energy(const Dynamics& how) const = 0;
  /// Displacements of points count from the present state.
  virtual void reset_displacements() = 0;

  /// The trial state becomes the state; points, anchors and both ends of the pairs move.
  virtual void commit(const NodalVector& du, const std::vector<Anchor*>& anchors) = 0;

  /// For output: ids, positions, displacements and velocities of this process's integration points.
  virtual const std::vector<std::int64_t>& point_ids() const = 0;
  virtual std::vector<Vec3> point_positions() const = 0;
  virtual std::vector<Vec3> point_displacements() const = 0;
  virtual std::vector<Vec3> point_velocities() const = 0;
  /// Where they were at the start.
  virtual std::vector<Vec3> point_origins() const = 0;
  /// Places that stand for a rigid shape: evenly spread points in the cells of the grid; empty for FEM.
  virtual std::vector<Vec3> points_inside(const Region& region, const std::string& body) const = 0;
  /// Representative size of the cells at reference [m]; scales penalties.
  virtual double cell_size() const = 0;

  /// Everything of a point of a slice as a row of doubles (first: its id), and the points of all slices from such rows,
  /// in whatever order they come: checkpoints. Rows may belong to other processes: they travel. Collective.
  virtual int row_width(int slice) const = 0;
  virtual std::vector<double> point_rows(int slice) const = 0;
  virtual void restore_points(const std::vector<std::vector<double>>& rows_of_slice) = 0;
  /// How space is cut among the processes where that follows the points (mpm), as Partition has it; alike on all of them.
  virtual std::vector<double> cuts() const { return {}; }
  virtual void restore_cuts(const std::vector<double>& /*cuts*/) {}
  /// What the nodes that this process owns keep from step to step (fem): node_width numbers each.
  static constexpr int node_width = 12;
  virtual std::vector<double> node_state() const { return {}; }
  virtual void restore_nodes(const std::vector<std::int64_t>&, const std::vector<double>&) {}

  /// Pairs of this process from the next begin_step on.
  virtual void set_pairs(std::vector<AnchorPair*> /*pairs*/) {}

  Halo halo;                ///< the local nodes of this step
  std::vector<Vec3> nodes;  ///< positions of the local nodes at reference
  Blocks blocks;            ///< connectivity of this step, in local nodes
  long connectivity = 0;    ///< grows whenever halo or blocks change
  MaterialState material;

protected:
  explicit Discretisation(const Comm& comm) : comm_(comm) {}
  Comm comm_;
  std::vector<Stencil> anchor_stencils_;  ///< of the anchors of this step
  double most_loaded_ = 1.0;  ///< points of the most loaded process over the mean
};

}  // namespace berm
