#include "transfer/mpm.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/place_text.hpp"
#include "method/crack_band.hpp"
#include "method/depth.hpp"
#include "mesh/cell_map.hpp"

namespace berm {
namespace {

/// A point's row: id, X, x, u, v, a, C, mass, measure, home, shift, stretch, edges, rim, then what the material
/// keeps.
constexpr int own_width = 1 + 3 + 3 + 3 + 3 + 3 + 9 + 1 + 1 + 1 + 3 + 1 + 9 + 3;

/// Domain of a point of the given area (volume): a box along the axes of a structured grid, in the given ratios or those of
/// its boxes; on other grids a square or cube.
Mat3 edges_of_seed(const Grid& grid, const Mat3& to_own_axes, double measure, const Vec3& box) {
  const int d = grid.dimension();
  Vec3 cell = Vec3::Ones();
  const StructuredGrid* s = grid.structure.get();
  if (s) cell.head(d) = box.isZero(0.0) ? s->cell_size.head(d) : box.head(d);
  Vec3 edges = Vec3::Zero();
  edges.head(d) = cell.head(d) * std::pow(measure / cell.head(d).prod(), 1.0 / d);
  return to_own_axes.transpose() * edges.asDiagonal();
}

}  // namespace

MpmDiscretisation::MpmDiscretisation(Grid grid, Space space, double ghost_penalty, Formulation formulation,
                                     const Comm& comm, Volumetric volumetric, ShapeChoice shapes)
    : Discretisation(comm),
      grid_(std::move(grid)),
      basis_(grid_, shapes.degree),
      shapes_(shapes),
      space_(space),
      ghost_penalty_(ghost_penalty),
      total_lagrangian_(formulation == Formulation::total_lagrangian),
      f_bar_(volumetric == Volumetric::f_bar),
      mixed_(volumetric == Volumetric::mixed) {
  if (f_bar_ && std::all_of(grid_.mesh.kinds.begin(), grid_.mesh.kinds.end(), is_simplex))
    throw InputError(
        "[model] volumetric = \"f_bar\" needs a background grid of quads or hexahedra: the strain of a linear triangle "
        "or tetrahedron is uniform already, its mean changes nothing");
  double sum = 0.0;
  for (int c = 0; c < grid_.mesh.n_cells(); ++c) {
    const CellKind kind = grid_.mesh.kinds[c];
    const double edge = edge_length(kind, cell_measure(grid_.mesh, c));
    sum += dimension() == 3 ? edge * edge * edge : edge * edge;
  }
  set_fields({}, 1);
  cell_size_ = std::pow(sum / grid_.mesh.n_cells(), 1.0 / dimension());
  const int d = dimension(), wide = shapes.degree + 2;
  using Domain = ShapeChoice::Domain;
  most_nodes_ = shapes.domain == Domain::none  ? basis_.most_nodes()
                : shapes.domain == Domain::box ? (d == 3 ? wide * wide * wide : wide * wide)
                                               : (d == 3 ? 64 : 16);
  stride_ = most_nodes_ * (1 + d);
  at_gauss_points_ = shapes.at_gauss_points;
}

void MpmDiscretisation::add_body(int body, const std::string& name, const Material& spec, const SeededPoints& points,
                                 double thickness) {
  const double youngs = std::visit([](const auto& law) { return law.stiffness(); }, spec.law);
  youngs_of_slice_.push_back(youngs * thickness);
  pressure_unit_ = std::max(pressure_unit_, youngs / cell_size_);
  const auto holder = [&](std::size_t p) { return static_cast<int>(p * comm_.size() / points.x.size()); };
  std::vector<double> volume, length;
  for (std::size_t p = 0; p < points.x.size(); ++p) {
    const Vec3& x = points.x[p];
    const int cell = grid_.locator->locate(x, -1);
    if (cell < 0)
      throw InputError(
          fmt::format("body \"{}\": a material point at {} lies outside the background grid: make the grid larger or "
                      "move the body",
                      name, place_text(origin_ + x, dimension())));
    const double l = crack_band_length(spec, grid_.mesh, cell);
    const std::string problem = std::visit([&](const auto& law) { return law.check(l); }, spec.law);
    if (!problem.empty()) throw InputError(fmt::format("body \"{}\", material \"{}\": {}", name, spec.name, problem));
    if (holder(p) != comm_.rank()) continue;  // until the first move_points
    // Around an axis the point stands for a ring (Pappus: exact for the centroid of its part, which a fitted quadrature
    // puts where the point sees the grid).
    const double radius = x.x() + (points.shift.empty() ? 0.0 : points.shift[p].x());
    volume.push_back(points.measure[p] * depth(space_, thickness, radius));
    length.push_back(l);
    id_.push_back(next_id_ + static_cast<std::int64_t>(p));
    X_.push_back(x);
    x_.push_back(x);
    for (auto* list : {&u_, &v_, &a_}) list->push_back(Vec3::Zero());
    C_.push_back(Mat3::Zero());
    mass_.push_back(spec.density * volume.back());
    measure_.push_back(points.measure[p]);
    cell_.push_back(cell);
    home_.push_back(points.shift.empty() ? -1 : cell);
    shift_.push_back(points.shift.empty() ? Vec3::Zero() : points.shift[p]);
    stretch_.push_back(1.0);
    rim_.push_back(Vec3::Zero());
    edges_.push_back(edges_of_seed(grid_, basis_.to_own_axes(), points.measure[p], points.box[p]));
  }
  next_id_ += static_cast<std::int64_t>(points.x.size());
  material.add(body, spec.law, volume, length);
  numbered_ = false;
}

void MpmDiscretisation::tell_surface(const std::vector<Vec3>& ways) {
  const std::int64_t first = next_id_ - static_cast<std::int64_t>(ways.size());
  for (std::size_t p = 0; p < id_.size(); ++p)
    if (id_[p] >= first) rim_[p] = ways[id_[p] - first];
}

void MpmDiscretisation::set_fields(std::vector<int> field_of_body, int n_fields) {
  field_of_body_ = std::move(field_of_body);
  n_fields_ = n_fields;
  active_index_.assign(std::size_t(n_fields) * grid_.mesh.n_cells(), -1);
  local_node_.assign(std::size_t(mixed_ ? 2 : 1) * n_fields * basis_.n_nodes(), -1);
}

// ---- points and processes

int MpmDiscretisation::row_width(int slice) const { return own_width + material.row_width(slice); }

std::vector<double> MpmDiscretisation::point_rows(int slice) const {
  const Slice& s = material.slices[slice];
  const int width = row_width(slice);
  std::vector<double> rows(std::size_t(s.end - s.begin) * width);
  for (int p = s.begin; p < s.end; ++p) write_row(p, rows.data() + std::size_t(p - s.begin) * width);
  return rows;
}

void MpmDiscretisation::write_row(int p, double* row) const {
  *row++ = static_cast<double>(id_[p]);
  for (const Vec3* v : {&X_[p], &x_[p], &u_[p], &v_[p], &a_[p]}) row = std::copy_n(v->data(), 3, row);
  row = std::copy_n(C_[p].data(), 9, row);
  *row++ = mass_[p];
  *row++ = measure_[p];
  *row++ = home_[p];
  row = std::copy_n(shift_[p].data(), 3, row);
  *row++ = stretch_[p];
  row = std::copy_n(edges_[p].data(), 9, row);
  row = std::copy_n(rim_[p].data(), 3, row);
  material.write_row(p, row);
}

/// The points of all slices from rows; ascending ids make sums independent of the way the points came.
void MpmDiscretisation::place_points(const std::vector<std::vector<double>>& rows_of_slice) {
  id_.clear(), X_.clear(), x_.clear(), u_.clear(), v_.clear(), a_.clear(), C_.clear(), mass_.clear(), measure_.clear();
  home_.clear(), shift_.clear(), stretch_.clear(), edges_.clear(), rim_.clear();
  std::vector<std::vector<double>> material_rows(rows_of_slice.size());
  for (std::size_t s = 0; s < rows_of_slice.size(); ++s) {
    const int width = row_width(static_cast<int>(s));
    const std::vector<double>& rows = rows_of_slice[s];
    std::vector<std::size_t> order(rows.size() / width);
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k * width;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rows[a] < rows[b]; });
    material_rows[s].reserve(order.size() * (width - own_width));
    for (const std::size_t at : order) {
      const double* row = rows.data() + at;
      id_.push_back(static_cast<std::int64_t>(*row++));
      for (auto* list : {&X_, &x_, &u_, &v_, &a_}) {
        list->emplace_back(row[0], row[1], row[2]);
        row += 3;
      }
      C_.push_back(Eigen::Map<const Mat3>(row));
      row += 9;
      mass_.push_back(*row++);
      measure_.push_back(*row++);
      home_.push_back(static_cast<int>(*row++));
      shift_.emplace_back(row[0], row[1], row[2]);
      row += 3;
      stretch_.push_back(*row++);
      edges_.push_back(Eigen::Map<const Mat3>(row));
      row += 9;
      rim_.emplace_back(row[0], row[1], row[2]);
      row += 3;
      material_rows[s].insert(material_rows[s].end(), row, rows.data() + at + width);
    }
  }
  material.replace(material_rows);
  cell_.assign(id_.size(), -1);
  // The cells of the last step know nothing of these points.
  for (int c : active_cells_) active_index_[c] = -1;
  active_cells_.clear(), cells_.clear(), layered_.clear();
}

void MpmDiscretisation::find_cells() {
  comm_.agree([&] {
    for (std::size_t p = 0; p < x_.size(); ++p) {
      if (total_lagrangian_ && cell_[p] >= 0) continue;  // the cells of the start hold
      cell_[p] = grid_.locator->locate(total_lagrangian_ ? X_[p] : x_[p], cell_[p]);
      if (cell_[p] < 0 && space_ == Space::axisymmetric && x_[p].x() <= 0.0)
        throw RunError(fmt::format("material point {} has crossed the axis of symmetry at {}: take smaller steps, or cells", id_[p],
                                   place_text(origin_ + x_[p], dimension())));
      if (cell_[p] < 0)
        throw RunError(
            fmt::format("material point {} has left the background grid at {}: make the grid larger, or stop the run "
                        "earlier",
                        id_[p], place_text(origin_ + x_[p], dimension())));
    }
  });
}

/// Points of the most loaded process over the mean once they have gone to where their cells belong: wherever they are at the
/// moment, so that a run that goes on from a checkpoint cuts the grid when the other one does.
double MpmDiscretisation::imbalance_of_cuts() const {
  std::vector<double> points(comm_.size(), 0.0);
  int owner = 0, last = -1;
  for (int p = 0; p < static_cast<int>(x_.size()); ++p) {  // most follow one of the same cell
    const int cell = deciding_cell(p);
    if (cell != last) owner = owner_of_cell(cell), last = cell;
    ++points[owner];
  }
  comm_.sum(std::span<double>(points));
  return Partition::imbalance(comm_, points[comm_.rank()]);
}

/// Cuts the grid anew where the points are.
void MpmDiscretisation::share_cells(double rebalance) {
  if (shared_out_ && imbalance_of_cuts() <= rebalance) return;
  std::map<int, int> points_of_cell;
  for (int p = 0; p < static_cast<int>(x_.size()); ++p) ++points_of_cell[deciding_cell(p)];
  std::vector<Vec3> places;
  std::vector<double> weights;
  for (const auto& [cell, n] : points_of_cell) {
    places.push_back(cell_centre(grid_.mesh, cell));
    weights.push_back(n);
  }
  partition_.balance(comm_, dimension(), places, weights);
  shared_out_ = true;
  numbered_ = false;
}

void MpmDiscretisation::send_points() {
  const int n_slices = static_cast<int>(material.slices.size());
  std::vector<int> owner(x_.size());
  bool leaving = false;
  for (std::size_t p = 0; p < x_.size(); ++p) {
    owner[p] = owner_of_cell(deciding_cell(static_cast<int>(p)));
    leaving = leaving || owner[p] != comm_.rank();
  }
  if (!comm_.any(leaving)) return;
  std::vector<std::vector<double>> mine(n_slices);
  for (int s = 0; s < n_slices; ++s) {
    const int width = row_width(s);
    std::vector<std::vector<double>> to(comm_.size());
    for (int p = material.slices[s].begin; p < material.slices[s].end; ++p) {
      auto& list = owner[p] == comm_.rank() ? mine[s] : to[owner[p]];
      list.resize(list.size() + width);
      write_row(p, list.data() + list.size() - width);
    }
    for (const auto& rows_from : comm_.exchange(to)) mine[s].insert(mine[s].end(), rows_from.begin(), rows_from.end());
  }
  place_points(mine);
  find_cells();
}

void MpmDiscretisation::move_points(double rebalance) {
  if (shapes_.domain != ShapeChoice::Domain::none) split_points();
  find_cells();
  if (comm_.size() == 1) return;
  share_cells(rebalance);
  send_points();
  most_loaded_ = Partition::imbalance(comm_, static_cast<double>(x_.size()));
}

void MpmDiscretisation::restore_cuts(const std::vector<double>& cuts) {
  partition_ = Partition::from_numbers(cuts);
  shared_out_ = true;
}

void MpmDiscretisation::restore_points(const std::vector<std::vector<double>>& rows_of_slice) {
  place_points(rows_of_slice);
  const auto last = std::max_element(id_.begin(), id_.end());
  next_id_ = std::max<std::int64_t>(next_id_, comm_.max(last == id_.end() ? 0L : static_cast<long>(*last + 1)));
  shared_out_ = numbered_ = false;
}

int MpmDiscretisation::locate(Anchor& a) const {
  const int hint = a.cell;
  for (const double inward : {1e-6, 0.02}) {  // what a support on the edge of the grid gives way may lie outside
    a.cell = grid_.locator->locate(seen(a) + inward * cell_size_ * a.inward, hint);
    if (a.cell >= 0) break;
  }
  if (a.cell < 0 && space_ == Space::axisymmetric && a.x.x() <= 0.0)
    throw RunError(fmt::format("a surface point has crossed the axis of rotation at {}: hold it there ([boundary.NAME] with ux = 0 at the nodes of x = 0)", place_text(origin_ + a.x, dimension())));
  if (a.cell < 0)
    throw RunError(fmt::format("a surface point has left the background grid at {}: make the grid larger",
                               place_text(origin_ + a.x, dimension())));
  return owner_of_cell(a.cell);
}

std::vector<Vec3> MpmDiscretisation::points_inside(const Region& region, const std::string& body) const {
  return seed_from_grid(region, grid_, {}, body).x;
}

// ---- kernels

template <class Work>
void MpmDiscretisation::with_space(Work work) const {
  if (space_ == Space::solid)
    work.template operator()<3, false>();
  else if (space_ == Space::axisymmetric)
    work.template operator()<2, true>();
  else
    work.template operator()<2, false>();
}

template <int dimension, class Work>
void MpmDiscretisation::with_nodes(int n, Work work) {
  if constexpr (dimension == 2) {
    if (n == 3) return work.template operator()<3>();
    if (n == 4) return work.template operator()<4>();
    if (n == 9) return work.template operator()<9>();
    work.template operator()<16>();
  } else {
    if (n == 4) return work.template operator()<4>();
    if (n == 8) return work.template operator()<8>();
    if (n == 27) return work.template operator()<27>();
    work.template operator()<64>();
  }
}

/// Hoop strain of a unit radial displacement of node k: N / r, on the axis its limit dN/dr.   [formulation (27)]
double MpmDiscretisation::hoop_gradient(const double* s, int n, double r, int k) const {
  return r > 1e-9 * cell_size_ ? s[k] / r : s[n + 2 * k];
}

/// F_{n+1} = (I + grad_n du) F_n and grad_{n+1} N = dF^-T grad_n N   [formulation (5), (7)];
/// small strain: F_{n+1} = F_n + grad du on the frozen configuration; total: by reference coordinates, (25).
template <int dimension, bool hoop>
void MpmDiscretisation::trial_gradients(const NodalVector& du, Kinematics kinematics) {
  std::array<Vec3, BasisAt::most> d;
  for (int a = 0; a < n_patches(); ++a) {
    const std::span<const int> list = blocks[a];
    const int n = static_cast<int>(list.size());
    for (int k = 0; k < n; ++k) d[k] = du[list[k]];
    for (int p : points_in(a)) {
      const double* s = shape(p);
      Mat3 grad = Mat3::Zero();
      for (int k = 0; k < n; ++k)
        for (int i = 0; i < dimension; ++i)
          for (int j = 0; j < dimension; ++j) grad(i, j) += d[k][i] * s[n + dimension * k + j];
      if constexpr (hoop) {
        const double r = seen(p).x();
        for (int k = 0; k < n; ++k) grad(2, 2) += hoop_gradient(s, n, r, k) * d[k].x();
      }
      if (kinematics == Kinematics::small) {
        material.trial_F[p] = material.F[p] + grad;
        push_[p].setIdentity();
        continue;
      }
      if (total_lagrangian_) {
        material.trial_F[p] = compatible_F(p) + grad;
        push_[p] = material.trial_F[p].inverse().transpose();
      } else {
        const Mat3 dF = Mat3::Identity() + grad;
        material.trial_F[p].noalias() = dF * material.F[p];
        push_[p] = dF.inverse().transpose();
      }
    }
  }
}

Status MpmDiscretisation::evaluate(const NodalVector& du, const LawSettings& settings) {
  kinematics_ = settings.kinematics;
  with_space([&]<int dimension, bool hoop>() { trial_gradients<dimension, hoop>(du, settings.kinematics); });
  const Status status = f_bar_ ? average_dilatation() : mixed_ ? volumes_of_pressures(du) : Status::ok;
  return status == Status::ok ? material.respond(settings) : status;
}

/// f_I = sum_p tau_p grad_{n+1} N_I V0   [formulation (8); around an axis (26); F-bar (45), first part; mixed (50); Gauss
/// points (66)]
template <int dimension, bool hoop>
void MpmDiscretisation::internal_force(NodalVector& f) const {
  std::array<Vec3, BasisAt::most> sum;
  for (int a = 0; a < n_patches(); ++a) {
    const std::span<const int> list = blocks[a];
    const int n = static_cast<int>(list.size());
    std::fill_n(sum.begin(), n, Vec3::Zero());
    const bool averaged = f_bar_ && first_group_[a + 1] > first_group_[a];  // its mean stress: add_mean_pressure
    for (int p : points_in(a)) {
      const double* s = shape(p);
      Mat3 tau = response_detail::tensor(material.trial[p].stress) * material.volume[p];
      if (averaged) tau.diagonal().head(volumetric_directions()).array() -= mean_stress_volume(p);
      const Mat3 by_gradient = tau * push_[p];
      const double* gradient = force_gradient(p, n);
      for (int k = 0; k < n; ++k)
        for (int i = 0; i < dimension; ++i)
          for (int j = 0; j < dimension; ++j) sum[k][i] += by_gradient(i, j) * gradient[dimension * k + j];
      if constexpr (hoop) {
        const double r = seen(p).x();
        for (int k = 0; k < n; ++k) sum[k].x() += by_gradient(2, 2) * hoop_gradient(s, n, r, k);
      }
    }
    for (int k = 0; k < n; ++k) f[list[k]] += sum[k];
  }
}

void MpmDiscretisation::add_internal_force(NodalVector& f) const {
  with_space([&]<int dimension, bool hoop>() { internal_force<dimension, hoop>(f); });
  if (f_bar_) add_mean_pressure(f);
  if (mixed_) add_volume_residuals(f);
}

/// K_(Ii)(Jk) = g_I,j a_ijkl g_J,l V0, summed over the points of a cell with n nodes; the first g is that of the forces.
/// [formulation (10)]
template <int dimension, bool hoop, int n>
void MpmDiscretisation::cell_tangent(int active, const LawSettings& settings, double* out) const {
  constexpr int components = dimension * dimension + (hoop ? 1 : 0), width = dimension * n;
  using Row = Eigen::Matrix<double, 1, width>;
  Eigen::Map<Eigen::Matrix<double, width, width, Eigen::RowMajor>> K(out);
  K.setZero();
  Modulus<components> a;
  // Increments of the stress components for unit displacements of the nodes.
  Eigen::Matrix<double, components, width, Eigen::RowMajor> increment;
  double g[n][dimension], of_force[n][dimension], ring[n] = {};
  for (int p : points_in(active)) {
    material.modulus<components>(p, settings, a);
    a *= material.volume[p];
    const double *s = shape(p), *gradient = force_gradient(p, n);
    const Mat3& push = push_[p];
    const double r = hoop ? seen(p).x() : 0.0;
    for (int k = 0; k < n; ++k) {
      for (int i = 0; i < dimension; ++i) {
        g[k][i] = of_force[k][i] = 0.0;
        for (int j = 0; j < dimension; ++j) {
          g[k][i] += push(i, j) * s[n + dimension * k + j];
          of_force[k][i] += push(i, j) * gradient[dimension * k + j];
        }
      }
      if constexpr (hoop) ring[k] = push(2, 2) * hoop_gradient(s, n, r, k);
    }
    for (int c = 0; c < components; ++c)
      for (int k = 0; k < n; ++k)
        for (int i = 0; i < dimension; ++i) {
          double sum = 0.0;
          for (int l = 0; l < dimension; ++l) sum += a(c, dimension * i + l) * g[k][l];
          if (hoop && i == 0) sum += a(c, components - 1) * ring[k];
          increment(c, dimension * k + i) = sum;
        }
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < dimension; ++i) {
        Row row = of_force[k][0] * increment.row(dimension * i);
        for (int j = 1; j < dimension; ++j) row += of_force[k][j] * increment.row(dimension * i + j);
        if (hoop && i == 0) row += ring[k] * increment.row(components - 1);
        K.row(dimension * k + i) += row;
      }
  }
}

template <int dimension, bool hoop>
void MpmDiscretisation::tangent(const LawSettings& settings, BlockAssembler& matrix) const {
  const std::size_t width = std::size_t(dimension) * most_nodes_;
  std::vector<double> K(width * width);
  for (int block = 0; block < n_patches(); ++block) {
    with_nodes<dimension>(static_cast<int>(blocks[block].size()), [&]<int n>() {
      if constexpr (n <= (1 << dimension))
        if (mixed_ && pressure_block_[block] >= 0) return mixed_tangent<dimension, hoop, n>(block, settings, matrix);
      bool done = false;
      if constexpr (n > dimension + 1) {
        if (f_bar_) f_bar_tangent<dimension, hoop, n>(block, settings, K.data());
        done = f_bar_;
      }
      if (!done) cell_tangent<dimension, hoop, n>(block, settings, K.data());
      matrix.add(block, K.data());
    });
  }
}

void MpmDiscretisation::add_tangent(const LawSettings& settings, BlockAssembler& matrix) const {
  with_space([&]<int dimension, bool hoop>() { tangent<dimension, hoop>(settings, matrix); });
}

/// j(du, w) = sum_faces gamma E h int [d_n du] . [d_n w] ds   [formulation (14)]
void MpmDiscretisation::add_stabilisation(const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const {
  const int d = dimension();
  std::vector<double> K;
  for (const Face& face : faces_) {
    const std::span<const int> list = blocks[face.block];
    const int n = static_cast<int>(face.node.size()), width = d * n;
    for (const auto& jump : face.jump) {
      Vec3 total = Vec3::Zero();
      for (int k = 0; k < n; ++k) total += jump[k] * du[list[k]];
      for (int k = 0; k < n; ++k) f[list[k]] += jump[k] * total;
    }
    if (!matrix) continue;
    K.assign(std::size_t(width) * width, 0.0);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        double value = 0.0;
        for (const auto& jump : face.jump) value += jump[i] * jump[j];
        for (int c = 0; c < d; ++c) K[(d * i + c) * width + d * j + c] = value;
      }
    matrix->add(face.block, K.data());
  }
}

void MpmDiscretisation::add_body_force(const std::function<Vec3(int body, const Vec3& X)>& acceleration,
                                       NodalVector& f) const {
  std::vector<Vec3> of_point(x_.size());
  for (const Slice& slice : material.slices)
    for (int p = slice.begin; p < slice.end; ++p) of_point[p] = acceleration(slice.body, X_[p]);
  for_points([&](std::span<const int> list, int p, const double* N) {
    for (std::size_t k = 0; k < list.size(); ++k) f[list[k]] += N[k] * mass_[p] * of_point[p];
  });
}

void MpmDiscretisation::commit(const NodalVector& du, const std::vector<Anchor*>& anchors) {
  const bool move = kinematics_ == Kinematics::finite;
  const int d = dimension();
  comm_.agree([&] {
    material.commit();
    if ((f_bar_ || mixed_) && move) stretch_ = trial_stretch_;
    for (int a = 0; a < n_patches(); ++a) {
      const std::span<const int> list = blocks[a];
      const int n = static_cast<int>(list.size());
      for (int p : points_in(a)) {
        // A point with a fitted quadrature sees the functions of a shifted place, but moves with its own.
        const Vec3 back = cell_[p] == home_[p] ? shift_[p] : Vec3::Zero();
        const double* s = shape(p);
        Vec3 step = Vec3::Zero();
        for (int k = 0; k < n; ++k) {
          double N = s[k];
          for (int i = 0; i < d; ++i) N -= s[n + d * k + i] * back[i];
          step += N * du[list[k]];
        }
        u_[p] += step;
        if (!move) continue;
        x_[p] += step;
        const double J = material.F[p].determinant();
        if (!(J > 0.0) || !std::isfinite(J))
          throw RunError(fmt::format("material point {} at {} is turned inside out (det F = {:.3g}): take smaller steps",
                                     id_[p], place_text(origin_ + x_[p], d), J));
      }
    }
  });
  const auto carry = [&](Anchor& a) {
    const Vec3 step = a.stencil->interpolate(du);
    a.u += step;
    if (!move) return;
    a.F = a.trial_F(du);
    a.x += step;
  };
  for (Anchor* a : anchors) carry(*a);
  for (AnchorPair* pair : pairs_) carry(pair->a), carry(pair->b);
}

}  // namespace berm
