/// Values at places, fitted to the points near them.
#include <fmt/format.h>

#include <algorithm>

#include "sim/recorder.hpp"
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

}  // namespace

std::vector<std::string> Recorder::probe_columns() const {
  std::vector<std::string> names;
  for (const NamedProbe& p : probes_)
    names.push_back(fmt::format("probe:{} [{}]", p.spec.name, unit_of(p.spec.quantity)));
  return names;
}

/// Weights by the places where the points were at the start. All processes know those near a probe. Anew when there are
/// other points, since some have been split.
void Recorder::fit_probes() {
  const Discretisation& d = *world_.discretisation;
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(&d);
  const long points = mpm ? mpm->points_made() : 0;
  if (points == fitted_points_) return;
  fitted_points_ = points;
  probes_.clear();
  const double h = d.cell_size(), reach = 3.0 * std::max(h, longest_edge(d.mesh()));
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

std::vector<double> Recorder::probe_values() {
  fit_probes();
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

}  // namespace berm
