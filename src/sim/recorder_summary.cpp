/// What a run comes to: energies, metrics, summary.json.
#include <algorithm>
#include <cmath>

#include "bc/case_lookup.hpp"
#include "mesh/region.hpp"
#include "sim/recorder.hpp"
#include "transfer/mpm.hpp"

namespace berm {

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

/// Of what has come in from outside and what is there, the larger: of work that is taken out again something is left to
/// compare with.
double Recorder::energy_now(double stored, double dissipated) const {
  const Balance& b = step_.balance();
  return std::max({std::abs(b.external_work), b.kinetic_at_start, b.kinetic + stored + dissipated});
}

/// |W_ext + KE_0 - KE - W_el - W_diss - W_damp - W_transfer - W_contact| over the largest energy so far.   [dynamics (18)]
double Recorder::energy_error(double stored, double dissipated) const {
  const Balance& b = step_.balance();
  const double size = std::max(largest_energy_, energy_now(stored, dissipated));
  const double missing = b.external_work + b.kinetic_at_start - b.kinetic - stored - dissipated - b.damped -
                         b.transferred - b.contact_work;
  return size == 0.0 ? 0.0 : std::abs(missing) / size;
}

/// Forces below the smallest that mean something, along the way that the bodies went, as in a rotation without strain.
bool Recorder::energy_is_rounding() const {
  constexpr double smallest = 1e-10;  // of the elastic scale
  double farthest = 0.0;
  for (const Vec3& u : world_.discretisation->point_displacements()) farthest = std::max(farthest, u.norm());
  const auto& bodies = world_.spec.bodies;
  const bool of_rigid = std::any_of(bodies.begin(), bodies.end(), [&](const Body& b) { return b.name == world_.spec.output.nominal.displacement; });
  for (std::size_t k = 0; k < rows_.size() && !of_rigid; k += n_columns_) farthest = std::max(farthest, std::abs(rows_[k + displacement_column]));  // and back again
  return largest_energy_ <= smallest * world_.elastic_scale * world_.comm.max(farthest);
}

EnergyLoss Recorder::energy_loss() const {
  constexpr double sizeable = 0.01;  // of the largest energy: less says nothing
  EnergyLoss loss;
  if (rows_.size() < 2 * std::size_t(n_columns_)) return loss;
  const double* first = rows_.data() + n_columns_;
  if (std::abs(first[work_column]) >= sizeable * largest_energy_) loss.first = first[energy_error_column];
  double before = 0.0, scale = 0.0, jump = 0.0;
  for (std::size_t k = 0; k < rows_.size(); k += n_columns_) {
    const double* row = rows_.data() + k;
    scale = std::max({scale, std::abs(row[work_column]), row[work_column + 1] + row[work_column + 2]});
    const double missing = row[energy_error_column] * scale;
    if (missing - before > jump) jump = missing - before, loss.time = row[1];
    before = missing;
  }
  loss.largest = before > 0.0 ? jump / before : 0.0;
  return loss;
}

double Recorder::quality_at(double load, double Quality::*value) const {
  const auto nearest = std::min_element(quality_.begin(), quality_.end(), [&](const Quality& a, const Quality& b) {
    return std::abs(a.load - load) < std::abs(b.load - load);
  });
  return nearest == quality_.end() ? std::nan("") : (*nearest).*value;
}

/// Of the nominal curve; none without a load.
std::vector<std::pair<std::string, double>> Recorder::load_metrics() const {
  const Nominal& n = world_.spec.output.nominal;
  if (n.load.empty()) return {};
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

  std::vector<std::pair<std::string, double>> list = {{"peak_load [N]", load}, {"peak_stress [Pa]", load / n.area}};
  if (!n.displacement.empty()) {
    list.emplace_back("displacement_at_peak [m]", curve[peak].displacement);
    if (std::isfinite(stiffness)) list.emplace_back("stiffness_10_40 [Pa]", stiffness);
  }
  if (load > 0.0) {
    list.emplace_back("stress_noise [-]", quality_at(0.5 * load, &Quality::noise));
    list.emplace_back("stress_error [-]", quality_at(0.5 * load, &Quality::error));
  }
  return list;
}

/// What means nothing for a case is left out.
std::vector<std::pair<std::string, double>> Recorder::metrics() const {
  const double stored = stored_energy(), dissipated = dissipated_energy();
  const MaterialState& m = world_.discretisation->material;
  std::vector<std::pair<std::string, double>> list = load_metrics();
  if (!energy_is_rounding()) list.emplace_back("energy_error [-]", energy_error(stored, dissipated));
  list.emplace_back("dissipated_energy [J]", dissipated);
  if (any_law(world_.spec, is_damage)) list.emplace_back("max_damage [-]", world_.comm.max(m.max_damage()));
  list.emplace_back("cut_steps [-]", double(cut_steps_));
  list.emplace_back("newton_iterations [-]", double(newton_iterations_));
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(world_.discretisation.get());
  list.emplace_back("points_lost [-]", double(mpm ? mpm->points_made() - world_.n_points() : 0));
  if (m.has_plasticity()) list.emplace_back("max_plastic_strain [-]", world_.comm.max(m.max_plastic_strain()));
  if (const double error = largest_extrapolation_error(); error > 0.0)
    list.emplace_back("extrapolation_error [-]", error);
  if (watched_.penetration > 0.0) list.emplace_back("penetration [m]", watched_.penetration);
  if (watched_.swelling > 1.0 + 1e-9) list.emplace_back("swelling [-]", watched_.swelling);
  if (watched_.columns > 0.0) list.emplace_back("crack_columns [-]", watched_.columns);
  if (watched_.jumps > 0.0) list.emplace_back("reaction_jump [-]", watched_.jump);
  if (gap_scatter_ > 0.0) list.emplace_back("contact_gap_scatter [m]", gap_scatter_);
  return list;
}

/// Of all IMPL-EX steps: [damage (11a)].
double Recorder::largest_extrapolation_error() const {
  double largest = 0.0;
  for (std::size_t k = 0; k < rows_.size(); k += n_columns_)
    if (rows_[k + error_column + 1] == static_cast<int>(Integration::impl_ex))
      largest = std::max(largest, rows_[k + error_column]);
  return largest;
}

void Recorder::finish(const std::string& status, const std::string& reason, double wall_seconds, const Origin& origin) {
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
  s.origin = origin;
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
      auto& rings = summary.body_rings[b.name] = region.plane()->rings();
      for (auto& ring : rings)
        for (Vec2& x : ring) x += in_plane(world_.spec.origin);
      continue;
    }
    const TriangleSurface& surface = region.solid()->surface();
    VtuData data;
    data.points = surface.vertices;
    for (Vec3& x : data.points) x += world_.spec.origin;
    for (const auto& triangle : surface.triangles) {
      data.connectivity.insert(data.connectivity.end(), triangle.begin(), triangle.end());
      data.offsets.push_back(static_cast<int>(data.connectivity.size()));
      data.types.push_back(vtk_triangle);
    }
    summary.body_surfaces[b.name] = "surface_" + b.name + ".vtu";
    write_vtu((folder_ / summary.body_surfaces[b.name]).string(), data);
  }
}

}  // namespace berm
