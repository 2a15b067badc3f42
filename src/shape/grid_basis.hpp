#pragma once
/// Shape functions on a background grid: linear functions of its cells, or B-splines on its lines. Their nodes are the
/// unknowns' places.   [docs/theory/formulation.md, section 16]

#include <array>
#include <span>
#include <vector>

#include "mesh/grid.hpp"

namespace berm {

/// Shape functions of a cell at one point; only the first n entries hold something.
struct BasisAt {
  static constexpr int most = 64;  ///< cubic, in space
  int n = 0;
  std::array<int, most> nodes;
  std::array<double, most> N;   ///< values [-]
  std::array<Vec3, most> grad;  ///< gradients by physical coordinates [1/m]
};

/// Cells that the domain of a point covers (docs/adr/0014), and the share of it that lies in each.
struct Cover {
  int n = 0;
  std::array<int, 8> cell;
  std::array<double, 8> share;  ///< sum 1

  void add(int of_cell, double part) {
    for (int k = 0; k < n; ++k)
      if (cell[k] == of_cell) return void(share[k] += part);
    cell[n] = of_cell;
    share[n++] = part;
  }
};

class GridBasis {
public:
  /// degree 1: linear functions of the grid's cells, nodes are those of its mesh. 2, 3: B-splines with knots on the lines of
  /// a structured grid of quads or hexahedra, continuous with their derivatives of order degree - 1, with repeated knots at
  /// its edges, so that the functions there take nodal values. `grid` must outlive the basis. Throws InputError for grids
  /// that are not structured.
  GridBasis(const Grid& grid, int degree);

  int degree() const { return degree_; }
  int n_nodes() const { return static_cast<int>(places_.size()); }
  /// Of a cell, at most.
  int most_nodes() const { return most_nodes_; }
  /// Where the nodes are: a linear field has the coefficients that it takes there (B-splines: Greville's abscissae).
  const std::vector<Vec3>& places() const { return places_; }
  std::span<const int> nodes_of(int cell) const;

  /// Also valid slightly outside of the cell. False if the cell's map cannot be inverted at x.
  bool evaluate(int cell, const Vec3& x, BasisAt& out) const;
  /// The derivative of order `degree` along the unit vector `normal` of a face, in place of the values: the first one that
  /// jumps there [1/m^degree].
  bool highest_derivative(int cell, const Vec3& x, const Vec3& normal, BasisAt& out) const;
  /// Means of the functions and of their gradients over a box about x with the given edges along the grid's own axes, none
  /// longer than a cell's (GIMP: Bardenhagen and Kober 2004; with degree 2, B2-GIMP). What lies outside of the grid is cut
  /// off. n = (degree + 2)^dimension; functions that the grid does not have: node -1, values zero. The first cell of the
  /// cover is that of the lowest corner of the box: boxes with the same one have the same nodes. Degree 1 and 2, structured
  /// grids of quads or hexahedra.   [docs/theory/formulation.md, (58), (59)]
  Cover average_box(const Vec3& x, const Vec3& edges, BasisAt& out) const;
  /// The first cell of that cover.
  int lowest_cell(const Vec3& x, const Vec3& edges) const;
  /// The same over a parallelogram or parallelepiped about x with the columns of `edges`, of functions that are linear
  /// along its edges and agree with those of the grid at its corners (CPDI: Sadeghirad, Brannon and Burghardt 2011). One
  /// that reaches out of the grid is shrunk about x until it does not. Nodes: those of the covered cells, which are in
  /// ascending order and at most one a corner. `hint`: cell of x. An empty cover if x is on the very edge of the grid or
  /// the map of a cell cannot be inverted. Degree 1, any grid.   [(60)]
  Cover average_corners(const Vec3& x, const Mat3& edges, int hint, BasisAt& out) const;
  const Mat3& to_own_axes() const { return back_; }

private:
  struct Spans {
    std::array<int, 3> cell;     ///< knot span by direction
    std::array<double, 3> at;    ///< place in units of cells
  };
  Spans spans(int cell, const Vec3& x) const;
  using Factors = std::array<double, 4>;  ///< of the functions that a cell or a segment sees in one direction
  void multiply_all(int last, const std::array<Factors, 3>& value, const std::array<Factors, 3>& slope,
                    BasisAt& out) const;
  struct Reach {
    int first = 0;        ///< span of the lower end
    double beyond = 0.0;  ///< share in the next one
  };
  Reach means(int direction, double low, double high, Factors& value, Factors& slope) const;
  int node(int i, int j, int k) const;
  double spline(int direction, int i, int order, int derivative, const Spans& s) const;

  const Grid* grid_;
  int degree_, dimension_, most_nodes_ = 0;
  std::array<int, 3> cells_{1, 1, 1};
  Mat3 back_ = Mat3::Identity();  ///< from the plane to the grid's own axes
  std::vector<Vec3> places_;
  std::vector<int> nodes_;        ///< B-splines: of all cells
};

}  // namespace berm
