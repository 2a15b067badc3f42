#include "sim/recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "sim/recovery.hpp"

namespace berm {
namespace {

template <class T>
int index_of(const std::vector<T>& list, const std::string& name) {
  for (std::size_t k = 0; k < list.size(); ++k)
    if (list[k].name == name) return static_cast<int>(k);
  return -1;
}

Vec3 motion_of(const NodeBoundary& b, double time) {
  Vec3 u = Vec3::Zero();
  if (b.normal) u = b.un.at(time) * *b.normal;
  for (int i = 0; i < 3; ++i)
    if (b.u[i]) u[i] = b.u[i]->at(time);
  return u;
}

}  // namespace

Recorder::Recorder(const World& world, const ImplicitStep& step, const std::filesystem::path& folder)
    : world_(world),
      step_(step),
      folder_(folder),
      dimension_(world.spec.dimension()),
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

/// What history.csv holds; nothing beside the first process.
std::string Recorder::history_text() const {
  if (!world_.comm.is_root() || !std::filesystem::is_regular_file(folder_ / "history.csv")) return "";
  std::ifstream file(folder_ / "history.csv", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Recorder::start() {
  open_history();
  write_row({}, world_.present_stage().solver.integration);
  write_frame(take_frame());
}

std::vector<std::string> Recorder::columns() const {
  std::vector<std::string> names = standard_history_columns();
  if (world_.spec.is_dynamic())
    names.insert(names.end(), {"kinetic_energy [J]", "damping_energy [J]", "transfer_energy [J]"});
  if (world_.spec.has_friction()) names.push_back("friction_energy [J]");
  for (const Gauge& g : world_.spec.output.gauges) names.push_back("gauge:" + g.name + " [m]");
  const std::vector<std::string> probes = probe_columns();
  names.insert(names.end(), probes.begin(), probes.end());
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
  const Balance& balance = step_.balance();
  Vec3 sum = Vec3::Zero();
  for (const std::string& name : c.output.nominal.load) {
    if (const int b = index_of(c.bodies, name); b >= 0)
      sum += balance.reactions.rigid[b];
    else if (const int boundary = index_of(c.boundaries, name); boundary >= 0)
      sum += balance.reactions.boundary[boundary];
    else if (const int pressure = index_of(c.pressures, name); pressure >= 0)
      sum += balance.pressure_force[pressure];
  }
  return sum;
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
  if (world_.spec.is_dynamic())
    row.insert(row.end(), {step_.balance().kinetic, step_.balance().damped, step_.balance().transferred});
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
  const double kinetic = world_.spec.is_dynamic() ? row[error_column + 2] : 0.0;
  largest_energy_ = std::max({largest_energy_, std::abs(row[work_column]), row[work_column + 1] + row[work_column + 2] + kinetic});
  world_.comm.agree([&] {
    if (history_) history_->append(row);
  });
}

void Recorder::record(const StepResult& result, Integration integration) {
  ++steps_;
  newton_iterations_ += result.iterations;
  write_row(result, integration);
  look_at_stress();
  gap_scatter_ = std::max(gap_scatter_, world_.comm.max(world_.boundary->grid_contact().scatter(*world_.discretisation)));
  const Output& o = world_.spec.output;
  const bool due =
      o.vtk_every > 0 ? steps_ % o.vtk_every == 0 : world_.time >= next_frame_ - 1e-12 * world_.spec.duration();
  follow_peak();
  if (!due) return;
  if (!peak_ || peak_->time != world_.time) return write_frame(take_frame());
  write_frame(*peak_);  // just taken, and now it has its file
  peak_.reset();
}

/// In space the metrics cost as much as a step: a look at them for every third more of load.
void Recorder::look_at_stress() {
  const double growth = dimension_ == 3 ? 1.33 : 1.1, load = std::abs(row_load_);
  if (!quality_.empty() && load <= growth * quality_.back().load) return;
  const Discretisation& d = *world_.discretisation;
  quality_.push_back({load, stress_noise(), recover_stress(d, contents_of_cells(d)).relative_error});
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
  s.watched = watched_.row();
  s.gap_scatter = gap_scatter_;
  s.peak_pending = peak_.has_value();
  for (const Quality& q : quality_) s.quality.insert(s.quality.end(), {q.load, q.noise, q.error});
  s.frames = points_pvd_.entries();
  return s;
}

void Recorder::resume(const RecorderState& s) {
  if (s.columns != n_columns_)
    throw InputError(
        fmt::format("the checkpoint has a history of {} columns, this case one of {}: gauges, probes, bodies and "
                    "boundaries must be those of the run that is to go on",
                    s.columns, n_columns_));
  const std::string there = history_text();
  open_history();
  for (std::size_t k = 0; k < s.rows.size(); k += n_columns_)
    append({s.rows.begin() + static_cast<std::ptrdiff_t>(k),
            s.rows.begin() + static_cast<std::ptrdiff_t>(k) + n_columns_});
  const bool of_another_run = !there.empty() && !there.starts_with(history_text());
  row_load_ = rows_[rows_.size() - n_columns_ + load_column];
  steps_ = s.steps;
  cut_steps_ = s.cut_steps;
  frame_ = s.frame;
  newton_iterations_ = s.newton_iterations;
  next_frame_ = s.next_frame;
  highest_ = s.highest;
  watched_.restore(s.watched);
  gap_scatter_ = s.gap_scatter;
  for (std::size_t k = 0; k < s.quality.size(); k += 3)
    quality_.push_back({s.quality[k], s.quality[k + 1], s.quality[k + 2]});
  restore_frames(of_another_run ? decltype(s.frames)() : s.frames);
  if (s.peak_pending) peak_ = take_frame();  // see before_checkpoint
}

}  // namespace berm
