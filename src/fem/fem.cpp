#include "fem/fem.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/sort_unique.hpp"
#include "fem/geometry.hpp"
#include "method/crack_band.hpp"
#include "method/depth.hpp"

namespace berm {
namespace {

constexpr const char* other_mesh = "the checkpoint was written with other meshes of the bodies than the case has now";

}  // namespace

FemDiscretisation::FemDiscretisation(Space space, const Comm& comm) : Discretisation(comm), space_(space) {}

// ---- bodies

void FemDiscretisation::add_body(int body, const std::string& name, const Material& spec, const Mesh& mesh,
                                 double thickness) {
  if (mesh.kinds.empty() || mesh.dimension() != dimension_of(space_))
    throw InputError(fmt::format("body \"{}\": its mesh has no cells of a {} model", name,
                                 space_ == Space::solid ? "solid" : "plane or axisymmetric"));
  const int node0 = mesh_.n_nodes(), element0 = mesh_.n_cells();
  mesh_.nodes.insert(mesh_.nodes.end(), mesh.nodes.begin(), mesh.nodes.end());
  for (const auto& [group, list] : mesh.node_groups)
    for (int node : list) mesh_.node_groups[group].push_back(node0 + node);

  BodyMesh added{body, name, spec, thickness, element0, mesh.n_cells(), 0.0, {}};
  double measure = 0.0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    std::array<int, fem::most_nodes> list{};
    const auto nodes_here = mesh.nodes_of_cell(c);
    for (std::size_t k = 0; k < nodes_here.size(); ++k) list[k] = node0 + nodes_here[k];
    mesh_.add_cell(mesh.kinds[c], list.data());
    measure += add_element(added, element0 + c);
  }
  measure_ += measure;
  added.cell_size = std::pow(measure / mesh.n_cells(), 1.0 / dimension());
  cell_size_ = std::pow(measure_ / mesh_.n_cells(), 1.0 / dimension());
  added.corners = make_unstructured_grid(fem::corner_mesh(mesh));
  bodies_.push_back(std::move(added));
  material.add(body, spec.law, {}, {});  // its points come with the elements of this process
}

/// Checks the last element of the mesh and numbers its points. Returns its area or volume.
double FemDiscretisation::add_element(const BodyMesh& b, int element) {
  const int number = element - b.first_element;
  const std::string problem =
      std::visit([&](const auto& law) { return law.check(crack_band(b, element)); }, b.material.law);
  if (!problem.empty())
    throw InputError(fmt::format("body \"{}\", material \"{}\": {}", b.name, b.material.name, problem));
  double measure = 0.0;
  const auto& rule = fem::element_rule(mesh_.kinds[element]);
  for (const fem::RulePoint& q : rule) {
    const double det = fem::jacobian(mesh_, element, q.shape).determinant();
    if (!(det > 0.0))
      throw InputError(fmt::format("body \"{}\": element {} of its mesh is turned inside out (Jacobian {:.3g})", b.name,
                                   number, det));
    if (space_ == Space::axisymmetric && !(fem::place(mesh_, element, q.shape).x() > 0.0))
      throw InputError(fmt::format(
          "body \"{}\": element {} of its mesh lies across the axis x = 0 (all of the body must have x >= 0)", b.name,
          number));
    measure += q.weight * det;
  }
  body_of_element_.push_back(b.body);
  first_number_.push_back(first_number_.back() + static_cast<std::int64_t>(rule.size()));
  return measure;
}

const FemDiscretisation::BodyMesh& FemDiscretisation::body_mesh(int body) const {
  for (const BodyMesh& b : bodies_)
    if (b.body == body) return b;
  throw RunError(fmt::format("body {} has no mesh", body));
}

int FemDiscretisation::points_of_body(int body) const {
  const BodyMesh& b = body_mesh(body);
  return static_cast<int>(first_number_[b.first_element + b.n_elements] - first_number_[b.first_element]);
}

double FemDiscretisation::crack_band(const BodyMesh& b, int element) const {
  return crack_band_length(b.material, mesh_, element);
}

// ---- elements and processes

void FemDiscretisation::move_points(double) { share_out(); }

void FemDiscretisation::share_out() {
  if (shared_out_) return;
  shared_out_ = true;
  share_elements();
  build_points();
  number_nodes();
  most_loaded_ = Partition::imbalance(comm_, static_cast<double>(id_.size()));
}

/// Every process names its part of the elements, so that no process has to hold all places.
void FemDiscretisation::share_elements() {
  const std::int64_t n = mesh_.n_cells();
  const int begin = static_cast<int>(n * comm_.rank() / comm_.size());
  const int end = static_cast<int>(n * (comm_.rank() + 1) / comm_.size());
  std::vector<Vec3> centres;
  std::vector<double> weights;
  for (int e = begin; e < end; ++e) {
    centres.push_back(cell_centre(mesh_, e));
    weights.push_back(static_cast<double>(first_number_[e + 1] - first_number_[e]));
  }
  partition_.balance(comm_, dimension(), centres, weights);
  for (int e = 0; e < n; ++e)
    if (owner_of_element(e) == comm_.rank()) elements_.push_back(e);
}

/// Gauss points and material of this process's elements.
void FemDiscretisation::build_points() {
  material = MaterialState{};
  std::size_t k = 0;
  for (const BodyMesh& b : bodies_) {
    std::vector<double> volume, length;
    for (; k < elements_.size() && elements_[k] < b.first_element + b.n_elements; ++k) {
      const int e = elements_[k];
      std::int64_t number = first_number_[e];
      for (const fem::RulePoint& q : fem::element_rule(mesh_.kinds[e])) {
        const Mat3 J = fem::jacobian(mesh_, e, q.shape);
        const double radius = fem::place(mesh_, e, q.shape).x();
        inverse_.push_back(J.inverse());
        if (space_ == Space::axisymmetric) radius_.push_back(radius);
        volume.push_back(q.weight * J.determinant() * depth(space_, b.thickness, radius));
        length.push_back(crack_band(b, e));
        id_.push_back(number++);
      }
      density_.push_back(b.material.density);
      first_.push_back(static_cast<int>(id_.size()));
    }
    material.add(b.body, b.material.law, volume, length);
  }
}

/// Local nodes and blocks, until other pairs have to be tied: nodes that this process owns stay as they are.
void FemDiscretisation::number_nodes() {
  ++connectivity;
  std::vector<std::int64_t> touched;
  for (int e : elements_)
    for (int node : mesh_.nodes_of_cell(e)) touched.push_back(node);
  for (const auto& [a, b] : tied_)
    for (const int e : {a, b})
      for (int node : mesh_.nodes_of_cell(e)) touched.push_back(node);
  sort_unique(touched);
  halo = build_halo(comm_, touched, [&](std::int64_t id) { return partition_.owner(mesh_.nodes[id]); });
  std::vector<int> local(mesh_.n_nodes(), -1);
  nodes.clear();
  for (int i = 0; i < halo.size(); ++i) {
    local[halo.ids[i]] = i;
    nodes.push_back(mesh_.nodes[halo.ids[i]]);
  }
  for (const auto list : state_) {
    (this->*list).resize(nodes.size(), Vec3::Zero());
    halo.copy_to_ghosts(reinterpret_cast<double*>((this->*list).data()), 3);
  }
  blocks = Blocks{};
  std::vector<int> list;
  const auto append = [&](int e) {
    for (int node : mesh_.nodes_of_cell(e)) list.push_back(local[node]);
  };
  for (int e : elements_) {
    list.clear();
    append(e);
    blocks.add(list);
  }
  for (const auto& [a, b] : tied_) {
    list.clear();
    append(a), append(b);
    blocks.add(list);
  }
}

// ---- checkpoints

std::vector<double> FemDiscretisation::point_rows(int slice) const {
  const Slice& s = material.slices[slice];
  const int width = row_width(slice);
  std::vector<double> rows(std::size_t(s.end - s.begin) * width);
  for (int p = s.begin; p < s.end; ++p) {
    double* row = rows.data() + std::size_t(p - s.begin) * width;
    row[0] = static_cast<double>(id_[p]);
    material.write_row(p, row + 1);
  }
  return rows;
}

int FemDiscretisation::element_of_point(std::int64_t id) const {
  return static_cast<int>(std::upper_bound(first_number_.begin(), first_number_.end(), id) - first_number_.begin()) - 1;
}

/// Rows by the processes that own their points.
std::vector<std::vector<double>> FemDiscretisation::rows_by_owner(int slice, const std::vector<double>& rows) const {
  const int width = row_width(slice);
  std::vector<std::vector<double>> to(comm_.size());
  for (std::size_t at = 0; at + width <= rows.size(); at += width) {
    const auto id = static_cast<std::int64_t>(rows[at]);
    if (id < 0 || id >= first_number_.back()) throw InputError(other_mesh);
    auto& list = to[owner_of_element(element_of_point(id))];
    list.insert(list.end(), rows.begin() + at, rows.begin() + at + width);
  }
  return to;
}

/// Rows of this process's points of a slice, whoever sent them, ordered and without the ids.
std::vector<double> FemDiscretisation::own_rows(int slice, const std::vector<std::vector<double>>& from) const {
  const int width = row_width(slice);
  std::vector<const double*> order;
  for (const auto& rows : from)
    for (std::size_t at = 0; at + width <= rows.size(); at += width) order.push_back(rows.data() + at);
  std::sort(order.begin(), order.end(), [](const double* a, const double* b) { return *a < *b; });
  const Slice& s = material.slices[slice];
  const auto mine = id_.begin() + s.begin;
  if (!std::equal(order.begin(), order.end(), mine, id_.begin() + s.end,
                  [](const double* row, std::int64_t id) { return *row == static_cast<double>(id); }))
    throw InputError(other_mesh);
  std::vector<double> out;
  out.reserve(order.size() * (width - 1));
  for (const double* row : order) out.insert(out.end(), row + 1, row + width);
  return out;
}

void FemDiscretisation::restore_points(const std::vector<std::vector<double>>& rows_of_slice) {
  share_out();
  std::vector<std::vector<double>> mine;
  for (int s = 0; s < static_cast<int>(material.slices.size()); ++s) {
    std::vector<std::vector<double>> to;
    comm_.agree([&] { to = rows_by_owner(s, rows_of_slice[s]); });
    const auto from = comm_.exchange(to);
    comm_.agree([&] { mine.push_back(own_rows(s, from)); });
  }
  material.replace(mine);
}

std::vector<double> FemDiscretisation::node_state() const {
  std::vector<double> out;
  for (int i = 0; i < halo.n_owned; ++i)
    for (const auto list : state_) out.insert(out.end(), (this->*list)[i].data(), (this->*list)[i].data() + 3);
  return out;
}

void FemDiscretisation::restore_nodes(const std::vector<std::int64_t>& ids, const std::vector<double>& state) {
  share_out();
  std::vector<std::vector<double>> to(comm_.size());
  comm_.agree([&] {
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (ids[i] < 0 || ids[i] >= mesh_.n_nodes()) throw InputError(other_mesh);
      auto& list = to[partition_.owner(mesh_.nodes[ids[i]])];
      list.push_back(static_cast<double>(ids[i]));
      list.insert(list.end(), state.begin() + i * node_width, state.begin() + (i + 1) * node_width);
    }
  });
  const auto from = comm_.exchange(to);
  comm_.agree([&] {
    int missing = halo.n_owned;
    for (const auto& rows : from)
      for (std::size_t at = 0; at < rows.size(); at += 1 + node_width, --missing) {
        const int node = halo.find(static_cast<std::int64_t>(rows[at]));
        if (node < 0) throw InputError(other_mesh);
        const double* row = rows.data() + at + 1;
        for (const auto list : state_) {
          (this->*list)[node] = Vec3(row[0], row[1], row[2]);
          row += 3;
        }
      }
    if (missing != 0) throw InputError(other_mesh);
  });
  if (comm_.size() == 1) return;
  for (const auto list : state_) halo.copy_to_ghosts(reinterpret_cast<double*>((this->*list).data()), 3);
}

// ---- anchors

/// From just below the surface downwards, up to half a cell: curved sides have their chords inside.
int FemDiscretisation::find_element(const BodyMesh& b, const Anchor& a) const {
  for (const double depth : {1e-6, 0.05, 0.15, 0.3, 0.5}) {
    const int cell = b.corners.locator->locate(a.X + depth * b.cell_size * a.inward, -1);
    const int found = cell < 0 ? -1 : walk_to(b, b.first_element + cell, a.X);
    if (found >= 0) return found;
    if (a.inward.isZero()) break;
  }
  return search(b, a.X);
}

/// From an element nearby to the one that holds x, neighbour by neighbour: corner cells tell not quite where curved
/// elements are. -1 if it leads nowhere.
int FemDiscretisation::walk_to(const BodyMesh& b, int start, const Vec3& x) const {
  constexpr double inside = 1e-9, farthest = 0.5;
  int here = start;
  double distance = fem::distance_outside(mesh_, here, x);
  for (int from = -1; distance > inside && here != from;) {
    from = here;
    for (int f = 0; f < max_faces; ++f) {
      const int other = b.corners.neighbours[std::size_t(max_faces) * (from - b.first_element) + f];
      if (other < 0) continue;
      const double d = fem::distance_outside(mesh_, b.first_element + other, x);
      if (d >= distance) continue;
      distance = d;
      here = b.first_element + other;
    }
  }
  return distance <= farthest ? here : -1;
}

/// The nearest of all elements, for the few anchors that nothing leads to.
int FemDiscretisation::search(const BodyMesh& b, const Vec3& x) const {
  int best = -1;
  double least = 0.5;
  for (int e = b.first_element; e < b.first_element + b.n_elements; ++e) {
    const Vec3 centre = cell_centre(mesh_, e);
    double reach = 0.0;
    for (int node : mesh_.nodes_of_cell(e)) reach = std::max(reach, (mesh_.nodes[node] - centre).squaredNorm());
    if ((x - centre).squaredNorm() > 4.0 * reach) continue;
    const double d = fem::distance_outside(mesh_, e, x);
    if (d > least || (best >= 0 && d == least)) continue;
    least = d;
    best = e;
  }
  return best;
}

int FemDiscretisation::locate(Anchor& a) const {
  const BodyMesh& b = body_mesh(a.body);
  if (a.cell < b.first_element || a.cell >= b.first_element + b.n_elements) a.cell = find_element(b, a);
  if (a.cell < 0)
    throw RunError(fmt::format("the point ({:.6g}, {:.6g}, {:.6g}) lies in no element of the mesh of body \"{}\"",
                               a.X.x(), a.X.y(), a.X.z(), b.name));
  return owner_of_element(a.cell);
}

void FemDiscretisation::attach(Anchor& a, Stencil& s) const {
  const auto found = std::lower_bound(elements_.begin(), elements_.end(), a.cell);
  if (found == elements_.end() || *found != a.cell)
    throw RunError(fmt::format("element {} belongs to another process than its anchor", a.cell));
  a.block = static_cast<int>(found - elements_.begin());
  attach(a, blocks[a.block], s);
}

void FemDiscretisation::attach_pairs() {
  pair_stencils_.resize(2 * pairs_.size());
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    AnchorPair& pair = *pairs_[k];
    const auto found = std::lower_bound(tied_.begin(), tied_.end(), std::pair(pair.a.cell, pair.b.cell));
    pair.block = static_cast<int>(elements_.size()) + static_cast<int>(found - tied_.begin());
    const std::span<const int> list = blocks[pair.block];
    const std::size_t n = mesh_.nodes_of_cell(pair.a.cell).size();
    attach(pair.a, list.first(n), pair_stencils_[2 * k]);
    attach(pair.b, list.subspan(n), pair_stencils_[2 * k + 1]);
  }
}

void FemDiscretisation::attach(Anchor& a, std::span<const int> list, Stencil& s) const {
  Vec3 xi;
  fem::local_coordinates(mesh_, a.cell, a.X, xi);
  const fem::ElementShape shape = fem::element_shape(mesh_.kinds[a.cell], xi);
  a.stencil = &s;
  s.resize(shape.n);
  std::copy_n(shape.N.begin(), shape.n, s.N.begin());
  const Mat3 by_X = fem::jacobian(mesh_, a.cell, shape).inverse().transpose();
  for (int k = 0; k < shape.n; ++k) s.gradient[k] = by_X * shape.dN[k];
  if (space_ == Space::axisymmetric) {
    const double radius = fem::place(mesh_, a.cell, shape).x();
    const bool on_axis = radius < 1e-9 * cell_size_;
    for (int k = 0; k < shape.n; ++k) s.hoop[k] = on_axis ? s.gradient[k].x() : shape.N[k] / radius;
  }
  a.by_reference = true;
  std::copy(list.begin(), list.end(), s.node.begin());
}

void FemDiscretisation::begin_step(const std::vector<Anchor*>& anchors) {
  std::vector<std::pair<int, int>> tied;
  for (const AnchorPair* pair : pairs_) tied.emplace_back(pair->a.cell, pair->b.cell);
  sort_unique(tied);
  if (comm_.any(tied != tied_)) {
    tied_ = std::move(tied);
    number_nodes();
  }
  comm_.agree([&] {
    anchor_stencils_.resize(anchors.size());
    for (std::size_t k = 0; k < anchors.size(); ++k) attach(*anchors[k], anchor_stencils_[k]);
    attach_pairs();
  });
}

}  // namespace berm
