#pragma once
/// Where material points start: n per direction in every cell of the grid, clipped to the body, or at the Gauss
/// points of a body mesh.

#include <vector>

#include "case/case.hpp"
#include "mesh/grid.hpp"

namespace berm {

struct SeededPoints {
  std::vector<Vec2> x;
  std::vector<double> area;  ///< [m2]
  std::vector<Vec2> shift;   ///< see fit_to_cells; empty: none
};

/// Points of `region` in the cells of the grid. Uncut cells get n x n points (quads: Gauss or evenly spaced; triangles:
/// the rule of n (n+1)/2 points); cut cells are divided into n x n parts, each part inside the body becomes a point at
/// its centroid. The areas add up to the region's area. Throws InputError if a part of the body lies outside the grid.
SeededPoints seed_from_grid(const Region& region, const Grid& grid, const PointSeeding& seeding,
                            const std::string& body);

/// Gauss points of a mesh of triangles (1, 3, 6, 12 points) or quads (1, 4, 9, 16 points).
SeededPoints seed_from_mesh(const Mesh& mesh, int per_element);

/// Makes points that ignore the grid integrate constants and linear functions over body and cell exactly (a
/// variationally consistent integration in the sense of Chen, Hillman and Rueter 2013, formulation (23), (24)): in
/// every cell the areas are scaled to the area of the body in it; `shift` moves the place where a point sees the shape
/// functions so that the mean place is the centroid of the body in the cell; a cell that the body touches but no point
/// lies in gets one at that centroid.
void fit_to_cells(SeededPoints& points, const Region& region, const Grid& grid);

}  // namespace berm
