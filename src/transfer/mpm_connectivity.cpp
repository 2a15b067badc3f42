/// What a step fixes before it moves anything: which cells hold material, what points see of the grid, faces to stabilise,
/// numbers of nodes, blocks.

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <cmath>

#include "base/error.hpp"
#include "base/sort_unique.hpp"
#include "mesh/cell_map.hpp"
#include "method/depth.hpp"
#include "shape/quadrature.hpp"
#include "transfer/mpm.hpp"

namespace berm {

void MpmDiscretisation::begin_step(const std::vector<Anchor*>& anchors) {
  if (shapes_.domain == ShapeChoice::Domain::none) {
    sort_points(anchors);
    evaluate_shapes();
    weigh_cells();
  } else {
    look_at_domains(anchors);
  }
  push_.resize(x_.size(), Mat3::Identity());
  remote_.clear();
  if (comm_.size() > 1 && (ghost_penalty_ > 0.0 || at_gauss_points_)) ask_neighbours();
  if (ghost_penalty_ > 0.0) find_spare_cells();
  if (at_gauss_points_) look_at_gauss_points();
  build_faces();
  number_nodes();
  if (f_bar_) group_points();
  if (mixed_) look_up_elasticity();
  attach(anchors);
  attach_pairs();
}

/// How many faces away from an anchor's cell one that carries it is looked for.
constexpr int carrier_reach = 3;

/// Of two cells that offer to carry {cell, distance; -1: none} the nearer one; as near but for rounding: the first of the grid,
/// whatever the order in which they are met, so that any number of processes takes the same.
using Offer = std::pair<int, double>;
bool is_better(const Offer& offer, const Offer& best) {
  constexpr double rounding = 1e-9;
  if (offer.first < 0) return false;
  if (best.first < 0) return true;
  const double apart = offer.second - best.second;
  const double same = rounding * std::max(offer.second, best.second);
  return std::abs(apart) <= same ? offer.first < best.first : apart < 0.0;
}

/// The cell with material that is nearest to a place in one without, and how far its centre is (0: the cell itself has some);
/// {-1, 0}: none is near.
std::pair<int, double> MpmDiscretisation::nearest_filled(int layered, const Vec3& place,
                                                         const std::function<bool(int layered)>& is_filled) const {
  if (is_filled(layered)) return {layered, 0.0};
  std::vector<int> around = {layered};
  Offer best = {-1, 0.0};
  for (std::size_t begin = 0, ring = 0; ring <= carrier_reach; ++ring) {
    const std::size_t end = around.size();
    for (std::size_t k = begin; k < end; ++k) {
      const double distance = (cell_centre(grid_.mesh, grid_cell(around[k])) - place).norm();
      if (is_filled(around[k]) && is_better({around[k], distance}, best)) best = {around[k], distance};
      for (int f = 0; f < max_faces; ++f)
        if (const int other = neighbour(around[k], f);
            other >= 0 && std::find(around.begin(), around.end(), other) == around.end())
          around.push_back(other);
    }
    begin = end;
  }
  return best;
}

/// A surface and the material behind it cross the lines of the grid at different times. Where no material is in the cell
/// of an anchor, the functions of the nearest cell that has some go on beyond its edge (they are polynomials): what the
/// anchor feels and does belongs to nodes that carry. So do the ends of pairs: stabilisation alone would hold an empty cell, anew
/// in every step, and what is tied there would creep. On several processes the nearest of all.   [formulation, section 6]
void MpmDiscretisation::find_carriers(const std::vector<Anchor*>& anchors,
                                      const std::function<bool(int layered)>& is_filled) {
  carrier_.clear();
  std::vector<double> mine;  // layered cell and place of each that looks for one
  std::vector<std::size_t> who;
  const auto look = [&](const Anchor& a) {
    carrier_.push_back(layered_cell(a.cell, a.body));
    if (a.rigid || is_filled(carrier_.back())) return;
    const Vec3 x = seen(a);
    mine.insert(mine.end(), {double(carrier_.back()), x.x(), x.y(), x.z()});
    who.push_back(carrier_.size() - 1);
  };
  for (const Anchor* a : anchors) look(*a);
  for (const AnchorPair* pair : pairs_) look(pair->a), look(pair->b);
  if (comm_.any(!mine.empty())) find_carriers_of(who, mine, is_filled);
  cells_of_pairs_.clear();
  for (std::size_t end = anchors.size(); end < carrier_.size(); end += 2) cells_of_pairs_.emplace_back(carrier_[end], carrier_[end + 1]);
  carrier_.resize(anchors.size());
}

/// `who`: of carrier_; `mine`: layered cell and place of each. Collective.
void MpmDiscretisation::find_carriers_of(const std::vector<std::size_t>& who, const std::vector<double>& mine,
                                         const std::function<bool(int layered)>& is_filled) {
  const std::size_t before = 2 * comm_.exclusive_sum(static_cast<long>(who.size()));
  const std::vector<double> wanted = comm_.all_gather(mine);
  std::vector<double> offers;  // cell and distance
  for (std::size_t k = 0; k < wanted.size(); k += 4) {
    const Vec3 x(wanted[k + 1], wanted[k + 2], wanted[k + 3]);
    const auto [cell, distance] = nearest_filled(static_cast<int>(wanted[k]), x, is_filled);
    offers.insert(offers.end(), {double(cell), distance});
  }
  const std::vector<double> all = comm_.all_gather(offers);  // those of one process after those of another
  for (std::size_t k = 0; k < who.size(); ++k) {
    Offer best = {-1, 0.0};
    for (std::size_t at = before + 2 * k; at < all.size(); at += offers.size())
      if (const Offer offer = {static_cast<int>(all[at]), all[at + 1]}; is_better(offer, best)) best = offer;
    if (best.first >= 0) carrier_[who[k]] = best.first;
  }
}

/// Counting sort of the points by cell; cells that carry anchors are active too.
void MpmDiscretisation::sort_points(const std::vector<Anchor*>& anchors) {
  for (int c : active_cells_) active_index_[c] = -1;
  active_cells_.clear();
  const auto activate = [&](int c) {
    if (active_index_[c] >= 0) return;
    active_index_[c] = 0;
    active_cells_.push_back(c);
  };
  layered_.resize(x_.size());
  for (const Slice& slice : material.slices)
    for (int p = slice.begin; p < slice.end; ++p) layered_[p] = layered_cell(cell_[p], slice.body);
  for (int c : layered_) activate(c);
  find_carriers(anchors, [this](int c) { return active_index_[c] >= 0; });
  anchor_cells_.clear();
  for (const int c : carrier_) {
    if (comm_.size() == 1 || owner_of_cell(grid_cell(c)) == comm_.rank())
      activate(c);
    else
      anchor_cells_.push_back(c);
  }
  sort_unique(anchor_cells_);
  std::sort(active_cells_.begin(), active_cells_.end());
  for (std::size_t k = 0; k < active_cells_.size(); ++k) active_index_[active_cells_[k]] = static_cast<int>(k);

  first_.assign(active_cells_.size() + 1, 0);
  for (int c : layered_) ++first_[active_index_[c] + 1];
  for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
  order_.resize(x_.size());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (std::size_t p = 0; p < x_.size(); ++p) order_[next[active_index_[layered_[p]]]++] = static_cast<int>(p);

  patch_nodes_ = {};
  std::vector<int> list;
  for (int c : active_cells_) {
    list.clear();
    for (int node : basis_.nodes_of(grid_cell(c))) list.push_back(node + field_of(c) * basis_.n_nodes());
    patch_nodes_.add(list);
  }
  cells_.assign(active_cells_.size(), {});
  for (std::size_t i = 0; i < anchors.size(); ++i)
    if (anchors[i]->rigid) cells_[active_index_[carrier_[i]]].holds_rigid = 1;
}

void MpmDiscretisation::evaluate_shapes() {
  shape_.resize(x_.size() * stride_);
  comm_.agree([&] {
    BasisAt shape;
    for (std::size_t a = 0; a < active_cells_.size(); ++a)
      for (int p : points_in(static_cast<int>(a))) {
        if (!basis_.evaluate(grid_cell(active_cells_[a]), seen(p), shape))
          throw RunError(fmt::format("cell {} of the background grid is too distorted", grid_cell(active_cells_[a])));
        store_shape(p, shape.n, shape);
      }
  });
}

/// Values, then gradients, of the n nodes of the point's patch: those beyond `shape` see nothing of it.
void MpmDiscretisation::store_shape(int p, int n, const BasisAt& shape) {
  const int d = dimension();
  double* s = shape_.data() + std::size_t(p) * stride_;
  std::fill_n(s, n * (1 + d), 0.0);
  std::copy_n(shape.N.begin(), shape.n, s);
  for (int k = 0; k < shape.n; ++k) std::copy_n(shape.grad[k].data(), d, s + n + d * k);
}

/// Fill and stiffness of the active cells from the points in them.
void MpmDiscretisation::weigh_cells() {
  int slice = 0;
  for (std::size_t p = 0; p < x_.size(); ++p) {
    while (static_cast<int>(p) >= material.slices[slice].end) ++slice;
    CellState& cell = cells_[active_index_[layered_[p]]];
    cell.fill += measure_[p];
    cell.stiffness += measure_[p] * youngs_of_slice_[slice] * (1.0 - material.damage[p]);
  }
  average_cells();
}

/// From the measure in the cells, and Young's moduli times it.
void MpmDiscretisation::average_cells() {
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    CellState& cell = cells_[a];
    if (cell.fill > 0.0) cell.stiffness /= cell.fill;
    cell.fill /= cell_measure(grid_.mesh, grid_cell(active_cells_[a]));
  }
}

std::vector<std::vector<int>> MpmDiscretisation::points_by_cell() const {
  std::vector<std::vector<int>> out(active_cells_.size());
  for (std::size_t p = 0; p < layered_.size(); ++p)
    if (const int a = active_index_[layered_[p]]; a >= 0) out[a].push_back(static_cast<int>(p));
  return out;
}

/// Tells the owners of neighbouring cells about the active cells at the border.
void MpmDiscretisation::ask_neighbours() {
  std::vector<std::vector<double>> to(comm_.size());
  std::vector<int> told(comm_.size(), -1);
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    const int cell = active_cells_[a];
    for (int f = 0; f < max_faces; ++f) {
      const int other = neighbour(cell, f);
      if (other < 0 || active_index_[other] >= 0) continue;
      const int rank = owner_of_cell(grid_cell(other));
      if (rank == comm_.rank() || told[rank] == cell) continue;
      told[rank] = cell;
      const CellState& s = cells_[a];
      to[rank].insert(to[rank].end(), {double(cell), s.fill, s.stiffness, double(s.holds_rigid), double(s.spare)});
    }
  }
  for (const auto& from : comm_.exchange(to))
    for (std::size_t k = 0; k < from.size(); k += 5)
      remote_[static_cast<int>(from[k])] = {from[k + 1], from[k + 2], static_cast<int>(from[k + 3]), static_cast<int>(from[k + 4])};
}

const MpmDiscretisation::CellState* MpmDiscretisation::cell_state(int cell) const {
  if (active_index_[cell] >= 0) return &cells_[active_index_[cell]];
  const auto found = remote_.find(cell);
  return found == remote_.end() ? nullptr : &found->second;
}

namespace {

constexpr double held = 0.4;  ///< filled more than this: a cell holds its nodes

/// Whether a cell holds the nodes that it has in common with another one that is filled less.
bool outweighs(double fill, double other) {
  constexpr double many_times = 10.0;
  return fill >= held || fill >= many_times * other;
}

}  // namespace

/// As the cell of a slot into which one side has moved a little: stabilisation would join that to the other side.   [formulation, section 6]
void MpmDiscretisation::find_spare_cells() {
  if (basis_.degree() > 1) return;  // of splines, whose nodes are those of many cells
  const Mesh& mesh = grid_.mesh;
  const auto corners = [&](int cell) { return std::span<const int>(mesh.cell(cell), corners_of(mesh.kinds[cell])); };
  std::vector<int> beside;  // nodes of cells that hold them
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    cells_[a].spare = 0;
    if (cells_[a].fill >= held) continue;
    const int cell = active_cells_[a];
    beside.clear();
    for (int f = 0; f < max_faces; ++f)
      if (const int other = neighbour(cell, f); other >= 0)
        if (const CellState* s = cell_state(other); s && outweighs(s->fill, cells_[a].fill))
          for (const int node : corners(grid_cell(other))) beside.push_back(node);
    const std::span<const int> own = corners(grid_cell(cell));
    cells_[a].spare = std::all_of(own.begin(), own.end(), [&](int node) { return std::find(beside.begin(), beside.end(), node) != beside.end(); });
  }
  if (comm_.size() > 1) ask_neighbours();
}

/// Ghost stabilisation (Burman 2010; for MPM: Coombs 2023): faces between active cells of which one is cut. A face
/// belongs to the process of the cell with the lower number.
void MpmDiscretisation::build_faces() {
  faces_.clear();
  if (ghost_penalty_ <= 0.0) return;
  constexpr double whole = 0.9;  // filled more than this: a cell does not need help
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    const int cell = active_cells_[a];
    const CellState& sa = cells_[a];
    for (int f = 0; f < max_faces; ++f) {
      const int other = neighbour(cell, f);
      if (other < cell) continue;
      const CellState* sb = cell_state(other);
      if (!sb || (sa.fill > whole && sb->fill > whole) || sa.holds_rigid || sb->holds_rigid) continue;
      const auto is_held_beside = [](const CellState& s, const CellState& t) { return s.spare && (t.spare || outweighs(t.fill, s.fill)); };
      if (is_held_beside(sa, *sb) || is_held_beside(*sb, sa)) continue;
      // The softer side counts (a broken cell must not be held by its neighbour); empty cells take the other side's
      // value; between two of them, where only surface points are, that of the softest material holds the nodes.
      const double ka = sa.stiffness, kb = sb->stiffness;
      double stiffness = ka > 0.0 && kb > 0.0 ? std::min(ka, kb) : std::max(ka, kb);
      if (stiffness == 0.0) stiffness = *std::min_element(youngs_of_slice_.begin(), youngs_of_slice_.end());
      faces_.push_back(make_face(cell, f, other, ghost_penalty_ * stiffness));
    }
  }
}

/// penalty: gamma E (plane: times thickness) [Pa or N/m].
MpmDiscretisation::Face MpmDiscretisation::make_face(int cell_a, int local, int cell_b, double penalty) const {
  const Mesh& mesh = grid_.mesh;
  const int grid_a = grid_cell(cell_a), grid_b = grid_cell(cell_b);
  const FaceCorners& corner = faces_of(mesh.kinds[grid_a])[local];
  std::array<Vec3, 4> p;
  for (int k = 0; k < corner.n; ++k) p[k] = mesh.nodes[mesh.cell(grid_a)[corner.corner[k]]];

  Face face;
  face.cell_a = cell_a;
  face.cell_b = cell_b;
  const std::vector<std::pair<double, double>> rule = gauss_line(basis_.degree() + 1);
  Vec3 normal;
  double area = 0.0;
  std::vector<std::pair<Vec3, double>> at;  // places and shares of the area
  if (dimension() == 2) {
    const Vec3 along = p[1] - p[0];
    area = along.norm();
    normal = Vec3(along.y(), -along.x(), 0.0) / area;
    for (const auto& [xi, weight] : rule) at.emplace_back(0.5 * (p[0] + p[1]) + 0.5 * xi * along, 0.5 * weight);
  } else if (corner.n == 3) {  // gradients are constant: one point
    const Vec3 twice = (p[1] - p[0]).cross(p[2] - p[0]);
    area = 0.5 * twice.norm();
    normal = twice.normalized();
    at.emplace_back((p[0] + p[1] + p[2]) / 3.0, 1.0);
  } else {
    const Vec3 twice = (p[2] - p[0]).cross(p[3] - p[1]);
    area = 0.5 * twice.norm();
    normal = twice.normalized();
    for (const auto& [xi, wx] : rule)
      for (const auto& [eta, wy] : rule) {
        Vec3 place = Vec3::Zero();
        for (int k = 0; k < 4; ++k)
          place += 0.25 * (1.0 + corner_sign[k][0] * xi) * (1.0 + corner_sign[k][1] * eta) * p[k];
        at.emplace_back(place, 0.25 * wx * wy);
      }
  }
  // Length of the face: the h of (14).
  const double h = dimension() == 2 ? area : std::sqrt(corner.n == 3 ? 2.0 * area : area);
  // Around an axis the face is a ring; the thickness of the plane is in the penalty.
  const double ring = depth(space_, 1.0, 0.5 * (p[0].x() + p[1].x()));
  const double factor = penalty * std::pow(h, 2 * basis_.degree() - 1) * area * ring;

  BasisAt side;
  for (const auto& [place, share] : at) {
    const double root = std::sqrt(factor * share);
    std::vector<double>& jump = face.jump.emplace_back(face.node.size(), 0.0);
    for (const int cell : {grid_a, grid_b}) {
      basis_.highest_derivative(cell, place, normal, side);
      for (int k = 0; k < side.n; ++k) {
        auto found = std::find(face.node.begin(), face.node.end(), side.nodes[k]);
        if (found == face.node.end()) {
          face.node.push_back(side.nodes[k]);
          jump.push_back(0.0);
          found = face.node.end() - 1;
        }
        jump[found - face.node.begin()] += (cell == grid_a ? root : -root) * side.N[k];
      }
    }
  }
  return face;
}

/// Local nodes and blocks, unless cells and faces are the same as in the last step on all processes.
void MpmDiscretisation::number_nodes() {
  std::vector<std::pair<int, int>> faces;
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    faces_[f].block = n_patches() + static_cast<int>(f);
    faces.emplace_back(faces_[f].cell_a, faces_[f].cell_b);
  }
  std::vector<std::pair<int, int>> tied = cells_of_pairs_;
  sort_unique(tied);
  std::vector<int> filled = mixed_ ? filled_cells() : std::vector<int>{};
  first_anchor_block_ = n_patches() + static_cast<int>(faces_.size());
  if (comm_.all(numbered_ && patch_nodes_ == numbered_patches_ && active_cells_ == numbered_cells_ &&
                anchor_cells_ == numbered_anchors_ && filled == numbered_filled_ && faces == numbered_faces_ && tied == numbered_pairs_))
    return;
  numbered_patches_ = patch_nodes_;
  numbered_anchors_ = anchor_cells_;
  numbered_cells_ = active_cells_;
  numbered_filled_ = std::move(filled);
  numbered_faces_ = std::move(faces);
  numbered_pairs_ = std::move(tied);
  numbered_ = true;
  ++connectivity;

  std::vector<char> touched(local_node_.size(), 0);
  const int layer = basis_.n_nodes();
  const auto layered_node = [&](int node, int layered_cell) { return node + field_of(layered_cell) * layer; };
  for (int node : patch_nodes_.nodes) touched[node] = 1;
  for (int c : active_cells_)
    for (int node : basis_.nodes_of(grid_cell(c))) touched[layered_node(node, c)] = 1;
  for (int c : anchor_cells_)
    for (int node : basis_.nodes_of(grid_cell(c))) touched[layered_node(node, c)] = 1;
  for (const Face& f : faces_)
    for (int node : f.node) touched[layered_node(node, f.cell_a)] = 1;
  for (const auto& [a, b] : numbered_pairs_)
    for (const int c : {a, b})
      for (int node : basis_.nodes_of(grid_cell(c))) touched[layered_node(node, c)] = 1;
  for (int a : numbered_filled_)
    for (int node : basis_.nodes_of(grid_cell(active_cells_[a])))
      touched[layered_node(node, active_cells_[a]) + n_fields_ * layer] = 1;  // its pressure
  std::vector<std::int64_t> ids;
  for (std::size_t node = 0; node < touched.size(); ++node)
    if (touched[node]) ids.push_back(static_cast<std::int64_t>(node));
  for (std::int64_t id : halo.ids) local_node_[id] = -1;
  halo = build_halo(comm_, ids, [&](std::int64_t id) { return partition_.owner(basis_.places()[id % layer]); });
  nodes.clear();
  for (int i = 0; i < halo.size(); ++i) {
    local_node_[halo.ids[i]] = i;
    nodes.push_back(basis_.places()[halo.ids[i] % layer]);
  }

  blocks = Blocks{};
  std::vector<int> list;
  const auto add_block = [&](std::span<const int> own, int cell) {
    list.clear();
    for (int node : own) list.push_back(local_node_[layered_node(node, cell)]);
    blocks.add(list);
  };
  for (int b = 0; b < n_patches(); ++b) {
    list.clear();
    for (int node : patch_nodes_[b]) list.push_back(local_node_[node]);
    blocks.add(list);
  }
  for (const Face& f : faces_) add_block(f.node, f.cell_a);
  for (int c : anchor_cells_) add_block(basis_.nodes_of(grid_cell(c)), c);
  add_pressure_blocks();
  pair_nodes();
  for (const auto& [a, b] : numbered_pairs_) {
    list.clear();
    for (const int c : {a, b})
      for (int node : basis_.nodes_of(grid_cell(c))) list.push_back(local_node_[layered_node(node, c)]);
    blocks.add(list);
  }
}

/// The functions of the grid at an anchor, whoever owns its cell.
void MpmDiscretisation::attach(int layered, Anchor& a, Stencil& s) const {
  BasisAt shape;
  basis_.evaluate(grid_cell(layered), seen(a), shape);
  const int layer = field_of(layered) * basis_.n_nodes();
  s.resize(shape.n);
  for (int k = 0; k < shape.n; ++k) {
    s.node[k] = local_node_[shape.nodes[k] + layer];
    s.N[k] = shape.N[k];
    s.gradient[k] = shape.grad[k];
    if (space_ == Space::axisymmetric) {
      const double r = seen(a).x();
      s.hoop[k] = r > 1e-9 * cell_size_ ? shape.N[k] / r : shape.grad[k].x();
    }
  }
  a.stencil = &s;
  a.by_reference = total_lagrangian_;
}

void MpmDiscretisation::attach(const std::vector<Anchor*>& anchors) {
  anchor_stencils_.resize(anchors.size());
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    Anchor& a = *anchors[i];
    const int layered = carrier_[i];
    attach(layered, a, anchor_stencils_[i]);
    const auto own = std::lower_bound(anchor_cells_.begin(), anchor_cells_.end(), layered);
    a.block = own == anchor_cells_.end() || *own != layered
                  ? active_index_[layered]
                  : first_anchor_block_ + static_cast<int>(own - anchor_cells_.begin());
  }
}

void MpmDiscretisation::attach_pairs() {
  pair_stencils_.resize(2 * pairs_.size());
  const int first_block = blocks.size() - static_cast<int>(numbered_pairs_.size());
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const std::pair<int, int>& own = cells_of_pairs_[i];
    attach(own.first, pairs_[i]->a, pair_stencils_[2 * i]);
    attach(own.second, pairs_[i]->b, pair_stencils_[2 * i + 1]);
    const auto cells = std::lower_bound(numbered_pairs_.begin(), numbered_pairs_.end(), own);
    pairs_[i]->block = first_block + static_cast<int>(cells - numbered_pairs_.begin());
  }
}

}  // namespace berm
