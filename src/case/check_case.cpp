/// Checks across tables.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "base/error.hpp"
#include "case/petsc_options.hpp"
#include "case/tables.hpp"

namespace berm {
namespace {

template <class T>
std::vector<std::string> names_of(const std::vector<T>& items) {
  std::vector<std::string> names;
  for (const T& item : items) names.push_back(item.name);
  return names;
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

class Checker {
public:
  Checker(const Case& c, Node& root, Problems& problems, bool allow_petsc_files)
      : c_(c), root_{problems, root, "", {c.file.string(), "", 0, 0}}, allow_petsc_files_(allow_petsc_files) {}

  void run() {
    check_bodies();
    check_loads();
    check_control();
    check_nominal();
    check_groups();
    check_radii();
    check_integration();
    check_stages();
    check_petsc();
    check_fluids();
    check_plane_stress();
    check_volumetric();
    check_quadrature();
    check_placement();
  }

private:
  /// The table [kind.name], or [kind] if name is empty.
  Scope at(const std::string& kind, const std::string& name = "") const {
    Node::Entry* entry = root_.node.find(kind);
    std::string path = kind;
    if (entry && !name.empty()) {
      entry = entry->value.find(name);
      path += "." + name;
    }
    return entry ? Scope{root_.problems, entry->value, path, entry->value.place} : root_;
  }

  void fail(const std::string& text) const { root_.problems.error(root_.place, text); }

  /// `key` of [kind.name] must be one of the names.
  void refer(const Scope& scope, std::string_view key, const std::string& name, const std::string& what,
             const std::vector<std::string>& names) const {
    if (name.empty() || holds(names, name)) return;
    scope.explain(key, fmt::format("no {} \"{}\"{}", what, name, suggestion(name, names)));
  }

  void refer_body(const Scope& scope, std::string_view key, const std::string& name, bool rigid) const {
    std::vector<std::string> fitting;
    for (const Body& body : c_.bodies) {
      if (body.rigid == rigid) fitting.push_back(body.name);
      if (body.rigid == rigid || body.name != name) continue;
      return scope.explain(key, fmt::format("body \"{}\" is {}; a {} one is needed", name,
                                            rigid ? "deformable" : "rigid", rigid ? "rigid" : "deformable"));
    }
    refer(scope, key, name, rigid ? "rigid body" : "deformable body", fitting);
  }

  void check_body(const Body& body) const {
    const Scope scope = at("body", body.name);
    refer(scope, "material", body.material, "material", names_of(c_.materials));
    if (body.rigid) return;
    const Node::Entry* points = scope.node.find("points");
    if (c_.method == Method::mpm && !body.mesh_file.empty() && !(points && points->value.find("per_element"))) {
      scope.missing("points.per_element", "Gauss points of an element of the file; e.g. points = { per_element = 4 }");
    }
    if (c_.method == Method::fem && body.shape && !scope.has("mesh")) {
      scope.missing("mesh", fmt::format("method \"fem\" meshes the body; e.g. mesh = {{ kind = \"{}\", size = 0.01 }}",
                                        c_.dimension() == 2 ? "quads" : "tetrahedra"));
    }
  }

  void check_bodies() const {
    if (std::none_of(c_.bodies.begin(), c_.bodies.end(), [](const Body& b) { return !b.rigid; })) {
      fail("no deformable body (add a [body.NAME])");
    }
    if (c_.method == Method::mpm && !root_.has("grid"))
      fail("missing table [grid]: method \"mpm\" needs a background grid");
    std::vector<std::string> used;
    for (const Body& body : c_.bodies) {
      used.push_back(body.material);
      check_body(body);
    }
    for (const Material& material : c_.materials) {
      if (holds(used, material.name)) continue;
      const Scope scope = at("material", material.name);
      root_.problems.warn(scope.place, fmt::format("[material.{}] is not used by any body", material.name));
    }
  }

  void check_loads() const {
    for (const NodeBoundary& b : c_.boundaries)
      if (!b.body.empty()) refer_body(at("boundary", b.name), "body", b.body, false);
    for (const Pin& pin : c_.pins) refer_body(at("pin", pin.name), "body", pin.body, false);
    for (const Pressure& p : c_.pressures) refer_body(at("pressure", p.name), "body", p.body, false);
    for (const Absorbing& a : c_.absorbing) refer_body(at("absorbing", a.name), "body", a.body, false);
    check_pairs();
    for (const Contact& contact : c_.contacts) {
      const Scope scope = at("contact", contact.name);
      refer_body(scope, "body", contact.body, false);
      if (contact.other.empty()) {
        refer_body(scope, "rigid", contact.rigid, true);
        continue;
      }
      refer_body(scope, "other", contact.other, false);
      if (c_.method == Method::fem && contact.kind != Contact::Kind::tie)
        scope.error("other", "needs a background grid (method \"mpm\") unless kind = \"tie\"");
    }
  }

  /// Two contacts of the same two bodies at once would push twice.
  void check_pairs() const {
    const auto pair = [](const Contact& c) {  // of rigid bodies the name cannot be that of a deformable one
      const std::string& other = c.other.empty() ? c.rigid : c.other;
      return std::pair(std::min(c.body, other), std::max(c.body, other));
    };
    for (std::size_t k = 0; k < c_.contacts.size(); ++k)
      for (std::size_t i = 0; i < k; ++i) {
        const Contact &first = c_.contacts[i], &second = c_.contacts[k];
        if (pair(first) != pair(second)) continue;
        if (first.stages.empty() || second.stages.empty() ||
            std::find_first_of(first.stages.begin(), first.stages.end(), second.stages.begin(), second.stages.end()) !=
                first.stages.end())
          at("contact", second.name)
              .explain(second.other.empty() ? "rigid" : "other",
                       fmt::format("[contact.{}] is for the same two bodies already; give them different stages",
                                   first.name));
      }
  }

  void check_control() const {
    if (c_.control.kind != Control::Kind::gauge) return;
    const Scope scope = at("control");
    if (c_.stages.size() > 1 || c_.is_dynamic())
      scope.error("kind", "may be \"gauge\" only in a run of one quasi-static stage");
    refer(scope, "gauge", c_.control.gauge, "gauge", names_of(c_.output.gauges));
    if (c_.pressures.empty()) scope.error("kind", "needs a load to scale (add a [pressure.NAME])");
  }

  void check_nominal() const {
    const Nominal& nominal = c_.output.nominal;
    const Node::Entry* output = root_.node.find("output");
    if (!output || !output->value.find("nominal")) return;
    Node::Entry* entry = at("output").node.find("nominal");
    const Scope scope{root_.problems, entry->value, "output.nominal", entry->value.place};
    std::vector<std::string> sources = names_of(c_.boundaries);
    for (const Body& body : c_.bodies) {
      if (body.rigid) sources.push_back(body.name);
    }
    for (const std::string& name : nominal.load)
      refer_one(scope, "load", name, "rigid body, boundary or pressure", sources, names_of(c_.pressures));
    if (std::set<std::string>(nominal.load.begin(), nominal.load.end()).size() < nominal.load.size())
      scope.explain("load", "names something twice, whose force would count twice");
    refer_one(scope, "displacement", nominal.displacement, "rigid body, boundary or gauge", sources,
              names_of(c_.output.gauges));
    for (const NodeBoundary& b : c_.boundaries)
      if (b.name == nominal.displacement && !b.body.empty() && !b.normal && b.slides())
        scope.explain("displacement", fmt::format("boundary \"{}\" moves along the normals of its surface, which differ from "
                                                  "place to place; give it a normal, or take a gauge",
                                                  b.name));
    for (const NodeBoundary& b : c_.boundaries)
      if (b.name == nominal.displacement && b.depends_on_place())
        scope.explain("displacement", fmt::format("the displacement of boundary \"{}\" differs from node to node; take "
                                                  "a gauge",
                                                  b.name));
  }

  /// Like refer(), and the name may mean one thing only.
  void refer_one(const Scope& scope, std::string_view key, const std::string& name, const std::string& what,
                 std::vector<std::string> names, const std::vector<std::string>& more) const {
    names.insert(names.end(), more.begin(), more.end());
    refer(scope, key, name, what, names);
    if (std::count(names.begin(), names.end(), name) > 1) {
      scope.explain(key, fmt::format("\"{}\" is the name of more than one {}", name, what));
    }
  }

  void check_group(const Scope& scope, const Where& where) const {
    if (!where.group) return;
    const bool grid_file = std::holds_alternative<std::string>(c_.grid);
    const bool body_file =
        std::any_of(c_.bodies.begin(), c_.bodies.end(), [](const Body& b) { return !b.mesh_file.empty(); });
    if (grid_file || body_file) return;
    scope.explain("where", "a group needs a grid or a body from a Gmsh file");
  }

  void check_groups() const {
    for (const NodeBoundary& b : c_.boundaries) check_group(at("boundary", b.name), b.where);
    for (const Pressure& p : c_.pressures) check_group(at("pressure", p.name), p.where);
    for (const Absorbing& a : c_.absorbing) check_group(at("absorbing", a.name), a.where);
  }

  /// Reports a radius smaller than zero, beyond rounding. `scale`: how large what is looked at is.
  static void check_radius(const Scope& scope, std::string_view key, std::string_view what, double x, double scale) {
    if (x >= -1e-9 * scale) return;
    scope.explain(
        key,
        fmt::format("the radius x must not be negative in an axisymmetric model; {} reaches x = {:.6g} m", what, x));
  }

  void check_shape_radius(const Body& body) const {
    const PlaneShape* shape = body.shape ? std::get_if<PlaneShape>(&*body.shape) : nullptr;
    if (!shape) return;
    try {
      const PlaneRegion region(*shape);
      const double scale = region.min().cwiseAbs().cwiseMax(region.max().cwiseAbs()).maxCoeff();
      check_radius(at("body", body.name), "shape", "the shape", region.min().x(), scale);
    } catch (const InputError&) {  // the table of bodies has told what is wrong with the shape
    }
  }

  void check_radii() const {
    if (c_.space != Space::axisymmetric) return;
    for (const Body& body : c_.bodies) check_shape_radius(body);
    const StructuredGrid* grid = std::get_if<StructuredGrid>(&c_.grid);
    if (!grid || grid->nx == 0) return;
    const Vec3 size = grid->cell_size.cwiseProduct(Vec3(grid->nx, grid->ny, 0.0));
    double x = infinity;
    for (const Vec3& corner : {Vec3(0.0, 0.0, 0.0), Vec3(size.x(), 0.0, 0.0), Vec3(0.0, size.y(), 0.0), size}) {
      const Vec3 p = grid->origin + corner;
      x = std::min(x, std::cos(grid->angle) * p.x() - std::sin(grid->angle) * p.y());
    }
    check_radius(at("grid"), "origin", "the grid", x, grid->origin.norm() + size.norm());
  }

  /// A cell with one pressure and no shear stiffness has nothing against hourglass modes: a tank does not stay at rest.
  void check_fluids() const {
    if (c_.volumetric != Volumetric::f_bar) return;
    for (const Material& m : c_.materials)
      if (std::holds_alternative<Newtonian>(m.law))
        at("model").warn("volumetric", fmt::format("\"f_bar\" leaves the fluid \"{}\" without resistance to hourglass "
                                                   "modes: take \"standard\"",
                                                   m.name));
  }

  void check_plane_stress() const {
    if (c_.space != Space::plane_stress) return;
    for (const Material& m : c_.materials)
      if (!knows_plane_stress(m.law))
        at("material", m.name)
            .explain("law", "is for plane strain, axisymmetric models and space, not for plane stress");
  }

  void check_placement() const {
    if (!has_domains(c_.shape_functions)) return;
    for (const Body& body : c_.bodies)
      if (body.points.placement == PointSeeding::Placement::gauss)
        at("body", body.name)
            .explain("points", "placement = \"gauss\" does not go with grid.shape_functions whose points have domains (gimp, "
                               "cpdi): these would overlap");
  }

  void check_volumetric() const {
    if (c_.volumetric == Volumetric::standard) return;
    const bool mixed = c_.volumetric == Volumetric::mixed;
    const auto refuse = [&](const char* why) {
      at("model").explain("volumetric", fmt::format("\"{}\" {}", mixed ? "mixed" : "f_bar", why));
    };
    if (c_.method == Method::fem)
      return refuse("is for method \"mpm\"; against locking finite elements have mesh = { ..., order = 2 }");
    if (c_.space == Space::plane_stress)
      return refuse("is not for plane stress, where nothing locks: the thickness is free to change");
    const auto* grid = std::get_if<StructuredGrid>(&c_.grid);
    const bool simplices = grid && grid->kind != GridKind::quads && grid->kind != GridKind::hexahedra;
    if (mixed && simplices && c_.moves_with_finite_strain_updated()) refuse(mixed_on_moving_simplices);
    if (mixed) return check_mixed();
    if (simplices)
      refuse(
          "needs a grid of quads or hexahedra: the strain of a linear triangle or tetrahedron is uniform already "
          "(\"mixed\" helps there as long as nothing moves)");
  }

  void check_quadrature() const {
    if (c_.quadrature == Quadrature::points) return;
    const auto refuse = [&](const char* why) { at("model").explain("quadrature", fmt::format("\"gauss\" {}", why)); };
    if (c_.method == Method::fem) refuse("is for method \"mpm\": finite elements have no other points");
    if (c_.volumetric != Volumetric::standard) refuse("goes with volumetric = \"standard\" only");
    if (c_.space == Space::axisymmetric) refuse("is for plane models and space, not for axisymmetric ones");
    if (c_.shape_functions != ShapeFunctions::linear)
      refuse("is for grid.shape_functions = \"linear\": a linear stress leaves modes of B-splines without stiffness, and domains "
             "integrate evenly by themselves");
  }

  /// What has pressures among its unknowns is solved directly, and the equation of volumes is no equation of motion.
  void check_mixed() const {
    for (const Material& m : c_.materials) {
      const bool fits = std::holds_alternative<LinearElastic>(m.law) || std::holds_alternative<NeoHookean>(m.law) ||
                        (is_plastic(m.law) && elastic_constants(m.law));
      if (!fits)
        at("material", m.name)
            .explain("law", "does not go with model.volumetric = \"mixed\", which is for elastic and plastic laws with "
                            "constant elastic moduli");
    }
    if (c_.shape_functions != ShapeFunctions::linear)
      at("grid").explain("shape_functions", "model.volumetric = \"mixed\" is for linear ones; others: \"f_bar\"");
    if (c_.control.kind == Control::Kind::gauge)
      at("control").explain("gauge", "does not go with model.volumetric = \"mixed\"");
    for (const Stage& stage : c_.stages) {
      const Scope solver = part_of(stage, "solver"), dynamics = part_of(stage, "dynamics");
      if (stage.solver.linear == Solver::Linear::iterative)
        solver.explain("linear", "must be \"direct\" or \"automatic\" where model.volumetric = \"mixed\": pressures are among the unknowns");
      if (stage.steps.analysis != Analysis::dynamic) continue;
      if (stage.dynamics.integrator == Dynamics::Integrator::hht)
        dynamics.explain("integrator", "\"hht\" weighs forces of two instants, which model.volumetric = \"mixed\" does "
                                       "not have for volumes: \"newmark\" or \"bossak\"");
      if (stage.dynamics.rayleigh_stiffness > 0.0)
        dynamics.explain("rayleigh_stiffness", "does not go with model.volumetric = \"mixed\": take rayleigh_mass");
    }
  }

  /// Only damage can be extrapolated.
  void check_integration() const {
    for (const Material& m : c_.materials) {
      if (!is_plastic(m.law)) continue;
      const std::string why =
          fmt::format("material \"{}\" has a law of plasticity, which is always integrated implicitly", m.name);
      for (const Stage& stage : c_.stages) {
        const Scope scope = part_of(stage, "solver");
        if (stage.solver.integration != Integration::implicit) scope.explain("integration", why);
        if (stage.solver.snap_back == Solver::SnapBack::impl_ex) scope.explain("snap_back", why);
      }
      return;
    }
  }

  /// "solver" or "dynamics" of a stage.
  Scope part_of(const Stage& stage, const std::string& key) const {
    if (stage.name.empty()) return at(key);
    Node::Entry* part = at("stage", stage.name).node.find(key);
    return {root_.problems, part->value, "stage." + stage.name + "." + key, part->value.place};
  }

  template <class T>
  void check_names_of_stages(const std::string& kind, const std::vector<T>& items) const {
    for (const T& item : items) {
      const Scope scope = at(kind, item.name);
      if (scope.has("stages") && item.stages.empty())
        scope.error("stages", "must not be empty: it acts in all stages without it");
      for (const std::string& name : item.stages) {
        if (c_.stages.size() == 1 && c_.stages.front().name.empty())
          return scope.explain("stages", "this run has no stages (add a [stage.NAME] for each)");
        refer(scope, "stages", name, "stage", names_of(c_.stages));
      }
    }
  }

  bool moves_in(const Stages& stages) const {
    return std::any_of(c_.stages.begin(), c_.stages.end(), [&](const Stage& s) {
      return s.steps.analysis == Analysis::dynamic && (stages.empty() || holds(stages, s.name));
    });
  }

  /// Motion that begins with a jump.
  void check_starts() const {
    if (c_.stages.front().steps.analysis != Analysis::dynamic) return;
    const auto look = [](const Scope& scope, const std::string& key, const TimeFunction& f) {
      if (f.is_number() || f.depends_on_place()) return;
      if (const double start = f.at(0.0); std::abs(start) > no_jump)
        scope.explain(key, fmt::format("\"{0}\" is {1:.4g} at t = 0: where the first stage is dynamic a displacement begins with 0; take "
                                       "\"{0} - ({1:.17g})\"",
                                       f.text(), start));
    };
    constexpr std::array<const char*, 3> keys = {"ux", "uy", "uz"};
    for (const NodeBoundary& b : c_.boundaries) {
      if (!b.stages.empty() && !holds(b.stages, c_.stages.front().name)) continue;
      for (std::size_t i = 0; i < keys.size(); ++i)
        if (b.u[i]) look(at("boundary", b.name), keys[i], *b.u[i]);
      look(at("boundary", b.name), "un", b.un);
    }
    for (const Body& b : c_.bodies)
      for (const TimeFunction& f : b.displacement.component) look(at("body", b.name), "displacement", f);
  }

  /// What would be read and never used.
  void check_motion() const {
    for (const Stage& stage : c_.stages)
      if (c_.method == Method::fem && stage.dynamics.projection_order > 1)
        part_of(stage, "dynamics").explain("projection_order", "is for method \"mpm\": finite elements keep their motion at nodes");
    for (const Body& b : c_.bodies)
      if (!b.velocity.is_zero() && c_.stages.front().steps.analysis != Analysis::dynamic)
        at("body", b.name)
            .explain("velocity",
                     "is of the start of the run: the first stage (or [steps]) needs analysis = \"dynamic\"");
    for (const Absorbing& a : c_.absorbing) {
      const Scope scope = at("absorbing", a.name);
      if (!moves_in(a.stages))
        scope.explain(a.stages.empty() ? "body" : "stages",
                      "dashpots act in motion: none of its stages has analysis = \"dynamic\"");
      if (a.s_wave_speed > a.p_wave_speed) scope.error("s_wave_speed", "must not be larger than \"p_wave_speed\"");
    }
    for (const Stage& s : c_.stages)
      if (s.dynamics.error_tolerance > 0.0 && !s.steps.adaptive && s.steps.analysis == Analysis::dynamic)
        part_of(s, "dynamics").explain("error_tolerance", "needs steps that may change: adaptive = true");
  }

  /// A number is reached at the end of the first stage: what begins to act later would not move.
  void check_late_motions() const {
    if (c_.stages.size() < 2) return;
    for (const NodeBoundary& b : c_.boundaries) {
      if (b.stages.empty() || holds(b.stages, c_.stages.front().name)) continue;
      const Scope scope = at("boundary", b.name);
      const auto look = [&](const char* key, const TimeFunction& f) {
        if (f.is_number() && !f.is_zero())
          scope.explain(key, fmt::format("a number is reached at the end of the first stage, \"{}\", in which this "
                                         "boundary does not act: give an expression of t",
                                         c_.stages.front().name));
      };
      constexpr std::array<const char*, 3> keys = {"ux", "uy", "uz"};
      for (std::size_t i = 0; i < keys.size(); ++i)
        if (b.u[i]) look(keys[i], *b.u[i]);
      look("un", b.un);
    }
  }

  /// What belongs to the whole run; what acts in some stages only.
  void check_stages() const {
    check_names_of_stages("boundary", c_.boundaries);
    check_names_of_stages("pin", c_.pins);
    check_names_of_stages("pressure", c_.pressures);
    check_names_of_stages("absorbing", c_.absorbing);
    check_names_of_stages("contact", c_.contacts);
    check_motion();
    check_starts();
    check_late_motions();
    for (const Stage& stage : c_.stages) {
      if (stage.solver.ghost_penalty != c_.solver.ghost_penalty)
        part_of(stage, "solver").explain("ghost_penalty", "must be the same in all stages: say it in [solver]");
      if (stage.solver.petsc != c_.solver.petsc)
        part_of(stage, "solver").explain("petsc", "must be the same in all stages: say it in [solver]");
    }
  }

  void check_petsc() const {
    if (const std::string why = problem_of_petsc(c_.solver.petsc, allow_petsc_files_); !why.empty())
      at("solver").explain("petsc", why);
  }

  const Case& c_;
  Scope root_;
  bool allow_petsc_files_;
};

}  // namespace

void check_case(const Case& c, Node& root, Problems& problems, bool allow_petsc_files) {
  Checker(c, root, problems, allow_petsc_files).run();
}

}  // namespace berm
