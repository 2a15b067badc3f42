/// What drives the run and what it writes.

#include "case/tables.hpp"

namespace berm {
namespace {

Table<Nominal> nominal_table() {
  Table<Nominal> t("Which load and which displacement make the nominal stress-strain curve.");
  KeyInfo load = plain_info("load", "name or names of rigid bodies, boundaries, pressures", "array",
                            "whose reaction is the load; of several the sum");
  load.json = either_schema(plain_info("", "", "string", "").json, array_schema(plain_info("", "", "string", "").json));
  t.custom(load, [](Scope& s, Node::Entry& e, Nominal& n) {
    if (const auto names = read_one_or_more(s, e)) n.load = *names;
    if (e.value.array() && e.value.array()->empty()) s.error("load", "must not be empty");
  });
  t.name("displacement", &Nominal::displacement, "name of a rigid body, boundary or gauge",
           "whose motion is the imposed displacement");
  t.vector("direction", &Nominal::direction, Unit::none, "both are measured along it; made a unit vector");
  const Range any_size{1e-100, 1e100};
  t.number("area", &Nominal::area, Unit::area, any_size, "nominal stress = load / area");
  t.number("length", &Nominal::length, Unit::length, any_size, "nominal strain = displacement / length");
  t.check([](Scope& s, Nominal& n) { make_unit(s, "direction", n.direction); });
  return t;
}

}  // namespace

Table<Control> control_table() {
  using Kind = Control::Kind;
  const auto by_gauge = [](const Scope&, const Control& c) { return c.kind == Kind::gauge; };
  Table<Control> t("What drives the run.");
  t.choice("kind", &Control::kind,
           std::vector<std::pair<std::string, Kind>>{{"time", Kind::time}, {"gauge", Kind::gauge}},
           "time: displacements and loads; gauge: the change of a gauge, while all pressures are scaled by an unknown "
           "factor");
  t.name("gauge", &Control::gauge, "name of a gauge", "the gauge that grows")
      .required()
      .only(by_gauge, "with kind = \"gauge\"");
  t.number("target", &Control::target, Unit::length, {}, "change of the gauge at the end, reached linearly")
      .required()
      .only(by_gauge, "with kind = \"gauge\"");
  t.check([](Scope& s, Control& c) {
    if (c.kind == Kind::gauge && c.target == 0.0) s.error("target", "must not be zero");
  });
  return t;
}

Table<Solver> solver_table() {
  using SnapBack = Solver::SnapBack;
  Table<Solver> t("How a step is solved.");
  t.choice("integration", &Solver::integration,
           std::vector<std::pair<std::string, Integration>>{
               {"implicit", Integration::implicit}, {"impl_ex", Integration::impl_ex}, {"lagged", Integration::lagged}},
           "damage of the step itself, extrapolated (always converges, small steps), or of the step before");
  t.choice("snap_back", &Solver::snap_back,
           std::vector<std::pair<std::string, SnapBack>>{{"stop", SnapBack::stop}, {"impl_ex", SnapBack::impl_ex}},
           "implicit: what to do when even the smallest step finds no solution");
  t.number("relative_tolerance", &Solver::relative_tolerance, Unit::none, {0.0, 1.0, true, true},
           "residual over reactions and loads");
  t.number("absolute_tolerance", &Solver::absolute_tolerance, Unit::none, positive(),
           "residual in units of Young's modulus, cell size and thickness, for unloaded bodies");
  t.integer("max_iterations", &Solver::max_iterations, {1.0, 10000.0}, "Newton iterations before the step is cut");
  t.boolean("line_search", &Solver::line_search, "shorten Newton steps that do not reduce the residual");
  t.number("ghost_penalty", &Solver::ghost_penalty, Unit::none, non_negative(),
           "stabilisation of barely filled cells in units of Young's modulus; 0 switches it off. Default: 0.001; with domains that follow the body "
           "(finite strain, updated Lagrangian) of solids other than soil, and of points from mesh files, 0.03")
      .no_default();
  using Linear = Solver::Linear;
  t.choice(
      "linear", &Solver::linear,
      Words<Linear>{{"automatic", Linear::automatic},
                    {"direct", Linear::direct},
                    {"distributed", Linear::distributed},
                    {"iterative", Linear::iterative}},
      "how linear systems are solved; automatic: directly in the plane, iteratively if large in space; direct: several processes send "
      "their rows to the first one, and the same run twice is equal to the bit; distributed: directly on all of them, quicker for "
      "large systems (1.5 times on two processes from 40 000 unknowns on), last digits differ from run to run");
  t.number("linear_tolerance", &Solver::linear_tolerance, Unit::none, {0.0, 1.0, true, true},
           "iterative: residual over right-hand side");
  t.text("petsc", &Solver::petsc, "options of PETSc's solvers, e.g. \"-ksp_view -snes_monitor\" (a wrong one is answered by the list of all); any others need berm run --allow-petsc-files");
  return t;
}

Table<Dynamics> dynamics_table() {
  using Integrator = Dynamics::Integrator;
  using Mass = Dynamics::Mass;
  using Transfer = Dynamics::Transfer;
  Table<Dynamics> t("How motion is integrated (analysis \"dynamic\").");
  t.choice("integrator", &Dynamics::integrator,
           Words<Integrator>{
               {"newmark", Integrator::newmark}, {"bossak", Integrator::bossak}, {"hht", Integrator::hht}},
           "newmark: constant mean acceleration, no numerical damping; the others damp high frequencies");
  t.number("alpha", &Dynamics::alpha, Unit::none, {-1.0 / 3.0, 0.0}, "numerical damping; 0: none");
  t.only([](const Scope&, const Dynamics& d) { return d.integrator != Integrator::newmark; },
         "with integrator = \"bossak\" or \"hht\"");
  t.choice("mass", &Dynamics::mass, Words<Mass>{{"lumped", Mass::lumped}, {"consistent", Mass::consistent}},
           "mass matrix of the equation of motion, and of the projection of velocities to the nodes: consistent keeps the "
           "energy of material points, lumped loses some in every step. Default: consistent with method \"mpm\", "
           "integrator \"newmark\", transfers other than \"apic\" and elastic laws or fluids, else lumped")
      .no_default();
  t.choice("transfer", &Dynamics::transfer,
           Words<Transfer>{{"flip", Transfer::flip},
                           {"pic", Transfer::pic},
                           {"blend", Transfer::blend},
                           {"apic", Transfer::apic}},
           "how material points take their velocity from the grid (method \"mpm\"): its change (keeps energy), its value "
           "(damps), a part of both, or its value and gradient (keeps angular momentum)");
  t.integer("projection_order", &Dynamics::projection_order, {1.0, 100.0},
            "order k of the projection of the motion of points to nodes (method \"mpm\", FMPM) with the lumped mass: the higher, "
            "the less it smooths; 1: with mass = \"consistent\" and \"newmark\", the solution with that mass");
  t.only([](const Scope&, const Dynamics& d) { return d.transfer != Transfer::apic; },
         "with transfers other than \"apic\", which carries gradients instead");
  t.number("flip_fraction", &Dynamics::flip_fraction, Unit::none, {0.0, 1.0}, "share of flip; the rest is pic");
  t.only([](const Scope&, const Dynamics& d) { return d.transfer == Transfer::blend; }, "with transfer = \"blend\"");
  t.number("rayleigh_mass", &Dynamics::rayleigh_mass, Unit::rate, non_negative(), "damping in units of the mass");
  t.number("rayleigh_stiffness", &Dynamics::rayleigh_stiffness, Unit::time, non_negative(),
           "damping in units of the stiffness");
  t.number("local_damping", &Dynamics::local_damping, Unit::none, {0.0, 1.0, false, true},
           "share of the unbalanced force of every node that opposes its motion, to come to rest (Cundall 1987)");
  t.number("error_tolerance", &Dynamics::error_tolerance, Unit::none, non_negative(),
           "error of a step aimed at: that of the mean acceleration over a step, relative to the displacement; 0: the "
           "effort of Newton's method alone decides on the steps");
  return t;
}

Table<Output> output_table() {
  Table<Output> t("What is written.");
  t.integer("vtk_every", &Output::vtk_every, {0.0}, "steps between VTK files; 0: `frames` decides");
  t.integer("frames", &Output::frames, {0.0, 100000.0},
            "VTK files over the run, evenly spaced, beside first, peak and last");
  t.custom(references_info(), [](Scope& s, Node::Entry& e, Output& output) { output.references = read_references(s, e); });
  t.table("nominal", &Output::nominal, nominal_table());
  return t;
}

Table<Checkpoint> checkpoint_table() {
  Table<Checkpoint> t(
      "When the state is saved, so that a run can go on after an end of any kind; never if both are 0.");
  t.integer("every_steps", &Checkpoint::every_steps, {0.0}, "steps between checkpoints; 0: by time alone");
  t.number("every_minutes", &Checkpoint::every_minutes, Unit::minutes, non_negative(),
           "wall-clock time between checkpoints; 0: by steps alone");
  return t;
}

Table<Parallel> parallel_table() {
  Table<Parallel> t("How the cells are shared out among the processes.");
  t.number("rebalance", &Parallel::rebalance, Unit::none, {1.0, infinity, true, false},
           "load of the busiest process over the mean at which the cells are shared out anew");
  return t;
}

Table<Gauge> gauge_table() {
  Table<Gauge> t("Change of the distance between two material points, along the line that joins them at the start.");
  t.vector("from", &Gauge::from, Unit::length, "reference position of the first point").required();
  t.vector("to", &Gauge::to, Unit::length, "reference position of the second point").required();
  t.check([](Scope& s, Gauge& gauge) {
    if (gauge.from == gauge.to) s.error("to", "must differ from \"from\"");
  });
  return t;
}

Table<Probe> probe_table() {
  using Q = Quantity;
  const Words<Q> plane = {
      {"stress_xx", Q::stress_xx},           {"stress_yy", Q::stress_yy}, {"stress_zz", Q::stress_zz},
      {"stress_xy", Q::stress_xy},           {"strain_xx", Q::strain_xx}, {"strain_yy", Q::strain_yy},
      {"strain_zz", Q::strain_zz},           {"strain_xy", Q::strain_xy}, {"displacement_x", Q::displacement_x},
      {"displacement_y", Q::displacement_y}, {"velocity_x", Q::velocity_x}, {"velocity_y", Q::velocity_y},
      {"damage", Q::damage},                 {"plastic_strain", Q::plastic_strain}};
  WordsByDimension<Q> quantities = {plane, plane};
  for (const auto& word : Words<Q>{{"stress_yz", Q::stress_yz},
                                   {"stress_zx", Q::stress_zx},
                                   {"strain_yz", Q::strain_yz},
                                   {"strain_zx", Q::strain_zx},
                                   {"displacement_z", Q::displacement_z},
                                   {"velocity_z", Q::velocity_z}})
    quantities.solid.push_back(word);
  Table<Probe> t("A quantity at a material point, over the run.");
  t.vector("at", &Probe::at, Unit::length, "reference position").required();
  t.choice("quantity", &Probe::quantity, quantities,
           "what is recorded; in axisymmetric models zz is the direction around the axis")
      .required();
  return t;
}

}  // namespace berm
