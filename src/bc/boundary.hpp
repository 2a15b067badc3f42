#pragma once
/// Everything that holds or loads the bodies, for both methods: prescribed nodes, pins, pressures, contact with rigid
/// bodies, gauges. Forces are linear in the step's increment except for contact that opens or closes.

#include <map>
#include <set>

#include "bc/surface.hpp"

namespace berm {

/// Surface pieces of one body, given by the method that meshes or samples it.
struct BodySurface {
  int body = 0;
  std::vector<SurfacePoint> points;
};

class BoundaryConditions {
public:
  /// node_groups: physical curves of the mesh that carries the nodes. Throws InputError if a boundary catches no node,
  /// a pressure no surface, a tie no touching surface, a pin or gauge no body.
  BoundaryConditions(const Case& c, const Discretisation& d, std::vector<BodySurface> surfaces,
                     const std::map<std::string, std::vector<int>>& node_groups);

  /// Every anchor that must move with the material.
  std::vector<Anchor*>& anchors() { return anchors_; }

  /// Freezes contact normals and gaps for the step; numbers the equations of the active free dofs.
  void begin_step(const Discretisation& d);
  const std::vector<int>& equation() const { return equation_; }
  int n_equations() const { return n_equations_; }

  /// Prescribed increments of the step from time t0 to t1 (2 per node, 0 where free).
  std::vector<double> prescribed_increment(double t0, double t1) const;

  /// Pin and contact forces that resist du, added to f; their matrix, if wanted.
  void add_forces(const NodalVector& du, double t0, double t1, NodalVector& f, BlockAssembler* matrix) const;
  /// Pressure forces at load factor 1, added to f.
  void add_pressure(NodalVector& f) const;
  bool has_pressure() const { return !pressures_.empty(); }

  /// Contact state at the end of the step.
  void commit(const NodalVector& du, double t0, double t1);

  /// Force of a rigid body (case body index) on the deformable ones at the increment du, whose nodal residual is given
  /// [N].
  Vec2 rigid_force(int body, const NodalVector& du, double t0, double t1, const NodalVector& residual) const;
  /// Total force of a pressure at load factor 1 [N].
  Vec2 pressure_force(const std::string& name) const;
  /// Sum of nodal forces over the nodes of a boundary; each component only where it is prescribed.
  Vec2 boundary_force(int boundary, const NodalVector& residual) const;

  std::vector<GaugeLine>& gauges() { return gauges_; }
  const std::vector<GaugeLine>& gauges() const { return gauges_; }
  const std::vector<PinPoint>& pins() const { return pins_; }
  /// Name of the first boundary none of whose nodes takes part in the step, or "".
  std::string idle_boundary(const Discretisation& d) const;

private:
  struct NodeCondition {
    int node, component, boundary;
    double value;
  };
  /// Force on the body at a contact point and its 2x2 stiffness.
  struct ContactForce {
    Vec2 force;
    Mat2 stiffness;
    bool active;
  };

  void read_boundaries(const Case& c, const Discretisation& d,
                       const std::map<std::string, std::vector<int>>& node_groups);
  void prescribe(int node, int component, int boundary, double value);
  void read_pressures(const Case& c);
  void read_contacts(const Case& c, const Discretisation& d);
  void read_pins_and_gauges(const Case& c);
  ContactForce contact_force(const RigidContact& contact, const ContactPoint& point, const NodalVector& du, double t0,
                             double t1) const;

  const Case& case_;
  double thickness_ = 1.0;
  std::vector<NodeCondition> conditions_;
  std::map<int, std::size_t> owner_;  ///< 2 node + component -> index into conditions_
  std::set<int> moved_by_rigid_;      ///< nodes that a rigid body moves in this step, whatever a boundary says
  std::vector<SurfacePoint> surface_;
  std::vector<PressureLoad> pressures_;
  std::vector<RigidContact> contacts_;
  std::map<int, Region> rigid_regions_;
  std::map<int, Vec2> rigid_offset_;  ///< displacement of the rigid bodies at t_n
  std::vector<PinPoint> pins_;
  std::vector<GaugeLine> gauges_;
  std::vector<Anchor*> anchors_;
  std::vector<int> equation_;
  int n_equations_ = 0;
};

}  // namespace berm
