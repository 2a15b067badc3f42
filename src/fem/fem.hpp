#pragma once
/// The reference: isoparametric finite elements on the bodies' own meshes, total Lagrangian, in the plane, around an
/// axis or in space. Shares laws, solver, boundary conditions and output with MPM, but no kernel
/// (docs/theory/formulation.md).
///
/// Every process knows the meshes; elements, with their Gauss points, are shared out once, by their centres.

#include "case/case.hpp"
#include "comm/partition.hpp"
#include "mesh/grid.hpp"
#include "method/discretisation.hpp"

namespace berm {

class FemDiscretisation final : public Discretisation {
public:
  explicit FemDiscretisation(Space space, const Comm& comm = {});

  /// Adds the mesh of one body, before the first move_points and alike on every process; bodies share no nodes. Throws
  /// InputError for an element that is turned inside out, lies across the axis of rotation or is too large for the
  /// fracture energy.
  void add_body(int body, const std::string& name, const Material& material, const Mesh& mesh, double thickness);
  /// Gauss points of a body's elements, those of all processes.
  int points_of_body(int body) const;

  /// Of all bodies.
  const Mesh& mesh() const override { return mesh_; }
  /// Shares out the elements the first time; they stay where they are afterwards.
  void move_points(double rebalance) override;
  /// Meshes of curved bodies leave slivers outside: the nearest element within half a cell serves, its functions
  /// extended.
  int locate(Anchor& anchor) const override;
  void begin_step(const std::vector<Anchor*>& anchors) override;
  void set_pairs(std::vector<AnchorPair*> pairs) override { pairs_ = std::move(pairs); }
  Status evaluate(const NodalVector& du, const LawSettings& settings) override;
  void add_internal_force(NodalVector& f) const override;
  void add_tangent(const LawSettings& settings, BlockAssembler& matrix) const override;
  void add_stabilisation(const NodalVector&, NodalVector&, BlockAssembler*) const override {}
  void add_body_force(const std::function<Vec3(int body, const Vec3& X)>& acceleration, NodalVector& f) const override;
  void commit(const NodalVector& du, const std::vector<Anchor*>& anchors) override;

  void start_motion(const std::function<Vec3(int body, const Vec3& X)>& velocity) override;
  void add_motion(std::vector<double>& mass, NodalVector& momentum, NodalVector& inertia) const override;
  void add_inertia(double factor, const NodalVector& a, NodalVector& f, BlockAssembler* matrix) const override;
  void start_accelerations(const NodalVector& a) override { a_ = a; }
  void commit_motion(const NodalVector& v0, const NodalVector& a0, const NodalVector& v1, const NodalVector& a1,
                     const Dynamics& how) override;
  double kinetic_energy(const Dynamics& how) const override;
  void reset_displacements() override { u_before_ = u_; }

  /// Numbers of the Gauss points: body by body, element by element, point by point of the rule.
  const std::vector<std::int64_t>& point_ids() const override { return id_; }
  std::vector<Vec3> point_positions() const override;
  std::vector<Vec3> point_displacements() const override;
  std::vector<Vec3> point_velocities() const override { return interpolate(v_); }
  std::vector<Vec3> point_origins() const override;
  std::vector<Vec3> points_inside(const Region&, const std::string&) const override { return {}; }
  double cell_size() const override { return cell_size_; }

  /// A point's row: its id, then what the material keeps.
  int row_width(int slice) const override { return 1 + material.row_width(slice); }
  std::vector<double> point_rows(int slice) const override;
  /// Throws InputError if the rows are not those of all Gauss points.
  void restore_points(const std::vector<std::vector<double>>& rows_of_slice) override;
  /// Displacement, velocity, acceleration, displacement when displacements were last reset.
  std::vector<double> node_state() const override;
  /// Nodes may come from any process. Throws InputError if one is missing.
  void restore_nodes(const std::vector<std::int64_t>& ids, const std::vector<double>& state) override;

  /// Of the local nodes, since the start.
  const NodalVector& displacement() const { return u_; }
  /// Elements of this process, ascending; block k belongs to elements()[k].
  const std::vector<int>& elements() const { return elements_; }
  /// Their Gauss points: those of elements()[k] are first_point()[k] .. first_point()[k + 1] - 1.
  const std::vector<int>& first_point() const { return first_; }
  int body_of_element(int element) const { return body_of_element_[element]; }

private:
  struct BodyMesh {
    int body;
    std::string name;
    Material material;
    double thickness;
    int first_element, n_elements;
    double cell_size;
    Grid corners;  ///< straight-sided cells with the same corners, to find elements
  };

  double add_element(const BodyMesh& body, int element);
  const BodyMesh& body_mesh(int body) const;
  double crack_band(const BodyMesh& body, int element) const;
  int owner_of_element(int element) const { return partition_.owner(cell_centre(mesh_, element)); }
  int element_of_point(std::int64_t id) const;

  void share_out();
  void share_elements();
  void build_points();
  void number_nodes();
  std::vector<std::vector<double>> rows_by_owner(int slice, const std::vector<double>& rows) const;
  std::vector<double> own_rows(int slice, const std::vector<std::vector<double>>& from) const;

  int find_element(const BodyMesh& body, const Anchor& anchor) const;
  int walk_to(const BodyMesh& body, int start, const Vec3& x) const;
  int search(const BodyMesh& body, const Vec3& x) const;
  /// The functions of the anchor's element; its nodes are those of `local`.
  void attach(Anchor& anchor, std::span<const int> local, Stencil& stencil) const;
  void attach(Anchor& anchor, Stencil& stencil) const;
  void attach_pairs();

  /// Calls work(ElementType, k) for every element k of this process.
  template <class Work>
  void for_elements(Work work) const;
  template <int dimension>
  Eigen::Matrix<double, dimension, dimension> push(int p) const;
  double hoop_push(int p) const;
  double element_mass(int k, double* M) const;
  template <class Type>
  void element_tangent(int k, const LawSettings& settings, double* K) const;
  /// Values at the Gauss points of what local nodes have.
  std::vector<Vec3> interpolate(const std::vector<Vec3>& nodal) const;

  Space space_;
  Kinematics kinematics_ = Kinematics::finite;
  double cell_size_ = 0.0, measure_ = 0.0;

  // alike on every process
  Mesh mesh_;
  std::vector<BodyMesh> bodies_;
  std::vector<int> body_of_element_;
  std::vector<std::int64_t> first_number_ = {0};  ///< of an element's Gauss points
  Partition partition_;
  bool shared_out_ = false;

  // of this process
  std::vector<int> elements_, first_ = {0};
  std::vector<std::int64_t> id_;
  std::vector<Mat3> inverse_;    ///< d(xi)/dX at the Gauss points
  std::vector<double> radius_;   ///< around an axis: of the Gauss points at reference
  std::vector<double> density_;  ///< of the elements
  NodalVector u_, v_, a_;        ///< displacement, velocity and acceleration of the local nodes
  NodalVector u_before_;         ///< displacement that is not counted
  static constexpr std::array state_ = {&FemDiscretisation::u_, &FemDiscretisation::v_, &FemDiscretisation::a_,
                                        &FemDiscretisation::u_before_};

  std::vector<AnchorPair*> pairs_;
  std::vector<std::pair<int, int>> tied_;  ///< their elements, ascending; their blocks follow the elements'
  std::vector<Stencil> pair_stencils_;     ///< of the two ends of each pair
};

}  // namespace berm
