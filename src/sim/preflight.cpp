#include "sim/preflight.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>

#include "base/error.hpp"
#include "bc/case_lookup.hpp"
#include "sim/advice.hpp"

namespace berm {
namespace {

/// Sets that grow together.
class Groups {
public:
  explicit Groups(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int of(int k) {
    while (parent_[k] != k) k = parent_[k] = parent_[parent_[k]];
    return k;
  }
  void join(int a, int b) { parent_[of(a)] = of(b); }

private:
  std::vector<int> parent_;
};

std::map<int, Region> regions_of_shapes(const Case& c, double size) {
  std::map<int, Region> regions;
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].shape) regions.try_emplace(static_cast<int>(b), *c.bodies[b].shape, size);
  return regions;
}

/// What of a body lies inside of a region.
struct Inside {
  double depth = 0.0;    ///< of the deepest place [m]
  double measure = 0.0;  ///< of the points [m2] or [m3]
  Vec3 at = Vec3::Zero();
};

Inside part_inside(const Region& region, int body, const BuiltBodies& built) {
  Inside in;
  const Vec3 low = region.min(), high = region.max();
  const int d = region.dimension();
  const auto look = [&](const Vec3& x, double measure) {
    if ((x.head(d).array() < low.head(d).array()).any() || (x.head(d).array() > high.head(d).array()).any()) return;
    const double depth = -region.nearest(x).distance;
    if (depth <= 0.0) return;
    in.measure += measure;
    if (depth > in.depth) in.depth = depth, in.at = x;
  };
  for (std::size_t p = 0; p < built.places[body].size(); ++p) look(built.places[body][p], built.measures[body][p]);
  for (const SurfacePoint& s : built.surface)
    if (s.body == body) look(s.X, 0.0);
  return in;
}

/// Contact that keeps the two apart in the first stage, or null.
const Contact* unilateral_contact(const Case& c, const std::string& body, const std::string& rigid) {
  using enum Contact::Kind;
  const std::string first = c.stages.front().name;
  for (const Contact& k : c.contacts)
    if (k.body == body && k.rigid == rigid && acts_in(k.stages, first) && k.kind != tie && k.kind != shared_nodes) return &k;
  return nullptr;
}

/// A place where two sides of a gap see a common node.
struct Glue {
  int piece, other;
  double width;
};

/// Sides of gaps turn towards each other: the angle between their normals and the way across is less than 37 degrees.
bool face_each_other(const SurfacePoint& s, const SurfacePoint& t, double size) {
  constexpr double facing = 0.8, closed = 1e-6;
  const Vec3 way = t.X - s.X;
  const double length = way.norm();
  return length > closed * size && way.dot(s.normal) > facing * length && -way.dot(t.normal) > facing * length;
}

/// A piece at which another body of its layer begins has no gap before it.
bool is_covered_by(const SurfacePoint& s, const SurfacePoint& t, double size) {
  constexpr double touching = 0.1, opposite = -0.7;
  const Vec3 way = t.X - s.X;
  const double apart = way.dot(s.normal);
  return t.body != s.body && s.normal.dot(t.normal) < opposite && std::abs(apart) <= touching * size &&
         (way - apart * s.normal).norm() <= s.size + t.size;
}

/// Whether some of the pieces may face each other: not where all normals lie in a cone, as on a face or an edge of a body.
bool may_face(const std::vector<int>& pieces, const std::vector<SurfacePoint>& surface) {
  constexpr double cone = 0.61;  // cosine of half of the 106 degrees that normals of facing pieces are apart at least
  Vec3 mean = Vec3::Zero();
  for (const int k : pieces) mean += surface[k].normal;
  const double bound = cone * mean.norm();
  return std::any_of(pieces.begin(), pieces.end(), [&](int k) { return surface[k].normal.dot(mean) <= bound; });
}

std::vector<Glue> find_glue(const MpmDiscretisation& mpm, const std::vector<int>& layers, const std::vector<SurfacePoint>& surface,
                            Groups& groups) {
  std::unordered_map<int, std::vector<int>> pieces_of_node;
  for (std::size_t k = 0; k < surface.size(); ++k) {
    const int cell = mpm.grid().locator->locate(surface[k].X - 1e-6 * mpm.cell_size() * surface[k].normal, -1);
    if (cell < 0) continue;  // who needs it there will say so
    for (const int node : mpm.nodes_of(cell)) pieces_of_node[node].push_back(static_cast<int>(k));
  }
  std::erase_if(pieces_of_node, [&](const auto& entry) { return !may_face(entry.second, surface); });
  const double h = mpm.cell_size();
  std::vector<char> covered(surface.size(), 0);
  for (const auto& [node, pieces] : pieces_of_node)
    for (const int k : pieces)
      for (const int other : pieces) covered[k] |= layers[surface[k].body] == layers[surface[other].body] && is_covered_by(surface[k], surface[other], h);
  std::vector<Glue> found;
  for (const auto& [node, pieces] : pieces_of_node) {
    int first = -1;  // glued piece at this node
    for (const int k : pieces)
      for (const int other : pieces) {
        const SurfacePoint &s = surface[k], &t = surface[other];
        if (other <= k || layers[s.body] != layers[t.body] || covered[k] || covered[other] || !face_each_other(s, t, h)) continue;
        found.push_back({k, other, std::max((t.X - s.X).dot(s.normal), (s.X - t.X).dot(t.normal))});
        if (first < 0) first = k;
        groups.join(k, first), groups.join(other, first);
      }
  }
  return found;
}

/// A gap that the grid does not see.
struct Gap {
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  double width = infinity;
  int piece = -1, other = -1;  ///< where it is narrowest
};

std::string cells_text(const MpmDiscretisation& mpm) {
  const StructuredGrid* grid = mpm.grid().structure.get();
  if (!grid || (grid->cell_size.head(mpm.dimension()).array() == grid->cell_size.x()).all()) return fmt::format("{:.4g} m", mpm.cell_size());
  return fmt::format("{:.4g} m", fmt::join(grid->cell_size.data(), grid->cell_size.data() + mpm.dimension(), " x "));
}

std::string gap_text(const Case& c, const MpmDiscretisation& mpm, const Gap& gap, const std::vector<SurfacePoint>& surface) {
  const SurfacePoint &s = surface[gap.piece], &t = surface[gap.other];
  const std::string &a = c.bodies[s.body].name, &b = c.bodies[t.body].name;
  const std::string where = s.body == t.body ? fmt::format("in body \"{}\"", a) : fmt::format("between \"{}\" and \"{}\"", a, b);
  const char* contact = s.body == t.body ? "" : ", give the two a [contact.NAME]";
  return fmt::format(
      "the gap of {:.4g} m {} near {} is too narrow for cells of {}: common nodes join its sides over {:.4g} m. Let {} "
      "whole cell{} lie in it, make the cells smaller than {:.4g} m{}, or allow it by [model] allow_glued = true",
      gap.width, where, place_text(c, 0.5 * (s.X + t.X)), cells_text(mpm), (gap.high - gap.low).norm(), mpm.degree(),
      mpm.degree() == 1 ? "" : "s", gap.width / (mpm.degree() + 1), contact);
}

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
  Vec3 centre() const { return 0.5 * (low + high); }
  double size() const { return std::max((high - low).norm(), 1e-300); }
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

/// How much of each body's mass the nodes have, by body of the case; complete at owned nodes. Collective.
std::vector<std::vector<double>> shares_of_nodes(const World& w) {
  const Discretisation& d = *w.discretisation;
  std::vector<std::vector<double>> share(w.spec.bodies.size());
  for (std::size_t b = 0; b < share.size(); ++b) {
    if (w.spec.bodies[b].rigid) continue;
    NodalVector f(d.n_nodes(), Vec3::Zero());
    d.add_body_force([&](int body, const Vec3&) { return Vec3(body == static_cast<int>(b) ? 1.0 : 0.0, 0.0, 0.0); }, f);
    d.halo.add_to_owners(f.data()->data(), 3);
    for (int i = 0; i < d.halo.n_owned; ++i) share[b].push_back(std::abs(f[i].x()));
  }
  return share;
}

/// Bodies that share nodes, are tied or touch by contact with friction move together. Collective.
Groups find_assemblies(const World& w, const std::vector<std::vector<double>>& share) {
  const Case& c = w.spec;
  const std::size_t n = c.bodies.size();
  Groups groups(n);
  for (const Joint& j : w.joints) groups.join(j.body, j.other);
  for (const Contact& k : c.contacts)
    if (!k.other.empty() && k.kind != Contact::Kind::frictionless && acts_in(k.stages, c.stages.front().name)) groups.join(body_index(c, k.body), body_index(c, k.other));
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b) {
      bool common = false;
      for (std::size_t i = 0; i < std::min(share[a].size(), share[b].size()); ++i) common |= share[a][i] > 0.0 && share[b][i] > 0.0;
      if (w.comm.any(common)) groups.join(static_cast<int>(a), static_cast<int>(b));
    }
  return groups;
}

std::map<int, Assembly> hold_assemblies(const World& w, const std::vector<std::vector<double>>& share, Groups& groups) {
  const Discretisation& d = *w.discretisation;
  const Case& c = w.spec;
  std::map<int, Assembly> assemblies;
  for (std::size_t b = 0; b < share.size(); ++b) {
    if (c.bodies[b].rigid) continue;
    Assembly& a = assemblies[groups.of(static_cast<int>(b))];
    for (int i = 0; i < d.halo.n_owned; ++i)
      if (share[b][i] > 0.0) a.low = a.low.cwiseMin(d.nodes[i]), a.high = a.high.cwiseMax(d.nodes[i]);
  }
  for (auto& [root, a] : assemblies)
    for (int i = 0; i < 3; ++i) a.low[i] = w.comm.min(a.low[i]), a.high[i] = w.comm.max(a.high[i]);
  for (const auto& hold : w.boundary->holds(d)) {
    std::set<int> bodies;
    if (hold.body >= 0) bodies.insert(groups.of(hold.body));
    for (std::size_t b = 0; hold.node >= 0 && b < share.size(); ++b)
      if (!share[b].empty() && share[b][hold.node] > 0.0) bodies.insert(groups.of(static_cast<int>(b)));
    for (const int root : bodies) {
      Assembly& a = assemblies[root];
      const Motion m = motion_along(c.space, hold.direction, (hold.at - a.centre()) / a.size());
      a.held += m * m.transpose();
    }
  }
  // Without friction bodies hold each other along the normal alone.
  for (const Interface& at : d.interfaces())
    for (const Contact& k : c.contacts) {
      if (k.other.empty() || k.kind != Contact::Kind::frictionless || !acts_in(k.stages, c.stages.front().name)) continue;
      const int first = body_index(c, k.body), second = body_index(c, k.other);
      if (std::minmax(w.layers[first], w.layers[second]) != std::minmax(at.field_a, at.field_b)) continue;
      for (const int body : {first, second}) {
        Assembly& a = assemblies[groups.of(body)];
        const Motion m = motion_along(c.space, at.normal, (d.nodes[at.a] - a.centre()) / a.size());
        a.held += m * m.transpose();
      }
    }
  for (auto& [root, a] : assemblies) w.comm.sum(std::span<double>(a.held.data(), 36));
  return assemblies;
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
void warn_of_left_nodes(World& w, const MpmDiscretisation& mpm, int boundary, const Mat3& own, const std::map<int, Region>& regions) {
  constexpr double flat = 0.5, left = 0.1;  // cells
  constexpr int samples = 100;
  const Case& c = w.spec;
  const NodeBoundary& b = c.boundaries[boundary];
  if (!b.body.empty() || !moves_through_grid(c)) return;
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  for (const auto& hold : w.boundary->holds(mpm))
    if (hold.boundary == boundary && hold.node >= 0) low = low.cwiseMin(hold.at), high = high.cwiseMax(hold.at);
  for (int i = 0; i < 3; ++i) low[i] = w.comm.min(low[i]), high[i] = w.comm.max(high[i]);
  for (int i = 0; i < mpm.dimension(); ++i) {
    const double thickness = high[i] - low[i];
    // Within a body there is material to follow that which moves on.
    const Vec3 middle = 0.5 * (low + high), way = 0.6 * mpm.cell_size() * Vec3::Unit(i);
    if (std::any_of(regions.begin(), regions.end(), [&](const auto& r) { return r.second.contains(middle + way) && r.second.contains(middle - way); }))
      continue;
    if (!b.u[i] || b.u[i]->depends_on_place() || !(thickness < flat * mpm.cell_size()) || !own.isIdentity(1e-12)) continue;
    double farthest = 0.0;
    for (int k = 0; k <= samples; ++k) farthest = std::max(farthest, std::abs(b.u[i]->at(c.duration() * k / samples)));
    if (farthest <= left * mpm.cell_size()) continue;
    w.spec.warnings.push_back(
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

void refuse_overlaps(const Case& c, const BuiltBodies& built, double size) {
  // Chords of a mesh lie inside of an arc by less; what is thinner than a part of a cell is a touch.
  constexpr double thin = 0.1, thin_rigid = 0.05;
  const std::map<int, Region> regions = regions_of_shapes(c, size);
  const int n = static_cast<int>(c.bodies.size()), d = c.dimension();
  for (int a = 0; a < n; ++a)
    for (const auto& [b, region] : regions) {
      if (a == b || c.bodies[a].rigid) continue;
      const std::string &first = c.bodies[a].name, &second = c.bodies[b].name;
      const Contact* contact = c.bodies[b].rigid ? unilateral_contact(c, first, second) : nullptr;
      if (c.bodies[b].rigid && !contact) continue;
      const Inside in = part_inside(region, a, built);
      if (in.depth <= (contact ? thin_rigid : thin) * size) continue;
      const std::string amount = in.measure > 0.0 ? fmt::format("{:.4g} {}", in.measure, d == 3 ? "m3" : "m2") : fmt::format("{:.4g} m", in.depth);
      if (contact)
        throw InputError(fmt::format(
            "[contact.{}]: {} of body \"{}\" lies inside of rigid body \"{}\", {:.4g} m deep at {}: let it start where it touches "
            "the surface, or take its place out of the body (shape.difference)",
            contact->name, amount, first, second, in.depth, place_text(c, in.at)));
      throw InputError(fmt::format("bodies \"{}\" and \"{}\" overlap: {} near {} belongs to both. Make their shapes disjoint "
                                   "(shape.difference)",
                                   std::min(first, second), std::max(first, second), amount, place_text(c, in.at)));
    }
}

void refuse_glued_gaps(World& w, const MpmDiscretisation& mpm, const std::vector<SurfacePoint>& surface) {
  const double tip = (mpm.degree() + 2) * mpm.cell_size();  // at the end of a notch its sides meet anyway
  Groups groups(surface.size());
  const std::vector<Glue> glue = find_glue(mpm, w.layers, surface, groups);
  std::map<int, Gap> gaps;
  for (const Glue& g : glue) {
    Gap& gap = gaps[groups.of(g.piece)];
    for (const int k : {g.piece, g.other}) gap.low = gap.low.cwiseMin(surface[k].X), gap.high = gap.high.cwiseMax(surface[k].X);
    if (g.width < gap.width) gap.width = g.width, gap.piece = g.piece, gap.other = g.other;
  }
  for (const auto& [root, gap] : gaps) {
    const int first = surface[gap.piece].body, second = surface[gap.other].body;
    const bool joined = first == second || std::any_of(w.joints.begin(), w.joints.end(), [&](const Joint& j) {
      return std::minmax(j.body, j.other) == std::minmax(first, second);
    });
    if (joined && (gap.high - gap.low).norm() <= tip) continue;
    const std::string text = gap_text(w.spec, mpm, gap, surface);
    if (!w.spec.allow_glued) throw InputError(text);
    w.spec.warnings.push_back(text.substr(0, text.find(". Let ")));
  }
}

void refuse_hanging_bodies(World& w, const MpmDiscretisation& mpm, const std::vector<SurfacePoint>& surface) {
  const Case& c = w.spec;
  const std::vector<std::vector<double>> share = shares_of_nodes(w);
  const double reach = (0.1 + 0.5 * (mpm.degree() - 1)) * mpm.cell_size();  // splines have nodes between the lines
  const StructuredGrid* grid = mpm.grid().structure.get();
  const Mat3 own = grid ? Mat3(Eigen::AngleAxisd(-grid->angle, Vec3::UnitZ()).toRotationMatrix()) : Mat3(Mat3::Identity());
  std::vector<std::vector<char>> held(c.boundaries.size());
  for (auto& nodes : held) nodes.assign(mpm.n_nodes(), 0);
  for (const auto& hold : w.boundary->holds(mpm))
    if (hold.node >= 0 && hold.boundary >= 0) held[hold.boundary][hold.node] = 1;
  const std::vector<Vec3> points = mpm.point_positions();
  const std::map<int, Region> regions = regions_of_shapes(c, mpm.cell_size());
  for (std::size_t b = 0; b < c.boundaries.size(); ++b) {
    mpm.halo.copy_to_ghosts(held[b].data(), 1);
    warn_of_left_nodes(w, mpm, static_cast<int>(b), own, regions);
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
      w.spec.warnings.push_back(text);
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

void refuse_free_bodies(const World& w) {
  const Case& c = w.spec;
  refuse_jumps(w);
  const std::vector<std::vector<double>> share = shares_of_nodes(w);
  if (const auto* mpm = dynamic_cast<const MpmDiscretisation*>(w.discretisation.get())) refuse_few_points(w, *mpm, share);
  if (c.stages.front().steps.analysis != Analysis::quasi_static) return;
  Groups groups = find_assemblies(w, share);
  for (const auto& [root, assembly] : hold_assemblies(w, share, groups)) {
    const std::string motion = free_motion(c, assembly);
    if (motion.empty()) continue;
    std::vector<std::string> names;
    for (std::size_t b = 0; b < c.bodies.size(); ++b)
      if (!c.bodies[b].rigid && groups.of(static_cast<int>(b)) == root) names.push_back("\"" + c.bodies[b].name + "\"");
    throw InputError(fmt::format("{} {} can {}: nothing holds {} there. A quasi-static stage needs a support ([boundary.NAME], [pin.NAME]), a "
                                 "[contact.NAME] with something that is held, or analysis = \"dynamic\"",
                                 names.size() == 1 ? "body" : "bodies", fmt::join(names, ", "), motion, names.size() == 1 ? "it" : "them"));
  }
}

}  // namespace berm
