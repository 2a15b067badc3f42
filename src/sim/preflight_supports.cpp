/// What holds the bodies at the start of each quasi-static stage, and which motions nothing resists.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <limits>
#include <map>
#include <set>

#include "base/findings.hpp"
#include "bc/case_lookup.hpp"
#include "case/places.hpp"
#include "sim/advice.hpp"
#include "sim/preflight_parts.hpp"

namespace berm {
namespace {

/// Motions of a rigid body that the space allows: displacements at x, seen from a centre, over the size of the body.
using Motion = Eigen::Matrix<double, 6, 1>;
Motion motion_along(Space space, const Vec3& direction, const Vec3& arm) {
  Motion m = Motion::Zero();
  if (space == Space::axisymmetric) {
    m[1] = direction.y();
    return m;
  }
  m.head<3>() = direction;
  m.tail<3>() = arm.cross(direction);
  return m;
}

using Hold6 = Eigen::Matrix<double, 6, 6>;
constexpr double nothing = 1e-10;  ///< of the largest eigenvalue of what holds

/// In how many directions displacements are held.
long directions(const Hold6& held) {
  const Eigen::Array3d values = Eigen::SelfAdjointEigenSolver<Mat3>(held.topLeftCorner<3, 3>(), Eigen::EigenvaluesOnly).eigenvalues().array();
  return (values > nothing * std::max(values.maxCoeff(), 1e-300)).count();
}

/// What a smooth contact holds, by the normals of both sides. Next to the place where a body touches, and a hundredth of a cell counts
/// as touching, the two differ, and one of them may turn from place to place: a beam slides on a roller all the same, and a
/// disc on a floor. What slides along either side is free but for that.
struct SmoothContact {
  Hold6 by_rigid = Hold6::Zero(), by_body = Hold6::Zero();
  const Hold6& weaker() const { return directions(by_body) < directions(by_rigid) ? by_body : by_rigid; }
};

/// An assembly of bodies that move together, and what holds it.
struct Assembly {
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  Hold6 held = Hold6::Zero(), held_truly = Hold6::Zero();  ///< as the normals of rigid bodies say, and by the weaker side of each smooth contact
  std::map<int, SmoothContact> smooth;  ///< with rigid bodies, by contact of the case
  bool carried = false;       ///< something takes weight: whatever holds along it, or a contact that it is drawn to
  std::set<int> let_go;       ///< contacts that it is drawn away from
  Vec3 least_grip = Vec3::Zero(), most_grip = Vec3::Zero();  ///< components of the ways in which those with friction push
  /// Between faces that push against each other a body may jam.
  bool may_jam() const { return ((least_grip.array() < -0.5) && (most_grip.array() > 0.5)).any(); }
  Vec3 centre() const { return 0.5 * (low + high); }
  double size() const { return std::max((high - low).norm(), 1e-300); }
  void hold(Space space, const Vec3& at, const Vec3& direction, Hold6& sum) const {
    const Motion m = motion_along(space, direction, (at - centre()) / size());
    sum += m * m.transpose();
  }
};

/// What the assembly can do freely, in words; empty: nothing.
std::string free_motion(const Case& c, const Assembly& a, const Hold6& by) {
  const Space space = c.space;
  const std::vector<int> motions = motions_of(space);
  const int n = static_cast<int>(motions.size());
  Eigen::MatrixXd held(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) held(i, j) = by(motions[i], motions[j]);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(held);
  Eigen::MatrixXd free(n, 0);
  for (int k = 0; k < n; ++k)
    if (modes.eigenvalues()[k] <= nothing * std::max(modes.eigenvalues()[n - 1], 1e-300)) {
      free.conservativeResize(n, free.cols() + 1);
      free.col(free.cols() - 1) = modes.eigenvectors().col(k);
    }
  if (free.cols() == 0) return "";
  std::vector<std::string> words, axes;
  for (int i = 0; i < n; ++i)
    if (motions[i] < 3 && free.row(i).norm() > 1.0 - 1e-6) axes.emplace_back(1, "xyz"[motions[i]]);
  if (!axes.empty()) words.push_back(fmt::format("move along {}", fmt::join(axes, ", ")));
  if (static_cast<int>(axes.size()) < free.cols()) {
    const bool plain = axes.empty() && free.cols() == 1 && is_plane(space) && std::abs(free(2, 0)) > 1e-6;
    const Vec3 about = plain ? Vec3(a.centre() + a.size() * Vec3(-free(1, 0), free(0, 0), 0.0) / free(2, 0)) : Vec3::Zero();
    words.push_back(plain ? "turn about " + place_text(c, about) : "turn");
  }
  return fmt::format("{}", fmt::join(words, " and "));
}

/// Parts of bodies, numbered through.
class Pieces {
public:
  explicit Pieces(const World& w) : w_(w) {
    for (const BodyParts& parts : w.parts) {
      first_.push_back(count_);
      count_ += parts.count();
    }
  }
  int count() const { return count_; }
  int first(int body) const { return first_[body]; }
  int end(int body) const { return first_[body] + w_.parts[body].count(); }
  int at(int body, const Vec3& x) const { return first_[body] + w_.parts[body].of(x); }

private:
  const World& w_;
  std::vector<int> first_;
  int count_ = 0;
};

/// Bodies are seen where they start: what contact does in later stages is not known.
bool is_first(const World& w, const std::string& stage) { return stage == w.spec.stages.front().name; }

/// Whether two deformable bodies touch at the start.
bool meet(const World& w, const Contact& k) {
  return w.neighbours.touching.contains(bodies_of(w.spec, k));
}

/// Parts that share nodes, are tied or touch by contact with friction in a stage move together. Collective.
Groups find_assemblies(const World& w, const std::string& stage, const std::vector<std::vector<double>>& share, const Pieces& pieces) {
  const Case& c = w.spec;
  const Discretisation& d = *w.discretisation;
  Groups groups(pieces.count());
  const auto join_bodies = [&](int a, int b) {
    for (int i = pieces.first(a); i < pieces.end(a); ++i)
      for (int j = pieces.first(b); j < pieces.end(b); ++j) groups.join(i, j);
  };
  for (const Joint& j : w.neighbours.joints)
    if (j.contact < 0 || acts_in(c.contacts[j.contact].stages, stage)) join_bodies(j.body, j.other);
  for (const Contact& k : c.contacts)
    if (!k.other.empty() && k.kind != Contact::Kind::frictionless && acts_in(k.stages, stage) &&
        (k.kind == Contact::Kind::tie || !is_first(w, stage) || meet(w, k)))
      join_bodies(body_index(c, k.body), body_index(c, k.other));
  std::set<std::array<int, 2>> common;
  for (int i = 0; i < d.halo.n_owned; ++i) {
    int first = -1;
    for (std::size_t b = 0; b < share.size(); ++b) {
      if (share[b].empty() || share[b][i] <= 0.0) continue;
      const int piece = pieces.at(static_cast<int>(b), d.nodes[i]);
      if (first >= 0) common.insert(std::array<int, 2>{first, piece});
      else first = piece;
    }
  }
  const std::vector<std::array<int, 2>> mine(common.begin(), common.end());
  for (const auto& [a, b] : w.comm.all_gather(mine)) groups.join(a, b);
  return groups;
}

constexpr double beside = 1e-6;  ///< a contact presses less than this share of the weight where it is upright

std::map<int, Assembly> hold_assemblies(const World& w, const std::string& stage, const std::vector<std::vector<double>>& share, Groups& groups, const Pieces& pieces) {
  const Discretisation& d = *w.discretisation;
  const Case& c = w.spec;
  std::map<int, Assembly> assemblies;
  for (std::size_t b = 0; b < share.size(); ++b) {
    if (c.bodies[b].rigid) continue;
    const int body = static_cast<int>(b);
    for (int piece = pieces.first(body); piece < pieces.end(body); ++piece) assemblies[groups.of(piece)];
    for (int i = 0; i < d.halo.n_owned; ++i) {
      if (share[b][i] <= 0.0) continue;
      Assembly& a = assemblies[groups.of(pieces.at(body, d.nodes[i]))];
      a.low = a.low.cwiseMin(d.nodes[i]), a.high = a.high.cwiseMax(d.nodes[i]);
    }
  }
  for (auto& [root, a] : assemblies)
    for (int i = 0; i < 3; ++i) a.low[i] = w.comm.min(a.low[i]), a.high[i] = w.comm.max(a.high[i]);
  const Vec3 weight = c.gravity.at(w.spec.stages.front().end());
  const double far = is_first(w, stage) ? still_touching * d.cell_size() : std::numeric_limits<double>::infinity();
  for (const auto& hold : w.boundary->holds(d)) {
    if (hold.gap > far) continue;
    std::set<int> held;
    if (hold.body >= 0) held.insert(groups.of(pieces.at(hold.body, hold.at)));
    for (std::size_t b = 0; hold.node >= 0 && b < share.size(); ++b)
      if (!share[b].empty() && share[b][hold.node] > 0.0) held.insert(groups.of(pieces.at(static_cast<int>(b), hold.at)));
    for (const int root : held) {
      Assembly& a = assemblies[root];
      if (hold.contact >= 0 && c.contacts[hold.contact].kind == Contact::Kind::frictionless) {
        SmoothContact& smooth = a.smooth[hold.contact];
        a.hold(c.space, hold.at, hold.push, smooth.by_rigid), a.hold(c.space, hold.at, hold.inward, smooth.by_body);
      } else {
        a.hold(c.space, hold.at, hold.direction, a.held);
      }
      const bool lets_go = hold.contact >= 0 && weight.dot(hold.push) > -beside * weight.norm();
      if (lets_go) a.let_go.insert(hold.contact);
      if (lets_go && c.contacts[hold.contact].kind != Contact::Kind::frictionless)
        a.least_grip = a.least_grip.cwiseMin(hold.push), a.most_grip = a.most_grip.cwiseMax(hold.push);
      if (!lets_go) a.carried |= hold.contact >= 0 || std::abs(weight.dot(hold.direction)) > beside * weight.norm();
    }
  }
  // Without friction bodies hold each other along the normal alone.
  for (const Interface& at : d.interfaces())
    for (const Contact& k : c.contacts) {
      if (k.other.empty() || k.kind != Contact::Kind::frictionless || !acts_in(k.stages, stage) || (is_first(w, stage) && !meet(w, k))) continue;
      const int first = body_index(c, k.body), second = body_index(c, k.other);
      if (std::minmax(w.layers[first], w.layers[second]) != std::minmax(at.field_a, at.field_b)) continue;
      for (const int body : {first, second}) {
        Assembly& a = assemblies[groups.of(pieces.at(body, d.nodes[at.a]))];
        a.hold(c.space, d.nodes[at.a], at.normal, a.held);
        a.carried = true;
      }
    }
  for (auto& [root, a] : assemblies) {
    w.comm.sum(std::span<double>(a.held.data(), 36));
    a.held_truly = a.held;
    for (std::size_t k = 0; k < c.contacts.size(); ++k) {
      if (c.contacts[k].kind != Contact::Kind::frictionless || c.contacts[k].rigid.empty()) continue;
      SmoothContact& smooth = a.smooth[static_cast<int>(k)];
      for (Hold6* sum : {&smooth.by_rigid, &smooth.by_body}) w.comm.sum(std::span<double>(sum->data(), 36));
      a.held += smooth.by_rigid, a.held_truly += smooth.weaker();
    }
    a.carried = w.comm.any(a.carried);
    for (int i = 0; i < 3; ++i) a.least_grip[i] = w.comm.min(a.least_grip[i]), a.most_grip[i] = w.comm.max(a.most_grip[i]);
    const std::vector<int> mine(a.let_go.begin(), a.let_go.end());
    for (const int contact : w.comm.all_gather(mine)) a.let_go.insert(contact);
  }
  return assemblies;
}

/// The bodies of an assembly, or their parts, in words.
std::vector<std::string> names_of(const World& w, Groups& groups, const Pieces& pieces, int root) {
  std::vector<std::string> names;
  for (std::size_t b = 0; b < w.spec.bodies.size(); ++b) {
    const int body = static_cast<int>(b);
    if (w.spec.bodies[b].rigid) continue;
    int here = 0;
    for (int piece = pieces.first(body); piece < pieces.end(body); ++piece) here += groups.of(piece) == root;
    if (here == 0) continue;
    const int all = w.parts[b].count();
    names.push_back(here == all ? fmt::format("\"{}\"", w.spec.bodies[b].name)
                                : fmt::format("\"{}\" ({} of its {} parts that are not connected)", w.spec.bodies[b].name, here, all));
  }
  return names;
}

/// What those contacts with rigid bodies lack that could hold a body of that name in the first stage and do not reach it. Collective.
std::string contacts_apart(const World& w, const std::vector<std::string>& names) {
  const Case& c = w.spec;
  const std::string& first = c.stages.front().name;
  std::vector<double> gap(c.contacts.size(), std::numeric_limits<double>::infinity());
  for (const auto& hold : w.boundary->holds(*w.discretisation))
    if (hold.contact >= 0) gap[hold.contact] = std::min(gap[hold.contact], hold.gap);
  std::string words;
  for (std::size_t k = 0; k < gap.size(); ++k) {
    const Contact& contact = c.contacts[k];
    const double nearest = w.comm.min(gap[k]);
    const bool named = std::any_of(names.begin(), names.end(), [&](const std::string& n) {
      return n == fmt::format("\"{}\"", contact.body) || n == fmt::format("\"{}\"", contact.other);
    });
    if (!named || !acts_in(contact.stages, first)) continue;
    if (contact.other.empty() && nearest > still_touching * w.discretisation->cell_size() && std::isfinite(nearest))
      words += fmt::format(" [contact.{}] is {:.3g} m apart in the middle of the nearest piece of the surface (a tip has no area): let the bodies start so much closer.",
                           contact.name, nearest);
    if (!contact.other.empty() && contact.kind != Contact::Kind::tie && !meet(w, contact))
      words += fmt::format(" [contact.{}]: \"{}\" and \"{}\" are apart: let them touch at the start.", contact.name, contact.body, contact.other);
  }
  return words;
}

/// Contact can push and not draw: where nothing but the weight acts, it must draw a body to one that carries it.
void refuse_lost_weight(const World& w, const Assembly& a, const std::vector<std::string>& names) {
  const Case& c = w.spec;
  if (a.carried || a.may_jam() || a.let_go.empty() || c.gravity.is_zero() || !only_weight_acts(c)) return;
  std::vector<std::string> contacts;
  for (const int k : a.let_go) contacts.push_back(fmt::format("[contact.{}]", c.contacts[k].name));
  throw InputError(fmt::format("nothing carries the weight of {} {}, near {}: {} can only push, and the weight draws the body away from there or along it. "
                               "A quasi-static stage needs a support below ([boundary.NAME], [pin.NAME], a contact with a body there), or analysis = \"dynamic\"",
                               names.size() == 1 ? "body" : "bodies", fmt::join(names, ", "), place_text(c, a.centre()), fmt::join(contacts, ", ")));
}

/// In the stage that the boundary conditions are in.
void look_for_free_bodies(World& w, const std::string& stage, Findings& found) {
  const Case& c = w.spec;
  const std::vector<std::vector<double>> share = shares_of_nodes(w);
  const Pieces pieces(w);
  Groups groups = find_assemblies(w, stage, share, pieces);
  for (const auto& [root, assembly] : hold_assemblies(w, stage, share, groups, pieces)) {
    if (!(assembly.low.x() <= assembly.high.x())) continue;  // without a node of its own
    const std::string when = c.stages.size() > 1 ? fmt::format(" in [stage.{}]", stage) : "";
    const std::string motion = free_motion(c, assembly, assembly.held);
    if (motion.empty()) {
      const std::string slips = free_motion(c, assembly, assembly.held_truly);
      if (!slips.empty())
        w.warnings.push_back(with_places(c, fmt::format("body {}, near {}, can {} on what it touches without friction{}: only the slope of the surfaces beside the places that touch "
                                                        "resists. Hold it in one place ([pin.NAME], [boundary.NAME]), or give a contact friction",
                                                        fmt::join(names_of(w, groups, pieces, root), ", "), place_text(c, assembly.centre()), slips, when)));
      if (is_first(w, stage)) found.look([&] { refuse_lost_weight(w, assembly, names_of(w, groups, pieces, root)); });
      continue;
    }
    const std::vector<std::string> names = names_of(w, groups, pieces, root);
    const bool one = names.size() == 1;
    const std::string reach = is_first(w, stage) ? contacts_apart(w, names) : "";
    found.look([&] {
      throw InputError(fmt::format("{} {}, near {}, can {}{}: nothing holds {} there.{} A quasi-static stage needs a support ([boundary.NAME], [pin.NAME]), a "
                                   "[contact.NAME] with something that is held, or analysis = \"dynamic\"",
                                   one ? "body" : "bodies", fmt::join(names, ", "), place_text(c, assembly.centre()), motion, when, one ? "it" : "them", reach));
    });
  }
}

/// Bodies are where they start, also where later stages are looked at.
void look_at_supports(World& w) {
  const Case& c = w.spec;
  Findings found;
  found.look([&] { refuse_jumps(w); });
  if (const auto* mpm = dynamic_cast<const MpmDiscretisation*>(w.discretisation.get())) found.look([&] { refuse_few_points(w, *mpm, shares_of_nodes(w)); });
  const auto enter = [&](const std::string& stage) {
    w.boundary->begin_stage(stage);
    w.begin_step();
  };
  warn_of_depth(w);
  const std::string& first = c.stages.front().name;
  std::vector<std::string> seen;  // what is held in the same way is wrong in the same way
  for (const Stage& stage : c.stages) {
    const auto like = [&](const std::string& other) { return same_act_in(c, other, stage.name); };
    if (stage.steps.analysis != Analysis::quasi_static || std::any_of(seen.begin(), seen.end(), like)) continue;
    seen.push_back(stage.name);
    if (stage.name != w.boundary->stage()) enter(stage.name);
    look_for_free_bodies(w, stage.name, found);
  }
  if (w.boundary->stage() != first) enter(first);
  found.throw_if_any();
}

}  // namespace

void refuse_free_bodies(World& w) {
  tell_places(w.spec, [&] { look_at_supports(w); });
}

}  // namespace berm
