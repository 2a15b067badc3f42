#include "sim/implicit_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "bc/case_lookup.hpp"

namespace berm {
namespace {

/// IMPL-EX steps are linear but for the change of geometry: this relative residual is accepted after one solve, the
/// rest is carried into the next step's equilibrium.
constexpr double impl_ex_tolerance = 1e-5;

/// Where the residual no longer falls, because states of contact or yielding come and go, this relative one is taken for
/// equilibrium; the rest is carried into the next step's. Whole zones at the limit of non-associated flow have no better one.
double still_tolerance(const Case& c) { return any_law(c, is_plastic) ? 1e-4 : 1e-5; }

/// A state in which nothing changes is kept if its forces are out of balance by no more than this, which comes from points that
/// have moved on the grid; with more it is no equilibrium.
constexpr double rest_tolerance = 1e-2;

/// Part of a step over which velocities at its ends are differences, and over which a motion begins.
constexpr double small_part = 1e-4;

/// The trial stresses are those of t_n.
void recall_stresses(MaterialState& m, Kinematics kinematics) {
  for (int p = 0; p < m.size(); ++p) {
    const double J = kinematics == Kinematics::finite ? m.F[p].determinant() * std::exp(m.strain_zz[p]) : 1.0;
    m.trial[p].stress = J * m.stress[p];  // Kirchhoff's
  }
}

bool all_elastic(const MaterialState& m) {
  return std::all_of(m.slices.begin(), m.slices.end(),
                     [](const Slice& s) { return std::holds_alternative<LinearElastic>(s.law); });
}

}  // namespace

ImplicitStep::ImplicitStep(World& world) : world_(world), dimension_(world.spec.dimension()) {
  const Case& c = world.spec;
  settings_.space = c.space;
  settings_.kinematics = c.kinematics;
  if (c.control.kind == Control::Kind::gauge)
    for (std::size_t g = 0; g < world.boundary->gauges().size(); ++g)
      if (world.boundary->gauges()[g].name == c.control.gauge) gauge_ = static_cast<int>(g);
  // The gauge equation is scaled to a force: the matrix stays well conditioned and one norm serves both.
  gauge_scale_ = world.elastic_scale / world.discretisation->cell_size();
  balance_.reactions.rigid.assign(c.bodies.size(), Vec3::Zero());
  balance_.reactions.boundary.assign(c.boundaries.size(), Vec3::Zero());
  balance_.pressure_force.assign(c.pressures.size(), Vec3::Zero());
  balance_.kinetic = balance_.kinetic_at_start = world.kinetic_energy();
  set_up_stage();
}

/// Over the nodes of all processes; a and b complete at the owned ones.
double ImplicitStep::dot(const NodalVector& a, const NodalVector& b) const {
  double sum = 0.0;
  for (int i = 0; i < world_.discretisation->halo.n_owned; ++i) sum += a[i].dot(b[i]);
  return world_.comm.sum(sum);
}

double ImplicitStep::norm(const NodalVector& f) const { return std::sqrt(dot(f, f)); }

double ImplicitStep::norm(const std::vector<double>& r) const {
  double sum = 0.0;
  for (const double value : r) sum += value * value;
  return std::sqrt(world_.comm.sum(sum));
}

int ImplicitStep::n_mine() const { return dimension_ * world_.discretisation->halo.n_owned + (owns_border() ? 1 : 0); }

void ImplicitStep::prepare(Integration integration) {
  Discretisation& d = *world_.discretisation;
  settings_.integration = integration;
  const bool mixed = world_.spec.volumetric == Volumetric::mixed;  // symmetric at best, but never positive definite
  const bool own_gradients = world_.spec.quadrature == Quadrature::gauss;  // of the forces
  const bool symmetric =
      gauge_ < 0 && !mixed && !own_gradients && world_.boundary->symmetric() && (integration != Integration::implicit || all_elastic(d.material));
  const Stopwatch watch(times_.connectivity);
  if (!prepared_) {
    if (!world_.step_begun) world_.begin_step();
    if (gauge_ >= 0) pressure_ = pressure_at(load_time(), no_motion());
    prepared_ = true;
    motion_ready_ = false;
  }
  keep_guess();
  lay_out(symmetric);
}

NodalVector ImplicitStep::no_motion() const { return NodalVector(world_.discretisation->n_nodes(), Vec3::Zero()); }

/// Complete at owned nodes.
NodalVector ImplicitStep::pressure_at(double time, const NodalVector& du) const {
  const Discretisation& d = *world_.discretisation;
  NodalVector f = no_motion();
  world_.comm.agree([&] { world_.boundary->add_pressure(time, du, 1.0, f, nullptr); });
  d.halo.add_to_owners(f.data()->data(), 3);
  return f;
}

bool ImplicitStep::has_weight() const {
  const Case& c = world_.spec;
  return !c.gravity.is_zero() ||
         std::any_of(c.bodies.begin(), c.bodies.end(), [](const Body& b) { return !b.acceleration.is_zero(); });
}

NodalVector ImplicitStep::weight_at(double time) const {
  const Discretisation& d = *world_.discretisation;
  NodalVector f(d.n_nodes(), Vec3::Zero());
  if (!has_weight()) return f;
  const std::vector<Body>& bodies = world_.spec.bodies;
  const Vec3 gravity = world_.spec.gravity.at(time);
  std::vector<std::optional<Vec3>> uniform;  // absent: differs from place to place
  for (const Body& b : bodies)
    uniform.push_back(b.acceleration.depends_on_place() ? std::nullopt
                                                        : std::optional<Vec3>(gravity + b.acceleration.at(time)));
  const auto acceleration = [&](int body, const Vec3& X) {
    return uniform[body] ? *uniform[body] : Vec3(gravity + bodies[body].acceleration.at(time, X));
  };
  world_.comm.agree([&] { d.add_body_force(acceleration, f); });
  d.halo.add_to_owners(f.data()->data(), 3);
  return f;
}

/// The matrix for the present connectivity, gauge and symmetry.
void ImplicitStep::lay_out(bool symmetric) {
  const Discretisation& d = *world_.discretisation;
  Border border;
  border.active = gauge_ >= 0;
  if (border.active) {
    functional_.assign(d.n_nodes(), Vec3::Zero());
    world_.boundary->add_gauge_functional(gauge_, functional_);
    for (int k = 0; k < dimension_ * d.n_nodes(); ++k) {
      const bool mine = k < dimension_ * d.halo.n_owned;  // the complete pressure stands at the owner
      if (mine && !pressure_[k / dimension_].isZero(0.0)) border.column_rows.push_back(k);  // they may turn
      if (functional_[k / dimension_][k % dimension_] != 0.0) border.row_columns.push_back(k);
    }
    const std::vector<char>& fixed = world_.boundary->fixed();
    const bool held = std::all_of(border.row_columns.begin(), border.row_columns.end(), [&](int k) { return fixed[k]; });
    if (world_.comm.all(held))
      throw RunError(fmt::format("[gauge.{}]: both ends are where all nodes are held: [control] kind = \"gauge\" cannot make it grow. Put one of them where the body moves",
                                 world_.spec.control.gauge));
  }
  const bool same = world_.comm.all(connectivity_ == d.connectivity && border_ == border);
  if (same && symmetric == symmetric_) return;
  if (!same) {
    connectivity_ = d.connectivity;
    border_ = border;
    assembler_.build(d.blocks, d.n_nodes(), dimension_, border_);
  }
  symmetric_ = symmetric;

  SystemLayout layout;
  layout.dimension = dimension_;
  layout.bordered = border_.active;
  layout.indefinite = world_.spec.volumetric == Volumetric::mixed;
  layout.n_mine = n_mine();
  layout.n_global = dimension_ * d.halo.n_global + (border_.active ? 1 : 0);
  for (std::int64_t node : d.halo.global)
    for (int i = 0; i < dimension_; ++i) layout.global.push_back(dimension_ * node + i);
  if (border_.active) layout.global.push_back(layout.n_global - 1);
  layout.places.assign(d.nodes.begin(), d.nodes.begin() + d.halo.n_owned);
  newton_->set_matrix(assembler_.matrix(), layout, symmetric);
}

/// Unknowns to the nodal increment of the step and the load factor.
void ImplicitStep::scatter(const std::vector<double>& x) {
  const Discretisation& d = *world_.discretisation;
  const std::vector<char>& fixed = world_.boundary->fixed();
  for (int k = 0; k < dimension_ * d.halo.n_owned; ++k)
    du_[k / dimension_][k % dimension_] = fixed[k] ? prescribed_[k] : x[k];
  d.halo.copy_to_ghosts(du_.data()->data(), 3);
  load_factor_ = gauge_ >= 0 ? world_.comm.broadcast(owns_border() ? x.back() : 0.0, world_.comm.size() - 1)
                             : t1_ / world_.spec.duration();
}

double ImplicitStep::gauge_value() const {
  double value = 0.0;
  for (std::size_t i = 0; i < du_.size(); ++i) value += functional_[i].dot(du_[i]);
  return world_.boundary->gauges()[gauge_].elongation() + world_.comm.sum(value);
}

/// Of the trial state, complete at owned nodes.
NodalVector ImplicitStep::internal_force() const {
  const Discretisation& d = *world_.discretisation;
  NodalVector f(d.n_nodes(), Vec3::Zero());
  d.add_internal_force(f);
  d.halo.add_to_owners(f.data()->data(), 3);
  return f;
}

/// force_ = internal + stabilisation + contact and pins - pressure (gauge: times load factor) - weight, and inertia and
/// damping, complete at owned nodes. [formulation (1), (14); dynamics (11)]
void ImplicitStep::sum_forces() {
  const Stopwatch watch(times_.assembly);
  const Discretisation& d = *world_.discretisation;
  force_ = internal_force();
  external_ = weight_;
  pressure_ = pressure_at(load_time(), du_);
  for (std::size_t i = 0; i < external_.size(); ++i) external_[i] += pressure_factor() * pressure_[i];
  force_scale_ = std::max(norm(force_), norm(external_));
  NodalVector resisting(d.n_nodes(), Vec3::Zero());
  if (motion_) {
    force_scale_ = std::max(force_scale_, inertia_scale_);
    weigh_forces();
    motion_->add_forces(d, du_, resisting, nullptr);
    world_.boundary->add_dashpots(motion_->weighed_velocity(du_), 0.0, resisting, nullptr);
  }
  d.add_stabilisation(du_, resisting, nullptr);
  world_.boundary->add_forces(d, du_, t0_, t1_, resisting, nullptr);
  d.halo.add_to_owners(resisting.data()->data(), 3);
  for (std::size_t i = 0; i < force_.size(); ++i) force_[i] += resisting[i] - external_[i];
}

/// Internal and external forces at the two ends of the step, as the equation of motion weighs them.   [dynamics (11)]
void ImplicitStep::weigh_forces() {
  const double fresh = motion_->new_internal_weight(), old = motion_->old_internal_weight();
  if (fresh == 1.0 && old == 0.0) return;
  for (std::size_t i = 0; i < force_.size(); ++i) {
    force_[i] = fresh * force_[i] + old * old_internal_[i];
    external_[i] = motion_->new_weight() * external_[i] + motion_->old_weight() * old_external_[i];
  }
}

bool ImplicitStep::residual(const std::vector<double>& x, std::vector<double>& r) {
  const bool cached = !cached_r_.empty() && x == cached_x_;
  if (world_.comm.all(cached)) {
    r = cached_r_;
    return true;
  }
  cached_r_.clear();  // belongs to another trial state from here on
  scatter(x);
  {
    const Stopwatch watch(times_.response);
    const Status status = world_.discretisation->evaluate(du_, settings_);
    if (!world_.comm.all(status == Status::ok)) return false;
  }
  sum_forces();
  r.assign(n_mine(), 0.0);
  const std::vector<char>& fixed = world_.boundary->fixed();
  for (int k = 0; k < dimension_ * world_.discretisation->halo.n_owned; ++k)
    if (!fixed[k]) r[k] = force_[k / dimension_][k % dimension_];
  if (gauge_ >= 0) {
    const double value = gauge_scale_ * (gauge_value() - world_.spec.control.target * (t1_ / world_.spec.duration()));
    if (owns_border()) r.back() = value;
  }
  cached_x_ = x;
  cached_r_ = r;
  return true;
}

/// The matrix of the trial state last evaluated.
void ImplicitStep::assemble(const std::vector<double>* prescribed) {
  const Stopwatch watch(times_.assembly);
  const Discretisation& d = *world_.discretisation;
  const std::vector<char>& fixed = world_.boundary->fixed();
  NodalVector unused(d.n_nodes(), Vec3::Zero());
  assembler_.zero(fixed, d.halo.n_owned, gauge_scale_, prescribed);
  d.add_tangent(settings_, assembler_);
  if (motion_) {
    assembler_.scale(motion_->new_internal_weight());
    motion_->add_forces(d, du_, unused, &assembler_);
    world_.boundary->add_dashpots(motion_->weighed_velocity(du_), motion_->weighed_velocity_by_increment(), unused,
                                  &assembler_);
  }
  d.add_stabilisation(du_, unused, &assembler_);
  world_.boundary->add_forces(d, du_, t0_, t1_, unused, &assembler_);
  const double factor = (motion_ ? motion_->new_weight() : 1.0) * pressure_factor();
  world_.comm.agree([&] { world_.boundary->add_pressure(load_time(), du_, factor, unused, &assembler_); });
  if (gauge_ < 0) return;
  std::vector<double> column, row;
  for (int k : border_.column_rows) column.push_back(fixed[k] ? 0.0 : -pressure_[k / dimension_][k % dimension_]);
  for (int k : border_.row_columns)
    row.push_back(fixed[k] ? 0.0 : gauge_scale_ * functional_[k / dimension_][k % dimension_]);
  assembler_.set_border(column, row);
}

/// First guess from the tangent at t_n: K_ff dx = -r(0) - K_fp du_p. The only linear solve of an IMPL-EX step. What presses
/// on a rigid body goes along with it: the penetration that carries a load is a small part of a step, and a body that
/// retreats would leave the whole surface without support. So does, in the first step, what is laid on another body with a gap
/// that nobody sees.
bool ImplicitStep::linear_predictor(std::vector<double>& x) {
  const Discretisation& d = *world_.discretisation;
  const std::vector<double> prescribed = prescribed_;
  std::fill(prescribed_.begin(), prescribed_.end(), 0.0);
  x.assign(n_mine(), 0.0);
  if (owns_border()) x.back() = world_.load_factor;
  std::vector<double> r, dx;
  const bool begins = t0_ - world_.present_stage().begin <= small_part * settings_.dt;
  world_.boundary->keep_closed((begins ? still_touching : just_touching) * d.cell_size());
  const bool fine = residual(x, r);
  if (fine) assemble(&prescribed);
  world_.boundary->keep_closed(none_closed);
  prescribed_ = prescribed;
  cached_r_.clear();
  if (!fine) return false;
  std::vector<double> from_prescribed = assembler_.prescribed_force();
  d.halo.add_to_owners(from_prescribed.data(), dimension_);
  for (std::size_t k = 0; k < r.size(); ++k) {
    const bool border = owns_border() && k + 1 == r.size();
    r[k] = -r[k] - (border ? 0.0 : from_prescribed[k]);
  }
  if (!newton_->solve_linear(r, dx)) return false;
  for (std::size_t k = 0; k < x.size(); ++k) x[k] += dx[k];
  return true;
}

std::vector<double> ImplicitStep::unknowns_of(const NodalVector& du) const {
  std::vector<double> x(n_mine(), 0.0);
  for (int k = 0; k < dimension_ * world_.discretisation->halo.n_owned; ++k) x[k] = du[k / dimension_][k % dimension_];
  return x;
}

/// Mean velocity of the prescribed unknowns.
std::vector<double> ImplicitStep::velocity_of_prescribed(double t0, double t1) const {
  std::vector<double> v = world_.boundary->prescribed_increment(t0, t1);
  for (double& value : v) value /= t1 - t0;
  return v;
}

/// Prescribed velocities are differences over a small part of the step at its ends.   [dynamics (6)]
void ImplicitStep::prescribe_motion(double dt) {
  const double part = small_part * dt;
  std::vector<double> v0, v1;
  world_.comm.agree([&] {
    v0 = velocity_of_prescribed(t0_, t0_ + part);
    v1 = velocity_of_prescribed(t1_ - part, t1_);
  });
  motion_->prescribe(*world_.discretisation, dt, world_.boundary->fixed(), v0, v1);
}

/// The motion of the nodes at t_n and of the prescribed ones over the step.
void ImplicitStep::begin_motion(double dt) {
  const Discretisation& d = *world_.discretisation;
  const Stage& stage = world_.present_stage();
  const bool fresh = !motion_ready_;
  if (fresh) motion_->gather(d);
  prescribe_motion(dt);
  if (fresh) {
    const double old = motion_->old_weight() + stage.dynamics.rayleigh_stiffness;
    const bool begins = t0_ - stage.begin < small_part * dt;
    if (old != 0.0 || begins) forces_at_start(begins);
    if (begins) {
      start_acceleration();
      prescribe_motion(dt);
    }
    motion_ready_ = true;
  }
  NodalVector inertia = motion_->inertia();
  d.halo.add_to_owners(inertia.data()->data(), 3);
  inertia_scale_ = norm(inertia);
}

/// Internal and external forces of the state at t_n, on the nodes of the step. The stresses are those that the points have:
/// a law that depends on the rate of strain would give others for no increment. Where a motion begins they are those of its
/// velocities, over a small part of the step.
void ImplicitStep::forces_at_start(bool begins) {
  Discretisation& d = *world_.discretisation;
  LawSettings settings = settings_;
  du_ = no_motion();
  if (begins) {
    settings.dt *= small_part;
    for (std::size_t i = 0; i < du_.size(); ++i) du_[i] = settings.dt * motion_->smooth_velocity()[i];
  }
  world_.boundary->grid_contact().begin_step(d);
  d.evaluate(du_, settings);
  if (!begins && world_.spec.volumetric != Volumetric::mixed) recall_stresses(d.material, settings_.kinematics);
  du_ = no_motion();
  old_internal_ = internal_force();
  old_external_ = weight_at(t0_);
  const NodalVector pressure = pressure_at(t0_, du_);
  for (std::size_t i = 0; i < pressure.size(); ++i) old_external_[i] += pressure[i];
}

/// The acceleration with which a motion begins: that of the forces, with those of damping.   [dynamics (10)]
void ImplicitStep::start_acceleration() {
  Discretisation& d = *world_.discretisation;
  NodalVector f = motion_->damping(d, motion_->velocity());
  world_.boundary->add_dashpots(motion_->smooth_velocity(), 0.0, f, nullptr);
  world_.boundary->add_forces(d, du_, t0_, t0_, f, nullptr);
  d.halo.add_to_owners(f.data()->data(), 3);
  for (std::size_t i = 0; i < f.size(); ++i) f[i] = old_external_[i] - old_internal_[i] - f[i];
  d.halo.copy_to_ghosts(f.data()->data(), 3);
  // Nodes whose motion is prescribed have no acceleration of their own: what is missing there is the force of the support.
  const std::vector<char>& fixed = world_.boundary->fixed();
  for (std::size_t i = 0; i < f.size(); ++i)
    for (int c = 0; c < dimension_; ++c)
      if (fixed[dimension_ * i + c]) f[i][c] = 0.0;
  motion_->set_acceleration(f);
  d.start_accelerations(motion_->gathered_acceleration());
}

/// Unknowns to start Newton's method from. False if the matrix of a linear guess could not be factorised.
bool ImplicitStep::first_guess(std::vector<double>& x, int& iterations, Integration integration) {
  if (motion_) {
    x = unknowns_of(motion_->guess());
    return true;
  }
  if (integration == Integration::implicit && last_dt_ > 0.0 && gauge_ < 0) {
    x = unknowns_of(last_du_);
    for (double& value : x) value *= settings_.dt / last_dt_;
    return true;
  }
  ++iterations;
  return linear_predictor(x);
}

/// How Newton's method is tried, in this order. Where damage localises, or a contact closes, the residual norm has to
/// grow before it falls: full steps get through more often. With inertia they mostly are the shortest way.
std::vector<ImplicitStep::Attempt> ImplicitStep::attempts(const Solver& s) const {
  constexpr int few = 8;
  using enum StepLength;
  if (!s.line_search) return {{full, s.max_iterations}};
  if (motion_) return {{full, std::min(few, s.max_iterations)}, {line_search, s.max_iterations}, {half, s.max_iterations}};
  std::vector<Attempt> tries = {{line_search, s.max_iterations}, {full, s.max_iterations}, {half, s.max_iterations}};
  // Where all places of a body slide, some this way and some that, as under a disc that spreads between platens, nothing resists a
  // motion of the body until some of them turn round, and Newton's method leaps along it. What resists little needs no spring: it
  // would take many iterations.   [boundaries (11)]
  constexpr double weak = 1e-5;
  const bool rubs = std::any_of(world_.spec.contacts.begin(), world_.spec.contacts.end(), [](const Contact& k) { return k.kind == Contact::Kind::friction && k.other.empty(); });
  if (rubs) tries.push_back({line_search, s.max_iterations, weak});
  return tries;
}

NewtonResult ImplicitStep::solve(std::vector<double>& x, double tolerance, const Attempt& how) {
  return newton_->solve(
      x, tolerance, how.length, how.most, [this](const auto& at, auto& out) { return residual(at, out); },
      [this, matrices = 0](const auto& at) mutable {
        constexpr int enough = 6;
        std::vector<double> unused;
        residual(at, unused);  // the trial state may be that of another place
        if (++matrices == enough) world_.boundary->grid_contact().freeze(du_);
        assemble(nullptr);
      });
}

/// Throws, on all processes alike, if a motion has no value at the end of the step.
void ImplicitStep::check_motions() const {
  for_each_motion(world_.spec, [this](const TimeFunction& f) {
    if (!f.depends_on_place()) f.at(t1_);
  });
}

/// States of contact as at the start of the step, and no residual that is known with others.
void ImplicitStep::forget_contact() {
  world_.boundary->grid_contact().begin_step(*world_.discretisation);
  cached_r_.clear();
}

/// Takes the unknowns with the smallest residual on the way for equilibrium, if it is below the bound with contacts as they
/// are there, and not as they were frozen later.
bool ImplicitStep::take_still(NewtonResult& newton, double bound, std::vector<double>& x) {
  if (newton.residuals.empty() || !(newton.least <= bound)) return false;
  forget_contact();
  std::vector<double> r;
  x = newton.best;
  if (!residual(x, r)) return false;
  newton.residual = norm(r);
  newton.converged = newton.residual <= bound;
  return newton.converged;
}

/// From a guess of the unknowns, whose residual may be known.
NewtonResult ImplicitStep::find_equilibrium(const std::vector<double>& guess, std::vector<double>& x, double tolerance, double scale,
                                            StepResult& result) {
  NewtonResult newton;
  const std::vector<Attempt> tries = attempts(world_.present_stage().solver);
  for (const Attempt& attempt : tries) {
    if (&attempt != &tries.front()) forget_contact();
    x = guess;
    world_.boundary->resist_sliding(attempt.spring);
    newton = solve(x, tolerance, attempt);
    world_.boundary->resist_sliding(0.0);
    result.iterations += newton.iterations;
    if (newton.converged && !is_fair()) {
      newton.converged = false;
      newton.reason = "bodies part, stick or slide otherwise than assumed in the step";
    }
    if (newton.converged) break;
    const bool last = &attempt == &tries.back();
    if ((newton.stood_still || last) && take_still(newton, still_tolerance(world_.spec) * scale, x)) {
      result.stood_still = true;
      break;
    }
  }
  return newton;
}

StepResult ImplicitStep::attempt(double dt, Integration integration) {
  prepare(integration);
  n_unknowns_ = world_.boundary->n_free() + (gauge_ >= 0 ? 1 : 0);
  t0_ = world_.time;
  t1_ = world_.time + dt;
  settings_.dt = dt;
  check_motions();
  weight_ = weight_at(t1_);
  world_.comm.agree([&] {
    prescribed_ = world_.boundary->prescribed_increment(t0_, t1_);
    world_.boundary->check_held_surfaces(t1_);
  });
  if (motion_) begin_motion(dt);
  du_.assign(world_.discretisation->n_nodes(), Vec3::Zero());
  cached_r_.clear();

  StepResult result;
  std::vector<double> x, r;
  world_.boundary->grid_contact().limit_at_once(true, !motion_);
  world_.boundary->grid_contact().begin_step(*world_.discretisation);
  if (integration == Integration::implicit && nothing_changes() && residual(std::vector<double>(n_mine(), 0.0), r)) {
    result.residual = norm(r) / std::max(force_scale_, 1e-300);
    if (result.residual <= rest_tolerance) {
      result.converged = reaches_equilibrium_ = true;
      result.at_rest = result.residual;
      return result;
    }
  }
  if (!first_guess(x, result.iterations, integration)) {
    result.reason = "the matrix of the first guess could not be factorised";
    return result;
  }
  // Prescribed unknowns have their values in the vector too, so that Newton's corrections of them are zero.
  const std::vector<char>& fixed = world_.boundary->fixed();
  for (int k = 0; k < dimension_ * world_.discretisation->halo.n_owned; ++k)
    if (fixed[k]) x[k] = prescribed_[k];
  bool defined = residual(x, r);
  if (!defined) {  // what the last step or the velocities promise may turn a point inside out: begin without them
    for (int k = 0; k < dimension_ * world_.discretisation->halo.n_owned; ++k)
      if (!fixed[k]) x[k] = 0.0;
    defined = residual(x, r);
  }
  if (!defined) {
    last_dt_ = 0.0;
    result.reason = "the first guess lies outside of what the law is defined for";
    return result;
  }
  const Solver& s = world_.present_stage().solver;
  const double relative =
      integration == Integration::implicit ? s.relative_tolerance : std::max(s.relative_tolerance, impl_ex_tolerance);
  const double scale = force_scale_;
  const double tolerance = relative * scale + s.absolute_tolerance * world_.elastic_scale;
  const std::vector<double> guess = x;
  NewtonResult newton = find_equilibrium(guess, x, tolerance, scale, result);
  if (GridContact& contact = world_.boundary->grid_contact(); !newton.converged && world_.comm.any(contact.some_at_once())) {
    // Bodies that are laid down may stick, slide and part in turn: without friction for one step, as where they move on.
    contact.limit_at_once(false, false);
    forget_contact();
    newton = find_equilibrium(guess, x, tolerance, scale, result);
  }
  if (newton.converged && flies_away()) {
    newton.converged = result.stood_still = false;
    newton.reason = reason_of_flight();
  }
  result.converged = newton.converged;
  reaches_equilibrium_ = integration == Integration::implicit && !motion_ && !result.stood_still;
  const double reference = std::max(scale, s.absolute_tolerance * world_.elastic_scale);
  result.residual = newton.residual / reference;
  for (double value : newton.residuals) result.residuals.push_back(value / reference);
  result.reason = newton.reason;
  if (!result.converged) {
    last_dt_ = 0.0;
    find_worst_node(result);
    return result;
  }
  residual(x, r);  // the trial state of the solution, if a rejected line search came after it
  result.extrapolation_error = world_.comm.max(world_.discretisation->material.max_extrapolation_error());
  if (motion_) {
    const Newmark::Resolution resolution = motion_->resolution(*world_.discretisation, du_);
    result.time_error = resolution.error, result.steps_a_period = resolution.steps_a_period;
  }
  return result;
}

/// Commit: energies by the trapezoidal rule on forces and displacements, then points, contact, time.
void ImplicitStep::accept() {
  Discretisation& d = *world_.discretisation;
  BoundaryConditions& bc = *world_.boundary;
  double work = 0.0;
  const Reactions now = bc.reactions(du_, t0_, t1_, force_);
  const Reactions& before = balance_.reactions;
  work += bc.support_work(motion_ && motion_->means() ? now : before, now, t0_, t1_);
  balance_.reactions = now;
  const double time_before = gauge_ >= 0 ? load_time() : t0_, factor_before = gauge_ >= 0 ? world_.load_factor : 1.0;
  work +=
      0.5 * (factor_before * dot(pressure_at(time_before, no_motion()), du_) + pressure_factor() * dot(pressure_, du_));
  balance_.pressure_force = bc.pressure_forces(load_time(), du_);
  for (Vec3& force : balance_.pressure_force) force *= pressure_factor();
  if (has_weight()) work += 0.5 * (dot(weight_at(t0_), du_) + dot(weight_, du_));
  balance_.external_work += work;
  const ContactWork contact = bc.contact_work(du_, t0_, t1_);
  balance_.contact_work += contact.total;
  balance_.friction_work += contact.heat;
  if (motion_) accept_motion();

  bc.commit(d, du_, t0_, t1_);
  d.commit(du_, bc.anchors());
  bc.share_gauges();
  last_du_ = du_;
  last_dt_ = t1_ - t0_;
  last_stage_ = world_.present_stage().name;
  in_equilibrium_ = reaches_equilibrium_;
  world_.time = t1_;
  world_.load_factor = load_factor_;
  prepared_ = world_.step_begun = false;
}

/// Velocities of the material, and what damping has taken of its energy.
void ImplicitStep::accept_motion() {
  Discretisation& d = *world_.discretisation;
  const Dynamics& how = world_.present_stage().dynamics;
  NodalVector v = motion_->velocity(du_);  // the mean one: damping forces are as rough as velocities
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = 0.5 * (v[i] + motion_->velocity()[i]);
  NodalVector damping = motion_->damping(d, v);
  world_.boundary->add_dashpots(v, 0.0, damping, nullptr);
  d.halo.add_to_owners(damping.data()->data(), 3);
  balance_.damped += dot(damping, du_);
  if (how.rayleigh_stiffness > 0.0) {
    const NodalVector internal = internal_force();
    balance_.damped += how.rayleigh_stiffness / settings_.dt * (dot(internal, du_) - dot(old_internal_, du_));
  }
  const NodalVector v1 = motion_->velocity(du_);
  const double gained =
      world_.comm.sum(motion_->kinetic_energy(d, v1) - motion_->kinetic_energy(d, motion_->velocity()));
  const double before = world_.kinetic_energy();
  d.commit_motion(motion_->velocity(), motion_->acceleration(), v1, motion_->acceleration(du_), how);
  balance_.kinetic = world_.kinetic_energy();
  balance_.transferred += gained - (balance_.kinetic - before);
}

/// What moves goes on to move unless the stage is quasi-static.
void ImplicitStep::begin_stage() {
  const Stage& stage = world_.present_stage();
  Discretisation& d = *world_.discretisation;
  set_up_stage();
  if (stage.steps.analysis == Analysis::quasi_static && balance_.kinetic > 0.0) {
    d.start_motion([](int, const Vec3&) { return Vec3(Vec3::Zero()); });
    balance_.damped += balance_.kinetic;
    balance_.kinetic = 0.0;
  }
  if (stage.reset_displacements) d.reset_displacements();
}

/// Solver and integrator of the world's stage.
void ImplicitStep::set_up_stage() {
  const Stage& stage = world_.present_stage();
  if (newton_) {
    times_.linear += newton_->linear_seconds();
    const LinearCount n = newton_->count();
    linear_count_ = {linear_count_.solves + n.solves, linear_count_.iterations + n.iterations,
                     linear_count_.fallbacks + n.fallbacks};
  }
  newton_ = std::make_unique<NewtonSolver>(stage.solver, world_.comm);
  connectivity_ = -1;                            // it has no matrix yet
  if (world_.boundary->stage() != stage.name) {  // other unknowns may be prescribed
    world_.boundary->begin_stage(stage.name);
    prepared_ = world_.step_begun = false;
  }
  last_dt_ = 0.0;
  motion_.reset();
  motion_ready_ = false;
  if (stage.steps.analysis == Analysis::dynamic) motion_.emplace(stage.dynamics, world_.spec.method == Method::fem);
}

void ImplicitStep::restore(const Balance& balance, bool in_equilibrium, const std::string& stage) {
  balance_ = balance;
  in_equilibrium_ = in_equilibrium;
  last_stage_ = stage;
}

LinearCount ImplicitStep::linear_count() const {
  const LinearCount n = newton_->count(), before = linear_count_;
  return {before.solves + n.solves, before.iterations + n.iterations, before.fallbacks + n.fallbacks};
}

StepTimes ImplicitStep::times() const {
  StepTimes t = times_;
  t.linear += newton_->linear_seconds();
  return t;
}

}  // namespace berm
