#pragma once
/// Everything that holds or loads the bodies, for both methods: prescribed nodes, pins, pressures, contact with rigid
/// bodies, gauges.

#include <map>

#include "bc/grid_contact.hpp"
#include "bc/surface.hpp"
#include "bc/surface_tie.hpp"

namespace berm {

/// Forces on the deformable bodies, summed over all processes [N].
struct Reactions {
  std::vector<Vec3> rigid;     ///< by case body; zero for deformable ones
  std::vector<Vec3> boundary;  ///< by case boundary; each component only where it is prescribed
  std::vector<double> node;    ///< by prescribed component of a node, if a displacement depends on the place
  double held_work = 0.0;      ///< of held surfaces in the step [J]
};

/// Fields of the grid that the bodies of a case need, by body: every body that can part from another deformable one has its
/// own, all others share 0.
std::vector<int> fields_of_bodies(const Case& c);

class BoundaryConditions {
public:
  /// surfaces: of all deformable bodies. Every process gives all of them; process 0 keeps what is to be followed until
  /// the first move_anchors. Throws InputError if a boundary catches no node, a pressure no surface, a tie no touching
  /// surface.
  BoundaryConditions(const Case& c, const Discretisation& d, const std::vector<SurfacePoint>& surfaces,
                     const std::vector<Joint>& joints = {});

  /// Only what acts in that stage counts from now on.
  void begin_stage(const std::string& name);
  const std::string& stage() const { return stage_; }

  /// Anchors travel to the processes that own their cells. Collective. Throws RunError if one lies outside the grid.
  void move_anchors(const Discretisation& d);
  /// Anchors of this process that must move with the material.
  const std::vector<Anchor*>& anchors() const { return anchors_; }
  /// Pairs of places that are tied together.
  const std::vector<AnchorPair*>& pairs() const { return ties_.pairs(); }

  /// Which unknowns are prescribed in this step; freezes contact normals and gaps. Collective.
  void begin_step(const Discretisation& d);
  /// One flag an unknown: dimension * local node + component.
  const std::vector<char>& fixed() const { return fixed_; }
  /// Unknowns of all processes that are not prescribed.
  long n_free() const { return n_free_; }

  /// Prescribed increments of the step from time t0 to t1 (one an unknown, 0 where free).
  std::vector<double> prescribed_increment(double t0, double t1) const;

  /// While a step is guessed, surfaces less than that far from a rigid body at t_n go along with it, whichever way it moves, and
  /// those of deformable bodies with each other where they first meet; else none_closed [m].
  void keep_closed(double gap) {
    kept_closed_ = gap;
    grid_contact_.keep_closed(gap);
  }
  /// Of the matrix alone: what slides along a rigid body resists its slip by that share of the stiffness of contact [-].
  void resist_sliding(double share) { sliding_spring_ = share; }
  /// Pin and contact forces that resist du, added to f; their matrix, if wanted.
  void add_forces(const Discretisation& d, const NodalVector& du, double t0, double t1, NodalVector& f,
                  BlockAssembler* matrix) const;
  /// Forces of dashpots that resist the velocity v of the nodes, added to f; their matrix times dv/du, if wanted.
  void add_dashpots(const NodalVector& v, double dv_by_du, NodalVector& f, BlockAssembler* matrix) const;
  /// Pressure forces at that time on the surface as du has moved it, times factor, added to f; what they take from the
  /// matrix, if wanted.
  void add_pressure(double time, const NodalVector& du, double factor, NodalVector& f, BlockAssembler* matrix) const;
  /// True if the matrices of all these forces are symmetric.
  bool symmetric() const;

  /// Contact state at the end of the step, before the anchors move; gauges once they have. Collective.
  void commit(const Discretisation& d, const NodalVector& du, double t0, double t1);
  /// Between deformable bodies.
  GridContact& grid_contact() { return grid_contact_; }
  const GridContact& grid_contact() const { return grid_contact_; }
  void share_gauges();

  /// What supports and rigid bodies do to the material at the increment du, whose nodal residual (complete at owned
  /// nodes) is given. Collective.
  Reactions reactions(const NodalVector& du, double t0, double t1, const NodalVector& residual) const;
  /// Work of the supports and rigid bodies of the stage in the step, by the trapezoidal rule [J].   [formulation (21)]
  double support_work(const Reactions& before, const Reactions& now, double t0, double t1) const;
  /// Sums over the surface of a pressure.
  struct LoadSum {
    long points = 0;
    double area = 0.0;  ///< on which it acts in the reference state [m2]
    Vec3 force = Vec3::Zero(), moment = Vec3::Zero();  ///< [N], about the origin of coordinates [N m]
  };
  /// Of every pressure at that time on the surface as du has moved it. Collective.
  std::vector<LoadSum> load_sums(double time, const NodalVector& du) const;
  /// Their forces alone [N]. Collective.
  std::vector<Vec3> pressure_forces(double time, const NodalVector& du) const;
  /// What contact and pins take in the step, of all processes. Collective.
  ContactWork contact_work(const NodalVector& du, double t0, double t1) const;

  const std::vector<GaugeLine>& gauges() const { return gauges_; }
  /// Adds the gauge's elongation as a functional of du over the local nodes: value = sum functional . du.
  void add_gauge_functional(int gauge, NodalVector& functional) const;

  /// A place that something holds in a direction: of a node of this process (body -1), or of a body.
  struct Hold {
    int body = -1, node = -1;  ///< node: local
    int boundary = -1;         ///< of the case; -1: something else
    Vec3 at, direction;
    int contact = -1;          ///< of the case, if it can open
    double gap = 0.0;          ///< of that contact at t_n [m]
    Vec3 push = Vec3::Zero();  ///< the way in which that contact can push the body
    Vec3 inward = Vec3::Zero(); ///< normal of the body there; along `push` where the two really touch
  };
  /// Whatever holds in this step and stage: supports, pins, rigid bodies. Of this process.
  std::vector<Hold> holds(const Discretisation& d) const;

  /// Sentences on contacts with friction that let a body go: of what touches at t_n, nine tenths slide. Collective.
  std::vector<std::string> slipping() const;

  /// What the user should know of the supports as they were read; on every process.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Names of the boundaries none of whose nodes takes part in the step. Collective.
  std::vector<std::string> idle_boundaries() const;
  /// Where a surface follows its support worst: what is missing of the prescribed displacement [m]. Of this process; boundary -1: nowhere.
  struct Lag {
    int boundary = -1;
    double missing = 0.0, prescribed = 0.0;
    Vec3 at = Vec3::Zero();
  };
  Lag worst_lag(double time) const;
  /// By contact of the case that ties, how far apart its surfaces have moved along their normal since the start, at most [m].
  /// Collective.
  std::map<int, double> tied_apart() const;

  /// What anchors keep from step to step, as rows of doubles: 0 contact, 1 pressure, 2 pins; of process 0 only: 3
  /// gauges, 4 inclined boundaries; of all: 5 dashpots, 6 held surfaces, 7 the two ends of ties.
  static constexpr int n_kinds = 8;
  /// id, x, u, F, slip (pins: displacement when they began; held surfaces: what is missing; ties: gap).
  static constexpr int row_width = 19;
  std::vector<double> rows(int kind) const;
  /// Rows of all processes, given to each, whoever has the anchors now; they travel with the next move_anchors.
  void restore(int kind, const std::vector<double>& rows);
  /// Where rigid bodies are at that time. Throws RunError if it is out of reach.
  void move_rigid(double time);
  /// The same; their points too move in finite kinematics.
  void restore_rigid(double time);
  void check_held_surfaces(double time) const;

private:
  struct NodeCondition {
    int node, component, boundary;  ///< node of the mesh
    Vec3 at;                        ///< place of the node
  };
  /// A node that is held along a normal by a penalty, alike on every process.
  struct InclinedNode {
    int node, boundary;  ///< node of the mesh, in its field
    double stiffness;    ///< [N/m]
    double push = 0.0;   ///< force of the node against the support at t_n [N]
  };
  /// An inclined node among the local ones.
  struct LocalInclined {
    int index;               ///< into inclined_
    int node, block, place;  ///< local node, a block that has it, its place there
    double share;            ///< 1 / processes that have it
  };
  /// Force on the body at a contact point, its stiffness, and what is kept from it.
  struct ContactForce {
    Vec3 force = Vec3::Zero();
    Mat3 stiffness = Mat3::Zero();
    bool active = false;
    Vec3 slip = Vec3::Zero();  ///< elastic, at the end of the step [m]
    double heat = 0.0;         ///< [J]
  };
  /// A pressure at the trial increment.
  struct PressureForce {
    double value;  ///< [Pa]
    Vec3 area;     ///< [m2], towards the body
    Vec3 place;    ///< [m]
  };

  void read_boundaries(const Case& c, const Discretisation& d);
  void read_boundary(int boundary, double stiffness, const Case& c, const Discretisation& d);
  void prescribe(int node, const Vec3& at, int component, int boundary);
  /// Prescribed nodes among the local ones.
  void find_prescribed(const Discretisation& d);
  void find_inclined(const Discretisation& d);
  /// Normals and gaps of contact with rigid bodies, frozen over the step.
  void find_gaps();
  double push_of(const LocalInclined& local, const NodalVector& du, double t0, double t1) const;
  void read_pressures(const Case& c, const std::vector<SurfacePoint>& surface);
  void read_absorbing(const Case& c, const std::vector<SurfacePoint>& surface);
  void read_held_surfaces(const Case& c, const std::vector<SurfacePoint>& surface);
  void refuse_disagreement(const NodeBoundary& spec, const NodeBoundary& first,
                           const std::vector<SurfacePoint>& surface) const;
  Mat3 held_directions(const HeldPoint& p) const;
  Vec3 held_step(const HeldPoint& p, double t0, double t1) const;
  Vec3 still_missing(const HeldPoint& p, const NodalVector& du, double t0, double t1) const;
  Vec3 held_force(const HeldPoint& p, const NodalVector& du, double t0, double t1) const;
  void commit_held_surfaces(const NodalVector& du, double t0, double t1);
  /// A force on the body at an anchor, which resists with that stiffness.
  void add_at(const Anchor& a, const Vec3& force, const Mat3& stiffness, NodalVector& f, BlockAssembler* matrix) const;
  void read_contacts(const Case& c, const Discretisation& d, const std::vector<SurfacePoint>& surface);
  void read_contact(int contact, const Case& c, const Discretisation& d, const std::vector<SurfacePoint>& surface);
  void add_rigid_points(const Case& c, int contact, const Region& region, const Discretisation& d);
  void read_pins_and_gauges(const Case& c, const Discretisation& d);
  void share_nodes(const Discretisation& d);
  Vec3 rigid_step(int body, double t0, double t1) const;
  /// Does it touch anything in this stage?
  bool acts_on_something(int rigid_body) const;
  bool follows(const Pressure& spec) const;
  PressureForce pressure_force(const PressurePoint& point, double time, const NodalVector& du) const;
  /// d(value area)/d(du) by nodes and components, times the value of the shape functions: a block.
  void add_pressure_matrix(const PressurePoint& point, double time, const NodalVector& du, double factor,
                           BlockAssembler& matrix) const;
  ContactForce contact_force(const ContactPoint& point, const NodalVector& du, double t0, double t1) const;

  const Case& case_;
  Comm comm_;
  int dimension_ = 2;
  double cell_size_ = 0.0;
  std::vector<NodeCondition> conditions_;
  GridContact grid_contact_;  ///< of the stage
  std::vector<InclinedNode> inclined_;
  bool by_place_ = false;  ///< a prescribed displacement depends on the place
  std::map<std::pair<int, int>, std::vector<int>> boundaries_at_;  ///< node, component -> boundaries, while reading
  std::vector<PressurePoint> pressures_;
  std::vector<DashpotPoint> dashpots_;
  std::vector<HeldPoint> held_;
  std::vector<ContactPoint> contacts_;
  std::vector<RigidPoint> rigid_points_;
  std::vector<PinPoint> pins_;
  std::vector<GaugeLine> gauges_;
  std::vector<int> rigid_of_contact_;   ///< case body
  std::map<int, Region> rigid_regions_;
  std::vector<Vec3> rigid_offset_;  ///< displacement of the rigid bodies at t_n, by case body
  std::vector<Anchor*> anchors_;
  double kept_closed_ = none_closed;
  double sliding_spring_ = 0.0;
  std::vector<std::string> warnings_;

  std::string stage_;
  bool acts(const Stages& stages) const;

  // of the step
  std::vector<char> fixed_;
  std::vector<std::pair<int, int>> local_conditions_;  ///< index into conditions_, local node
  std::vector<double> reached_;  ///< by boundary: 1 if it has nodes of this process, that another may hold for it
  std::vector<LocalInclined> local_inclined_;
  std::vector<int> moved_by_;  ///< local node -> contact whose rigid body moves it, whatever a boundary says, or -1
  int n_owned_ = 0;
  long n_free_ = 0, connectivity_ = -1;

  SurfaceTies ties_;
};

}  // namespace berm
