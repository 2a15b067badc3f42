#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <span>

#include "base/error.hpp"
#include "bc/case_lookup.hpp"
#include "fem/fem.hpp"
#include "io/log.hpp"
#include "la/newton.hpp"
#include "law/kinds.hpp"
#include "sim/advice.hpp"
#include "sim/world.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

/// Bytes of the linear solver. Nested dissection leaves about 31/2 n log2 n entries in the factors in the plane (George 1973) and
/// some n^(4/3) in space; what MUMPS works in comes to it. With multigrid: the matrix and its coarse levels. Factors measured on
/// nine examples, to a tenth (bench/README.md).
double solver_bytes(const World& w, long unknowns) {
  const double n = std::max(2L, unknowns);
  if (w.spec.dimension() == 2) return 1.5 * 31.0 / 2.0 * n * std::log2(n) * sizeof(double);
  using Linear = Solver::Linear;
  const Linear wish = w.spec.solver.linear;
  const bool direct = wish == Linear::direct || wish == Linear::distributed || (wish == Linear::automatic && n <= largest_direct_in_space);
  return direct ? 870.0 * std::pow(n, 4.0 / 3.0) : n * (w.spec.method == Method::mpm ? 4000.0 : 3000.0);
}

/// Of all processes together.
double memory_bytes(const World& w, long points, long unknowns) {
  constexpr double program = 88e6, per_point = 1500.0;
  return w.comm.size() * (program + grid_bytes(w.spec)) + points * per_point + solver_bytes(w, unknowns);
}

const char* space_text(Space space) {
  switch (space) {
    case Space::plane_strain:
      return "plane strain";
    case Space::plane_stress:
      return "plane stress";
    case Space::axisymmetric:
      return "axisymmetric";
    default:
      return "three-dimensional";
  }
}

/// Seconds of one solution of a linear system on one process, measured like the memory.
double solver_seconds(const World& w, double n) {
  if (w.spec.dimension() == 2) return 1.6e-7 * n * std::log2(std::max(2.0, n));
  return n <= largest_direct_in_space ? 4e-9 * n * n : 11e-6 * n;
}

/// A guess: every step as the case says, none cut, none added.
double run_seconds(const World& w, long points, long unknowns) {
  constexpr double per_point = 3e-6;  // laws and assembly, an iteration
  const bool linear = w.spec.kinematics == Kinematics::small && !any_law(w.spec, [](const AnyLaw& law) { return !std::holds_alternative<LinearElastic>(law); });
  double seconds = 0.0;
  for (const Stage& s : w.spec.stages) {
    const double iterations = linear ? 1.0 : s.solver.integration == Integration::impl_ex ? 1.5 : 4.0;
    seconds += s.steps.count * iterations * (per_point * points / w.comm.size() + solver_seconds(w, unknowns));
  }
  return seconds;
}

std::string vector_text(const Vec3& v, int dimension) {
  // Sums that cancel leave rounding.
  const double least = 1e-9 * v.norm();
  std::vector<double> parts;
  for (int i = 0; i < dimension; ++i) parts.push_back(std::abs(v[i]) > least ? v[i] : 0.0);
  return fmt::format("({:.4g})", fmt::join(parts, ", "));
}

/// A load; around an axis only what it does along the axis means something.
std::string resultant_text(const Case& c, const Vec3& force, Vec3 moment, double cell_size) {
  const int d = c.dimension();
  const std::string text = vector_text(force, d) + " N";
  if (c.space == Space::axisymmetric) return text;
  if (moment.norm() < 1e-9 * force.norm() * cell_size) moment.setZero();
  const Vec3 m = moment + c.origin.cross(force);
  return fmt::format("{}, moment about the origin {} N m", text, d == 3 ? vector_text(m, 3) : fmt::format("{:.4g}", m.z()));
}

/// What one boundary holds in the first stage.
struct Held {
  long nodes = 0, surface = 0;
  std::array<bool, 3> along{};
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
};

/// By boundary of the case. Collective.
std::vector<Held> held_by_boundaries(const World& w) {
  std::vector<Held> all(w.spec.boundaries.size());
  std::vector<std::set<std::pair<int, std::array<double, 3>>>> places(all.size());
  for (const auto& hold : w.boundary->holds(*w.discretisation)) {
    if (hold.boundary < 0) continue;
    Held& held = all[hold.boundary];
    for (int i = 0; i < 3; ++i) held.along[i] |= std::abs(hold.direction[i]) > 1e-9;
    held.low = held.low.cwiseMin(hold.at), held.high = held.high.cwiseMax(hold.at);
    if (!places[hold.boundary].insert({hold.node, {hold.at.x(), hold.at.y(), hold.at.z()}}).second) continue;
    ++(hold.node >= 0 ? held.nodes : held.surface);
  }
  for (Held& held : all) {
    held.nodes = w.comm.sum(held.nodes), held.surface = w.comm.sum(held.surface);
    for (int i = 0; i < 3; ++i) {
      held.along[i] = w.comm.any(held.along[i]);
      held.low[i] = w.comm.min(held.low[i]), held.high[i] = w.comm.max(held.high[i]);
    }
  }
  return all;
}

std::string held_text(const World& w, const Held& held, bool idle) {
  const int d = w.spec.dimension();
  if (held.nodes + held.surface == 0) return idle ? "nothing in the first stage" : "what another boundary holds";
  std::string along;
  for (int i = 0; i < d; ++i)
    if (held.along[i]) along += fmt::format("{}{}", along.empty() ? "" : ", ", "xyz"[i]);
  return fmt::format("{} {} along {}, from {} to {}", held.nodes + held.surface, held.nodes > 0 ? "nodes" : "places of the surface", along,
                     place_text(w.spec, held.low), place_text(w.spec, held.high));
}

/// Resultants at the end of the first stage, on bodies where they start. Collective.
std::string loads_text(const World& w) {
  const Discretisation& d = *w.discretisation;
  const double end = w.spec.stages.front().end();
  const NodalVector still(d.n_nodes(), Vec3::Zero());
  std::string text;
  const std::vector<BoundaryConditions::LoadSum> sums = w.boundary->load_sums(end, still);
  for (std::size_t k = 0; k < sums.size(); ++k)
    text += fmt::format("  pressure {:<8} on {:.4g} m2 ({} places), at t = {:.4g}: {}\n", w.spec.pressures[k].name, sums[k].area, sums[k].points,
                        end, resultant_text(w.spec, sums[k].force, sums[k].moment, d.cell_size()));
  if (w.spec.gravity.is_zero()) return text;
  NodalVector f(d.n_nodes(), Vec3::Zero());
  w.comm.agree([&] { d.add_body_force([&](int, const Vec3& x) { return w.spec.gravity.at(end, x); }, f); });
  std::array<double, 6> sum{};
  for (int node = 0; node < d.n_nodes(); ++node) {
    const Vec3 moment = d.nodes[node].cross(f[node]);
    for (int i = 0; i < 3; ++i) sum[i] += f[node][i], sum[3 + i] += moment[i];
  }
  w.comm.sum(std::span<double>(sum));
  return text + fmt::format("  weight            at t = {:.4g}: {}\n", end, resultant_text(w.spec, Vec3(&sum[0]), Vec3(&sum[3]), d.cell_size()));
}

}  // namespace

std::string describe(const World& w) {
  const Discretisation& d = *w.discretisation;
  const bool solid = w.spec.dimension() == 3;
  std::string text;
  auto line = [&](const std::string& s) { text += s + "\n"; };
  line(fmt::format("{}", w.spec.title));
  line(fmt::format("  method            {}, {}, {} strain{}",
                   w.spec.method == Method::fem                          ? "fem"
                   : w.spec.formulation == Formulation::total_lagrangian ? "mpm, total Lagrangian"
                                                                         : "mpm",
                   space_text(w.spec.space), w.spec.kinematics == Kinematics::finite ? "finite" : "small",
                   w.spec.volumetric == Volumetric::f_bar   ? ", F-bar"
                   : w.spec.volumetric == Volumetric::mixed ? ", mixed u-p"
                                                            : ""));
  const char* unit = solid ? "m3" : "m2";
  for (const BodySummary& b : w.bodies)
    line(b.rigid ? fmt::format("  body {:<12} rigid, {:.6g} {}", b.name, b.measure, unit)
                 : fmt::format("  body {:<12} {:.6g} {}, {:.6g} kg, {} points{}", b.name, b.measure, unit, b.mass,
                               b.points, b.elements ? fmt::format(", {} elements", b.elements) : ""));
  for (const Joint& j : w.neighbours.joints)
    line(fmt::format("  joined            \"{}\" and \"{}\" where they touch ({:.3g} m2), {}", w.spec.bodies[j.body].name,
                     w.spec.bodies[j.other].name, j.area(),
                     j.shared_nodes ? "by the nodes of the grid that they share" : "by a tie on their surface"));
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(&d);
  const auto* fem = dynamic_cast<const FemDiscretisation*>(&d);
  const long cells = w.comm.sum(mpm ? long(mpm->active_cells().size()) : long(fem->elements().size()));
  const long points = w.n_points(), unknowns = w.boundary->n_free();
  line(fmt::format("  cells             {} in use, {:.2f} points each", cells, double(points) / cells));
  line(fmt::format("  cell size         {:.6g} m", d.cell_size()));
  if (const auto* grid = std::get_if<StructuredGrid>(&w.spec.grid); mpm && grid && grid->angle != 0.0)
    line(fmt::format("  grid              turned by {:.4g} degrees about the origin of coordinates, not about its own corner", grid->angle * 180.0 / std::numbers::pi));
  line(fmt::format("  unknowns          {}", unknowns));
  if (w.comm.size() > 1)
    line(fmt::format("  processes         {}, the most loaded has {:.2f} times the mean", w.comm.size(),
                     d.most_loaded()));
  line(fmt::format("  memory, estimated {:.0f} MB", memory_bytes(w, points, unknowns) / 1e6));
  line("  time, estimated   " + duration_text(run_seconds(w, points, unknowns)) + ", if no step is cut");
  const std::vector<Held> held = held_by_boundaries(w);
  const std::vector<std::string> idle = w.boundary->idle_boundaries();
  const auto is_idle = [&](const NodeBoundary& b) {
    return !acts_in(b.stages, w.spec.stages.front().name) || std::find(idle.begin(), idle.end(), b.name) != idle.end();
  };
  for (std::size_t b = 0; b < held.size(); ++b)
    line(fmt::format("  boundary {:<8} holds {}", w.spec.boundaries[b].name, held_text(w, held[b], is_idle(w.spec.boundaries[b]))));
  try {
    text += loads_text(w);
  } catch (const RunError& error) {
    line(fmt::format("  loads             not known at the end of the first stage: {}", error.what()));
  }
  for (const Stage& s : w.spec.stages)
    line(fmt::format("  steps             {}{}{}{}", s.steps.count, s.steps.adaptive ? " (adaptive)" : "",
                     s.steps.analysis == Analysis::dynamic ? ", dynamic" : "",
                     s.name.empty() ? "" : ", stage " + s.name));
  if (any_law(w.spec, is_damage))
    line("  cracks            follow the lines of the grid (laws with a crack band): trust their direction only if it stays on a turned grid");
  for (const std::string& note : w.thin_parts) line("  thin              " + note);
  for (const std::string& choice : w.spec.choices) line("  chosen            " + choice);
  return text;
}

}  // namespace berm
