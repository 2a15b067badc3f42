#include "sim/stage_doubts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "bc/case_lookup.hpp"

namespace berm {
namespace {

constexpr double noticeable = 0.1;  ///< cells

/// How far material has moved from where it started, at most; displacements may have been set back [m]. Collective.
double farthest_motion(const World& w) {
  const std::vector<Vec3> x = w.discretisation->point_positions(), X = w.discretisation->point_origins();
  double farthest = 0.0;
  for (std::size_t p = 0; p < x.size(); ++p) farthest = std::max(farthest, (x[p] - X[p]).norm());
  return w.comm.max(farthest);
}

}  // namespace

std::vector<std::string> doubts_of_stage(const World& w) {
  const Case& c = w.spec;
  const std::string &now = w.present_stage().name, &before = c.stages[w.stage - 1].name;
  const auto begins = [&](const Stages& stages) { return acts_in(stages, now) && !acts_in(stages, before); };
  const double h = w.discretisation->cell_size(), moved = farthest_motion(w);

  for (const auto& [contact, apart] : w.boundary->tied_apart())
    if (begins(c.contacts[contact].stages) && apart > noticeable * h)
      throw RunError(fmt::format("[contact.{}] begins in [stage.{}] to tie surfaces that are {:.3g} m ({:.2g} cells) farther apart or deeper in one "
                                 "another than at the start: bring them back to where they touch, or let contact act there",
                                 c.contacts[contact].name, now, apart, apart / h));

  std::vector<std::string> doubts;
  const std::vector<std::string> idle = w.boundary->idle_boundaries();
  for (const NodeBoundary& b : c.boundaries) {
    if (!begins(b.stages) || !b.body.empty() || c.method != Method::mpm || !moves_through_grid(c)) continue;
    const std::string remedy = fmt::format("hold the surface of the body wherever it is (boundary.{}.body = \"NAME\")", b.name);
    if (std::find(idle.begin(), idle.end(), b.name) != idle.end())
      doubts.push_back(fmt::format("[boundary.{}] holds nothing in [stage.{}]: no body touches its nodes any more; {}", b.name, now, remedy));
    else if (moved > noticeable * h)
      doubts.push_back(fmt::format("[boundary.{}] begins in [stage.{}] to hold nodes of the grid, and bodies have moved by up to {:.3g} m ({:.2g} cells) since the start: "
                                   "what it holds is the material that is there now; {}",
                                   b.name, now, moved, moved / h, remedy));
  }
  return doubts;
}

}  // namespace berm
