/// What an implicit step asks of itself: is anything to be done, is the answer one, where is it worst.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "bc/case_lookup.hpp"
#include "sim/body_mass.hpp"
#include "sim/implicit_step.hpp"

namespace berm {
namespace {

/// Forces of a contact whose nodes have been frozen may be off by this share of themselves.
constexpr double most_violation = 0.1;

}  // namespace

/// Whether the contacts of the trial state are as assumed.
bool ImplicitStep::is_fair() const {
  return world_.boundary->grid_contact().violation(*world_.discretisation, du_) <= most_violation;
}

/// In equilibrium, whether supports, rigid bodies and loads are at the end of the step what and where they were at its start.
bool ImplicitStep::nothing_changes() const {
  const Case& c = world_.spec;
  if (motion_ || gauge_ >= 0 || !in_equilibrium_ || !same_act_in(c, last_stage_, world_.present_stage().name)) return false;
  if (any_law(c, [](const AnyLaw& law) { return std::holds_alternative<Newtonian>(law); })) return false;
  bool same = std::all_of(prescribed_.begin(), prescribed_.end(), [](double du) { return du == 0.0; });
  for (const Body& b : c.bodies) same = same && b.displacement.step(t0_, t1_).isZero(0.0);
  for (const NodeBoundary& b : c.boundaries) {
    const auto rests = [&](const TimeFunction& u) { return !u.depends_on_place() && u.step(t0_, t1_) == 0.0; };
    same = same && (b.body.empty() || std::all_of(b.u.begin(), b.u.end(), [&](const auto& u) { return !u || rests(*u); })) && rests(b.un);
  }
  return world_.comm.all(same) && world_.comm.all(weight_ == weight_at(t0_)) &&
         world_.comm.all(pressure_at(t0_, no_motion()) == pressure_at(t1_, no_motion()));
}

/// Where forces of the last residual balance least, on all processes.
void ImplicitStep::find_worst_node(StepResult& result) const {
  const Discretisation& d = *world_.discretisation;
  if (static_cast<int>(force_.size()) != d.n_nodes()) return;
  const std::vector<char>& fixed = world_.boundary->fixed();
  double sum = 0.0, worst = -1.0;
  int node = -1;
  for (int i = 0; i < d.halo.n_owned; ++i) {
    double here = 0.0;
    for (int k = 0; k < dimension_; ++k)
      if (!fixed[dimension_ * i + k]) here += force_[i][k] * force_[i][k];
    sum += here;
    if (here > worst) worst = here, node = i;
  }
  sum = world_.comm.sum(sum);
  const double all = world_.comm.max(worst);
  std::vector<Vec3> found;
  if (node >= 0 && worst == all) found.push_back(d.nodes[node]);
  found = world_.comm.all_gather(found);
  if (found.empty() || !(sum > 0.0)) return;
  result.where = found[0];
  result.share = std::sqrt(all / sum);
}

/// The largest motion that supports and rigid bodies prescribe in the step [m]. Collective.
double ImplicitStep::prescribed_motion() const {
  double largest = 0.0;
  for (const double value : prescribed_) largest = std::max(largest, std::abs(value));
  for (const Body& body : world_.spec.bodies)
    if (body.rigid) largest = std::max(largest, body.displacement.step(t0_, t1_).norm());
  return world_.comm.max(largest);
}

/// An equilibrium in which a body has moved by half its size is none that a step leads to: what only its loads held has flown
/// there. Not where supports move as far. Collective.
bool ImplicitStep::flies_away() const {
  constexpr double cells = 2.0, size = 0.5;
  if (motion_) return false;
  const Discretisation& d = *world_.discretisation;
  double farthest = 0.0;
  for (int node = 0; node < d.halo.n_owned; ++node) farthest = std::max(farthest, du_[node].norm());
  const double enough = 2.0 * prescribed_motion();
  if (world_.comm.max(farthest) <= cells * d.cell_size() + enough) return false;
  for (const Slice& slice : d.material.slices) {
    // Its mean motion, by the mass that each node has of it.
    const std::vector<double> mass = mass_at_nodes(d, slice.body);
    std::array<double, 4> sums{};
    Vec3 low = Vec3::Constant(1e300), high = -low;
    for (int node = 0; node < d.halo.n_owned; ++node) {
      if (mass[node] == 0.0) continue;
      sums[3] += mass[node];
      for (int i = 0; i < 3; ++i) sums[i] += mass[node] * du_[node][i];
      low = low.cwiseMin(d.nodes[node]), high = high.cwiseMax(d.nodes[node]);
    }
    world_.comm.sum(std::span<double>(sums));
    for (int i = 0; i < 3; ++i) low[i] = world_.comm.min(low[i]), high[i] = world_.comm.max(high[i]);
    if (sums[3] != 0.0 && (Vec3(sums.data()) / sums[3]).norm() > size * (high - low).norm() + enough) return true;
  }
  return false;
}

std::string ImplicitStep::reason_of_flight() const {
  const std::string text = "a body would move by half its size in one quasi-static step: nothing holds it in the direction in which it goes";
  const auto follows = [](const Pressure& p) { return !p.traction && p.direction == Pressure::Direction::following; };
  const auto& pressures = world_.spec.pressures;
  const auto found = std::find_if(pressures.begin(), pressures.end(), follows);
  if (found == pressures.end() || world_.spec.kinematics != Kinematics::finite) return text;
  return text + fmt::format("; a pressure that turns with its face may push it there: [pressure.{}] direction = \"dead\" does not", found->name);
}

}  // namespace berm
