#include "sim/quasi_static.hpp"

#include <algorithm>
#include <cmath>

#include "base/stopwatch.hpp"

namespace berm {
namespace {

/// IMPL-EX steps are linear but for the change of geometry: this relative residual is accepted after one solve, the
/// rest is carried into the next step's equilibrium.
constexpr double impl_ex_tolerance = 1e-5;

bool all_elastic(const MaterialState& m) {
  return std::all_of(m.slices.begin(), m.slices.end(),
                     [](const Slice& s) { return std::holds_alternative<LinearElastic>(s.law); });
}

}  // namespace

QuasiStaticStep::QuasiStaticStep(World& world)
    : world_(world), dimension_(world.spec.dimension()), newton_(world.spec.solver, world.comm) {
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
}

/// Over the nodes of all processes; a and b complete at the owned ones.
double QuasiStaticStep::dot(const NodalVector& a, const NodalVector& b) const {
  double sum = 0.0;
  for (int i = 0; i < world_.discretisation->halo.n_owned; ++i) sum += a[i].dot(b[i]);
  return world_.comm.sum(sum);
}

double QuasiStaticStep::norm(const NodalVector& f) const { return std::sqrt(dot(f, f)); }

int QuasiStaticStep::n_mine() const {
  return dimension_ * world_.discretisation->halo.n_owned + (owns_border() ? 1 : 0);
}

void QuasiStaticStep::prepare(Integration integration) {
  Discretisation& d = *world_.discretisation;
  settings_.integration = integration;
  const bool symmetric =
      gauge_ < 0 && world_.boundary->symmetric() && (integration != Integration::implicit || all_elastic(d.material));
  const Stopwatch watch(times_.connectivity);
  if (!prepared_) {
    if (!world_.step_begun) world_.begin_step();
    if (gauge_ >= 0) pressure_ = pressure_at(load_time(), no_motion());
    prepared_ = true;
  }
  if (connectivity_ != d.connectivity) last_dt_ = 0.0;
  lay_out(symmetric);
}

NodalVector QuasiStaticStep::no_motion() const { return NodalVector(world_.discretisation->n_nodes(), Vec3::Zero()); }

/// Complete at owned nodes.
NodalVector QuasiStaticStep::pressure_at(double time, const NodalVector& du) const {
  const Discretisation& d = *world_.discretisation;
  NodalVector f = no_motion();
  world_.comm.agree([&] { world_.boundary->add_pressure(time, du, 1.0, f, nullptr); });
  d.halo.add_to_owners(f.data()->data(), 3);
  return f;
}

NodalVector QuasiStaticStep::weight_at(double time) const {
  const Discretisation& d = *world_.discretisation;
  NodalVector f(d.n_nodes(), Vec3::Zero());
  if (world_.spec.gravity.is_zero()) return f;
  d.add_body_force(world_.spec.gravity.at(time), f);
  d.halo.add_to_owners(f.data()->data(), 3);
  return f;
}

/// The matrix for the present connectivity, gauge and symmetry.
void QuasiStaticStep::lay_out(bool symmetric) {
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
  layout.n_mine = n_mine();
  layout.n_global = dimension_ * d.halo.n_global + (border_.active ? 1 : 0);
  for (std::int64_t node : d.halo.global)
    for (int i = 0; i < dimension_; ++i) layout.global.push_back(dimension_ * node + i);
  if (border_.active) layout.global.push_back(layout.n_global - 1);
  layout.places.assign(d.nodes.begin(), d.nodes.begin() + d.halo.n_owned);
  newton_.set_matrix(assembler_.matrix(), layout, symmetric);
}

/// Unknowns to the nodal increment of the step and the load factor.
void QuasiStaticStep::scatter(const std::vector<double>& x) {
  const Discretisation& d = *world_.discretisation;
  const std::vector<char>& fixed = world_.boundary->fixed();
  for (int k = 0; k < dimension_ * d.halo.n_owned; ++k)
    du_[k / dimension_][k % dimension_] = fixed[k] ? prescribed_[k] : x[k];
  d.halo.copy_to_ghosts(du_.data()->data(), 3);
  load_factor_ = gauge_ >= 0 ? world_.comm.broadcast(owns_border() ? x.back() : 0.0, world_.comm.size() - 1)
                             : t1_ / world_.spec.steps.duration;
}

double QuasiStaticStep::gauge_value() const {
  double value = 0.0;
  for (std::size_t i = 0; i < du_.size(); ++i) value += functional_[i].dot(du_[i]);
  return world_.boundary->gauges()[gauge_].elongation() + world_.comm.sum(value);
}

/// force_ = internal + stabilisation + contact and pins - pressure (gauge: times load factor) - weight, complete at
/// owned nodes. [formulation (1), (14)]
void QuasiStaticStep::sum_forces() {
  const Stopwatch watch(times_.assembly);
  const Discretisation& d = *world_.discretisation;
  force_.assign(d.n_nodes(), Vec3::Zero());
  d.add_internal_force(force_);
  d.halo.add_to_owners(force_.data()->data(), 3);
  const double scale = norm(force_);
  external_ = weight_;
  pressure_ = pressure_at(load_time(), du_);
  for (std::size_t i = 0; i < external_.size(); ++i) external_[i] += pressure_factor() * pressure_[i];
  force_scale_ = std::max(scale, norm(external_));
  NodalVector resisting(d.n_nodes(), Vec3::Zero());
  d.add_stabilisation(du_, resisting, nullptr);
  world_.boundary->add_forces(du_, t0_, t1_, resisting, nullptr);
  d.halo.add_to_owners(resisting.data()->data(), 3);
  for (std::size_t i = 0; i < force_.size(); ++i) force_[i] += resisting[i] - external_[i];
}

bool QuasiStaticStep::residual(const std::vector<double>& x, std::vector<double>& r) {
  const bool cached = !cached_r_.empty() && x == cached_x_;
  if (world_.comm.all(cached)) {
    r = cached_r_;
    return true;
  }
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
    const double value =
        gauge_scale_ * (gauge_value() - world_.spec.control.target * (t1_ / world_.spec.steps.duration));
    if (owns_border()) r.back() = value;
  }
  cached_x_ = x;
  cached_r_ = r;
  return true;
}

/// The matrix of the trial state last evaluated.
void QuasiStaticStep::assemble(const std::vector<double>* prescribed) {
  const Stopwatch watch(times_.assembly);
  const Discretisation& d = *world_.discretisation;
  const std::vector<char>& fixed = world_.boundary->fixed();
  NodalVector unused(d.n_nodes(), Vec3::Zero());
  assembler_.zero(fixed, d.halo.n_owned, gauge_scale_, prescribed);
  d.add_tangent(settings_, assembler_);
  d.add_stabilisation(du_, unused, &assembler_);
  world_.boundary->add_forces(du_, t0_, t1_, unused, &assembler_);
  world_.comm.agree(
      [&] { world_.boundary->add_pressure(load_time(), du_, pressure_factor(), unused, &assembler_); });
  if (gauge_ < 0) return;
  std::vector<double> column, row;
  for (int k : border_.column_rows) column.push_back(fixed[k] ? 0.0 : -pressure_[k / dimension_][k % dimension_]);
  for (int k : border_.row_columns)
    row.push_back(fixed[k] ? 0.0 : gauge_scale_ * functional_[k / dimension_][k % dimension_]);
  assembler_.set_border(column, row);
}

/// First guess from the tangent at t_n: K_ff dx = -r(0) - K_fp du_p. The only linear solve of an IMPL-EX step.
bool QuasiStaticStep::linear_predictor(std::vector<double>& x) {
  const Discretisation& d = *world_.discretisation;
  const std::vector<double> prescribed = prescribed_;
  std::fill(prescribed_.begin(), prescribed_.end(), 0.0);
  x.assign(n_mine(), 0.0);
  if (owns_border()) x.back() = world_.load_factor;
  std::vector<double> r, dx;
  const bool fine = residual(x, r);
  if (fine) assemble(&prescribed);
  prescribed_ = prescribed;
  cached_r_.clear();
  if (!fine) return false;
  std::vector<double> from_prescribed = assembler_.prescribed_force();
  d.halo.add_to_owners(from_prescribed.data(), dimension_);
  for (std::size_t k = 0; k < r.size(); ++k) {
    const bool border = owns_border() && k + 1 == r.size();
    r[k] = -r[k] - (border ? 0.0 : from_prescribed[k]);
  }
  if (!newton_.solve_linear(r, dx)) return false;
  for (std::size_t k = 0; k < x.size(); ++k) x[k] += dx[k];
  return true;
}

std::vector<double> QuasiStaticStep::last_increment(double factor) const {
  std::vector<double> x(n_mine(), 0.0);
  for (int k = 0; k < dimension_ * world_.discretisation->halo.n_owned; ++k)
    x[k] = last_du_[k / dimension_][k % dimension_] * factor;
  return x;
}

NewtonResult QuasiStaticStep::solve(std::vector<double>& x, double tolerance, bool line_search) {
  return newton_.solve(
      x, tolerance, line_search, [this](const auto& at, auto& out) { return residual(at, out); },
      [this](const auto& at) {
        std::vector<double> unused;
        residual(at, unused);  // the trial state may be that of another place
        assemble(nullptr);
      });
}

/// Throws, on all processes alike, if a motion has no value at the end of the step.
void QuasiStaticStep::check_motions() const {
  for_each_motion(world_.spec, [this](const TimeFunction& f) {
    if (!f.depends_on_place()) f.at(t1_);
  });
}

StepResult QuasiStaticStep::attempt(double dt, Integration integration) {
  prepare(integration);
  n_unknowns_ = world_.boundary->n_free() + (gauge_ >= 0 ? 1 : 0);
  t0_ = world_.time;
  t1_ = world_.time + dt;
  settings_.dt = dt;
  check_motions();
  weight_ = weight_at(t1_);
  world_.comm.agree([&] { prescribed_ = world_.boundary->prescribed_increment(t0_, t1_); });
  du_.assign(world_.discretisation->n_nodes(), Vec3::Zero());
  cached_r_.clear();

  StepResult result;
  std::vector<double> x, r;
  if (integration == Integration::implicit && last_dt_ > 0.0 && gauge_ < 0) {
    x = last_increment(dt / last_dt_);
  } else {
    ++result.iterations;
    if (!linear_predictor(x)) {
      result.reason = "the matrix of the first guess could not be factorised";
      return result;
    }
  }
  // Prescribed unknowns have their values in the vector too, so that Newton's corrections of them are zero.
  const std::vector<char>& fixed = world_.boundary->fixed();
  for (int k = 0; k < dimension_ * world_.discretisation->halo.n_owned; ++k)
    if (fixed[k]) x[k] = prescribed_[k];
  if (!residual(x, r)) {
    last_dt_ = 0.0;
    result.reason = "the first guess lies outside of what the law is defined for";
    return result;
  }
  const Solver& s = world_.spec.solver;
  const double relative =
      integration == Integration::implicit ? s.relative_tolerance : std::max(s.relative_tolerance, impl_ex_tolerance);
  const double scale = force_scale_;
  const double tolerance = relative * scale + s.absolute_tolerance * world_.elastic_scale;
  const std::vector<double> guess = x;
  NewtonResult newton = solve(x, tolerance, s.line_search);
  result.iterations += newton.iterations;
  if (!newton.converged && s.line_search) {
    // Where damage localises the residual norm has to grow before it falls: full steps get through more often.
    x = guess;
    newton = solve(x, tolerance, false);
    result.iterations += newton.iterations;
  }
  result.converged = newton.converged;
  const double reference = std::max(scale, s.absolute_tolerance * world_.elastic_scale);
  result.residual = newton.residual / reference;
  for (double value : newton.residuals) result.residuals.push_back(value / reference);
  result.reason = newton.reason;
  if (!result.converged) {
    last_dt_ = 0.0;
    return result;
  }
  residual(x, r);  // the trial state of the solution, if a rejected line search came after it
  result.extrapolation_error = world_.comm.max(world_.discretisation->material.max_extrapolation_error());
  return result;
}

/// Commit: energies by the trapezoidal rule on forces and displacements, then points, contact, time.
void QuasiStaticStep::accept() {
  Discretisation& d = *world_.discretisation;
  BoundaryConditions& bc = *world_.boundary;
  const Case& c = world_.spec;
  double work = 0.0;
  const Reactions now = bc.reactions(du_, t0_, t1_, force_);
  const Reactions& before = balance_.reactions;
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].rigid)
      work += 0.5 *
              (now.rigid[b] + before.rigid[b]).dot(c.bodies[b].displacement.at(t1_) - c.bodies[b].displacement.at(t0_));
  work += bc.support_work(before, now, t0_, t1_);
  balance_.reactions = now;
  const double time_before = gauge_ >= 0 ? load_time() : t0_, factor_before = gauge_ >= 0 ? world_.load_factor : 1.0;
  work +=
      0.5 * (factor_before * dot(pressure_at(time_before, no_motion()), du_) + pressure_factor() * dot(pressure_, du_));
  balance_.pressure_force = bc.pressure_forces(load_time(), du_);
  for (Vec3& force : balance_.pressure_force) force *= pressure_factor();
  if (!c.gravity.is_zero()) work += 0.5 * (dot(weight_at(t0_), du_) + dot(weight_, du_));
  balance_.external_work += work;
  balance_.friction_work += bc.friction_work(du_, t0_, t1_);

  bc.commit(du_, t0_, t1_);
  d.commit(du_, bc.anchors());
  bc.share_gauges();
  last_du_ = du_;
  last_dt_ = t1_ - t0_;
  world_.time = t1_;
  world_.load_factor = load_factor_;
  prepared_ = world_.step_begun = false;
}

StepTimes QuasiStaticStep::times() const {
  StepTimes t = times_;
  t.linear = newton_.linear_seconds();
  return t;
}

}  // namespace berm
