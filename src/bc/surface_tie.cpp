#include "bc/surface_tie.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <unordered_map>

#include "base/error.hpp"
#include "bc/boundary.hpp"
#include "bc/case_lookup.hpp"
#include "bc/piece_bins.hpp"
#include "bc/travel.hpp"

namespace berm {
namespace {

using Pair = std::pair<int, int>;  // of bodies, ascending

/// Of the size of a cell: pieces of surfaces touch that are no farther apart. Chords of a curved mesh may be: eight of them
/// to a circle are a tenth of their length away from it.
constexpr double touching_distance = 0.1;

/// Whether the middle of the first piece lies on the second: they face each other, and it is not beside the other's end.
bool touch(const SurfacePoint& first, const SurfacePoint& second, double size) {
  constexpr double beside = 0.04, facing = -0.5;
  if (first.normal.dot(second.normal) > facing) return false;
  const Vec3 off = first.X - closest_on_piece(first.X, second);
  const double apart = off.dot(second.normal);
  return std::abs(apart) <= touching_distance * size && (off - apart * second.normal).norm() <= beside * size;
}

/// What touches at a vertex is no gap [cells].
constexpr double in_a_corner = 1e-3;

/// Whether an end of a piece lies on another.
bool meet_in_a_corner(const SurfacePoint& s, const SurfacePoint& other, double size) {
  bool found = false;
  look_at_piece(s, [&](const Vec3& x) { found |= (x - closest_on_piece(x, other)).norm() <= in_a_corner * size; });
  return found;
}

/// Regions of bodies that have a shape in the plane, where there is no doubt whether the shapes themselves touch.
class Shapes {
public:
  Shapes(const Case& c, double size) : case_(c), size_(size) {}
  /// Of the shapes near a place on the surface of a body; zero where there are none.
  double apart(const Vec3& x, int body, int other) {
    const Region *own = region(body), *theirs = region(other);
    return own && theirs ? std::abs(theirs->nearest(own->nearest(x).point).distance) : 0.0;
  }
  /// At the middle or an end of a piece, whatever is least.
  double least_apart(const SurfacePoint& s, int other) {
    double least = infinity;
    look_at_piece(s, [&](const Vec3& x) { least = std::min(least, apart(x, s.body, other)); });
    return least;
  }

private:
  const Region* region(int body) {
    if (case_.dimension() == 3 || !case_.bodies[body].shape) return nullptr;
    return &regions_.try_emplace(body, *case_.bodies[body].shape, size_).first->second;
  }
  const Case& case_;
  double size_;
  std::map<int, Region> regions_;
};

/// By pair of bodies, the pieces of the first one's surface that touch the second; and, in `found`, how far apart the bodies are
/// where they only nearly do, and which touch in a corner and nowhere else.
std::map<Pair, std::vector<SurfacePoint>> touching_pieces(const Case& c, const std::vector<SurfacePoint>& surface,
                                                          double size, Neighbours& found) {
  constexpr double closed = 1e-3;
  std::map<Pair, std::vector<SurfacePoint>> pieces;
  Shapes shapes(c, size);
  const PieceBins bins(surface, size);
  std::set<Pair> corners;
  for (const SurfacePoint& s : surface) {
    std::set<int> touched;
    bins.for_near(s.X, [&](int k) {
      const SurfacePoint& other = surface[k];
      if (other.body <= s.body || touched.count(other.body)) return;
      if (!touch(s, other, size)) {
        if (meet_in_a_corner(s, other, size)) corners.insert({s.body, other.body});
        return;
      }
      if (shapes.apart(s.X, s.body, other.body) <= closed * size) {
        touched.insert(other.body);
      } else {
        double& least = found.nearly.try_emplace({s.body, other.body}, infinity).first->second;
        least = std::min(least, shapes.least_apart(s, other.body));
      }
    });
    for (const int body : touched) pieces[{s.body, body}].push_back(s);
  }
  for (const Pair& pair : corners)
    if (!pieces.count(pair) && found.nearly.try_emplace(pair, 0.0).second) found.in_a_corner.insert(pair);
  return pieces;
}

/// What flows through the grid mixes and folds: shared nodes see that wherever it happens, a tie only where the bodies
/// touched at the start.
bool flows(const Case& c, int body) {
  const AnyLaw& law = material_of(c, body)->law;
  return moves_through_grid(c) &&
         (is_plastic(law) || std::holds_alternative<Newtonian>(law));
}

bool needs_tie(const Case& c, const Joint& joint, const std::function<bool(const SurfacePoint&)>& in_one_cell) {
  if (joint.contact >= 0) return true;
  return c.bodies[joint.body].material != c.bodies[joint.other].material && !flows(c, joint.body) &&
         !flows(c, joint.other) && std::any_of(joint.pieces.begin(), joint.pieces.end(), in_one_cell);
}

/// Bodies on two sides of a third one that is tied to both and thinner there than what the grid tells apart: in one layer it would
/// join them. Soil that flows keeps the nodes that it shares with other soil.
std::set<Pair> parted_by_a_thin_body(const Case& c, const std::vector<Joint>& joints, const std::set<Pair>& tied, double thin) {
  constexpr double opposite = -0.5;
  struct Side {
    std::vector<SurfacePoint> pieces;  // of the surface of the body between
    std::vector<int> body;
  };
  std::map<int, Side> sides;  // by the body between
  std::set<Pair> joined, parted;
  for (const Joint& j : joints) {
    joined.insert(std::minmax(j.body, j.other));
    if (!tied.count(std::minmax(j.body, j.other))) continue;
    for (const auto& [middle, other, sign] : {std::tuple(j.body, j.other, 1.0), std::tuple(j.other, j.body, -1.0)})
      for (SurfacePoint s : j.pieces) {
        s.normal *= sign;
        sides[middle].pieces.push_back(s), sides[middle].body.push_back(other);
      }
  }
  for (const auto& [middle, side] : sides) {
    const PieceBins bins(side.pieces, thin);
    for (std::size_t i = 0; i < side.pieces.size(); ++i)
      bins.for_near(side.pieces[i].X, [&](int k) {
        const SurfacePoint &s = side.pieces[i], &t = side.pieces[k];
        const int a = side.body[i], b = side.body[k];
        if (a >= b || s.normal.dot(t.normal) > opposite || flows(c, a) || flows(c, b) || joined.count({a, b})) return;
        const Vec3 way = t.X - s.X;
        const double through = -way.dot(s.normal);
        if (through > 0.0 && through < thin && (way + through * s.normal).norm() <= s.size + t.size) parted.insert({a, b});
      });
  }
  return parted;
}

/// Of the penalty of a joint that no contact speaks of, in units of E / h.
constexpr double tie_penalty = 500.0;
/// Share of the penalty that differences of the gap within a pair of cells see: functions of cut cells cannot follow each
/// other at every point of a surface, and would take the stresses out of each other.   [contact (10)]
constexpr double loose_share = 0.02;

}  // namespace

double Joint::area() const {
  double sum = 0.0;
  for (const SurfacePoint& s : pieces) sum += s.area;
  return sum;
}

Neighbours find_neighbours(const Case& c, const std::vector<SurfacePoint>& surface, double size) {
  Neighbours found;
  const auto pieces = touching_pieces(c, surface, size, found);
  std::vector<Joint>& joints = found.joints;
  std::set<Pair> spoken_of;
  for (std::size_t k = 0; k < c.contacts.size(); ++k) {
    const Contact& contact = c.contacts[k];
    if (contact.other.empty()) continue;
    const Pair pair = bodies_of(c, contact);
    spoken_of.insert(pair);
    if (contact.kind != Contact::Kind::tie) {
      if (!pieces.count(pair) && !found.nearly.count(pair)) found.apart.insert(pair);
      continue;
    }
    const auto list = pieces.find(pair);
    if (list == pieces.end())
      throw InputError(fmt::format("[contact.{}]: the surfaces of \"{}\" and \"{}\" do not touch, so nothing can be tied: "
                                   "they count as touching up to {:.3g} m apart",
                                   contact.name, contact.body, contact.other, touching_distance * size));
    joints.push_back({pair.first, pair.second, static_cast<int>(k), false, list->second});
  }
  for (const auto& [pair, list] : pieces) {
    found.touching.insert(pair);
    if (!spoken_of.count(pair)) joints.push_back({pair.first, pair.second, -1, false, list});
  }
  for (const auto& [pair, apart] : found.nearly)
    if (apart <= still_touching * size) found.touching.insert(pair);
  std::erase_if(found.in_a_corner, [&](const Pair& pair) { return spoken_of.count(pair) > 0; });
  std::erase_if(found.nearly, [&](const auto& entry) {
    return entry.second <= in_a_corner * size || pieces.count(entry.first) || spoken_of.count(entry.first);
  });
  return found;
}

std::vector<int> layers_of_bodies(const Case& c, Neighbours& neighbours, double thin,
                                  const std::function<bool(const SurfacePoint&)>& in_one_cell) {
  std::vector<Joint>& joints = neighbours.joints;
  std::vector<int> layer = fields_of_bodies(c);
  const int n_fixed = layer.empty() ? 0 : *std::max_element(layer.begin(), layer.end());
  std::set<Pair> apart;
  for (const Joint& j : joints)
    if (needs_tie(c, j, in_one_cell)) apart.insert(std::minmax(j.body, j.other));
  neighbours.parted = parted_by_a_thin_body(c, joints, apart, thin);
  apart.insert(neighbours.parted.begin(), neighbours.parted.end());
  // Each body takes the first layer in which nothing is that it must be tied to.
  const std::vector<int> given = layer;
  for (int body = 0; body < static_cast<int>(layer.size()); ++body) {
    if (given[body] != 0) continue;
    const auto taken = [&](int wanted) {
      for (int other = 0; other < body; ++other)
        if (layer[other] == wanted && apart.count({other, body})) return true;
      return false;
    };
    for (int next = n_fixed + 1; taken(layer[body]); ++next) layer[body] = next;
  }
  for (Joint& j : joints) j.shared_nodes = layer[j.body] == layer[j.other];
  return layer;
}

SurfaceTies::SurfaceTies(const Case& c, const std::vector<Joint>& joints, double size, const Comm& comm)
    : comm_(comm), dimension_(c.dimension()) {
  for (const Joint& joint : joints) {
    if (joint.shared_nodes) continue;
    const double factor = joint.contact < 0 ? tie_penalty : c.contacts[joint.contact].stiffness;
    const double youngs = std::min(stiffness_of(c, joint.body), stiffness_of(c, joint.other));
    for (const SurfacePoint& s : joint.pieces) {
      TiePoint p;
      p.ends.a = anchor_at(joint.body, s.X, s.normal);
      p.ends.b = anchor_at(joint.other, s.X, -s.normal);
      p.id = static_cast<int>(points_.size());
      p.joint = static_cast<int>(stages_.size());
      p.stiffness = factor * youngs / size * s.area;
      points_.push_back(p);
    }
    contact_.push_back(joint.contact);
    stages_.push_back(joint.contact < 0 ? Stages{} : c.contacts[joint.contact].stages);
  }
  acts_.assign(stages_.size(), 1);
}

void SurfaceTies::begin_stage(const std::function<bool(const Stages&)>& acts) {
  for (std::size_t k = 0; k < stages_.size(); ++k) acts_[k] = acts(stages_[k]);
}

void SurfaceTies::move(const Discretisation& d) {
  travel(points_, d);
  std::set<std::tuple<int, int, int>> seen;  // process, body, cell
  std::vector<std::vector<Anchor>> to(comm_.size());
  pairs_.clear();
  comm_.agree([&] {
    for (TiePoint& p : points_) {
      pairs_.push_back(&p.ends);
      for (Anchor* end : {&p.ends.a, &p.ends.b}) {
        const int rank = d.locate(*end);
        if (!seen.insert({rank, end->body, end->cell}).second) continue;
        to[rank].push_back(*end);
      }
    }
  });
  keepers_.clear();
  for (const auto& from : comm_.exchange(to)) keepers_.insert(keepers_.end(), from.begin(), from.end());
}

/// Displacement of b less that of a at t_{n+1}.
Vec3 SurfaceTies::gap(const TiePoint& p, const NodalVector& du) const {
  return p.gap + p.ends.b.stencil->interpolate(du) - p.ends.a.stencil->interpolate(du);
}

namespace {

/// The functions of both ends, those of a with the sign of its displacement in the gap.
void gap_functions(const TiePoint& p, std::vector<double>& w) {
  w.clear();
  for (const auto& [end, sign] : {std::pair(&p.ends.a, -1.0), std::pair(&p.ends.b, 1.0)})
    for (int k = 0; k < end->stencil->n; ++k) w.push_back(sign * end->stencil->N[k]);
}

/// Calls work(k, node) for the nodes of both ends.
template <class Work>
void for_nodes(const TiePoint& p, Work work) {
  std::size_t k = 0;
  for (const Anchor* end : {&p.ends.a, &p.ends.b})
    for (int i = 0; i < end->stencil->n; ++i) work(k++, end->stencil->node[i]);
}

/// Of the points in one cell whose ends have the same functions: all are on one process, wherever its limits run.
struct MeanGap {
  const TiePoint* first = nullptr;
  double stiffness = 0.0;
  Vec3 pull = Vec3::Zero();       ///< stiffness times gap
  std::vector<double> functions;  ///< times stiffness
};

void add_block(double stiffness, const std::vector<double>& w, int block, int d, std::vector<double>& K,
               BlockAssembler& matrix) {
  const std::size_t n = w.size(), width = d * n;
  K.assign(width * width, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (int q = 0; q < d; ++q) K[(d * i + q) * width + d * j + q] = stiffness * w[i] * w[j];
  matrix.add(block, K.data());
}

}  // namespace

void SurfaceTies::add_forces(const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const {
  std::map<std::pair<int, int>, MeanGap> means;  // by cell of the first end and block
  std::vector<double> w, K;
  for (const TiePoint& p : points_) {
    if (!acts_[p.joint]) continue;
    const Vec3 jump = gap(p, du);
    gap_functions(p, w);
    const double loose = loose_share * p.stiffness, rest = p.stiffness - loose;
    for_nodes(p, [&](std::size_t k, int node) { f[node] += loose * w[k] * jump; });
    if (matrix) add_block(loose, w, p.ends.block, dimension_, K, *matrix);
    MeanGap& mean = means[{p.ends.a.cell, p.ends.block}];
    if (!mean.first) {
      mean.first = &p;
      mean.functions.assign(w.size(), 0.0);
    }
    mean.stiffness += rest;
    mean.pull += rest * jump;
    for (std::size_t k = 0; k < w.size(); ++k) mean.functions[k] += rest * w[k];
  }
  for (const auto& [place, mean] : means) {
    for_nodes(*mean.first, [&, &m = mean](std::size_t k, int node) { f[node] += m.functions[k] / m.stiffness * m.pull; });
    if (matrix) add_block(1.0 / mean.stiffness, mean.functions, place.second, dimension_, K, *matrix);
  }
}

void SurfaceTies::commit(const NodalVector& du) {
  for (TiePoint& p : points_) p.gap = acts_[p.joint] ? gap(p, du) : Vec3(Vec3::Zero());
}

}  // namespace berm
