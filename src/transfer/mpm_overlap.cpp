/// Bodies that lie in one another: contact that does not see them, or bodies that were put into one place.

#include "transfer/mpm.hpp"

namespace berm {

std::optional<MpmDiscretisation::Overlap> MpmDiscretisation::overlap() const {
  constexpr double half = 0.5, too_full = 1.75;  // of a cell: points are counted whole where their middle is
  std::map<std::pair<int, int>, double> mine;    // of cell and body
  for (const Slice& slice : material.slices)
    for (int p = slice.begin; p < slice.end; ++p) {
      const int cell = grid_.locator->locate(now(p), cell_[p]);
      const Mat3& F = material.F[p];
      if (cell >= 0) mine[{cell, slice.body}] += measure_[p] * F.determinant() / (space_ == Space::axisymmetric ? F(2, 2) : 1.0);
    }
  std::vector<std::array<double, 3>> rows;
  for (const auto& [at, measure] : mine) rows.push_back({double(at.first), double(at.second), measure});
  std::map<int, std::map<int, double>> fill;  // of bodies, by cell
  for (const auto& [cell, body, measure] : comm_.all_gather(rows))
    fill[static_cast<int>(cell)][static_cast<int>(body)] += measure / cell_measure(grid_.mesh, static_cast<int>(cell));
  std::optional<Overlap> worst;
  for (const auto& [cell, bodies] : fill)
    for (auto a = bodies.begin(); a != bodies.end(); ++a)
      for (auto b = std::next(a); b != bodies.end(); ++b) {
        const double sum = a->second + b->second;
        if (std::min(a->second, b->second) < half || sum < (worst ? worst->fill : too_full)) continue;
        worst = {a->first, b->first, cell_centre(grid_.mesh, cell), sum};
      }
  return worst;
}

}  // namespace berm
