#include "sim/meeting.hpp"

#include <array>

#include "bc/case_lookup.hpp"
#include "law/kinds.hpp"
#include "sim/of_largest.hpp"
#include "sim/preflight_parts.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

/// A point of a patch stands for it at the nodes that the patch sees.
struct Seen {
  int body = -1;  ///< of the case; -1: none
  std::array<double, 3> X{}, x{};
  std::array<double, 9> F{};
};

/// Whose points a node sees. What has cracked, flowed or strained much says little of where the material next to it is, and
/// may fill the place between two others.
struct Company {
  int body = -1, other = -1;
  bool mixed = false;
  void add(int of_body) {
    if (body < 0) body = of_body;
    else if (of_body != body && other < 0) other = of_body;
    else mixed |= of_body != body && of_body != other;
  }
  void add(const Company& company) {
    mixed |= company.mixed;
    for (const int one : {company.body, company.other})
      if (one >= 0) add(one);
  }
  bool is_only(int a, int b) const { return !mixed && (other < 0 || a != b); }
};

bool keeps_together(const AnyLaw& law) { return !is_plastic(law) && !flows_far(law); }

bool is_mild(const Mat3& F) {
  constexpr double mild = 0.5;
  return (F.transpose() * F - Mat3::Identity()).norm() < mild;
}

/// How much closer two places are than the deformation of both says, to second order of their distance.
double closer_by(const Seen& a, const Seen& b) {
  const Eigen::Map<const Mat3> F_a(a.F.data()), F_b(b.F.data());
  const Vec3 X = Eigen::Map<const Vec3>(b.X.data()) - Eigen::Map<const Vec3>(a.X.data());
  const Vec3 x = Eigen::Map<const Vec3>(b.x.data()) - Eigen::Map<const Vec3>(a.x.data());
  return 0.5 * ((F_a * X).norm() + (F_b * X).norm()) - x.norm();
}

/// What the patches of this process have in them.
struct Patches {
  std::vector<Seen> seen;
  std::vector<Company> company;
};

Patches look_into_patches(const MpmDiscretisation& mpm) {
  constexpr double sound = 0.1;  // damage
  const MaterialState& m = mpm.material;
  const std::vector<Vec3> X = mpm.point_origins(), x = mpm.point_positions();
  std::vector<int> body(m.size(), -1);
  std::vector<char> keeps(m.size(), 0);
  for (const Slice& slice : m.slices)
    for (int p = slice.begin; p < slice.end; ++p) body[p] = slice.body, keeps[p] = keeps_together(slice.law) && m.damage[p] < sound && is_mild(m.F[p]);
  Patches patches;
  for (int patch = 0; patch < mpm.n_patches(); ++patch) {
    Seen seen;
    Company company;
    for (const int p : mpm.points_in(patch)) {
      company.add(body[p]);
      company.mixed |= !keeps[p];
      if (seen.body >= 0 || !keeps[p]) continue;
      seen.body = body[p];
      for (int i = 0; i < 3; ++i) seen.X[i] = X[p][i], seen.x[i] = x[p][i];
      std::copy_n(m.F[p].data(), 9, seen.F.begin());
    }
    patches.seen.push_back(seen), patches.company.push_back(company);
  }
  return patches;
}

/// What its owner has of each node, where it has something.
template <class T, class Has>
void take_from_owners(const MpmDiscretisation& mpm, std::vector<T>& at_node, Has has) {
  const std::vector<T> mine = at_node;
  mpm.halo.copy_to_ghosts(at_node.data(), 1);
  for (std::size_t node = 0; node < mine.size(); ++node)
    if (!has(at_node[node])) at_node[node] = mine[node];
}

}  // namespace

std::optional<Meeting> find_meeting(const World& world) {
  constexpr double told = 0.25;  // cells
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(world.discretisation.get());
  if (!mpm || !moves_through_grid(world.spec)) return {};
  const Patches patches = look_into_patches(*mpm);
  // The first one at each node, as its owner has it; all others are compared with it.
  std::vector<Seen> at_node(mpm->n_nodes());
  std::vector<Company> around(mpm->n_nodes());
  for (int patch = 0; patch < mpm->n_patches(); ++patch)
    for (const int node : mpm->blocks[patch]) {
      if (at_node[node].body < 0) at_node[node] = patches.seen[patch];
      around[node].add(patches.company[patch]);
    }
  std::vector<Company> of_owners = around;
  take_from_owners(*mpm, at_node, [](const Seen& seen) { return seen.body >= 0; });
  take_from_owners(*mpm, of_owners, [](const Company& company) { return company.body >= 0; });
  Seen worst_a, worst_b;
  double closest = 0.0;
  for (int patch = 0; patch < mpm->n_patches(); ++patch)
    for (const int node : mpm->blocks[patch]) {
      const Seen &a = at_node[node], &b = patches.seen[patch];
      if (a.body < 0 || b.body < 0 || !around[node].is_only(a.body, b.body) || !of_owners[node].is_only(a.body, b.body)) continue;
      if (const double closer = closer_by(a, b); closer > closest && (a.body == b.body || !are_joined(world, a.body, b.body))) closest = closer, worst_a = a, worst_b = b;
    }
  const double most = world.comm.max(closest);
  if (most <= told * mpm->cell_size()) return {};
  const std::vector<double> found =
      row_of_largest(world.comm, closest, most, {double(worst_a.body), double(worst_b.body), worst_a.x[0], worst_a.x[1], worst_a.x[2]});
  return Meeting{static_cast<int>(found[0]), static_cast<int>(found[1]), Vec3(found[2], found[3], found[4]), most};
}

}  // namespace berm
