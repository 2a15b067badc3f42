#pragma once
/// The reference: isoparametric finite elements on the bodies' own meshes, total Lagrangian.
/// Shares laws, solver, boundary conditions and output with MPM, but no kernel (docs/theory/formulation.md).

#include "case/case.hpp"
#include "fem/element.hpp"
#include "mesh/grid.hpp"
#include "method/discretisation.hpp"

namespace berm {

class FemDiscretisation final : public Discretisation {
public:
  /// Adds the mesh of one body; bodies share no nodes. Throws InputError for a cell too large for the fracture energy.
  void add_body(int body, const std::string& name, const Material& material, const Mesh& mesh, double thickness);

  void begin_step(std::vector<Anchor*>& anchors) override;
  Status evaluate(const NodalVector& du, const LawSettings& settings, bool tangent) override;
  void add_internal_force(NodalVector& f) const override;
  void add_tangent(BlockAssembler& matrix) const override;
  void add_stabilisation(const NodalVector&, NodalVector&, BlockAssembler*) const override {}
  void add_body_force(const Vec2& acceleration, NodalVector& f) const override;
  void commit(const NodalVector& du, std::vector<Anchor*>& anchors) override;

  std::vector<Vec2> point_positions() const override;
  std::vector<Vec2> point_displacements() const override;
  std::vector<Vec2> points_inside(const Region&, const std::string&) const override { return {}; }
  double cell_size() const override { return cell_size_; }

  const Mesh& mesh() const { return mesh_; }
  const NodalVector& displacement() const { return u_; }
  /// Gauss points of element e: first[e] .. first[e+1]-1.
  const std::vector<int>& first_point() const { return first_; }
  int body_of_element(int e) const { return body_of_element_[e]; }
  /// First element of a body's mesh.
  int first_element(int body) const;

private:
  struct GaussPoint {
    std::array<double, 8> N;
    std::array<Vec2, 8> grad;  ///< by reference coordinates
  };
  struct BodyMesh {
    int body, first_element;
    Grid corners;  ///< corner cells, to find elements
  };

  void attach(Anchor& anchor) const;

  Mesh mesh_;  ///< of all bodies
  std::vector<BodyMesh> bodies_;
  std::vector<int> body_of_element_;
  std::vector<int> first_ = {0};
  std::vector<GaussPoint> points_;
  std::vector<std::array<Vec2, 8>> push_;  ///< gradients on the trial configuration
  std::vector<double> mass_;
  NodalVector u_;
  double cell_size_ = 0.0, area_ = 0.0;
};

}  // namespace berm
