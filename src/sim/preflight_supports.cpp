/// What holds the bodies at the start: nothing, nodes beside them, or too few points.

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
#include "sim/body_mass.hpp"
#include "sim/preflight.hpp"
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
std::vector<int> motions_of(Space space) {
  if (space == Space::axisymmetric) return {1};
  if (space == Space::solid) return {0, 1, 2, 3, 4, 5};
  return {0, 1, 5};
}

/// An assembly of bodies that move together, and what holds it.
struct Assembly {
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  Eigen::Matrix<double, 6, 6> held = Eigen::Matrix<double, 6, 6>::Zero();
  bool carried = false;       ///< something takes weight: whatever holds along it, or a contact that it is drawn to
  std::set<int> let_go;       ///< contacts that it is drawn away from
  Vec3 least_grip = Vec3::Zero(), most_grip = Vec3::Zero();  ///< components of the ways in which those with friction push
  /// Between faces that push against each other a body may jam.
  bool may_jam() const { return ((least_grip.array() < -0.5) && (most_grip.array() > 0.5)).any(); }
  Vec3 centre() const { return 0.5 * (low + high); }
  double size() const { return std::max((high - low).norm(), 1e-300); }
  void hold(Space space, const Vec3& at, const Vec3& direction) {
    const Motion m = motion_along(space, direction, (at - centre()) / size());
    held += m * m.transpose();
  }
};

/// What the assembly can do freely, in words; empty: nothing.
std::string free_motion(const Case& c, const Assembly& a) {
  const Space space = c.space;
  constexpr double nothing = 1e-10;
  const std::vector<int> motions = motions_of(space);
  const int n = static_cast<int>(motions.size());
  Eigen::MatrixXd held(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) held(i, j) = a.held(motions[i], motions[j]);
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

/// Sizes of the masses that the owned nodes have of each body of the case; none of rigid ones. Collective.
std::vector<std::vector<double>> shares_of_nodes(const World& w) {
  std::vector<std::vector<double>> share(w.spec.bodies.size());
  for (std::size_t b = 0; b < share.size(); ++b) {
    if (w.spec.bodies[b].rigid) continue;
    share[b] = mass_at_nodes(*w.discretisation, static_cast<int>(b));
    for (double& mass : share[b]) mass = std::abs(mass);
  }
  return share;
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
  return w.neighbours.touching.contains(std::minmax(body_index(w.spec, k.body), body_index(w.spec, k.other)));
}

/// A contact farther apart than this at the start holds nothing in the first step [cells].
constexpr double apart = 0.01;

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
  const double far = is_first(w, stage) ? apart * d.cell_size() : std::numeric_limits<double>::infinity();
  for (const auto& hold : w.boundary->holds(d)) {
    if (hold.gap > far) continue;
    std::set<int> held;
    if (hold.body >= 0) held.insert(groups.of(pieces.at(hold.body, hold.at)));
    for (std::size_t b = 0; hold.node >= 0 && b < share.size(); ++b)
      if (!share[b].empty() && share[b][hold.node] > 0.0) held.insert(groups.of(pieces.at(static_cast<int>(b), hold.at)));
    for (const int root : held) {
      Assembly& a = assemblies[root];
      a.hold(c.space, hold.at, hold.direction);
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
        a.hold(c.space, d.nodes[at.a], at.normal);
        a.carried = true;
      }
    }
  for (auto& [root, a] : assemblies) {
    w.comm.sum(std::span<double>(a.held.data(), 36));
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

/// B-splines: as many strains as unknowns, or some motions of the nodes cost nothing. Collective.
void refuse_few_points(const World& w, const MpmDiscretisation& mpm, const std::vector<std::vector<double>>& share) {
  const Case& c = w.spec;
  if (c.shape_functions != ShapeFunctions::quadratic_bspline && c.shape_functions != ShapeFunctions::cubic_bspline) return;
  const int d = c.dimension(), strains = c.space == Space::solid ? 6 : c.space == Space::axisymmetric ? 4 : 3;
  for (const Slice& slice : mpm.material.slices) {
    // Bodies of a layer share nodes: the points of all strain them.
    long unknowns = 0, points = 0;
    for (int i = 0; i < mpm.halo.n_owned; ++i) {
      bool reached = false;
      for (const Slice& other : mpm.material.slices)
        reached |= w.layers[other.body] == w.layers[slice.body] && share[other.body][i] > 0.0;
      for (int k = 0; k < d && reached; ++k) unknowns += !w.boundary->fixed()[d * i + k];
    }
    for (const Slice& other : mpm.material.slices)
      if (w.layers[other.body] == w.layers[slice.body]) points += other.end - other.begin;
    unknowns = w.comm.sum(unknowns) - static_cast<long>(motions_of(c.space).size());
    points = w.comm.sum(points);
    const Body& body = c.bodies[slice.body];
    // One point a cell leaves cubic functions motions without strain, however many cells there are.
    const bool single = mpm.degree() == 3 && body.points.kind == PointSeeding::Kind::grid && body.mesh_file.empty() && body.points.per_direction == 1;
    if (strains * points >= unknowns && !single) continue;
    const double factor = std::max(single ? 2.0 : 1.0, std::pow(double(unknowns) / (strains * points), 1.0 / d));
    const bool by_mesh = body.points.kind == PointSeeding::Kind::mesh || !body.mesh_file.empty();
    const std::string more =
        by_mesh ? fmt::format("a finer mesh for them or more points.per_element")
                : fmt::format("points.per_direction = {} or more", static_cast<int>(std::ceil(factor * body.points.per_direction - 1e-9)));
    throw InputError(fmt::format(
        "body \"{}\" has {} points, too few for the {} unknowns of B-splines of degree {}: take [body.{}] {}, or smaller cells",
        body.name, points, unknowns, mpm.degree(), body.name, more));
  }
}

/// Held nodes stay where they are in the grid: a body that is pushed or drawn away from a row of them leaves it, and is no
/// longer held by what its support was. Collective.
void warn_of_left_nodes(World& w, const MpmDiscretisation& mpm, int boundary, const std::vector<BoundaryConditions::Hold>& holds, const Mat3& own,
                        const std::map<int, Region>& regions) {
  constexpr double flat = 0.5, left = 0.1;  // cells
  constexpr int samples = 100;
  const Case& c = w.spec;
  const NodeBoundary& b = c.boundaries[boundary];
  if (!b.body.empty() || !moves_through_grid(c)) return;
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  for (const auto& hold : holds)
    if (hold.boundary == boundary && hold.node >= 0) low = low.cwiseMin(hold.at), high = high.cwiseMax(hold.at);
  for (int i = 0; i < 3; ++i) low[i] = w.comm.min(low[i]), high[i] = w.comm.max(high[i]);
  for (int i = 0; i < mpm.dimension(); ++i) {
    const double thickness = high[i] - low[i];
    if (!b.u[i] || b.u[i]->depends_on_place() || !(thickness < flat * mpm.cell_size()) || !own.isIdentity(1e-12)) continue;
    // Within a body there is material to follow that which moves on.
    const Vec3 middle = 0.5 * (low + high), way = 0.6 * mpm.cell_size() * Vec3::Unit(i);
    if (std::any_of(regions.begin(), regions.end(), [&](const auto& r) { return r.second.contains(middle + way) && r.second.contains(middle - way); }))
      continue;
    double farthest = 0.0;
    for (int k = 0; k <= samples; ++k) farthest = std::max(farthest, std::abs(b.u[i]->at(c.duration() * k / samples)));
    if (farthest <= left * mpm.cell_size()) continue;
    w.warnings.push_back(
        fmt::format("[boundary.{}] moves nodes of the grid by {:.3g} m ({:.2g} cells) along {}, but they stay in their places: the body leaves them. Hold "
                    "its surface in their place (boundary.{}.body = \"NAME\"), or take [model] formulation = \"total_lagrangian\"",
                    b.name, farthest, farthest / mpm.cell_size(), "xyz"[i], b.name));
  }
}

/// Calls work with the middle and the ends of a piece.
template <class Work>
void look_at_piece(const SurfacePoint& s, Work work) {
  work(s.X);
  for (int k = 0; k < s.n_corners; ++k) work(s.corner[k]);
  if (s.n_corners > 0) return;
  const Vec3 half = 0.5 * s.size * Vec3(-s.normal.y(), s.normal.x(), 0.0);
  work(s.X + half), work(s.X - half);
}

/// From a body to the boxes of the held nodes of each cell, on this process; it need not be exact below `enough`.
double distance_to_held(const MpmDiscretisation& mpm, const Slice& slice, const std::vector<char>& held, const Mat3& own,
                        const std::vector<SurfacePoint>& surface, const std::vector<Vec3>& points, const Region* region, double enough) {
  double nearest = infinity;
  for (int node = 0; region && node < mpm.n_nodes(); ++node)
    if (held[node] && region->contains(mpm.nodes[node])) return 0.0;
  for (int block = 0; block < mpm.n_patches() && nearest > enough; ++block) {
    Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
    for (const int node : mpm.blocks[block])
      if (held[node]) low = low.cwiseMin(own * mpm.nodes[node]), high = high.cwiseMax(own * mpm.nodes[node]);
    if (low.x() > high.x()) continue;
    const auto look = [&](const Vec3& x) {
      const Vec3 y = own * x;
      nearest = std::min(nearest, (low - y).cwiseMax(y - high).head(mpm.dimension()).maxCoeff());
    };
    for (std::size_t k = 0; k < surface.size() && nearest > enough; ++k)
      if (surface[k].body == slice.body) look_at_piece(surface[k], look);
    for (int p = slice.begin; p < slice.end && nearest > enough; ++p) look(points[p]);
  }
  return nearest;
}

}  // namespace

void refuse_hanging_bodies(World& w, const MpmDiscretisation& mpm, const std::vector<SurfacePoint>& surface) {
  const Case& c = w.spec;
  const std::vector<std::vector<double>> share = shares_of_nodes(w);
  const double reach = (0.1 + 0.5 * (mpm.degree() - 1)) * mpm.cell_size();  // splines have nodes between the lines
  const StructuredGrid* grid = mpm.grid().structure.get();
  const Mat3 own = grid ? Mat3(Eigen::AngleAxisd(-grid->angle, Vec3::UnitZ()).toRotationMatrix()) : Mat3(Mat3::Identity());
  std::vector<std::vector<char>> held(c.boundaries.size());
  for (auto& nodes : held) nodes.assign(mpm.n_nodes(), 0);
  const std::vector<BoundaryConditions::Hold> holds = w.boundary->holds(mpm);
  for (const auto& hold : holds)
    if (hold.node >= 0 && hold.boundary >= 0) held[hold.boundary][hold.node] = 1;
  const std::vector<Vec3> points = mpm.point_positions();
  const std::map<int, Region> regions = regions_of_shapes(c, mpm.cell_size());
  for (std::size_t b = 0; b < c.boundaries.size(); ++b) {
    mpm.halo.copy_to_ghosts(held[b].data(), 1);
    warn_of_left_nodes(w, mpm, static_cast<int>(b), holds, own, regions);
    std::map<int, bool> touches;   // by body that has some of the nodes
    std::map<int, double> nearest;
    for (const Slice& slice : mpm.material.slices) {
      bool reached = false;
      for (int i = 0; i < mpm.halo.n_owned; ++i) reached |= held[b][i] && share[slice.body][i] > 0.0;
      if (!w.comm.any(reached)) continue;
      const double distance = distance_to_held(mpm, slice, held[b], own, surface, points, regions.count(slice.body) ? &regions.at(slice.body) : nullptr, reach);
      nearest[slice.body] = w.comm.min(distance);
      touches[slice.body] = nearest[slice.body] <= reach;
    }
    for (const auto& [body, by_itself] : touches) {
      // What lies between, and has the same nodes, may touch them for it.
      bool carried = by_itself;
      for (const auto& [other, other_touches] : touches) {
        bool common = false;
        for (int i = 0; i < mpm.halo.n_owned; ++i) common |= held[b][i] && share[body][i] > 0.0 && share[other][i] > 0.0;
        carried |= other_touches && w.comm.any(common);
      }
      if (carried) continue;
      const std::string text = fmt::format("[boundary.{}] holds nodes {:.4g} m beside body \"{}\", which does not touch them and would hang on them all "
                                           "the same",
                                           c.boundaries[b].name, nearest[body], c.bodies[body].name);
      if (!c.allow_glued)
        throw InputError(fmt::format("{}. Move the body to them, hold its surface by [boundary.{}] body = \"{}\", keep them a cell away from "
                                     "it, or allow it by [model] allow_glued = true",
                                     text, c.boundaries[b].name, c.bodies[body].name));
      w.warnings.push_back(text);
    }
  }
}

/// The reader has looked at motions that are the same everywhere.
void refuse_jumps(const World& w) {
  const Case& c = w.spec;
  if (c.stages.front().steps.analysis != Analysis::dynamic) return;
  w.comm.agree([&] {
    for (const auto& hold : w.boundary->holds(*w.discretisation)) {
      if (hold.boundary < 0) continue;
      const NodeBoundary& b = c.boundaries[hold.boundary];
      for (const std::optional<TimeFunction>& u : {b.u[0], b.u[1], b.u[2], std::optional(b.un)})
        if (u && u->depends_on_place() && std::abs(u->at(0.0, hold.at)) > no_jump)
          throw InputError(fmt::format("[boundary.{}]: \"{}\" is {:.4g} at {} and t = 0: where the first stage is dynamic a displacement begins "
                                       "with 0 everywhere",
                                       b.name, u->text(), u->at(0.0, hold.at), place_text(c, hold.at)));
    }
  });
}

namespace {

/// What lies inside a rigid body at the start is pushed out in the first step, by the stiff springs of contact. Collective.
void warn_of_depth(World& w) {
  constexpr double told = 1e-4, meshed = 0.01;  // cells
  const Case& c = w.spec;
  const double h = w.discretisation->cell_size();
  const std::vector<BoundaryConditions::Hold> holds = w.boundary->holds(*w.discretisation);
  const bool some = std::any_of(holds.begin(), holds.end(), [&](const auto& hold) { return hold.contact >= 0 && hold.gap < -told * h; });
  if (!w.comm.any(some)) return;
  const std::map<int, Region> regions = regions_of_shapes(c, h);
  // Chords of a mesh lie inside of an arc: the place of the body's own shape counts.
  const auto depth = [&](const BoundaryConditions::Hold& hold) {
    const auto own = regions.find(hold.body), rigid = regions.find(body_index(c, c.contacts[hold.contact].rigid));
    if (own == regions.end() || rigid == regions.end()) return -hold.gap - meshed * h;
    return -rigid->second.nearest(own->second.nearest(hold.at).point).distance;
  };
  for (std::size_t k = 0; k < c.contacts.size(); ++k) {
    double deepest = 0.0;
    for (const auto& hold : holds)
      if (hold.contact == static_cast<int>(k) && hold.gap < -told * h) deepest = std::max(deepest, depth(hold));
    deepest = w.comm.max(deepest);
    if (deepest <= told * h) continue;
    w.warnings.push_back(with_places(c, fmt::format("[contact.{}]: the surface of \"{}\" starts up to {:.3g} m inside of rigid body \"{}\", and is pushed out in the first "
                                          "step: let it start where the two touch",
                                                    c.contacts[k].name, c.contacts[k].body, deepest, c.contacts[k].rigid)));
  }
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
    if (contact.other.empty() && nearest > apart * w.discretisation->cell_size() && std::isfinite(nearest))
      words += fmt::format(" [contact.{}] is {:.3g} m apart: let the bodies touch at the start.", contact.name, nearest);
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
void look_for_free_bodies(const World& w, const std::string& stage, Findings& found) {
  const Case& c = w.spec;
  const std::vector<std::vector<double>> share = shares_of_nodes(w);
  const Pieces pieces(w);
  Groups groups = find_assemblies(w, stage, share, pieces);
  for (const auto& [root, assembly] : hold_assemblies(w, stage, share, groups, pieces)) {
    if (!(assembly.low.x() <= assembly.high.x())) continue;  // without a node of its own
    const std::string motion = free_motion(c, assembly);
    if (motion.empty()) {
      if (is_first(w, stage)) found.look([&] { refuse_lost_weight(w, assembly, names_of(w, groups, pieces, root)); });
      continue;
    }
    const std::vector<std::string> names = names_of(w, groups, pieces, root);
    const bool one = names.size() == 1;
    const std::string reach = is_first(w, stage) ? contacts_apart(w, names) : "";
    const std::string when = c.stages.size() > 1 ? fmt::format(" in [stage.{}]", stage) : "";
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
