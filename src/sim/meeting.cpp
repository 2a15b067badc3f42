#include "sim/meeting.hpp"

#include <array>

#include "bc/case_lookup.hpp"
#include "law/kinds.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

/// A point of a patch stands for it at the nodes that the patch sees.
struct Seen {
  double body = -1.0;  ///< of the case; -1: none
  std::array<double, 3> X{}, x{};
  std::array<double, 9> F{};
};

bool keeps_together(const AnyLaw& law) { return !is_plastic(law) && !flows_far(law); }

/// Where nothing has cracked or flowed. Elsewhere deformation says little of where the material next to it is.
bool is_mild(const Mat3& F) {
  constexpr double mild = 0.5;
  return (F.transpose() * F - Mat3::Identity()).norm() < mild;
}

/// How much closer two places are than the deformation of both says, to second order of their distance.
double closer_by(const Seen& a, const Seen& b) {
  const Eigen::Map<const Mat3> F_a(a.F.data()), F_b(b.F.data());
  const Vec3 X = Eigen::Map<const Vec3>(b.X.data()) - Eigen::Map<const Vec3>(a.X.data());
  const Vec3 x = Eigen::Map<const Vec3>(b.x.data()) - Eigen::Map<const Vec3>(a.x.data());
  return (0.5 * (F_a + F_b) * X).norm() - x.norm();
}

}  // namespace

std::optional<Meeting> find_meeting(const World& world) {
  constexpr double told = 0.25;  // cells
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(world.discretisation.get());
  if (!mpm || !moves_through_grid(world.spec)) return {};
  const MaterialState& m = mpm->material;
  const std::vector<Vec3> X = mpm->point_origins(), x = mpm->point_positions();
  std::vector<double> body(m.size(), -1.0);
  for (const Slice& slice : m.slices)
    if (keeps_together(slice.law)) std::fill(body.begin() + slice.begin, body.begin() + slice.end, slice.body);
  const auto seen_in = [&](int patch) {
    Seen seen;
    for (const int p : mpm->points_in(patch)) {
      if (body[p] < 0.0 || !is_mild(m.F[p])) continue;
      seen.body = body[p];
      for (int i = 0; i < 3; ++i) seen.X[i] = X[p][i], seen.x[i] = x[p][i];
      std::copy_n(m.F[p].data(), 9, seen.F.begin());
      break;
    }
    return seen;
  };
  std::vector<Seen> of_patch;
  for (int patch = 0; patch < mpm->n_patches(); ++patch) of_patch.push_back(seen_in(patch));
  // The first one at each node, as its owner has it; all others are compared with it.
  std::vector<Seen> at_node(mpm->n_nodes());
  for (int patch = 0; patch < mpm->n_patches(); ++patch)
    for (const int node : mpm->blocks[patch])
      if (of_patch[patch].body >= 0.0 && at_node[node].body < 0.0) at_node[node] = of_patch[patch];
  mpm->halo.copy_to_ghosts(at_node.data(), 1);
  Seen worst_a, worst_b;
  double closest = 0.0;
  for (int patch = 0; patch < mpm->n_patches(); ++patch) {
    if (of_patch[patch].body < 0.0) continue;
    for (const int node : mpm->blocks[patch]) {
      if (at_node[node].body < 0.0) continue;
      if (const double closer = closer_by(at_node[node], of_patch[patch]); closer > closest) closest = closer, worst_a = at_node[node], worst_b = of_patch[patch];
    }
  }
  const double most = world.comm.max(closest);
  if (most <= told * mpm->cell_size()) return {};
  std::vector<double> found;  // of the process that has seen it
  if (closest == most) found = {worst_a.body, worst_b.body, worst_a.x[0], worst_a.x[1], worst_a.x[2]};
  found = world.comm.all_gather(found);
  return Meeting{static_cast<int>(found[0]), static_cast<int>(found[1]), Vec3(found[2], found[3], found[4]), most};
}

}  // namespace berm
