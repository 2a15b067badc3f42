#pragma once
/// Stress at nodes out of the stress at points, and how far the two are apart: superconvergent patch recovery and the
/// error estimate that goes with it (Zienkiewicz and Zhu 1992, docs/theory/formulation.md (63)-(65)). For output only:
/// nothing of it goes back into the computation.

#include <functional>
#include <span>
#include <unordered_map>

#include "base/tensor.hpp"
#include "method/discretisation.hpp"

namespace berm {

/// A cell with the points in it. Cells that share a node make up its patch.
struct PatchCell {
  std::vector<long> nodes;  ///< numbers, the same on all processes
  std::vector<int> points;
};

/// The points, where the cells see them.
struct PointStress {
  std::span<const Vec3> x;         ///< [m]
  std::span<const double> volume;  ///< [m3]
  std::span<const Voigt> stress;   ///< Cauchy [Pa]
};

struct RecoveredStress {
  std::unordered_map<long, Voigt> node;  ///< [Pa], by node number
  std::vector<double> cell_error;        ///< RMS over the volume of |stress - recovered| in each cell [Pa]
  double relative_error = 0.0;           ///< the same over all cells and processes, over the RMS of |stress| [-]
};

/// degree: of the polynomials, 1 or 2. `place` gives the position of a node. Where the points of a patch determine less
/// than a polynomial (a cell that is barely filled), the slopes that they say nothing about are zero. Collective.
RecoveredStress recover_stress(const Comm& comm, int dimension, int degree, double cell_size,
                               const std::vector<PatchCell>& cells, const PointStress& points,
                               const std::function<Vec3(long node)>& place);

/// Cells of this process, and what lies in them: its own points, and after them those that other processes have there.
struct CellContents {
  std::vector<PatchCell> cells;
  std::vector<Vec3> x;
  std::vector<double> volume, damage;
  std::vector<Voigt> stress;
};

/// Active cells of the grid (mpm), in their order, or elements (fem). Nodes have the numbers of the mesh, those of
/// further fields come after them; bodies of one field share theirs. Collective.
CellContents contents_of_cells(const Discretisation& d);

/// With polynomials of the degree of the displacements, at most 2. Collective.
RecoveredStress recover_stress(const Discretisation& d, const CellContents& contents);

}  // namespace berm
