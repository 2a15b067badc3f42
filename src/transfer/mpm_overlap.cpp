/// Bodies that lie in one another: contact that does not see them, or bodies that were put into one place.

#include "transfer/mpm.hpp"

namespace berm {

std::optional<MpmDiscretisation::Overlap> MpmDiscretisation::overlap() const {
  constexpr double half = 0.5, too_full = 1.75, too_full_around = 1.6;  // of a cell: points are counted whole where their middle is
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
  // Where points of two bodies that are compressed happen to lie in one cell, its neighbours hold the less: together they tell.
  const auto sum = [&fill](int cell) {
    double all = 0.0;
    if (const auto at = fill.find(cell); at != fill.end())
      for (const auto& [body, share] : at->second) all += share;
    return all;
  };
  const auto around = [&](int cell) {
    double all = sum(cell);
    int n = 1;
    for (int f = 0; f < max_faces; ++f)
      if (const int other = grid_.neighbours[std::size_t(max_faces) * cell + f]; other >= 0) all += sum(other), ++n;
    return all / n;
  };
  std::optional<Overlap> worst;
  for (const auto& [cell, bodies] : fill)
    for (auto a = bodies.begin(); a != bodies.end(); ++a)
      for (auto b = std::next(a); b != bodies.end(); ++b) {
        const double both = a->second + b->second;
        if (std::min(a->second, b->second) < half || both < too_full || around(cell) < too_full_around) continue;
        if (!worst || both > worst->fill) worst = {a->first, b->first, cell_centre(grid_.mesh, cell), both};
      }
  return worst;
}

}  // namespace berm
