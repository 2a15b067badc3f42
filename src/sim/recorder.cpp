#include "sim/recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "fem/fem.hpp"
#include "mesh/region.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

bool is_stress(Quantity q) { return q <= Quantity::stress_zx; }
bool is_strain(Quantity q) { return q > Quantity::stress_zx && q <= Quantity::strain_zx; }
bool is_displacement(Quantity q) { return q >= Quantity::displacement_x && q <= Quantity::displacement_z; }

bool is_velocity(Quantity q) { return q >= Quantity::velocity_x && q <= Quantity::velocity_z; }

const char* unit_of(Quantity q) {
  return is_stress(q) ? "Pa" : is_displacement(q) ? "m" : is_velocity(q) ? "m/s" : "-";
}

template <class T>
int index_of(const std::vector<T>& list, const std::string& name) {
  for (std::size_t k = 0; k < list.size(); ++k)
    if (list[k].name == name) return static_cast<int>(k);
  return -1;
}

unsigned char vtk_type(CellKind kind) {
  constexpr unsigned char types[] = {vtk_triangle, vtk_quad,       vtk_quadratic_triangle, vtk_quadratic_quad,
                                     vtk_tetra,    vtk_hexahedron, vtk_quadratic_tetra,    vtk_quadratic_hexahedron};
  return types[static_cast<int>(kind)];
}

Vec3 motion_of(const NodeBoundary& b, double time) {
  Vec3 u = Vec3::Zero();
  if (b.normal) u = b.un.at(time) * *b.normal;
  for (int i = 0; i < 3; ++i)
    if (b.u[i]) u[i] = b.u[i]->at(time);
  return u;
}

/// Positions in the standard columns of the history (io/history.cpp).
constexpr int displacement_column = 2, load_column = 3;

}  // namespace

Recorder::Recorder(const World& world, const ImplicitStep& step, const std::filesystem::path& folder)
    : world_(world),
      step_(step),
      folder_(folder),
      dimension_(world.spec.dimension()),
      n_points_(world.n_points()),
      points_pvd_((folder / "points.pvd").string()),
      mesh_pvd_((folder / "mesh.pvd").string()) {
  fit_probes();
  n_columns_ = static_cast<int>(columns().size());
}

/// Empties a history that is there.
void Recorder::open_history() {
  world_.comm.agree([&] {
    if (world_.comm.is_root())
      history_ = std::make_unique<HistoryWriter>((folder_ / "history.csv").string(), columns());
  });
}

void Recorder::start() {
  open_history();
  write_row({}, world_.present_stage().solver.integration);
  write_frame(take_frame());
}

/// Weights by the places where the points were at the start. All processes know those near a probe.
void Recorder::fit_probes() {
  const Discretisation& d = *world_.discretisation;
  const double h = d.cell_size(), reach = 3.0 * h;
  const std::vector<Vec3> origins = d.point_origins();
  std::vector<double> near;
  for (std::size_t p = 0; p < origins.size(); ++p)
    for (const Probe& probe : world_.spec.output.probes)
      if ((origins[p] - probe.at).norm() < reach) {
        const Vec3& x = origins[p];
        near.insert(near.end(), {double(d.point_ids()[p]), x.x(), x.y(), x.z(), d.material.volume[p]});
        break;
      }
  near = world_.comm.all_gather(near);
  // In the order of the ids: the same on any number of processes.
  std::vector<std::size_t> order(near.size() / 5);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = 5 * k;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return near[a] < near[b]; });
  std::vector<std::int64_t> ids;
  std::vector<Vec3> x;
  std::vector<double> volume;
  for (std::size_t at : order) {
    ids.push_back(static_cast<std::int64_t>(near[at]));
    x.emplace_back(near[at + 1], near[at + 2], near[at + 3]);
    volume.push_back(near[at + 4]);
  }
  const PointBins bins(x, 1.5 * h, dimension_);
  for (const Probe& p : world_.spec.output.probes) {
    // A quadratic fit keeps peaks; damage is too rough for one.
    const LocalFit fit = bins.fit(p.at, 1.5 * h, volume,
                                  p.quantity == Quantity::damage || p.quantity == Quantity::plastic_strain ? 1 : 2);
    NamedProbe probe{p, {}};
    for (std::size_t k = 0; k < fit.point.size(); ++k)
      probe.weight_of_point.emplace_back(ids[fit.point[k]], fit.weight[k]);
    probes_.push_back(std::move(probe));
  }
}

std::vector<std::string> Recorder::columns() const {
  std::vector<std::string> names = standard_history_columns();
  if (world_.spec.is_dynamic()) names.insert(names.end(), {"kinetic_energy [J]", "damping_energy [J]"});
  if (world_.spec.has_friction()) names.push_back("friction_energy [J]");
  for (const Gauge& g : world_.spec.output.gauges) names.push_back("gauge:" + g.name + " [m]");
  for (const NamedProbe& p : probes_)
    names.push_back(fmt::format("probe:{} [{}]", p.spec.name, unit_of(p.spec.quantity)));
  auto reaction = [&](const std::string& name) {
    for (const char* axis = axes(); *axis; ++axis) names.push_back(fmt::format("reaction_{}:{} [N]", *axis, name));
  };
  for (const Body& b : world_.spec.bodies)
    if (b.rigid) reaction(b.name);
  for (const NodeBoundary& b : world_.spec.boundaries) reaction(b.name);
  return names;
}

Vec3 Recorder::nominal_force() const {
  const Case& c = world_.spec;
  const std::string& name = c.output.nominal.load;
  if (const int b = index_of(c.bodies, name); b >= 0) return step_.balance().reactions.rigid[b];
  if (const int b = index_of(c.boundaries, name); b >= 0) return step_.balance().reactions.boundary[b];
  if (const int b = index_of(c.pressures, name); b >= 0) return step_.balance().pressure_force[b];
  return Vec3::Zero();
}

double Recorder::nominal_displacement() const {
  const Case& c = world_.spec;
  const Nominal& n = c.output.nominal;
  if (const int b = index_of(c.bodies, n.displacement); b >= 0)
    return c.bodies[b].displacement.at(world_.time).dot(n.direction);
  if (const int b = index_of(c.boundaries, n.displacement); b >= 0)
    return motion_of(c.boundaries[b], world_.time).dot(n.direction);
  if (const int g = index_of(world_.boundary->gauges(), n.displacement); g >= 0)
    return world_.boundary->gauges()[g].elongation();
  return 0.0;
}

std::vector<double> Recorder::probe_values() const {
  std::vector<double> values(probes_.size(), 0.0);
  if (probes_.empty()) return values;
  const Discretisation& d = *world_.discretisation;
  const MaterialState& m = d.material;
  const auto wanted = [&](auto is_kind) {
    return std::any_of(probes_.begin(), probes_.end(), [&](const NamedProbe& p) { return is_kind(p.spec.quantity); });
  };
  std::vector<Vec3> u, v;
  if (wanted(is_displacement)) u = d.point_displacements();
  if (wanted(is_velocity)) v = d.point_velocities();
  const auto value_at = [&](Quantity q, int p) {
    const int k = static_cast<int>(q);
    if (is_stress(q)) return m.stress[p][k];
    if (is_strain(q)) {
      const int c = k - static_cast<int>(Quantity::strain_xx);
      return (c < 3 ? 1.0 : 0.5) * m.strain[p][c];
    }
    if (is_displacement(q)) return u[p][k - static_cast<int>(Quantity::displacement_x)];
    if (is_velocity(q)) return v[p][k - static_cast<int>(Quantity::velocity_x)];
    return q == Quantity::plastic_strain ? m.plastic_strain[p] : m.damage[p];
  };
  const std::vector<std::int64_t>& ids = d.point_ids();
  for (std::size_t k = 0; k < probes_.size(); ++k)
    for (const auto& [id, weight] : probes_[k].weight_of_point)
      for (const Slice& slice : m.slices) {  // ids ascend within a slice
        const auto end = ids.begin() + slice.end;
        const auto found = std::lower_bound(ids.begin() + slice.begin, end, id);
        if (found != end && *found == id)
          values[k] += weight * value_at(probes_[k].spec.quantity, static_cast<int>(found - ids.begin()));
      }
  world_.comm.sum(values);
  return values;
}

/// N = RMS(stress - smooth stress) / max |stress|, smooth = linear fit over three cells, components in the plane or
/// all. Process 0 looks at the points of all; in space, where a neighbourhood may hold a thousand, at a sample of them,
/// spread by a multiplicative hash of their ids (Knuth 1973, 6.4): neighbours have consecutive ids.
double Recorder::stress_noise() const {
  const Discretisation& d = *world_.discretisation;
  constexpr int width = 11;
  constexpr double most = 5000.0;
  const double share = dimension_ == 3 ? most / static_cast<double>(world_.n_points()) : 1.0;
  const auto chosen = [&](std::int64_t id) { return std::uint32_t(id) * 2654435769u < share * 4294967296.0; };
  std::vector<double> mine;
  const std::vector<Vec3> origins = d.point_origins();
  for (std::size_t p = 0; p < origins.size(); ++p) {
    mine.push_back(chosen(d.point_ids()[p]));
    mine.insert(mine.end(), origins[p].data(), origins[p].data() + 3);
    mine.push_back(d.material.volume[p]);
    mine.insert(mine.end(), d.material.stress[p].data(), d.material.stress[p].data() + 6);
  }
  const std::vector<double> all = world_.comm.gather(mine);
  if (!world_.comm.is_root()) return 0.0;
  const std::size_t n = all.size() / width;
  std::vector<Vec3> x;
  std::vector<double> volume;
  for (std::size_t p = 0; p < n; ++p) {
    x.emplace_back(all[width * p + 1], all[width * p + 2], all[width * p + 3]);
    volume.push_back(all[width * p + 4]);
  }
  const double radius = 1.5 * d.cell_size();
  const PointBins bins(x, radius, dimension_);
  double sum = 0.0, largest = 0.0;
  int looked_at = 0;
  const auto component = [&](std::size_t p, int c) { return all[width * p + 5 + c]; };
  for (std::size_t p = 0; p < n; ++p) {
    const bool chosen_point = all[width * p] != 0.0;
    const LocalFit fit = chosen_point ? bins.fit(x[p], radius, volume) : LocalFit{};
    double difference = 0.0, size = 0.0;
    for (int c : {XX, YY, ZZ, XY, YZ, ZX}) {
      if (dimension_ == 2 && c != XX && c != YY && c != XY) continue;
      const double weight = c >= XY ? 2.0 : 1.0, here = component(p, c);
      size += weight * here * here;
      const double off = here - fit.apply([&](int q) { return component(q, c); });
      difference += weight * off * off;
    }
    largest = std::max(largest, size);
    if (!chosen_point) continue;
    sum += difference;
    ++looked_at;
  }
  return largest > 0.0 ? std::sqrt(sum / looked_at / largest) : 0.0;
}

double Recorder::stored_energy() const { return world_.comm.sum(world_.discretisation->material.stored_energy()); }
double Recorder::dissipated_energy() const {
  return world_.comm.sum(world_.discretisation->material.dissipated_energy());
}

/// |W_ext + KE_0 - KE - W_el - W_diss - W_damp| / max(|W_ext|, KE_0).
double Recorder::energy_error(double stored, double dissipated) const {
  const Balance& b = step_.balance();
  const double size = std::max(std::abs(b.external_work), b.kinetic_at_start);
  const double missing = b.external_work + b.kinetic_at_start - b.kinetic - stored - dissipated - b.damped -
                         b.friction_work;
  return size == 0.0 ? 0.0 : std::abs(missing) / size;
}

void Recorder::write_row(const StepResult& result, Integration integration) {
  const Nominal& n = world_.spec.output.nominal;
  const double load = nominal_force().dot(n.direction), displacement = nominal_displacement();
  const double stored = stored_energy(), dissipated = dissipated_energy();
  row_load_ = load;
  std::vector<double> row = {double(steps_),
                             world_.time,
                             displacement,
                             load,
                             load / n.area,
                             displacement / n.length,
                             world_.load_factor,
                             world_.comm.max(world_.discretisation->material.max_damage()),
                             step_.balance().external_work,
                             stored,
                             dissipated,
                             energy_error(stored, dissipated),
                             double(result.iterations),
                             result.residual,
                             result.extrapolation_error,
                             double(static_cast<int>(integration))};
  if (world_.spec.is_dynamic()) row.insert(row.end(), {step_.balance().kinetic, step_.balance().damped});
  if (world_.spec.has_friction()) row.push_back(step_.balance().friction_work);
  for (const GaugeLine& g : world_.boundary->gauges()) row.push_back(g.elongation());
  const std::vector<double> probes = probe_values();
  row.insert(row.end(), probes.begin(), probes.end());
  const Reactions& reactions = step_.balance().reactions;
  for (std::size_t b = 0; b < world_.spec.bodies.size(); ++b)
    if (world_.spec.bodies[b].rigid)
      row.insert(row.end(), reactions.rigid[b].data(), reactions.rigid[b].data() + dimension_);
  for (const Vec3& force : reactions.boundary) row.insert(row.end(), force.data(), force.data() + dimension_);
  append(row);
}

void Recorder::append(const std::vector<double>& row) {
  rows_.insert(rows_.end(), row.begin(), row.end());
  world_.comm.agree([&] {
    if (history_) history_->append(row);
  });
}

void Recorder::record(const StepResult& result, Integration integration) {
  ++steps_;
  newton_iterations_ += result.iterations;
  write_row(result, integration);
  // In space the metric costs as much as a step: a look at it for every third more of load.
  const double growth = dimension_ == 3 ? 1.33 : 1.1;
  if (noise_.empty() || std::abs(row_load_) > growth * noise_.back().first)
    noise_.emplace_back(std::abs(row_load_), stress_noise());
  const Output& o = world_.spec.output;
  const bool due =
      o.vtk_every > 0 ? steps_ % o.vtk_every == 0 : world_.time >= next_frame_ - 1e-12 * world_.spec.duration();
  follow_peak();
  if (!due) return;
  if (!peak_ || peak_->time != world_.time) return write_frame(take_frame());
  write_frame(*peak_);  // just taken, and now it has its file
  peak_.reset();
}

/// Keeps the state at the peak load (within 1 %) and writes it once the load has fallen by 3 %.
void Recorder::follow_peak() {
  if (row_load_ > 1.01 * highest_) {
    highest_ = row_load_;
    peak_ = take_frame();
  } else if (peak_ && row_load_ < 0.97 * highest_) {
    write_frame(*peak_);
    peak_.reset();
  }
}

void Recorder::before_checkpoint() {
  if (!peak_ || peak_->time == world_.time) return;
  write_frame(*peak_);
  peak_.reset();
}

Recorder::Frame Recorder::take_frame() const { return {world_.time, points_data(), mesh_data()}; }

/// One file, or one a process and the list of them; returns the name of what a .pvd should name.
std::string Recorder::write_pieces(const std::string& kind, const VtuData& data) const {
  const Comm& comm = world_.comm;
  const std::string name = fmt::format("{}_{:04d}", kind, frame_);
  if (comm.size() == 1) {
    write_vtu((folder_ / (name + ".vtu")).string(), data);
    return name + ".vtu";
  }
  comm.agree([&] {
    write_vtu((folder_ / fmt::format("{}_{}.vtu", name, comm.rank())).string(), data);
    if (!comm.is_root()) return;
    std::vector<std::string> pieces;
    for (int r = 0; r < comm.size(); ++r) pieces.push_back(fmt::format("{}_{}.vtu", name, r));
    write_pvtu((folder_ / (name + ".pvtu")).string(), data, pieces);
  });
  return name + ".pvtu";
}

void Recorder::write_frame(const Frame& frame) {
  const std::string points = write_pieces("points", frame.points), mesh = write_pieces("mesh", frame.mesh);
  world_.comm.agree([&] {
    if (!world_.comm.is_root()) return;
    points_pvd_.add(frame.time, points);
    mesh_pvd_.add(frame.time, mesh);
  });
  ++frame_;
  if (frame.time < world_.time) return;
  last_frame_step_ = steps_;
  const double end = world_.spec.duration(), spacing = end / std::max(1, world_.spec.output.frames);
  while (next_frame_ <= world_.time + 1e-12 * end) next_frame_ += spacing;
}

VtuData Recorder::points_data() const {
  const Discretisation& d = *world_.discretisation;
  const MaterialState& m = d.material;
  const std::vector<Vec3> u = d.point_displacements();
  const int n = m.size();
  VtuData data = vertices(d.point_positions());
  std::vector<double> displacement, stress, strain;
  std::vector<int> body(n, 0);
  for (const Slice& slice : m.slices) std::fill(body.begin() + slice.begin, body.begin() + slice.end, slice.body);
  for (int p = 0; p < n; ++p) {
    displacement.insert(displacement.end(), u[p].data(), u[p].data() + 3);
    for (int c = 0; c < 6; ++c) {
      stress.push_back(m.stress[p][c]);
      strain.push_back(c < 3 ? m.strain[p][c] : 0.5 * m.strain[p][c]);
    }
  }
  data.point_fields = {{"displacement", 3, displacement},
                       {"stress", 6, stress},
                       {"strain", 6, strain},
                       {"damage", 1, m.damage},
                       {"volume", 1, m.volume},
                       {"body", 1, body},
                       {"crack_opening", 1, m.crack_opening()},
                       {"released_energy_fraction", 1, m.released_energy_fraction()},
                       {"id", 1, d.point_ids()}};
  if (world_.spec.is_dynamic()) {
    std::vector<double> velocity;
    for (const Vec3& v : d.point_velocities()) velocity.insert(velocity.end(), v.data(), v.data() + 3);
    data.point_fields.push_back({"velocity", 3, velocity});
  }
  if (m.has_plasticity()) data.point_fields.push_back({"plastic_strain", 1, m.plastic_strain});
  return data;
}

VtuData Recorder::mesh_data() const {
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(world_.discretisation.get());
  const auto* fem = dynamic_cast<const FemDiscretisation*>(world_.discretisation.get());
  const Discretisation& d = *world_.discretisation;
  const MaterialState& m = d.material;
  const Mesh& mesh = d.mesh();
  const std::vector<int>& cells = mpm ? mpm->active_cells() : fem->elements();

  VtuData data;
  std::vector<double> displacement, fill, stress, damage;
  std::vector<int> body, number(d.n_nodes(), -1);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const int cell = cells[k];
    for (const int node : d.blocks[static_cast<int>(k)]) {
      if (number[node] < 0) {
        number[node] = static_cast<int>(data.points.size());
        const Vec3 u = fem ? fem->displacement()[node] : Vec3::Zero();
        data.points.push_back(d.nodes[node] + u);
        displacement.insert(displacement.end(), u.data(), u.data() + 3);
      }
      data.connectivity.push_back(number[node]);
    }
    data.offsets.push_back(static_cast<int>(data.connectivity.size()));
    data.types.push_back(vtk_type(mesh.kinds[mpm ? mpm->grid_cell(cell) : cell]));
    double volume = 0.0, sum = 0.0;
    Voigt s = Voigt::Zero();
    auto add = [&](int p) {
      volume += m.volume[p];
      sum += m.volume[p] * m.damage[p];
      s += m.volume[p] * m.stress[p];
    };
    if (mpm)
      for (int p : mpm->points_in(static_cast<int>(k))) add(p);
    else
      for (int p = fem->first_point()[k]; p < fem->first_point()[k + 1]; ++p) add(p);
    if (volume > 0.0) {
      sum /= volume;
      s /= volume;
    }
    damage.push_back(sum);
    stress.insert(stress.end(), s.data(), s.data() + 6);
    if (mpm)
      fill.push_back(mpm->fill(static_cast<int>(k)));
    else
      body.push_back(fem->body_of_element(cell));
  }
  data.cell_fields = {{"stress", 6, stress}, {"damage", 1, damage}};
  if (mpm)
    data.cell_fields.push_back({"fill", 1, fill});
  else {
    data.cell_fields.push_back({"body", 1, body});
    data.point_fields.push_back({"displacement", 3, displacement});
  }
  if (world_.comm.size() > 1)
    data.cell_fields.push_back({"rank", 1, std::vector<int>(cells.size(), world_.comm.rank())});
  return data;
}

std::vector<std::pair<std::string, double>> Recorder::metrics() const {
  const Nominal& n = world_.spec.output.nominal;
  struct Point {
    double displacement, load;
  };
  std::vector<Point> curve;
  for (std::size_t k = 0; k < rows_.size(); k += n_columns_)
    curve.push_back({rows_[k + displacement_column], rows_[k + load_column]});
  std::size_t peak = 0;
  for (std::size_t k = 0; k < curve.size(); ++k)
    if (curve[k].load > curve[peak].load) peak = k;
  const double load = curve[peak].load;

  // Stiffness: least squares over the rising branch between 10 and 40 % of the peak; the two ends bracket it if the
  // steps are too large to fall inside.
  auto at_load = [&](double wanted) {
    for (std::size_t k = 1; k <= peak; ++k)
      if (curve[k].load >= wanted) {
        const Point &a = curve[k - 1], &b = curve[k];
        return a.displacement + (b.displacement - a.displacement) * (wanted - a.load) / (b.load - a.load);
      }
    return std::nan("");
  };
  const double stiffness = 0.3 * load / n.area / ((at_load(0.4 * load) - at_load(0.1 * load)) / n.length);

  double noise = std::nan("");
  double best = infinity;
  for (const auto& [at, value] : noise_)
    if (std::abs(at - 0.5 * load) < best) {
      best = std::abs(at - 0.5 * load);
      noise = value;
    }
  const double stored = stored_energy(), dissipated = dissipated_energy();
  std::vector<std::pair<std::string, double>> list = {
      {"peak_load [N]", load},
      {"peak_stress [Pa]", load / n.area},
      {"displacement_at_peak [m]", curve[peak].displacement},
      {"stiffness_10_40 [Pa]", stiffness},
      {"stress_noise [-]", noise},
      {"energy_error [-]", energy_error(stored, dissipated)},
      {"dissipated_energy [J]", dissipated},
      {"max_damage [-]", world_.comm.max(world_.discretisation->material.max_damage())},
      {"cut_steps [-]", double(cut_steps_)},
      {"newton_iterations [-]", double(newton_iterations_)},
      {"points_lost [-]", double(n_points_ - world_.n_points())}};
  const MaterialState& m = world_.discretisation->material;
  if (m.has_plasticity()) list.emplace_back("max_plastic_strain [-]", world_.comm.max(m.max_plastic_strain()));
  return list;
}

void Recorder::finish(const std::string& status, const std::string& reason, double wall_seconds) {
  if (last_frame_step_ != steps_) write_frame(take_frame());
  Summary s;
  s.title = world_.spec.title;
  s.method = world_.spec.method == Method::mpm ? "mpm" : "fem";
  s.case_file = world_.spec.file.filename().string();
  s.status = status;
  s.reason = reason;
  s.dofs = step_.unknowns();
  s.points = world_.n_points();
  s.steps = steps_;
  s.cut_steps = cut_steps_;
  s.newton_iterations = newton_iterations_;
  s.wall_seconds = wall_seconds;
  s.thickness = world_.spec.thickness;
  s.dimension = dimension_;
  s.axisymmetric = world_.spec.space == Space::axisymmetric;
  s.processes = world_.comm.size();
  s.references = world_.spec.output.references;
  s.metrics = metrics();
  for (const Body& b : world_.spec.bodies)
    if (b.rigid)
      for (const auto& [time, file] : points_pvd_.entries()) {
        const Vec3 u = b.displacement.at(time);
        s.rigid_motion[b.name].push_back({time, u.x(), u.y(), u.z()});
      }
  world_.comm.agree([&] {
    if (!world_.comm.is_root()) return;
    write_surfaces(s);
    write_summary((folder_ / "summary.json").string(), s);
  });
}

/// Outlines in the plane; in space one file of triangles a body.
void Recorder::write_surfaces(Summary& summary) const {
  for (const Body& b : world_.spec.bodies) {
    if (!b.shape) continue;
    const Region region(*b.shape, world_.discretisation->cell_size());
    if (region.plane()) {
      summary.body_rings[b.name] = region.plane()->rings();
      continue;
    }
    const TriangleSurface& surface = region.solid()->surface();
    VtuData data;
    data.points = surface.vertices;
    for (const auto& triangle : surface.triangles) {
      data.connectivity.insert(data.connectivity.end(), triangle.begin(), triangle.end());
      data.offsets.push_back(static_cast<int>(data.connectivity.size()));
      data.types.push_back(vtk_triangle);
    }
    summary.body_surfaces[b.name] = "surface_" + b.name + ".vtu";
    write_vtu((folder_ / summary.body_surfaces[b.name]).string(), data);
  }
}

RecorderState Recorder::state() const {
  RecorderState s;
  s.rows = rows_;
  s.columns = n_columns_;
  s.steps = steps_;
  s.cut_steps = cut_steps_;
  s.frame = frame_;
  s.newton_iterations = newton_iterations_;
  s.next_frame = next_frame_;
  s.highest = highest_;
  s.peak_pending = peak_.has_value();
  for (const auto& [load, noise] : noise_) s.noise.insert(s.noise.end(), {load, noise});
  s.frames = points_pvd_.entries();
  return s;
}

void Recorder::resume(const RecorderState& s) {
  if (s.columns != n_columns_)
    throw InputError(
        fmt::format("the checkpoint has a history of {} columns, this case one of {}: gauges, probes, bodies and "
                    "boundaries must be those of the run that is to go on",
                    s.columns, n_columns_));
  open_history();
  for (std::size_t k = 0; k < s.rows.size(); k += n_columns_)
    append({s.rows.begin() + static_cast<std::ptrdiff_t>(k),
            s.rows.begin() + static_cast<std::ptrdiff_t>(k) + n_columns_});
  row_load_ = rows_[rows_.size() - n_columns_ + load_column];
  steps_ = s.steps;
  cut_steps_ = s.cut_steps;
  frame_ = s.frame;
  newton_iterations_ = s.newton_iterations;
  next_frame_ = s.next_frame;
  highest_ = s.highest;
  for (std::size_t k = 0; k < s.noise.size(); k += 2) noise_.emplace_back(s.noise[k], s.noise[k + 1]);
  restore_frames(s.frames);
  if (s.peak_pending) peak_ = take_frame();  // see before_checkpoint
}

/// Frames that are not in this folder, since the run goes on in another one, are left out.
void Recorder::restore_frames(std::vector<std::pair<double, std::string>> frames) {
  std::erase_if(frames, [&](const auto& frame) { return !std::filesystem::exists(folder_ / frame.second); });
  if (!frames.empty() && frames.back().first >= world_.time) last_frame_step_ = steps_;
  last_frame_step_ = world_.comm.broadcast(last_frame_step_);
  points_pvd_.restore(frames);
  for (auto& [time, file] : frames) file.replace(0, std::string("points").size(), "mesh");
  mesh_pvd_.restore(frames);
}

}  // namespace berm
