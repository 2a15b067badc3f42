/// What Watch looks for in the material itself: soil that swells, strains that small strain does not see, cracks that are smeared.

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/cube.hpp"
#include "base/error.hpp"
#include "bc/case_lookup.hpp"
#include "sim/advice.hpp"
#include "sim/watch.hpp"

namespace berm {
namespace {

bool dilates(const AnyLaw& law) {
  if (const auto* soil = std::get_if<MohrCoulomb>(&law)) return soil->dilatancy_angle > 0.0;
  if (const auto* soil = std::get_if<DruckerPrager>(&law)) return soil->dilatancy_angle > 0.0;
  return false;
}

}  // namespace

/// Dilatancy does not end by itself.
void Watch::look_for_swelling() {
  constexpr double told = 1.1;
  const MaterialState& m = world_.discretisation->material;
  for (const Slice& slice : m.slices) {
    if (!dilates(slice.law)) continue;
    double before = 0.0, now = 0.0, most = 0.0;
    for (int p = slice.begin; p < slice.end; ++p) {
      const double J = m.F[p].determinant();
      before += m.volume[p], now += J * m.volume[p], most = std::max(most, J);
    }
    before = world_.comm.sum(before), now = world_.comm.sum(now), most = world_.comm.max(most);
    seen.swelling = std::max(seen.swelling, now / before);
    if (now < told * before || has_told("swelling")) continue;
    tell_once("swelling", fmt::format("\"{}\" has swollen to {:.3g} times its volume at time {:.6g}, a point to {:.3g} times: dilatancy does not end by itself{}",
                      world_.spec.bodies[slice.body].name, now / before, world_.time, most, advice_on_dilatancy(slice.law)));
  }
}

/// What small strain leaves out is of the second order in the strains and rotations of a body as a whole. Bands and cracks, where
/// they are large, are its own business.
void Watch::look_for_large_motion() {
  constexpr double told = 0.1, absurd = 2.0;
  if (world_.spec.kinematics != Kinematics::small) return;
  const MaterialState& m = world_.discretisation->material;
  for (const Slice& slice : m.slices) {
    double sum = 0.0, volume = 0.0;
    for (int p = slice.begin; p < slice.end; ++p) sum += m.volume[p] * (m.F[p] - Mat3::Identity()).norm(), volume += m.volume[p];
    sum = world_.comm.sum(sum), volume = world_.comm.sum(volume);
    if (!(sum > told * volume)) continue;
    const std::string text = fmt::format("strains and rotations of body \"{}\" are {:.2g} in the mean at time {:.6g}", world_.spec.bodies[slice.body].name, sum / volume, world_.time);
    if (sum > absurd * volume && !is_damage(slice.law))  // pieces that have broken off may go anywhere
      throw RunError(text + ", of which small strain knows nothing: the load is more than can be borne, or take [model] kinematics = \"finite\"");
    tell_once("motion", text + ": small strain neglects their squares. Take [model] kinematics = \"finite\"");
  }
}

/// A crack of a law with a crack band is a column of cells. Where a uniform zone softens, nothing says which: many do side by
/// side and each takes up the energy of a crack. Energies of points in tension in boxes of a cell, summed across the crack.
void Watch::look_for_smeared_cracks() {
  if (!any_law(world_.spec, is_damage)) return;
  constexpr int reach = 5;
  constexpr double told = 3.0, little = 0.05;  // of the fracture energy
  struct CellEnergy {
    double energy = 0.0;
    Vec3 across = Vec3::Zero();
  };
  const Discretisation& d = *world_.discretisation;
  const MaterialState& m = d.material;
  const double h = d.cell_size();
  const std::vector<double> released = m.released_energy_fraction();
  const std::vector<Vec3> X = d.point_origins();
  std::vector<std::array<double, 5>> mine;  // box, energy, axis across
  std::map<Cube, CellEnergy> boxes;
  for (int p = 0; p < m.size(); ++p) {
    if (released[p] < little) continue;
    Voigt strain = m.strain[p];
    for (const int shear : {XY, YZ, ZX}) strain[shear] *= 0.5;
    const Eigen::SelfAdjointEigenSolver<Mat3> principal(response_detail::tensor(strain));
    if (principal.eigenvalues()[2] < -principal.eigenvalues()[0]) continue;  // crushed
    CellEnergy& box = boxes[cube_of(X[p], h)];
    box.energy += released[p] * m.volume[p];
    box.across += released[p] * m.volume[p] * principal.eigenvectors().col(2).cwiseAbs();
  }
  for (const auto& [at, box] : boxes) {
    int axis = 0;
    box.across.maxCoeff(&axis);
    mine.push_back({double(at[0]), double(at[1]), double(at[2]), box.energy, double(axis)});
  }
  std::map<Cube, std::pair<double, int>> all;
  for (const auto& [x, y, z, energy, axis] : world_.comm.all_gather(mine)) {
    auto& box = all[{std::lround(x), std::lround(y), std::lround(z)}];
    if (energy > 0.5 * box.first) box.second = static_cast<int>(axis);
    box.first += energy;
  }
  // All cells side by side are a zone of uniform stress too where there are few. Points are a part of a cell from the ends.
  Vec3 low = Vec3::Constant(infinity), high = -low, most;
  for (const Vec3& x : X) low = low.cwiseMin(x), high = high.cwiseMax(x);
  for (int i = 0; i < 3; ++i) {
    const double cells = std::ceil((world_.comm.max(high[i]) - world_.comm.min(low[i])) / h + 0.2);
    most[i] = cells > 1.0 ? std::min(told, 0.9 * cells) : told;
  }
  double sum = 0.0, columns = 0.0, allowed = 0.0, widest = 0.0;
  Vec3 where = Vec3::Zero();
  for (const auto& [at, box] : all) {
    double across = 0.0, largest = 0.0;
    for (int k = -reach; k <= reach; ++k) {
      std::array<long, 3> beside = at;
      beside[box.second] += k;
      const auto found = all.find(beside);
      if (found == all.end()) continue;
      across += found->second.first, largest = std::max(largest, found->second.first);
    }
    sum += box.first, columns += box.first * across / largest, allowed += box.first * most[box.second];
    if (across / largest > widest) widest = across / largest, where = h * Vec3(at[0] + 0.5, at[1] + 0.5, world_.spec.dimension() == 3 ? at[2] + 0.5 : 0.0);
  }
  if (sum <= 0.0) return;
  seen.columns = std::max(seen.columns, columns / sum);
  if (columns <= allowed || has_told("smeared")) return;
  tell_once("smeared", fmt::format("cracks are smeared over {:.2g} cells side by side in the mean at time {:.6g}, most near {}: a zone of uniform stress softens "
                    "as a whole and takes up the energy of as many cracks. Say where the crack begins: a notch, or a body one cell wide of a "
                    "material with a tensile strength a few per cent lower",
                    columns / sum, world_.time, place_text(world_.spec, where)));
}

/// What loads and supports do not hold of the pressure with which points of Cam-Clay start, lets a body swell in the first step.
void Watch::look_for_lost_pressure() {
  constexpr double lost = 0.5;
  const MaterialState& m = world_.discretisation->material;
  for (const Slice& slice : m.slices) {
    const auto* clay = std::get_if<ModifiedCamClay>(&slice.law);
    if (!clay) continue;
    double sum = 0.0, volume = 0.0;
    for (int p = slice.begin; p < slice.end; ++p) sum -= m.volume[p] * m.stress[p].head<3>().sum() / 3.0, volume += m.volume[p];
    const double pressure = world_.comm.sum(sum) / world_.comm.sum(volume);
    if (pressure >= lost * clay->reference_pressure) continue;
    const std::string& body = world_.spec.bodies[slice.body].name;
    tell_once("pressure", fmt::format("body \"{0}\" starts at the reference_pressure of its material, {1:.4g} Pa, and is at {2:.3g} Pa in the mean after the first step: loads and "
                      "supports do not hold it, and it swells. Let a [pressure.NAME] act on its free faces from the start (value = \"{1:.4g} + 0*t\"), or let it "
                      "start at less",
                      body, clay->reference_pressure, pressure));
  }
}

}  // namespace berm
