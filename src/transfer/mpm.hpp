#pragma once
/// Implicit material point method on a background grid with linear shape functions (docs/theory/formulation.md). The
/// only place where points meet nodes. Updated Lagrangian: points see the grid from where they are at t_n. Total
/// Lagrangian: they see it from where they started, so that no point ever crosses a cell and no gap can open between
/// points: for specimens that crack but hardly move.

#include <map>
#include <optional>

#include "comm/partition.hpp"
#include "mesh/grid.hpp"
#include "method/discretisation.hpp"
#include "points/seeding.hpp"
#include "shape/grid_basis.hpp"

namespace berm {

/// What a point means over which part of space (docs/adr/0014).
struct ShapeChoice {
  enum class Domain { none, box, parallelepiped };  ///< values at the point; over a box; between the corners of E
  int degree = 1;                                   ///< of the grid's functions (GridBasis)
  Domain domain = Domain::none;
  bool follows = false;  ///< the domain deforms with the body, else it keeps its edges of the start
  bool at_gauss_points = false;  ///< forces inside of the body from stresses at Gauss points; degree 1, no domains
};

class MpmDiscretisation final : public Discretisation {
public:
  /// ghost_penalty: factor on E of the face stabilisation, 0 for none. Domains that follow are for finite strain, boxes for
  /// structured grids of quads or hexahedra, neither for Volumetric::mixed. Throws InputError if the volumetric strain is
  /// to be averaged over cells of which none is a quad or a hexahedron.
  MpmDiscretisation(Grid grid, Space space, double ghost_penalty,
                    Formulation formulation = Formulation::updated_lagrangian, const Comm& comm = {},
                    Volumetric volumetric = Volumetric::standard, ShapeChoice shapes = {});

  /// Adds the points of one body; every process gives all of them, process 0 keeps them until the first move_points.
  /// Throws InputError if a point lies outside of the grid or its cell is too large for the law's fracture energy.
  void add_body(int body, const std::string& name, const Material& material, const SeededPoints& points,
                double thickness);

  /// Of the coordinates: messages have the user's.
  void tell_origin(const Vec3& origin) { origin_ = origin; }

  /// Ways from the points of the body added last to its surface; zero: far. For gaps between bodies.
  void tell_surface(const std::vector<Vec3>& ways);

  /// Bodies of different fields have nodes and cells of their own in the same grid, so that they can part and slide: a
  /// *layered* cell or node has the number of the grid's one plus field times how many there are. Before the first step.
  void set_fields(std::vector<int> field_of_body, int n_fields);
  int n_fields() const override { return n_fields_; }
  const std::vector<Interface>& interfaces() const override { return interfaces_; }
  void look_at_interfaces(const std::vector<char>& held) override;
  struct Overlap {
    int body_a, body_b;  ///< of the case
    Vec3 where;          ///< middle of the cell
    double fill;         ///< of both, over the measure of the cell [-]
  };
  /// Where two bodies lie in one another most, if any do: a cell that both fill by half and more, together by 1.75.
  std::optional<Overlap> overlap() const;
  const std::vector<int>& scalar_nodes() const override { return scalar_nodes_; }

  const Mesh& mesh() const override { return grid_.mesh; }
  const std::vector<Vec3>& node_places() const override { return basis_.places(); }
  void move_points(double rebalance) override;
  int locate(Anchor& anchor) const override;
  void begin_step(const std::vector<Anchor*>& anchors) override;
  void set_pairs(std::vector<AnchorPair*> pairs) override { pairs_ = std::move(pairs); }
  Status evaluate(const NodalVector& du, const LawSettings& settings) override;
  void add_internal_force(NodalVector& f) const override;
  void add_tangent(const LawSettings& settings, BlockAssembler& matrix) const override;
  void add_stabilisation(const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const override;
  void add_body_force(const std::function<Vec3(int body, const Vec3& X)>& acceleration, NodalVector& f) const override;
  void commit(const NodalVector& du, const std::vector<Anchor*>& anchors) override;

  void start_motion(const std::function<Vec3(int body, const Vec3& X)>& velocity) override;
  void add_motion(std::vector<double>& mass, NodalVector& momentum, NodalVector& inertia) const override;
  void add_inertia(double factor, const NodalVector& a, NodalVector& f, BlockAssembler* matrix) const override;
  void start_accelerations(const NodalVector& a) override;
  void commit_motion(const NodalVector& v0, const NodalVector& a0, const NodalVector& v1, const NodalVector& a1,
                     const Dynamics& how) override;
  double kinetic_energy(const Dynamics& how) const override;
  void reset_displacements() override;
  const std::vector<double>& point_masses() const { return mass_; }
  const std::vector<Mat3>& point_velocity_gradients() const { return C_; }

  const std::vector<std::int64_t>& point_ids() const override { return id_; }
  std::vector<Vec3> point_positions() const override { return x_; }
  std::vector<Vec3> point_displacements() const override { return u_; }
  std::vector<Vec3> point_velocities() const override { return v_; }
  std::vector<Vec3> point_origins() const override { return X_; }
  std::vector<Vec3> points_inside(const Region& region, const std::string& body) const override;
  double cell_size() const override { return cell_size_; }

  std::vector<double> cuts() const override { return partition_.numbers(); }
  void restore_cuts(const std::vector<double>& cuts) override;
  int row_width(int slice) const override;
  std::vector<double> point_rows(int slice) const override;
  void restore_points(const std::vector<std::vector<double>>& rows_of_slice) override;

  const Grid& grid() const { return grid_; }
  /// Of the shape functions that see a place in a cell of the grid, without layers.
  std::span<const int> nodes_of(int grid_cell) const { return basis_.nodes_of(grid_cell); }
  /// Without layers.
  const GridBasis& basis() const { return basis_; }
  /// Of the shape functions.
  int degree() const { return basis_.degree(); }
  /// Where the grid sees the points: where they are, total Lagrangian where they started.
  const std::vector<Vec3>& places_in_grid() const { return total_lagrangian_ ? X_ : x_; }
  /// Layered cells of this process that hold material, in the order of the blocks; the cell of the grid that one is; and
  /// the filled fraction of each.
  const std::vector<int>& active_cells() const { return active_cells_; }
  int grid_cell(int layered) const { return layered % grid_.mesh.n_cells(); }
  double fill(int active_index) const { return cells_[active_index].fill; }
  /// Points of a patch, of which all talk to the same nodes, those of the block with its number. Without domains the
  /// patches are the active cells.
  std::span<const int> points_in(int patch) const {
    return {order_.data() + first_[patch], order_.data() + first_[patch + 1]};
  }
  /// Points that there have been on all processes: those of the start and those that came by splitting.
  long points_made() const { return static_cast<long>(next_id_); }
  int n_patches() const { return patch_nodes_.size(); }
  /// Points that lie in each active cell.
  std::vector<std::vector<int>> points_by_cell() const;
  /// Layered, of each point. With the mean dilatation of boxes it may be another process's.
  const std::vector<int>& cells_of_points() const { return layered_; }

private:
  /// What the stabilisation wants to know of an active cell.
  struct CellState {
    double fill = 0.0;
    double stiffness = 0.0;  ///< mean damaged E (plane: times thickness)
    int holds_rigid = 0;     ///< points of a rigid body
    int spare = 0;           ///< 1: little in it, and every node is one of a cell beside it that holds it
  };
  /// F-bar: points of one body in one patch, which share their dilatation.
  struct Group {
    int patch, begin, end;  ///< points order_[begin..end-1] of the patch
  };
  /// A face between two active cells, one of them cut: jump of the first normal derivative of the shape functions that has
  /// one.
  struct Face {
    int block = -1;
    int cell_a = 0, cell_b = 0;  ///< layered
    std::vector<int> node;       ///< of the basis
    /// At each point of the face, by node: the jump times sqrt(gamma E h^(2 degree - 1) times the area of the point).
    std::vector<std::vector<double>> jump;
  };

  void write_row(int p, double* row) const;
  void place_points(const std::vector<std::vector<double>>& rows_of_slice);
  void find_cells();
  double imbalance_of_cuts() const;
  void share_cells(double rebalance);
  void send_points();
  /// The cell whose owner has a point. Boxes with one list of nodes have one mean dilatation, which takes all of them.
  int deciding_cell(int p) const;
  // the connectivity of a step (mpm_connectivity.cpp)
  void sort_points(const std::vector<Anchor*>& anchors);
  void find_carriers(const std::vector<Anchor*>& anchors, const std::function<bool(int layered)>& is_filled);
  void find_carriers_of(const std::vector<std::size_t>& who, const std::vector<double>& mine, const std::function<bool(int layered)>& is_filled);
  std::pair<int, double> nearest_filled(int layered, const Vec3& place,
                                        const std::function<bool(int layered)>& is_filled) const;
  void evaluate_shapes();
  void store_shape(int p, int n, const BasisAt& shape);
  void weigh_cells();
  void average_cells();
  void ask_neighbours();
  void find_spare_cells();
  const CellState* cell_state(int cell) const;
  // stresses at Gauss points (mpm_quadrature.cpp)
  bool is_inside(int active) const;
  void look_at_gauss_points();
  void fit_forces(int active);
  void build_faces();
  Face make_face(int cell_a, int local, int cell_b, double penalty) const;
  void number_nodes();
  void attach(const std::vector<Anchor*>& anchors);
  void attach(int layered, Anchor& anchor, Stencil& stencil) const;
  void attach_pairs();
  // domains of points (mpm_domains.cpp)
  void look_at_domains(const std::vector<Anchor*>& anchors);
  Cover cover_of(int p, BasisAt& shape) const;
  void spread_shape(int p, std::span<const int> own, std::span<const int> nodes);
  void weigh_covered_cells(const std::map<int, CellState>& covered, const std::vector<Anchor*>& anchors);
  Mat3 edges(int p) const;
  Vec3 box_edges(int p) const;
  Vec3 domain_box(int p) const;
  int edge_to_split(int p) const;
  void split_points();
  int layered_cell(int cell, int body) const {
    const bool of_field = body >= 0 && body < static_cast<int>(field_of_body_.size());
    return cell + (of_field ? field_of_body_[body] : 0) * grid_.mesh.n_cells();
  }
  int field_of(int layered_cell) const { return layered_cell / grid_.mesh.n_cells(); }
  /// Layered cell across a face, or -1.
  int neighbour(int layered, int face) const {
    const int other = grid_.neighbours[std::size_t(max_faces) * grid_cell(layered) + face];
    return other < 0 ? -1 : other + field_of(layered) * grid_.mesh.n_cells();
  }
  // where fields meet (mpm_contact.cpp)
  void pair_nodes();
  /// Where a point is now: in small strain x stays at X.
  Vec3 now(int p) const { return x_[p] == X_[p] ? Vec3(X_[p] + u_[p]) : x_[p]; }
  void surfaces_of_interfaces(const std::vector<char>& held);
  void separate_points(const std::vector<char>& held);
  void face_surfaces(const std::vector<char>& held);
  Vec3 outward_at(int p) const;
  struct Extent {
    double place, variance;  ///< from the node [m]; of the places of the surface that points say [m2]
  };
  std::vector<Extent> extents_along(NodalVector& normal) const;
  void gaps_of_interfaces();
  /// Area (volume in space) of a point over the one at reference, as the grid sees it.
  double swollen(int p) const {
    const double J = total_lagrangian_ ? 1.0 : material.F[p].determinant();
    return space_ == Space::axisymmetric && !total_lagrangian_ ? J / material.F[p](2, 2) : J;
  }
  int owner_of_cell(int cell) const { return partition_.owner(cell_centre(grid_.mesh, cell)); }

  template <int dimension, bool hoop>
  void trial_gradients(const NodalVector& du, Kinematics kinematics);
  template <int dimension, bool hoop>
  void internal_force(NodalVector& f) const;
  template <int dimension, bool hoop, int n>
  void cell_tangent(int active, const LawSettings& settings, double* K) const;
  template <int dimension, bool hoop>
  void tangent(const LawSettings& settings, BlockAssembler& matrix) const;
  // F-bar (mpm_f_bar.cpp)
  void group_points();
  Mat3 compatible_F(int p) const;
  void divergence(int p, int n, double* c) const;
  Status average_dilatation();
  double mean_stress_volume(int p) const;
  void add_mean_pressure(NodalVector& f) const;
  template <int dimension, bool hoop, int n>
  void f_bar_tangent(int patch, const LawSettings& settings, double* K) const;
  // pressures of their own (mpm_mixed.cpp)
  std::vector<int> filled_cells() const;
  void add_pressure_blocks();
  void look_up_elasticity();
  Status volumes_of_pressures(const NodalVector& du);
  double own_share(int p) const { return kinematics_ == Kinematics::small ? 0.0 : own_share_[p]; }
  template <int n>
  Eigen::Matrix<double, n, n> pressure_stabilisation(int active) const;
  template <int n>
  void volume_residual(int active, NodalVector& f) const;
  void add_volume_residuals(NodalVector& f) const;
  template <int dimension, bool hoop, int n>
  void mixed_tangent(int active, const LawSettings& settings, BlockAssembler& matrix) const;
  /// Components of the gradient of unit displacements of the n nodes on the trial configuration, and their divergence.
  template <int dimension, bool hoop, int n, class Components, class Row>
  void unit_gradients(int p, Components& B, Row& c) const;
  /// Number of directions that the volumetric strain of the model has: F_zz of plane strain stays 1.
  int volumetric_directions() const { return space_ == Space::plane_strain ? 2 : 3; }

  /// Calls work.operator()<dimension, hoop>().
  template <class Work>
  void with_space(Work work) const;
  /// Calls work.operator()<n>() with the number of nodes of a cell.
  template <int dimension, class Work>
  static void with_nodes(int n, Work work);

  std::span<const int> points_in(const Group& g) const { return {order_.data() + g.begin, order_.data() + g.end}; }
  const double* mean_divergence(std::size_t group) const {
    return mean_divergence_.data() + group * dimension() * most_nodes_;
  }

  /// Shape functions of a point at t_n: n values, then n gradients.
  /// Gradients with which a point of a patch with n nodes pushes at them: its own, or those of its cell's Gauss points.
  const double* force_gradient(int p, int n) const {
    return at_gauss_points_ ? force_gradient_.data() + std::size_t(p) * dimension() * most_nodes_ : shape(p) + n;
  }
  const double* shape(int p) const { return shape_.data() + std::size_t(p) * stride_; }
  double hoop_gradient(const double* s, int n, double r, int k) const;

  Grid grid_;
  GridBasis basis_;
  ShapeChoice shapes_;
  Space space_;
  double ghost_penalty_ = 0.0;
  bool total_lagrangian_ = false;
  bool f_bar_ = false, mixed_ = false;
  double pressure_unit_ = 0.0;  ///< mixed: of the unknowns [Pa/m]
  double cell_size_ = 0.0;
  Vec3 origin_ = Vec3::Zero();
  Kinematics kinematics_ = Kinematics::finite;

  /// Place from which the grid is seen.
  Vec3 seen(int p) const {
    const Vec3& x = total_lagrangian_ ? X_[p] : x_[p];
    return cell_[p] == home_[p] ? Vec3(x + shift_[p]) : x;  // points in their first cell keep its quadrature
  }
  /// Calls work(local nodes, point, its shape) for all points.
  template <class Work>
  void for_points(Work work) const {
    for (int block = 0; block < n_patches(); ++block) {
      const std::span<const int> list = blocks[block];
      for (int p : points_in(block)) work(list, p, shape(p));
    }
  }

  Vec3 seen(const Anchor& a) const { return total_lagrangian_ ? a.X : a.x; }

  Partition partition_;
  bool shared_out_ = false;

  // per point
  std::vector<std::int64_t> id_;
  std::vector<Vec3> X_, x_, u_;  ///< start, now, and what lies between
  std::vector<Vec3> v_, a_;      ///< velocity, acceleration
  std::vector<Mat3> C_;          ///< velocity gradient that the point carries (apic), else zero
  std::vector<double> mass_, measure_;
  std::vector<Mat3> edges_;  ///< of the domain at the start, by columns [m]
  std::vector<Vec3> rim_;    ///< to the body's surface nearby at the start, else zero [m]
  std::vector<int> cell_;
  std::vector<int> layered_;  ///< of the step
  std::vector<int> home_;    ///< first cell of points with a fitted quadrature, else -1
  std::vector<Vec3> shift_;  ///< of their places in that cell
  std::vector<double> shape_;
  std::vector<double> force_gradient_;  ///< see force_gradient()
  std::vector<Mat3> push_;  ///< from gradients at t_n (total: at the start) to the trial configuration
  std::vector<double> stretch_;        ///< F-bar, total Lagrangian: stored over compatible stretch, s of (43)
  std::vector<double> trial_stretch_;  ///< of the trial state
  std::vector<double> share_;          ///< F-bar: of the point in its group's trial volume, w of (44)
  std::vector<double> bulk_, shear_;   ///< mixed: elastic moduli, (48) [Pa]
  std::vector<double> nodal_pressure_;  ///< mixed: trial increments, tension positive [Pa]
  std::vector<double> own_share_;      ///< mixed: of the volumetric strain that a point keeps, (48)
  std::vector<double> excess_;         ///< mixed: volumetric strain of the step beyond that of the pressure, (48)
  int most_nodes_ = 0;      ///< of a patch
  int stride_ = 0;          ///< of shape_
  bool at_gauss_points_ = false;
  std::int64_t next_id_ = 0;  ///< points that there have been, on all processes

  std::vector<double> youngs_of_slice_;  ///< scales the stabilisation (plane: times thickness)

  std::vector<int> field_of_body_;
  int n_fields_ = 1;
  std::vector<Interface> interfaces_;

  Blocks patch_nodes_;                            ///< layered nodes of the basis; block b is of patch b
  std::vector<int> carrier_;                      ///< of an anchor: layered cell whose functions it sees
  std::vector<int> anchor_cells_;                 ///< layered cells with blocks of their own for anchors
  int first_anchor_block_ = 0;
  std::vector<int> active_cells_, active_index_;  ///< layered cell -> index or -1
  std::vector<CellState> cells_;                  ///< by active index
  std::map<int, CellState> remote_;               ///< active cells of other processes at the border
  std::vector<int> order_, first_;
  std::vector<Group> groups_;            ///< F-bar
  std::vector<int> first_group_;         ///< of a patch
  std::vector<int> pressure_block_;      ///< mixed: of an active cell with points, else -1
  std::vector<int> scalar_nodes_;
  std::vector<double> mean_divergence_;  ///< by group: divergence of unit displacements of the nodes, b of (44)
  std::vector<Face> faces_;
  std::vector<int> local_node_;  ///< layered node -> local node or -1

  // what the present node numbers were made for
  Blocks numbered_patches_;
  std::vector<int> numbered_cells_, numbered_anchors_, numbered_filled_;
  std::vector<std::pair<int, int>> numbered_faces_;
  bool numbered_ = false;

  std::vector<AnchorPair*> pairs_;
  std::vector<std::pair<int, int>> cells_of_pairs_;  ///< layered ones whose functions the ends of each see
  std::vector<std::pair<int, int>> numbered_pairs_;  ///< layered cells of pairs, ascending; their blocks are the last ones
  std::vector<Stencil> pair_stencils_;               ///< of the two ends of each pair
};

template <int dimension, bool hoop, int n, class Components, class Row>
void MpmDiscretisation::unit_gradients(int p, Components& B, Row& c) const {
  const double* s = shape(p);
  const Mat3& push = push_[p];
  B.setZero();
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < dimension; ++j) {
      double gradient = 0.0;
      for (int l = 0; l < dimension; ++l) gradient += push(j, l) * s[n + dimension * k + l];
      for (int i = 0; i < dimension; ++i) B(dimension * i + j, dimension * k + i) = gradient;
      c[dimension * k + j] = gradient;
    }
  if constexpr (hoop)
    for (int k = 0; k < n; ++k) {
      double& ring = B(dimension * dimension, dimension * k);
      ring = push(2, 2) * hoop_gradient(s, n, seen(p).x(), k);
      c[dimension * k] += ring;
    }
}

}  // namespace berm
