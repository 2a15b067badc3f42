#pragma once
/// Where material points start: n per direction in every cell of the grid, clipped to the body, or at the Gauss
/// points of a body mesh.

#include <vector>

#include "case/case.hpp"
#include "mesh/grid.hpp"

namespace berm {

struct SeededPoints {
  std::vector<Vec3> x;
  std::vector<double> measure;  ///< area [m2] or volume [m3]
  std::vector<Vec3> shift;      ///< see fit_to_cells; empty: none
  /// Ratios of the edges, along the axes of the grid, of the boxes that the points stand for; zero: those of the cells.
  std::vector<Vec3> box;

  void add(const Vec3& place, double size, const Vec3& edges = Vec3::Zero()) {
    x.push_back(place);
    measure.push_back(size);
    box.push_back(edges);
  }
};

/// Points of `region` in the cells of the grid. Uncut cells get n points a direction (quads, hexahedra: Gauss or evenly
/// spaced; triangles: the rule of n (n+1)/2 points; tetrahedra: of 1 or 4); cut cells are divided into n parts a direction,
/// each part inside the body becomes a point at its centroid. The measures add up to the region's. Throws InputError if a
/// part of the body lies outside the grid.
SeededPoints seed_from_grid(const Region& region, const Grid& grid, const PointSeeding& seeding,
                            const std::string& body);

/// Gauss points of a mesh of triangles (1, 3, 6, 12 points), quads (1, 4, 9, 16), tetrahedra (1, 4) or hexahedra (1, 8,
/// 27).
SeededPoints seed_from_mesh(const Mesh& mesh, int per_element);

/// Makes points that ignore the grid integrate constants and linear functions over body and cell exactly (a
/// variationally consistent integration in the sense of Chen, Hillman and Rueter 2013, formulation (23), (24)): in
/// every cell the measures are scaled to that of the body in it; `shift` moves the place where a point sees the shape
/// functions so that the mean place is the centroid of the body in the cell; a cell that the body touches but no point
/// lies in gets one at that centroid. The gradients of a hexahedron have products of two coordinates too: in full cells
/// whose edges are parallel the shifts differ from point to point such that these agree as well.
void fit_to_cells(SeededPoints& points, const Region& region, const Grid& grid);

}  // namespace berm
