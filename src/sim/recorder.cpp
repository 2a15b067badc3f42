#include "sim/recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/fem.hpp"
#include "mesh/region.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

const char* unit_of(Quantity q) {
  switch (q) {
    case Quantity::stress_xx:
    case Quantity::stress_yy:
    case Quantity::stress_zz:
    case Quantity::stress_xy:
      return "Pa";
    case Quantity::displacement_x:
    case Quantity::displacement_y:
      return "m";
    default:
      return "-";
  }
}

template <class T>
int index_of(const std::vector<T>& list, const std::string& name) {
  for (std::size_t k = 0; k < list.size(); ++k)
    if (list[k].name == name) return static_cast<int>(k);
  return -1;
}

unsigned char vtk_type(CellKind kind) {
  switch (kind) {
    case CellKind::tri3:
      return vtk_triangle;
    case CellKind::quad4:
      return vtk_quad;
    case CellKind::tri6:
      return vtk_quadratic_triangle;
    default:
      return vtk_quadratic_quad;
  }
}

}  // namespace

Recorder::Recorder(const World& world, const QuasiStaticStep& step, const std::filesystem::path& folder)
    : world_(world),
      step_(step),
      folder_(folder),
      reference_(world.discretisation->point_positions()),
      points_pvd_((folder / "points.pvd").string()),
      mesh_pvd_((folder / "mesh.pvd").string()) {
  const double h = world.discretisation->cell_size();
  const PointBins bins(reference_, 1.5 * h);
  for (const Probe& p : world.spec.output.probes)
    // A quadratic fit keeps peaks; damage is too rough for one.
    probes_.push_back(
        {p, bins.fit(p.at, 1.5 * h, world.discretisation->material.volume, p.quantity == Quantity::damage ? 1 : 2)});
  history_ = std::make_unique<HistoryWriter>((folder / "history.csv").string(), columns());
  write_row({}, world.spec.solver.integration);
  write_frame(take_frame());
}

std::vector<std::string> Recorder::columns() const {
  std::vector<std::string> names = standard_history_columns();
  for (const Gauge& g : world_.spec.output.gauges) names.push_back("gauge:" + g.name + " [m]");
  for (const NamedProbe& p : probes_)
    names.push_back(fmt::format("probe:{} [{}]", p.spec.name, unit_of(p.spec.quantity)));
  auto reaction = [&](const std::string& name) {
    names.push_back("reaction_x:" + name + " [N]");
    names.push_back("reaction_y:" + name + " [N]");
  };
  for (const Body& b : world_.spec.bodies)
    if (b.rigid) reaction(b.name);
  for (const NodeBoundary& b : world_.spec.boundaries) reaction(b.name);
  return names;
}

Vec2 Recorder::nominal_force() const {
  const Case& c = world_.spec;
  const std::string& name = c.output.nominal.load;
  if (const int b = index_of(c.bodies, name); b >= 0) return step_.balance().rigid_force[b];
  if (const int b = index_of(c.boundaries, name); b >= 0) return step_.balance().boundary_force[b];
  if (const int b = index_of(c.pressures, name); b >= 0) return step_.balance().pressure_force[b];
  return Vec2::Zero();
}

double Recorder::nominal_displacement() const {
  const Case& c = world_.spec;
  const Nominal& n = c.output.nominal;
  if (const int b = index_of(c.bodies, n.displacement); b >= 0)
    return c.bodies[b].displacement.dot(n.direction) * world_.time;
  if (const int b = index_of(c.boundaries, n.displacement); b >= 0)
    return Vec2(c.boundaries[b].ux.value_or(0.0), c.boundaries[b].uy.value_or(0.0)).dot(n.direction) * world_.time;
  if (const int g = index_of(world_.boundary->gauges(), n.displacement); g >= 0)
    return world_.boundary->gauges()[g].elongation();
  return 0.0;
}

double Recorder::probe_value(const NamedProbe& probe) const {
  const MaterialState& m = world_.discretisation->material;
  switch (probe.spec.quantity) {
    case Quantity::stress_xx:
      return probe.fit.apply([&](int p) { return m.stress[p][XX]; });
    case Quantity::stress_yy:
      return probe.fit.apply([&](int p) { return m.stress[p][YY]; });
    case Quantity::stress_zz:
      return probe.fit.apply([&](int p) { return m.stress[p][ZZ]; });
    case Quantity::stress_xy:
      return probe.fit.apply([&](int p) { return m.stress[p][XY]; });
    case Quantity::strain_xx:
      return probe.fit.apply([&](int p) { return m.strain[p][XX]; });
    case Quantity::strain_yy:
      return probe.fit.apply([&](int p) { return m.strain[p][YY]; });
    case Quantity::strain_xy:
      return probe.fit.apply([&](int p) { return 0.5 * m.strain[p][XY]; });
    case Quantity::damage:
      return probe.fit.apply([&](int p) { return m.damage[p]; });
    case Quantity::displacement_x:
    case Quantity::displacement_y: {
      const std::vector<Vec2> u = world_.discretisation->point_displacements();
      const int c = probe.spec.quantity == Quantity::displacement_x ? 0 : 1;
      return probe.fit.apply([&](int p) { return u[p][c]; });
    }
  }
  return 0.0;
}

/// N = RMS(stress - smooth stress) / max |stress|, smooth = linear fit over three cells, in-plane components.
double Recorder::stress_noise() const {
  const MaterialState& m = world_.discretisation->material;
  const double radius = 1.5 * world_.discretisation->cell_size();
  const PointBins bins(reference_, radius);
  double sum = 0.0, largest = 0.0;
  for (int p = 0; p < m.size(); ++p) {
    const LocalFit fit = bins.fit(reference_[p], radius, m.volume);
    double difference = 0.0, size = 0.0;
    for (int c : {XX, YY, XY}) {
      const double weight = c == XY ? 2.0 : 1.0;
      const double smooth = fit.apply([&](int q) { return m.stress[q][c]; });
      difference += weight * (m.stress[p][c] - smooth) * (m.stress[p][c] - smooth);
      size += weight * m.stress[p][c] * m.stress[p][c];
    }
    sum += difference;
    largest = std::max(largest, size);
  }
  return largest > 0.0 ? std::sqrt(sum / m.size() / largest) : 0.0;
}

/// |W_ext - W_el - W_diss| / largest W_ext.
double Recorder::energy_error() const {
  const MaterialState& m = world_.discretisation->material;
  const double work = step_.balance().external_work;
  if (work == 0.0) return 0.0;
  return std::abs(work - m.stored_energy() - m.dissipated_energy()) / std::abs(work);
}

void Recorder::write_row(const StepResult& result, Integration integration) {
  const MaterialState& m = world_.discretisation->material;
  const Nominal& n = world_.spec.output.nominal;
  const double load = nominal_force().dot(n.direction), displacement = nominal_displacement();
  row_load_ = load;
  curve_.push_back({displacement, load});
  std::vector<double> row = {double(steps_),
                             world_.time,
                             displacement,
                             load,
                             load / n.area,
                             displacement / n.length,
                             world_.load_factor,
                             m.max_damage(),
                             step_.balance().external_work,
                             m.stored_energy(),
                             m.dissipated_energy(),
                             energy_error(),
                             double(result.iterations),
                             result.residual,
                             result.extrapolation_error,
                             double(static_cast<int>(integration))};
  for (const GaugeLine& g : world_.boundary->gauges()) row.push_back(g.elongation());
  for (const NamedProbe& p : probes_) row.push_back(probe_value(p));
  for (std::size_t b = 0; b < world_.spec.bodies.size(); ++b)
    if (world_.spec.bodies[b].rigid)
      for (int c : {0, 1}) row.push_back(step_.balance().rigid_force[b][c]);
  for (const Vec2& force : step_.balance().boundary_force)
    for (int c : {0, 1}) row.push_back(force[c]);
  history_->append(row);
}

void Recorder::record(const StepResult& result, Integration integration) {
  ++steps_;
  newton_iterations_ += result.iterations;
  write_row(result, integration);
  if (noise_.empty() || std::abs(row_load_) > 1.1 * noise_.back().first)
    noise_.emplace_back(std::abs(row_load_), stress_noise());
  const Output& o = world_.spec.output;
  const bool due = o.vtk_every > 0 ? steps_ % o.vtk_every == 0 : world_.time >= next_frame_ - 1e-12;
  follow_peak();
  if (due) write_frame(take_frame());
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

Recorder::Frame Recorder::take_frame() const { return {world_.time, row_load_, points_data(), mesh_data()}; }

void Recorder::write_frame(const Frame& frame) {
  const std::string points = fmt::format("points_{:04d}.vtu", frame_), mesh = fmt::format("mesh_{:04d}.vtu", frame_);
  write_vtu((folder_ / points).string(), frame.points);
  write_vtu((folder_ / mesh).string(), frame.mesh);
  points_pvd_.add(frame.time, points);
  mesh_pvd_.add(frame.time, mesh);
  ++frame_;
  if (frame.time < world_.time) return;
  last_frame_step_ = steps_;
  const double spacing = 1.0 / std::max(1, world_.spec.output.frames);
  while (next_frame_ <= world_.time + 1e-12) next_frame_ += spacing;
}

VtuData Recorder::points_data() const {
  const Discretisation& d = *world_.discretisation;
  const MaterialState& m = d.material;
  const std::vector<Vec2> x = d.point_positions(), u = d.point_displacements();
  const int n = m.size();
  VtuData data;
  std::vector<double> displacement, stress, strain;
  std::vector<int> body(n, 0);
  for (const Slice& slice : m.slices) std::fill(body.begin() + slice.begin, body.begin() + slice.end, slice.body);
  for (int p = 0; p < n; ++p) {
    data.points.emplace_back(x[p].x(), x[p].y(), 0.0);
    data.connectivity.push_back(p);
    data.offsets.push_back(p + 1);
    data.types.push_back(vtk_vertex);
    displacement.insert(displacement.end(), {u[p].x(), u[p].y(), 0.0});
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
                       {"released_energy_fraction", 1, m.released_energy_fraction()}};
  return data;
}

VtuData Recorder::mesh_data() const {
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(world_.discretisation.get());
  const auto* fem = dynamic_cast<const FemDiscretisation*>(world_.discretisation.get());
  const MaterialState& m = world_.discretisation->material;
  const Mesh& mesh = mpm ? mpm->grid().mesh : fem->mesh();
  const int n_cells = mpm ? static_cast<int>(mpm->active_cells().size()) : mesh.n_cells();

  VtuData data;
  std::vector<double> displacement, fill, stress, damage;
  std::vector<int> body, number(mesh.nodes.size(), -1);
  for (int k = 0; k < n_cells; ++k) {
    const int cell = mpm ? mpm->active_cells()[k] : k;
    for (int i = 0; i < nodes_of(mesh.kinds[cell]); ++i) {
      const int node = mesh.cell(cell)[i];
      if (number[node] < 0) {
        number[node] = static_cast<int>(data.points.size());
        const Vec2 u = fem ? fem->displacement()[node] : Vec2::Zero();
        data.points.emplace_back(mesh.nodes[node].x() + u.x(), mesh.nodes[node].y() + u.y(), 0.0);
        displacement.insert(displacement.end(), {u.x(), u.y(), 0.0});
      }
      data.connectivity.push_back(number[node]);
    }
    data.offsets.push_back(static_cast<int>(data.connectivity.size()));
    data.types.push_back(vtk_type(mesh.kinds[cell]));
    double volume = 0.0, d = 0.0;
    Voigt s = Voigt::Zero();
    auto add = [&](int p) {
      volume += m.volume[p];
      d += m.volume[p] * m.damage[p];
      s += m.volume[p] * m.stress[p];
    };
    if (mpm)
      for (int p : mpm->points_in(k)) add(p);
    else
      for (int p = fem->first_point()[k]; p < fem->first_point()[k + 1]; ++p) add(p);
    if (volume > 0.0) {
      d /= volume;
      s /= volume;
    }
    damage.push_back(d);
    stress.insert(stress.end(), s.data(), s.data() + 6);
    if (mpm)
      fill.push_back(mpm->fill(k));
    else
      body.push_back(fem->body_of_element(k));
  }
  data.cell_fields = {{"stress", 6, stress}, {"damage", 1, damage}};
  if (mpm)
    data.cell_fields.push_back({"fill", 1, fill});
  else {
    data.cell_fields.push_back({"body", 1, body});
    data.point_fields.push_back({"displacement", 3, displacement});
  }
  return data;
}

std::vector<std::pair<std::string, double>> Recorder::metrics() const {
  const Nominal& n = world_.spec.output.nominal;
  std::size_t peak = 0;
  for (std::size_t k = 0; k < curve_.size(); ++k)
    if (curve_[k].load > curve_[peak].load) peak = k;
  const double load = curve_[peak].load;

  // Stiffness: least squares over the rising branch between 10 and 40 % of the peak; the two ends bracket it if the
  // steps are too large to fall inside.
  auto at_load = [&](double wanted) {
    for (std::size_t k = 1; k <= peak; ++k)
      if (curve_[k].load >= wanted) {
        const Point &a = curve_[k - 1], &b = curve_[k];
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
  const MaterialState& m = world_.discretisation->material;
  return {{"peak_load [N]", load},
          {"peak_stress [Pa]", load / n.area},
          {"displacement_at_peak [m]", curve_[peak].displacement},
          {"stiffness_10_40 [Pa]", stiffness},
          {"stress_noise [-]", noise},
          {"energy_error [-]", energy_error()},
          {"dissipated_energy [J]", m.dissipated_energy()},
          {"max_damage [-]", m.max_damage()},
          {"cut_steps [-]", double(cut_steps_)},
          {"newton_iterations [-]", double(newton_iterations_)},
          {"points_lost [-]", double(reference_.size()) - m.size()}};
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
  s.points = world_.discretisation->material.size();
  s.steps = steps_;
  s.cut_steps = cut_steps_;
  s.newton_iterations = newton_iterations_;
  s.wall_seconds = wall_seconds;
  s.thickness = world_.spec.thickness;
  for (const Body& b : world_.spec.bodies)
    if (b.shape) s.body_rings[b.name] = Region(*b.shape).rings();
  s.references = world_.spec.output.references;
  s.metrics = metrics();
  write_summary((folder_ / "summary.json").string(), s);
}

}  // namespace berm
