#include "sim/quasi_static.hpp"

#include <algorithm>
#include <cmath>

#include "base/stopwatch.hpp"

namespace berm {
namespace {

double norm(const NodalVector& f) {
  double sum = 0.0;
  for (const Vec2& v : f) sum += v.squaredNorm();
  return std::sqrt(sum);
}

double dot(const NodalVector& a, const NodalVector& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

/// IMPL-EX steps are linear but for the change of geometry: this relative residual is accepted after one solve, the
/// rest is carried into the next step's equilibrium.
constexpr double impl_ex_tolerance = 1e-5;

bool all_elastic(const MaterialState& m) {
  return std::all_of(m.slices.begin(), m.slices.end(),
                     [](const Slice& s) { return std::holds_alternative<LinearElastic>(s.law); });
}

}  // namespace

QuasiStaticStep::QuasiStaticStep(World& world) : world_(world), newton_(world.spec.solver.max_iterations) {
  const Case& c = world.spec;
  settings_.plane = c.plane;
  settings_.kinematics = c.kinematics;
  if (c.control.kind == Control::Kind::gauge)
    for (std::size_t g = 0; g < world.boundary->gauges().size(); ++g)
      if (world.boundary->gauges()[g].name == c.control.gauge) gauge_ = static_cast<int>(g);
  // The gauge equation is scaled to a force: the matrix stays well conditioned and one norm serves both.
  gauge_scale_ = world.elastic_scale / world.discretisation->cell_size();
  balance_.rigid_force.assign(c.bodies.size(), Vec2::Zero());
  balance_.boundary_force.assign(c.boundaries.size(), Vec2::Zero());
  balance_.pressure_force.assign(c.pressures.size(), Vec2::Zero());
}

void QuasiStaticStep::prepare(Integration integration) {
  Discretisation& d = *world_.discretisation;
  BoundaryConditions& bc = *world_.boundary;
  settings_.integration = integration;
  const bool symmetric = gauge_ < 0 && (integration != Integration::implicit || all_elastic(d.material));
  const Stopwatch watch(times_.connectivity);
  if (!prepared_) {
    d.begin_step(bc.anchors());
    bc.begin_step(d);
    pressure_.assign(d.n_nodes(), Vec2::Zero());
    bc.add_pressure(pressure_);
    last_du_.resize(d.n_nodes(), Vec2::Zero());
    prepared_ = true;
  }
  Border border;
  if (gauge_ >= 0) {
    border.active = true;
    const GaugeLine& g = bc.gauges()[gauge_];
    std::vector<Vec2> functional(d.n_nodes(), Vec2::Zero());
    for (int k = 0; k < g.to.stencil.n; ++k) functional[g.to.stencil.node[k]] += g.to.stencil.N[k] * g.direction;
    for (int k = 0; k < g.from.stencil.n; ++k) functional[g.from.stencil.node[k]] -= g.from.stencil.N[k] * g.direction;
    for (int dof = 0; dof < 2 * d.n_nodes(); ++dof) {
      const int equation = bc.equation()[dof];
      if (equation < 0) continue;
      if (pressure_[dof / 2][dof % 2] != 0.0) border.column_rows.push_back(equation);
      if (functional[dof / 2][dof % 2] != 0.0) border.row_columns.push_back(equation);
    }
  }
  const bool same = blocks_ == d.blocks && equation_ == bc.equation() && border_ == border;
  if (!same) {
    blocks_ = d.blocks;
    equation_ = bc.equation();
    border_ = border;
    n_unknowns_ = bc.n_equations() + (border.active ? 1 : 0);
    assembler_.build(blocks_, equation_, bc.n_equations(), border_);
    last_dt_ = 0.0;
  }
  if (!same || symmetric != symmetric_) newton_.set_matrix(assembler_.matrix(), symmetric);
  symmetric_ = symmetric;
}

/// Unknowns to the nodal increment of the step and the load factor.
void QuasiStaticStep::scatter(const std::vector<double>& x) {
  for (std::size_t dof = 0; dof < equation_.size(); ++dof)
    du_[dof / 2][dof % 2] = equation_[dof] >= 0 ? x[equation_[dof]] : prescribed_[dof];
  load_factor_ = gauge_ >= 0 ? x.back() : t1_;
}

double QuasiStaticStep::gauge_value() const {
  const GaugeLine& g = world_.boundary->gauges()[gauge_];
  return g.elongation() + g.direction.dot(g.to.stencil.interpolate(du_) - g.from.stencil.interpolate(du_));
}

/// r = internal + stabilisation + contact and pins - load factor * pressure - weight.   [formulation (1), (14)]
bool QuasiStaticStep::residual(const std::vector<double>& x, std::vector<double>& r, bool tangent) {
  if (!tangent && !x.empty() && x == cached_x_) {
    r = cached_r_;
    return true;
  }
  Discretisation& d = *world_.discretisation;
  BoundaryConditions& bc = *world_.boundary;
  scatter(x);
  {
    const Stopwatch watch(times_.response);
    if (d.evaluate(du_, settings_, tangent) != Status::ok) return false;
  }
  const Stopwatch watch(times_.assembly);
  force_.assign(d.n_nodes(), Vec2::Zero());
  d.add_internal_force(force_);
  const double scale = norm(force_);
  external_.assign(d.n_nodes(), Vec2::Zero());
  if (!world_.spec.gravity.isZero()) d.add_body_force(world_.spec.gravity * t1_, external_);
  for (std::size_t i = 0; i < external_.size(); ++i) external_[i] += load_factor_ * pressure_[i];
  force_scale_ = std::max(scale, norm(external_));
  d.add_stabilisation(du_, force_, nullptr);
  bc.add_forces(du_, t0_, t1_, force_, nullptr);
  for (std::size_t i = 0; i < force_.size(); ++i) force_[i] -= external_[i];

  r.resize(n_unknowns_);
  for (std::size_t dof = 0; dof < equation_.size(); ++dof)
    if (equation_[dof] >= 0) r[equation_[dof]] = force_[dof / 2][dof % 2];
  if (gauge_ >= 0) r.back() = gauge_scale_ * (gauge_value() - world_.spec.control.target * t1_);
  cached_x_ = x;
  cached_r_ = r;
  return true;
}

/// The matrix of the trial state last evaluated with its tangent.
void QuasiStaticStep::assemble(const std::vector<double>* prescribed) {
  const Stopwatch watch(times_.assembly);
  const Discretisation& d = *world_.discretisation;
  NodalVector unused(d.n_nodes(), Vec2::Zero());
  assembler_.zero(prescribed);
  d.add_tangent(assembler_);
  d.add_stabilisation(du_, unused, &assembler_);
  world_.boundary->add_forces(du_, t0_, t1_, unused, &assembler_);
  if (gauge_ < 0) return;
  std::vector<double> column, row;
  const GaugeLine& g = world_.boundary->gauges()[gauge_];
  std::vector<double> functional(n_unknowns_, 0.0), load(n_unknowns_, 0.0);
  auto add = [&](const Anchor& a, double sign) {
    for (int k = 0; k < a.stencil.n; ++k)
      for (int c = 0; c < 2; ++c) {
        const int equation = equation_[2 * a.stencil.node[k] + c];
        if (equation >= 0) functional[equation] += sign * gauge_scale_ * a.stencil.N[k] * g.direction[c];
      }
  };
  add(g.to, 1.0);
  add(g.from, -1.0);
  for (std::size_t dof = 0; dof < equation_.size(); ++dof)
    if (equation_[dof] >= 0) load[equation_[dof]] = -pressure_[dof / 2][dof % 2];
  for (int equation : border_.column_rows) column.push_back(load[equation]);
  for (int equation : border_.row_columns) row.push_back(functional[equation]);
  assembler_.set_border(column, row);
}

/// First guess from the tangent at t_n: K_ff dx = -r(0) - K_fp du_p. The only linear solve of an IMPL-EX step.
bool QuasiStaticStep::linear_predictor(std::vector<double>& x) {
  const std::vector<double> prescribed = prescribed_;
  std::fill(prescribed_.begin(), prescribed_.end(), 0.0);
  x.assign(n_unknowns_, 0.0);
  if (gauge_ >= 0) x.back() = world_.load_factor;
  std::vector<double> r, dx;
  const bool fine = residual(x, r, true);
  if (fine) assemble(&prescribed);
  prescribed_ = prescribed;
  cached_x_.clear();
  if (!fine) return false;
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = -r[i] - assembler_.prescribed_force()[i];
  if (!newton_.solve_linear(r, dx)) return false;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += dx[i];
  return true;
}

NewtonResult QuasiStaticStep::solve(std::vector<double>& x, double tolerance, bool line_search) {
  return newton_.solve(
      x, tolerance, line_search, [this](const auto& at, auto& out) { return residual(at, out, false); },
      [this](const auto& at) {
        std::vector<double> unused;
        residual(at, unused, true);
        assemble(nullptr);
      });
}

StepResult QuasiStaticStep::attempt(double dt, Integration integration) {
  prepare(integration);
  t0_ = world_.time;
  t1_ = world_.time + dt;
  settings_.dt = dt;
  prescribed_ = world_.boundary->prescribed_increment(t0_, t1_);
  du_.assign(world_.discretisation->n_nodes(), Vec2::Zero());
  cached_x_.clear();

  StepResult result;
  std::vector<double> x, r;
  if (integration == Integration::implicit && last_dt_ > 0.0 && gauge_ < 0) {
    x.resize(n_unknowns_);
    for (std::size_t dof = 0; dof < equation_.size(); ++dof)
      if (equation_[dof] >= 0) x[equation_[dof]] = last_du_[dof / 2][dof % 2] * dt / last_dt_;
  } else {
    ++result.iterations;
    if (!linear_predictor(x)) {
      result.reason = "the matrix of the first guess could not be factorised";
      return result;
    }
  }
  if (!residual(x, r, false)) {
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
  residual(x, r, false);  // the trial state of the solution, if a rejected line search came after it
  result.extrapolation_error = world_.discretisation->material.max_extrapolation_error();
  return result;
}

/// Commit: energies by the trapezoidal rule on forces and displacements, then points, contact, time.
void QuasiStaticStep::accept() {
  Discretisation& d = *world_.discretisation;
  BoundaryConditions& bc = *world_.boundary;
  const Case& c = world_.spec;
  const double dt = t1_ - t0_;
  double work = 0.0;
  for (std::size_t b = 0; b < c.bodies.size(); ++b) {
    if (!c.bodies[b].rigid) continue;
    const Vec2 force = bc.rigid_force(static_cast<int>(b), du_, t0_, t1_, force_);
    work += 0.5 * (force + balance_.rigid_force[b]).dot(c.bodies[b].displacement) * dt;
    balance_.rigid_force[b] = force;
  }
  for (std::size_t b = 0; b < c.boundaries.size(); ++b) {
    const Vec2 force = bc.boundary_force(static_cast<int>(b), force_);
    const Vec2 motion(c.boundaries[b].ux.value_or(0.0), c.boundaries[b].uy.value_or(0.0));
    work += 0.5 * (force + balance_.boundary_force[b]).dot(motion) * dt;
    balance_.boundary_force[b] = force;
  }
  work += 0.5 * (load_factor_ + world_.load_factor) * dot(pressure_, du_);
  for (std::size_t k = 0; k < c.pressures.size(); ++k)
    balance_.pressure_force[k] = load_factor_ * bc.pressure_force(c.pressures[k].name);
  if (!c.gravity.isZero()) {
    NodalVector weight(d.n_nodes(), Vec2::Zero());
    d.add_body_force(c.gravity * (0.5 * (t0_ + t1_)), weight);
    work += dot(weight, du_);
  }
  balance_.external_work += work;

  bc.commit(du_, t0_, t1_);
  d.commit(du_, bc.anchors());
  last_du_ = du_;
  last_dt_ = dt;
  world_.time = t1_;
  world_.load_factor = load_factor_;
  prepared_ = false;
}

StepTimes QuasiStaticStep::times() const {
  StepTimes t = times_;
  t.linear = newton_.linear_seconds();
  return t;
}

}  // namespace berm
