#pragma once
/// A case file in memory: typed, complete, validated. Plain data; filled by read_case() only.
/// Every length is in metres, every angle in radians, every stress in pascals.

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/reference_curve.hpp"
#include "base/time_function.hpp"
#include "law/all.hpp"
#include "law/point_response.hpp"
#include "mesh/gmsh.hpp"
#include "mesh/grid.hpp"
#include "mesh/region.hpp"

namespace berm {

enum class Method { mpm, fem };
enum class Formulation { updated_lagrangian, total_lagrangian };
/// Volumetric strain of a point: its own, the mean over the points of its cell, or that of a pressure at the nodes.
enum class Volumetric { standard, f_bar, mixed };
enum class Quadrature { points, gauss };
/// On the background grid.
enum class ShapeFunctions { linear, quadratic_bspline, cubic_bspline, ugimp, cpgimp, b2gimp, cpdi };
/// Points stand for domains that cover several cells.
constexpr bool has_domains(ShapeFunctions functions) { return functions >= ShapeFunctions::ugimp; }

/// Names of the stages in which something acts; empty: in all.
using Stages = std::vector<std::string>;

/// Which places a boundary condition acts on: everything inside all the given limits.
struct Where {
  std::optional<Vec3> min, max;      ///< box = { min, max }; plane models: z does not limit
  std::optional<std::string> group;  ///< physical curve (space: surface) of a Gmsh body mesh or grid
  struct Sector {
    Vec2 centre;
    double from, to;  ///< counter-clockwise from the x axis, seen against z [rad]
  };
  std::optional<Sector> sector;
  struct HalfSpace {
    Vec3 at, normal;
  };
  std::optional<HalfSpace> beyond;  ///< on the side of a plane to which its normal points
};

struct Material {
  std::string name;
  AnyLaw law;
  double density = 0.0;
  enum class CrackBand { sqrt_area, equal_circle, fixed } crack_band = CrackBand::sqrt_area;
  double crack_band_length = 0.0;  ///< used with CrackBand::fixed
};

struct PointSeeding {
  enum class Kind { grid, mesh } kind = Kind::grid;
  int per_direction = 2;                                                 ///< grid: points per cell and direction
  /// Grid: positions in uncut cells; automatic: uniform if points have domains, else gauss.
  enum class Placement { automatic, gauss, uniform } placement = Placement::automatic;
  BodyMeshOptions mesh;  ///< mesh: the body mesh whose Gauss points become points
  int per_element = 4;  ///< mesh: 1, 3, 6, 12 a triangle; 1, 4, 9, 16 a quad; 1, 4 a tetrahedron; 1, 8, 27 a hexahedron
};

struct Body {
  std::string name;
  bool rigid = false;
  std::string material;        ///< empty for rigid bodies
  std::optional<Shape> shape;  ///< one of shape and mesh_file; a plane or a solid one as `dimension` says
  std::string mesh_file,
      mesh_group;        ///< Gmsh file (path resolved against the case file) and physical surface ("" = all cells)
  PointSeeding points;   ///< mpm
  BodyMeshOptions mesh;  ///< fem
  VectorFunction displacement;  ///< rigid: motion [m]
  VectorFunction acceleration;  ///< deformable: a body force over the density, beside gravity [m/s2]
  VectorFunction velocity;      ///< deformable: of its places at the start [m/s]
};

/// Prescribed displacement of grid nodes (mpm) or body-mesh nodes (fem) in a region.
struct NodeBoundary {
  std::string name;
  std::string body;  ///< whose surface is held, wherever it moves; empty: nodes
  Where where;
  std::array<std::optional<TimeFunction>, 3> u;  ///< ux, uy, uz: displacement [m]; absent: free
  std::optional<Vec3> normal;                    ///< of an inclined slip boundary; of a surface: else its own
  TimeFunction un;                               ///< displacement along it [m]
  Stages stages;

  /// Only along its normal is the displacement prescribed.
  bool slides() const { return !u[0] && !u[1] && !u[2]; }
  bool depends_on_place() const {
    for (const auto& f : u)
      if (f && f->depends_on_place()) return true;
    return false;
  }
};

/// Held material points (any place inside a body): removes rigid motion where no boundary does.
struct Pin {
  std::string name, body;
  Vec3 at;
  std::array<bool, 3> fixed = {false, false, false};  ///< x, y, z
  Stages stages;
};

/// Pressure or traction on the surface of a body (mpm: surface points; fem: element edges). The loaded points move with
/// the material.
struct Pressure {
  std::string name, body;
  Where where;
  TimeFunction value;                      ///< positive pushes into the body [Pa]
  std::optional<VectorFunction> traction;  ///< in its place: force per reference area along the axes [Pa]
  enum class Direction {
    following,  ///< finite kinematics: direction and area are those of the deformed face
    dead        ///< those of the reference state
  } direction = Direction::following;
  Stages stages;
};

/// Dashpots on the surface of a body that let waves out (Lysmer and Kuhlemeyer 1969), in dynamic stages.
struct Absorbing {
  std::string name, body;
  Where where;
  double p_wave_speed = 0.0, s_wave_speed = 0.0;  ///< of the ground beyond [m/s]
  double density = 0.0;                           ///< of the ground beyond [kg/m3]
  Stages stages;
};

/// A deformable body's surface against a rigid body, or against another deformable one at the nodes of the grid.
struct Contact {
  std::string name, body, rigid, other;  ///< one of rigid and other
  enum class Kind {
    tie,           ///< surfaces that touch at the start move together, both ways
    no_slip,       ///< unilateral; no sliding while in touch
    frictionless,  ///< unilateral; free sliding
    friction,      ///< unilateral; slides where the shear reaches Coulomb's limit
    shared_nodes   ///< mpm: grid nodes of the cells that hold the rigid body's points move with it (no slip, no gap)
  } kind = Kind::tie;
  double stiffness = 1000.0;  ///< penalty in units of E/h [-]
  double friction = 0.0;      ///< Coulomb's coefficient, with Kind::friction [-]
  Stages stages;
};

/// Change of the distance between two material points along the line that joins them at the start.
struct Gauge {
  std::string name;
  Vec3 from, to;
};

/// Stresses and strains (tensor shear) in Voigt order, then the rest.
enum class Quantity {
  stress_xx,
  stress_yy,
  stress_zz,
  stress_xy,
  stress_yz,
  stress_zx,
  strain_xx,
  strain_yy,
  strain_zz,
  strain_xy,
  strain_yz,
  strain_zx,
  displacement_x,
  displacement_y,
  displacement_z,
  velocity_x,
  velocity_y,
  velocity_z,
  damage,
  plastic_strain
};

struct Probe {
  std::string name;
  Vec3 at;  ///< reference position
  Quantity quantity = Quantity::stress_xx;
};

/// What drives the run.
struct Control {
  enum class Kind {
    time,  ///< displacements and loads are functions of time
    gauge  ///< a gauge grows linearly to `target` at the end, loads are scaled by an unknown factor
  } kind = Kind::time;
  std::string gauge;
  double target = 0.0;  ///< [m]
};

enum class Analysis { quasi_static, dynamic };

struct Steps {
  Analysis analysis = Analysis::quasi_static;
  double duration = 1.0;  ///< of the stage [s]
  int count = 100;        ///< increments that cover it when none is cut
  bool adaptive = true;
  double min_fraction = 1e-3;     ///< smallest step, as a fraction of duration/count
  double max_fraction = 1.0;      ///< largest step, as a fraction of duration/count
  double error_tolerance = 0.005;  ///< impl_ex: largest error of a stress over the strength aimed at
  int easy_iterations = 5;        ///< implicit: grow the step after fewer iterations than this
};

struct Solver {
  Integration integration = Integration::implicit;
  enum class SnapBack { stop, impl_ex } snap_back = SnapBack::stop;
  double relative_tolerance = 1e-8;   ///< residual norm over the norm of the reactions and loads
  double absolute_tolerance = 1e-10;  ///< of E h t, for unloaded bodies
  int max_iterations = 25;
  bool line_search = true;
  std::optional<double> ghost_penalty;  ///< in units of E; 0 switches it off, absent: as the functions need it
  /// How the linear systems are solved; automatic: direct in the plane, iterative for large systems in space; distributed: direct
  /// on all processes together.
  enum class Linear { automatic, direct, distributed, iterative } linear = Linear::automatic;
  double linear_tolerance = 1e-8;  ///< iterative: true residual over right-hand side
  std::string petsc;               ///< PETSc options, e.g. "-ksp_view -snes_monitor"
};

/// How motion is integrated (docs/theory/dynamics.md).
struct Dynamics {
  enum class Integrator { newmark, bossak, hht } integrator = Integrator::newmark;
  double alpha = -0.1;  ///< of Bossak and HHT: numerical damping of high frequencies [-]
  enum class Mass { lumped, consistent } mass = Mass::lumped;  ///< in the equation of motion
  int projection_order = 1;                                    ///< of the motion of points to nodes (FMPM)
  /// How points take their velocity from the grid (mpm).
  enum class Transfer { flip, pic, blend, apic } transfer = Transfer::flip;
  double flip_fraction = 0.99;      ///< blend: of flip; the rest is pic [-]
  double rayleigh_mass = 0.0;       ///< damping in units of the mass [1/s]
  double rayleigh_stiffness = 0.0;  ///< damping in units of the stiffness [s]
  double local_damping = 0.0;       ///< share of the unbalanced force that opposes the motion [-]
  double error_tolerance = 0.0;     ///< error of the time integration that a step should have; 0: any [-]
};

/// A part of the run with an analysis and a solver of its own; the state is carried over. Times are those of the whole run.
struct Stage {
  std::string name;  ///< empty: the only one
  Steps steps;
  Solver solver;
  Dynamics dynamics;
  bool reset_displacements = false;  ///< points begin the stage with no displacement
  double begin = 0.0;                ///< [s]
  double end() const { return begin + steps.duration; }
};

/// Measured: a slump on such a grid takes up energy without bound [docs/theory/formulation.md, section 15].
inline constexpr const char* mixed_on_moving_simplices =
    "gains energy in motion on triangles and tetrahedra in finite strain: take a grid of quads or hexahedra, or "
    "formulation = \"total_lagrangian\"";

/// Which load and which displacement make the nominal curve.
struct Nominal {
  std::vector<std::string> load;  ///< names of rigid bodies, boundaries or pressures, whose forces are summed
  std::string displacement;  ///< name of a rigid body, boundary or gauge
  Vec3 direction = Vec3(0.0, -1.0, 0.0);
  double area = 1.0;    ///< nominal stress = reaction / area [m2]
  double length = 1.0;  ///< nominal strain = imposed displacement / length [m]
};

struct Output {
  int vtk_every = 0;  ///< steps between VTK files; 0: only first, peak and last
  int frames = 20;    ///< with vtk_every = 0: evenly spaced files over the run
  Nominal nominal;
  std::vector<Gauge> gauges;
  std::vector<Probe> probes;
  std::vector<ReferenceCurve> references;  ///< for the report
};

/// When the state is saved, so that a run can go on after an end of any kind.
struct Checkpoint {
  int every_steps = 0;          ///< steps between checkpoints; 0: by time alone
  double every_minutes = 10.0;  ///< wall-clock minutes between checkpoints; 0: by steps alone
};

/// How the cells are shared out among the processes.
struct Parallel {
  double rebalance = 1.2;  ///< most loaded over mean at which the cells are shared out anew
};

struct Case {
  std::filesystem::path file;
  std::string title;
  Method method = Method::mpm;
  Space space = Space::plane_strain;
  Kinematics kinematics = Kinematics::finite;
  Formulation formulation = Formulation::updated_lagrangian;  ///< mpm only
  Volumetric volumetric = Volumetric::standard;               ///< mpm only
  Quadrature quadrature = Quadrature::points;                 ///< mpm only
  double thickness = 1.0;                                     ///< of plane models [m]
  VectorFunction gravity;                                     ///< [m/s2]
  std::variant<StructuredGrid, std::string> grid;             ///< mpm: structured, or a Gmsh file (resolved path)
  ShapeFunctions shape_functions = ShapeFunctions::linear;    ///< mpm only
  bool allow_glued = false;  ///< mpm: parts that the grid cannot tell apart may hang together
  std::vector<Material> materials;
  std::vector<Body> bodies;
  std::vector<NodeBoundary> boundaries;
  std::vector<Pin> pins;
  std::vector<Pressure> pressures;
  std::vector<Absorbing> absorbing;
  std::vector<Contact> contacts;
  Vec3 origin = Vec3::Zero();  ///< of all places, in the user's coordinates [m]   [sim/far_origin.hpp]
  Control control;
  Steps steps;        ///< of a run with a single stage
  Solver solver;      ///< what stages begin with
  Dynamics dynamics;  ///< likewise
  std::vector<Stage> stages;  ///< in their order, one at least
  std::string petsc_place;    ///< where solver.petsc was written, for what PETSc says of it
  Output output;
  Checkpoint checkpoint;
  Parallel parallel;
  /// Where the tables [kind.NAME] stand that checks beyond the reader's may have to name: "pin.left" -> "dam.toml:14:1".
  std::map<std::string, std::string> places;
  int dimension() const { return space == Space::solid ? 3 : 2; }
  double duration() const { return stages.back().end(); }  ///< of the whole run [s]
  bool is_dynamic() const {
    return std::any_of(stages.begin(), stages.end(), [](const Stage& s) { return s.steps.analysis == Analysis::dynamic; });
  }
  bool moves_with_finite_strain_updated() const {
    return is_dynamic() && kinematics == Kinematics::finite && formulation == Formulation::updated_lagrangian;
  }
  bool has_friction() const {
    return std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.kind == Contact::Kind::friction; });
  }
  std::string resolved;  ///< the case as TOML after `base` and defaults, for the output folder
  std::vector<std::string> warnings;
  std::vector<std::string> choices;  ///< what was chosen where the file is silent, and why
};

/// Calls f with every motion of a case and its gravity. Prescribed displacements and body forces may depend on the place.
template <class AnyCase, class F>
void for_each_motion(AnyCase& c, F f) {
  for (auto& component : c.gravity.component) f(component);
  for (auto& body : c.bodies)
    for (auto* motion : {&body.displacement, &body.acceleration})
      for (auto& component : motion->component) f(component);
  for (auto& boundary : c.boundaries) {
    for (auto& u : boundary.u)
      if (u) f(*u);
    f(boundary.un);
  }
}

}  // namespace berm
