#include "sim/watch.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "bc/case_lookup.hpp"
#include "sim/advice.hpp"
#include "sim/meeting.hpp"
#include "sim/of_largest.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

constexpr int steps_between_looks = 20;  ///< for what takes longer to look for

/// Loads and supports that may be the cause of a change of reactions.
bool changes_otherwise(const Case& c, double t0, double t1) {
  const auto rests = [&](const TimeFunction& f) { return !f.depends_on_place() && f.step(t0, t1) == 0.0; };
  const auto all_rest = [&](const auto& functions) { return std::all_of(functions.begin(), functions.end(), rests); };
  return !all_rest(c.gravity.component) || std::any_of(c.pressures.begin(), c.pressures.end(), [&](const Pressure& p) {
    return !rests(p.value) || (p.traction && !all_rest(p.traction->component));
  }) || std::any_of(c.boundaries.begin(), c.boundaries.end(), [&](const NodeBoundary& b) {
    return !rests(b.un) || std::any_of(b.u.begin(), b.u.end(), [&](const auto& u) { return u && !rests(*u); });
  });
}

}  // namespace

void Watched::restore(const std::vector<double>& row) {
  if (row.size() != this->row().size()) return;
  penetration = row[0], swelling = row[1], jump = row[2], jumps = row[3], columns = row[4];
}

Watch::Watch(const World& world, Say warn)
    : world_(world), warn_(std::move(warn)), reaction_(world.spec.bodies.size(), Vec3::Zero()), change_(reaction_), rate_(reaction_),
      largest_(reaction_.size(), 0.0), time_(world.time) {
  constexpr int most_boxes = 1000000;
  using enum Contact::Kind;
  const Case& c = world.spec;
  const double h = world.discretisation->cell_size();
  for (const Contact& k : c.contacts) {
    if (!k.other.empty() || k.kind == tie || k.kind == shared_nodes) continue;
    Obstacle o{body_index(c, k.rigid), body_index(c, k.body), k.stages, Region(*c.bodies[body_index(c, k.rigid)].shape, h), {}, h, {1, 1, 1}, {}};
    o.low = o.region.min();
    const Vec3 size = o.region.max() - o.low;
    const auto count = [&] {
      for (int i = 0; i < c.dimension(); ++i) o.n[i] = static_cast<int>(std::min(1e7, std::floor(size[i] / o.width))) + 1;
      return double(o.n[0]) * o.n[1] * o.n[2];
    };
    while (count() > most_boxes) o.width *= 2.0;
    o.box.assign(static_cast<std::size_t>(count()), 0);
    obstacles_.push_back(std::move(o));
  }
}

void Watch::resume(const Watched& before, const Reactions& now) {
  seen = before;
  time_ = world_.time;
  span_ = 0.0;
  reaction_ = now.rigid;
  // What a body touched before is not known: some reaction may have been.
  for (std::size_t b = 0; b < reaction_.size(); ++b) largest_[b] = std::max(reaction_[b].norm(), std::numeric_limits<double>::min());
}

double Watch::Obstacle::depth(const Vec3& x) {
  constexpr char far = 1, near = 2;
  std::size_t at = 0;
  Vec3 middle = x;
  for (int i = region.dimension() - 1; i >= 0; --i) {
    const double k = std::floor((x[i] - low[i]) / width);
    if (!(k >= 0.0 && k < n[i])) return 0.0;
    at = at * n[i] + static_cast<std::size_t>(k);
    middle[i] = low[i] + (k + 0.5) * width;
  }
  if (box[at] == 0) {
    const double corner = 0.5 * std::sqrt(double(region.dimension())) * width;
    box[at] = region.nearest(middle).distance > corner ? far : near;
  }
  return box[at] == far ? 0.0 : std::max(0.0, -region.nearest(x).distance);
}

void Watch::tell_once(const char* what, const std::string& text) {
  if (told_.insert(what).second) warn_(text);
}

/// In small strain places stay where they started.
Vec3 Watch::place_now(const std::vector<Vec3>& X, const std::vector<Vec3>& x, const std::vector<Vec3>& u, int p) const {
  return world_.spec.kinematics == Kinematics::small ? Vec3(X[p] + u[p]) : x[p];
}

void Watch::look(const ImplicitStep& step, int n_steps) {
  look_for_jumps(step.balance().reactions, world_.time);
  look_for_penetration();
  if (n_steps == 1) look_for_lost_pressure();
  if (n_steps % steps_between_looks == 0) look_now_and_then();
}

void Watch::look_now_and_then() {
  look_for_overlap();
  look_for_meetings();
  look_for_swelling();
  look_for_large_motion();
  look_for_smeared_cracks();
  look_for_lag();
  look_for_torn_ties();
}

void Watch::look_last() {
  look_now_and_then();
  look_for_idle_bodies();
  if (seen.jumps > 0.0)
    warn_(fmt::format("reactions jumped by more than a tenth in {:.0f} step{} of a smooth motion{}: look at history.csv there; smaller steps "
                      "show whether the jump is of the model",
                      seen.jumps, seen.jumps == 1.0 ? "" : "s", worst_jump_));
}

bool Watch::displacements_were_reset() const {
  const auto& stages = world_.spec.stages;
  return std::any_of(stages.begin(), stages.begin() + world_.stage + 1, [](const Stage& s) { return s.reset_displacements; });
}

void Watch::look_for_penetration() {
  // Where displacements have been set back in small strain, places are no longer known.
  const bool lost = world_.spec.kinematics == Kinematics::small && displacements_were_reset();
  if (obstacles_.empty() || lost) return;
  constexpr double told = 0.1, most = 1.0;  // cells
  const Discretisation& d = *world_.discretisation;
  const double h = d.cell_size();
  const std::vector<Vec3> X = d.point_origins(), x = d.point_positions(), u = d.point_displacements();
  double deepest = 0.0;
  Vec3 where = Vec3::Zero();
  int worst = -1;
  for (std::size_t k = 0; k < obstacles_.size(); ++k) {
    Obstacle& o = obstacles_[k];
    if (!acts_in(o.stages, world_.present_stage().name)) continue;
    const Vec3 moved = world_.spec.bodies[o.rigid].displacement.at(world_.time);
    for (const Slice& slice : d.material.slices) {
      if (slice.body != o.body) continue;
      for (int p = slice.begin; p < slice.end; ++p) {
        const Vec3 at = place_now(X, x, u, p);
        if (const double depth = o.depth(at - moved); depth > deepest) deepest = depth, where = at, worst = static_cast<int>(k);
      }
    }
  }
  const double all = world_.comm.max(deepest);
  seen.penetration = std::max(seen.penetration, all);
  if (all <= told * h || (has_told("penetration") && all <= most * h)) return;
  const std::vector<double> found = row_of_largest(world_.comm, deepest, all, {double(worst), where.x(), where.y(), where.z()});
  const Obstacle& o = obstacles_[static_cast<int>(found[0])];
  const std::string text =
      fmt::format("material of \"{}\" is {:.3g} m deep inside of rigid body \"{}\" at {}, time {:.6g} ({:.2g} cells): contact acts on the "
                  "surface of the body, which has slid off there",
                  world_.spec.bodies[o.body].name, all, world_.spec.bodies[o.rigid].name, place_text(world_.spec, Vec3(found[1], found[2], found[3])),
                  world_.time, all / h);
  if (all > most * h)
    throw RunError(text + ". What the rigid body feels is no longer right: end the run before, " + advice_on_penetration(world_.spec));
  tell_once("penetration", text);
}

void Watch::look_for_overlap() {
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(world_.discretisation.get());
  const auto& bodies = world_.spec.bodies;
  const auto deformable = std::count_if(bodies.begin(), bodies.end(), [](const Body& b) { return !b.rigid; });
  if (has_told("overlap") || !mpm || deformable < 2) return;
  const auto found = mpm->overlap();
  if (!found) return;
  tell_once("overlap", fmt::format("bodies \"{}\" and \"{}\" lie in one another at time {:.6g}: a cell at {} holds {:.2g} times as much as it has room for{}",
                    bodies[found->body_a].name, bodies[found->body_b].name, world_.time, place_text(world_.spec, found->where), found->fill,
                    advice_on_overlap(world_.spec)));
}

/// Functions of the grid join what lies in one cell or in two beside each other.
void Watch::look_for_meetings() {
  if (has_told("meeting")) return;
  const auto found = find_meeting(world_);
  if (!found) return;
  const std::string &a = world_.spec.bodies[found->body_a].name, &b = world_.spec.bodies[found->body_b].name;
  const std::string who = a == b ? fmt::format("two sides of body \"{}\"", a) : fmt::format("bodies \"{}\" and \"{}\"", a, b);
  tell_once("meeting", fmt::format("{} have come {:.3g} m nearer to each other near {}, time {:.6g}, than their strains say, and the grid joins them there: from a cell or two apart "
                                   "on they push and draw each other. {} have a [contact.NAME], or smaller cells while they stay apart",
                                   who, found->closer, place_text(world_.spec, found->where), world_.time,
                                   a == b ? "Sides that may meet must be two bodies that" : "Bodies that may meet must"));
}

/// A support on a surface gives way by a 500th of what a cell does [boundaries (14)]. Where it lags behind by more, something else
/// holds the same place: nodes, another body, a tie. Tractions of a twentieth of Young's modulus are more than a material bears.
void Watch::look_for_lag() {
  constexpr double told = 0.1, far = 1e-4, rounding = 1e-9;  // of the motion; cells
  const Discretisation& d = *world_.discretisation;
  if (has_told("lag")) return;
  const BoundaryConditions::Lag mine = world_.boundary->worst_lag(world_.time);
  const double missing = world_.comm.max(mine.missing);
  if (missing <= (displacements_were_reset() ? far : rounding) * d.cell_size()) return;
  double moved = 0.0;
  for (const Vec3& u : d.point_displacements()) moved = std::max(moved, u.norm());
  moved = world_.comm.max(moved);
  const std::vector<double> found =
      row_of_largest(world_.comm, mine.missing, missing, {double(mine.boundary), mine.prescribed, mine.at.x(), mine.at.y(), mine.at.z()});
  if (missing <= told * std::max(moved, found[1]) || (missing <= far * d.cell_size() && missing <= told * found[1])) return;
  const NodeBoundary& b = world_.spec.boundaries[static_cast<int>(found[0])];
  tell_once("lag", fmt::format("[boundary.{}] prescribes {:.3g} m, and the surface of \"{}\" near {} is {:.3g} m off at time {:.6g}: something else holds it, as "
                    "nodes of the grid, a rigid body or a tie that move otherwise. Leave out one of the two, or keep their regions a cell apart",
                    b.name, found[1], b.body, place_text(world_.spec, Vec3(found[2], found[3], found[4])), missing, world_.time));
}

/// A tie gives way by a thousandth of what a cell does.   [boundaries (3)]
void Watch::look_for_torn_ties() {
  constexpr double told = 0.01, most = 1.0;  // cells
  const double h = world_.discretisation->cell_size();
  for (const auto& [k, apart] : world_.boundary->tied_apart()) {
    const Contact& tie = world_.spec.contacts[k];
    if (!acts_in(tie.stages, world_.present_stage().name)) continue;
    if (apart <= told * h || (has_told("torn") && apart <= most * h)) continue;
    const std::string text = fmt::format("the surfaces that [contact.{}] ties are {:.3g} m ({:.2g} cells) apart or deep in one another at time {:.6g}: what is prescribed "
                                         "tears or crushes the body, and the reaction is that of the tie. Is the motion meant to be so large, in m?",
                                         tie.name, apart, apart / h, world_.time);
    if (apart > most * h) throw RunError(text);
    tell_once("torn", text);
  }
}

/// A rigid body that is moved is meant to touch something; one at rest may lie in wait.
void Watch::look_for_idle_bodies() const {
  const Case& c = world_.spec;
  for (std::size_t b = 0; b < c.bodies.size(); ++b) {
    const Body& body = c.bodies[b];
    const bool named = std::any_of(c.contacts.begin(), c.contacts.end(), [&](const Contact& k) { return k.rigid == body.name; });
    if (named && largest_[b] == 0.0 && !body.displacement.is_zero())
      warn_(fmt::format("rigid body \"{}\" has moved and never pressed on anything: it is still apart from what it should touch, or moves away from it", body.name));
  }
}

/// Where rigid bodies move evenly in equilibrium and nothing cracks, a reaction changes from step to step as it did.
void Watch::look_for_jumps(const Reactions& now, double time) {
  constexpr double told = 0.1, sudden = 3.0, even = 0.1;
  const double span = time - time_, before = span_;
  const bool in_equilibrium = world_.present_stage().steps.analysis == Analysis::quasi_static && !any_law(world_.spec, is_damage);
  const bool same_stage = time_ > world_.present_stage().begin && !changes_otherwise(world_.spec, time_, time);
  for (std::size_t b = 0; b < reaction_.size(); ++b) {
    if (!world_.spec.bodies[b].rigid) continue;
    const VectorFunction& motion = world_.spec.bodies[b].displacement;
    const Vec3 rate = motion.step(time_, time) / span, change = now.rigid[b] - reaction_[b];
    largest_[b] = std::max(largest_[b], now.rigid[b].norm());
    const bool goes_on = before > 0.0 && rate.norm() > 0.0 && (rate - rate_[b]).norm() <= even * rate.norm();
    const Vec3 odd = before > 0.0 ? Vec3(change - change_[b] * (span / before)) : change;
    const double size = std::min(change.norm(), odd.norm());
    if (in_equilibrium && same_stage && goes_on && reaction_[b].norm() > told * largest_[b] && size > told * largest_[b] &&
        change.norm() > sudden * change_[b].norm() * (span / before)) {
      seen.jumps += 1.0;
      if (size / largest_[b] > seen.jump) {
        seen.jump = size / largest_[b];
        worst_jump_ = fmt::format(", most at time {:.6g}, where that of \"{}\" went from ({:.4g}) to ({:.4g}) N", time, world_.spec.bodies[b].name,
                                  fmt::join(reaction_[b].data(), reaction_[b].data() + world_.spec.dimension(), ", "),
                                  fmt::join(now.rigid[b].data(), now.rigid[b].data() + world_.spec.dimension(), ", "));
      }
    }
    reaction_[b] = now.rigid[b], change_[b] = change, rate_[b] = rate;
  }
  time_ = time, span_ = span;
}

}  // namespace berm
