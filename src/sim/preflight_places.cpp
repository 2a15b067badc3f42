/// Bodies in one place, and gaps that the grid does not see.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <map>
#include <unordered_map>

#include "base/error.hpp"
#include "bc/case_lookup.hpp"
#include "bc/piece_bins.hpp"
#include "sim/advice.hpp"
#include "sim/preflight.hpp"
#include "sim/preflight_parts.hpp"

namespace berm {
namespace {

/// What of a body lies inside of a region.
struct Inside {
  double depth = 0.0;    ///< of the deepest place [m]
  double measure = 0.0;  ///< of the points [m2] or [m3]
  Vec3 at = Vec3::Zero();
};

/// Points and pieces of the surface of a body.
struct PlacesOfBody {
  std::vector<std::pair<Vec3, double>> all;  ///< place, measure
  Eigen::AlignedBox3d box;
};

std::vector<PlacesOfBody> places_of_bodies(const BuiltBodies& built) {
  std::vector<PlacesOfBody> bodies(built.places.size());
  const auto add = [&](std::size_t body, const Vec3& x, double measure) {
    bodies[body].all.emplace_back(x, measure);
    bodies[body].box.extend(x);
  };
  for (std::size_t b = 0; b < bodies.size(); ++b)
    for (std::size_t p = 0; p < built.places[b].size(); ++p) add(b, built.places[b][p], built.measures[b][p]);
  for (const SurfacePoint& s : built.surface) add(s.body, s.X, 0.0);
  return bodies;
}

Inside part_inside(const Region& region, const PlacesOfBody& body) {
  Inside in;
  const int d = region.dimension();
  Eigen::AlignedBox3d reach(region.min(), region.max());
  if (d == 2) reach.min().z() = -infinity, reach.max().z() = infinity;
  if (!reach.intersects(body.box)) return in;
  for (const auto& [x, measure] : body.all) {
    if (!reach.contains(x)) continue;
    const double depth = -region.nearest(x).distance;
    if (depth <= 0.0) continue;
    in.measure += measure;
    if (depth > in.depth) in.depth = depth, in.at = x;
  }
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
  constexpr double facing = 0.8, closed = 1e-6, opposite = -0.27;
  if (s.normal.dot(t.normal) > opposite) return false;  // both angles imply it, and places on triangles take long
  const Vec3 way = closest_on_piece(s.X, t) - s.X;  // a gap may be much narrower than pieces are long
  const double length = way.norm();
  return length > closed * size && way.dot(s.normal) > facing * length && -way.dot(t.normal) > facing * length;
}

/// A piece at which another body that it touches begins has no gap before it.
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

std::vector<Glue> find_glue(const World& w, const MpmDiscretisation& mpm, const std::vector<SurfacePoint>& surface, Groups& groups) {
  const std::vector<int>& layers = w.layers;
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
      for (const int other : pieces) covered[k] |= layers[surface[k].body] == layers[surface[other].body] && is_covered_by(surface[k], surface[other], h) &&
                      are_joined(w, surface[k].body, surface[other].body);
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
  const std::string where = s.body == t.body ? fmt::format("in body \"{}\"", a) : fmt::format("between bodies \"{}\" and \"{}\"", a, b);
  return fmt::format("the gap of {:.4g} m {} near {} is too narrow for cells of {}: common nodes join its sides over {:.4g} m", gap.width, where,
                     place_text(c, 0.5 * (s.X + t.X)), cells_text(mpm), (gap.high - gap.low).norm());
}

std::string remedy_for(const MpmDiscretisation& mpm, const Gap& gap, bool in_one_body) {
  const char* close = gap.width < 0.1 * mpm.cell_size() ? "Close it, let" : "Let";
  return fmt::format("{} {} whole cell{} lie in it, make the cells smaller than {:.4g} m{}, or allow it by [model] allow_glued = true", close, mpm.degree(),
                     mpm.degree() == 1 ? "" : "s", gap.width / (mpm.degree() + 1), in_one_body ? "" : ", give the two a [contact.NAME]");
}

}  // namespace

void refuse_overlaps(const Case& c, const BuiltBodies& built, double size) {
  // Chords of a mesh lie inside of an arc by less; what is thinner than a part of a cell is a touch.
  constexpr double thin = 0.1, thin_rigid = 0.05;
  if (c.bodies.size() < 2) return;
  const std::map<int, Region> regions = regions_of_shapes(c, size);
  const std::vector<PlacesOfBody> places = places_of_bodies(built);
  const int n = static_cast<int>(c.bodies.size()), d = c.dimension();
  for (int a = 0; a < n; ++a)
    for (const auto& [b, region] : regions) {
      if (a == b || c.bodies[a].rigid) continue;
      const std::string &first = c.bodies[a].name, &second = c.bodies[b].name;
      const Contact* contact = c.bodies[b].rigid ? unilateral_contact(c, first, second) : nullptr;
      if (c.bodies[b].rigid && !contact) continue;
      Inside in = part_inside(region, places[a]);
      // Chords of a mesh across a hole lie outside of the body's own shape.
      if (const auto own = regions.find(a); own != regions.end() && in.depth > 0.0) in.depth -= std::max(0.0, own->second.nearest(in.at).distance);
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
  const std::vector<Glue> glue = find_glue(w, mpm, surface, groups);
  std::map<int, Gap> gaps;
  for (const Glue& g : glue) {
    Gap& gap = gaps[groups.of(g.piece)];
    for (const int k : {g.piece, g.other}) gap.low = gap.low.cwiseMin(surface[k].X), gap.high = gap.high.cwiseMax(surface[k].X);
    if (g.width < gap.width) gap.width = g.width, gap.piece = g.piece, gap.other = g.other;
  }
  for (const auto& [root, gap] : gaps) {
    const int first = surface[gap.piece].body, second = surface[gap.other].body;
    if (are_joined(w, first, second) && (gap.high - gap.low).norm() <= tip) continue;
    const std::string text = gap_text(w.spec, mpm, gap, surface);
    if (!w.spec.allow_glued) throw InputError(text + ". " + remedy_for(mpm, gap, first == second));
    w.warnings.push_back(text);
  }
}

void warn_of_strangers(World& w) {
  const Case& c = w.spec;
  const int n = static_cast<int>(c.bodies.size());
  Groups known(c.bodies.size());  // by joints, contacts, and places in which they touch, which are told
  for (const Joint& j : w.neighbours.joints) known.join(j.body, j.other);
  for (const Contact& k : c.contacts)
    if (!k.other.empty()) known.join(body_index(c, k.body), body_index(c, k.other));
  for (const auto& [a, b] : w.neighbours.in_a_corner) known.join(a, b);
  for (const auto& [pair, gap] : w.neighbours.nearly) known.join(pair.first, pair.second);
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b) {
      if (c.bodies[a].rigid || c.bodies[b].rigid || known.of(a) == known.of(b)) continue;
      known.join(a, b);
      const bool moves = c.method == Method::mpm && moves_through_grid(c);
      w.warnings.push_back(fmt::format("nothing is said of bodies \"{0}\" and \"{1}\": should they come near each other, {2}. If they may, give them a [contact.NAME] with "
                                       "body = \"{0}\" and other = \"{1}\"{3}",
                                       c.bodies[a].name, c.bodies[b].name,
                                       moves && w.layers[a] == w.layers[b] ? "the grid would join them from a cell or two apart" : "they would pass through each other",
                                       moves ? "" : ", which needs method = \"mpm\", kinematics = \"finite\" and formulation = \"updated_lagrangian\""));
    }
}

void warn_of_loaded_joints(World& w, const std::vector<SurfacePoint>& surface) {
  constexpr double some = 0.01, opposite = -0.7;
  const Case& c = w.spec;
  const double touching = 0.1 * w.discretisation->cell_size();
  for (const Joint& j : w.neighbours.joints) {
    const PieceBins bins(j.pieces, touching);  // of the surface of its first body
    const auto is_joined = [&](const SurfacePoint& s) {
      bool found = false;
      bins.for_near(s.X, [&](int k) {
        const SurfacePoint& t = j.pieces[k];
        found |= s.body == j.body ? t.X == s.X : t.normal.dot(s.normal) < opposite && (closest_on_piece(s.X, t) - s.X).norm() <= touching;
      });
      return found;
    };
    for (const Pressure& p : c.pressures) {
      const int body = body_index(c, p.body);
      if ((j.body != body && j.other != body) || (j.contact >= 0 && !share_a_stage(p.stages, c.contacts[j.contact].stages))) continue;
      double area = 0.0, joined = 0.0;
      for (const auto& [s, share] : without_strips(caught_surface("pressure." + p.name, p.where, body, p.body, surface, c.dimension())))
        area += share * s.area, joined += is_joined(s) ? share * s.area : 0.0;
      if (joined <= some * area) continue;
      w.warnings.push_back(fmt::format("[pressure.{}]: {:.3g} of its {:.3g} m2 are where body \"{}\" is joined to \"{}\": it presses on the first alone, and what joins them "
                                       "takes it. Let where catch the free surface only{}",
                                       p.name, joined, area, p.body, c.bodies[j.body == body ? j.other : j.body].name, j.contact < 0 ? ", or part the two by a [contact.NAME]" : ""));
    }
  }
}

void warn_of_corners(World& w) {
  Groups joined(w.spec.bodies.size());
  for (const Joint& j : w.neighbours.joints) joined.join(j.body, j.other);
  for (const auto& [a, b] : w.neighbours.in_a_corner)
    if (w.layers[a] == w.layers[b] && joined.of(a) != joined.of(b))
      w.warnings.push_back(fmt::format("bodies \"{0}\" and \"{1}\" touch at a corner or an edge only, and the grid joins them there as if over a cell: let them share a "
                                       "face, or part them by a [contact.NAME] with body = \"{0}\" and other = \"{1}\"",
                                       w.spec.bodies[a].name, w.spec.bodies[b].name));
}

}  // namespace berm
