#pragma once
/// What the step driver asks of a space discretisation. MPM (transfer/) and FEM (fem/) answer with kernels of their
/// own: the reference must be able to disagree.

#include <string>
#include <vector>

#include "mesh/region.hpp"
#include "method/csr.hpp"
#include "method/material_state.hpp"
#include "shape/stencil.hpp"

namespace berm {

/// A material spot that is no integration point: a surface point, a pin, the end of a gauge.
struct Anchor {
  int body = 0;
  Vec2 X = Vec2::Zero();       ///< reference position [m]
  Vec2 x = Vec2::Zero();       ///< current position [m]; stays at X in small strain
  Vec2 u = Vec2::Zero();       ///< displacement since the start [m]
  Stencil stencil;             ///< nodes of the step that carry it
  int block = -1;              ///< block (cell) that contains those nodes
  int cell = -1;               ///< last known cell, a hint
  bool rigid = false;          ///< belongs to a rigid body: its cell needs no stabilisation
  Vec2 inward = Vec2::Zero();  ///< surface points: unit vector into the body; on a cell's edge, that side's cell counts
};

/// Nodal vectors: one Vec2 a node of the grid (mpm) or of the body meshes (fem).
using NodalVector = std::vector<Vec2>;

class Discretisation {
public:
  virtual ~Discretisation() = default;

  /// Fixes the connectivity of the coming step: cells of points and anchors, blocks, stencils. It stays as it is until
  /// the next begin_step. Throws RunError with position and remedy if a point or anchor lies outside the grid.
  virtual void begin_step(std::vector<Anchor*>& anchors) = 0;

  int n_nodes() const { return static_cast<int>(nodes.size()); }
  /// Trial state for the increment du of the step.
  virtual Status evaluate(const NodalVector& du, const LawSettings& settings, bool tangent) = 0;
  /// Internal force of the trial state, added to f (tension pulls nodes inwards: positive = resists).
  virtual void add_internal_force(NodalVector& f) const = 0;
  virtual void add_tangent(BlockAssembler& matrix) const = 0;
  /// Stabilisation of cut cells (linear in du): force and matrix. Nothing for FEM.
  virtual void add_stabilisation(const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const = 0;
  /// Weight of the material under a uniform acceleration, added to f.
  virtual void add_body_force(const Vec2& acceleration, NodalVector& f) const = 0;
  /// The trial state becomes the state; points and anchors move.
  virtual void commit(const NodalVector& du, std::vector<Anchor*>& anchors) = 0;

  /// For output: position and displacement of the integration points, and of the mesh.
  virtual std::vector<Vec2> point_positions() const = 0;
  virtual std::vector<Vec2> point_displacements() const = 0;
  /// Places that stand for a rigid shape: evenly spread points in the cells of the grid; empty for FEM.
  virtual std::vector<Vec2> points_inside(const Region& region, const std::string& body) const = 0;
  /// Representative size of the cells at reference [m]; scales penalties.
  virtual double cell_size() const = 0;

  std::vector<Vec2> nodes;   ///< positions of the nodes that du belongs to, at reference
  std::vector<char> active;  ///< nodes that take part in this step
  Blocks blocks;             ///< connectivity of this step
  MaterialState material;
};

}  // namespace berm
