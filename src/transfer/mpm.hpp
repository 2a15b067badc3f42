#pragma once
/// Implicit material point method on a background grid with linear shape functions (docs/theory/formulation.md). The
/// only place where points meet nodes. Updated Lagrangian: points see the grid from where they are at t_n. Total
/// Lagrangian: they see it from where they started, so that no point ever crosses a cell and no gap can open between
/// points: for specimens that crack but hardly move.

#include "mesh/grid.hpp"
#include "method/discretisation.hpp"
#include "points/seeding.hpp"

namespace berm {

class MpmDiscretisation final : public Discretisation {
public:
  /// ghost_penalty: factor on E of the face stabilisation, 0 for none.
  MpmDiscretisation(Grid grid, double ghost_penalty, Formulation formulation = Formulation::updated_lagrangian);

  /// Adds the points of one body. Throws InputError if a point lies outside of the grid or its cell is too large for
  /// the law's fracture energy.
  void add_body(int body, const std::string& name, const Material& material, const SeededPoints& points,
                double thickness);

  void begin_step(std::vector<Anchor*>& anchors) override;
  Status evaluate(const NodalVector& du, const LawSettings& settings, bool tangent) override;
  void add_internal_force(NodalVector& f) const override;
  void add_tangent(BlockAssembler& matrix) const override;
  void add_stabilisation(const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const override;
  void add_body_force(const Vec2& acceleration, NodalVector& f) const override;
  void commit(const NodalVector& du, std::vector<Anchor*>& anchors) override;

  std::vector<Vec2> point_positions() const override { return x_; }
  std::vector<Vec2> point_displacements() const override { return u_; }
  std::vector<Vec2> points_inside(const Region& region, const std::string& body) const override;
  double cell_size() const override { return cell_size_; }

  const Grid& grid() const { return grid_; }
  /// Cells that hold material, in the order of the blocks, and the filled fraction of each.
  const std::vector<int>& active_cells() const { return active_cells_; }
  double fill(int active_index) const { return fill_[active_index]; }
  /// Points of an active cell.
  std::span<const int> points_in(int active_index) const {
    return {order_.data() + first_[active_index], order_.data() + first_[active_index + 1]};
  }

private:
  struct Gradients {
    std::array<double, 4> N;
    std::array<Vec2, 4> grad;
  };
  /// A face between two active cells, one of them cut: jump of the normal derivative of the shape functions.
  struct Face {
    int block;
    int cell_a, cell_b;  ///< active indices
    double weight;       ///< gamma E h times the length that one of its two points stands for [N/m * m]
    std::array<std::array<double, 6>, 2> jump;  ///< at two points of the face
  };

  void sort_points(const std::vector<Anchor*>& anchors);
  void evaluate_shapes();
  void build_faces();
  void trial_gradients(const NodalVector& du, Kinematics kinematics);

  Grid grid_;
  std::vector<InteriorEdge> grid_edges_;
  std::vector<double> cell_area_;
  double cell_size_ = 0.0;
  double ghost_penalty_ = 0.0;
  Kinematics kinematics_ = Kinematics::finite;

  bool total_lagrangian_ = false;
  /// Place from which the grid is seen.
  Vec2 seen(int p) const {
    const Vec2& x = total_lagrangian_ ? X_[p] : x_[p];
    return cell_[p] == home_[p] ? Vec2(x + shift_[p]) : x;  // points in their first cell keep its quadrature
  }
  Vec2 seen(const Anchor& a) const { return total_lagrangian_ ? a.X : a.x; }

  std::vector<Vec2> X_, x_, u_;  ///< start, now, and what lies between
  std::vector<double> mass_, area_;
  std::vector<double> youngs_;  ///< of the point's material, scales the stabilisation
  std::vector<int> cell_;
  std::vector<int> home_;    ///< first cell of points with a fitted quadrature, else -1
  std::vector<Vec2> shift_;  ///< of their places in that cell

  std::vector<int> active_cells_, active_index_;  ///< cell -> index or -1
  std::vector<double> fill_;
  std::vector<char> holds_rigid_;  ///< active cells with points of a rigid body
  std::vector<int> order_, first_;
  std::vector<Gradients> shape_;           ///< at t_n
  std::vector<std::array<Vec2, 4>> push_;  ///< gradients on the trial configuration
  std::vector<Face> faces_;
  std::vector<double> cell_stiffness_;  ///< mean damaged E of an active cell
};

}  // namespace berm
