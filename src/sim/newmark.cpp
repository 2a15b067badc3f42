#include "sim/newmark.hpp"

#include <cmath>

namespace berm {

/// Bossak: alpha weighs inertia (Wood, Bossak and Zienkiewicz 1980); HHT: forces (Hilber, Hughes and Taylor 1977). The
/// same beta and gamma make both accurate to second order and unconditionally stable.
Newmark::Newmark(const Dynamics& how) : how_(how) {
  if (how.integrator == Dynamics::Integrator::newmark) return;
  gamma_ = 0.5 - how.alpha;
  beta_ = 0.25 * (1.0 - how.alpha) * (1.0 - how.alpha);
  if (how.integrator == Dynamics::Integrator::hht)
    old_ = -how.alpha;
  else
    old_mass_ = how.alpha;
}

void Newmark::gather(const Discretisation& d) {
  dimension_ = d.dimension();
  const std::size_t n = d.n_nodes();
  mass_.assign(n, 0.0);
  gathered_v_.assign(n, Vec3::Zero());
  gathered_a_.assign(n, Vec3::Zero());
  d.add_motion(mass_, gathered_v_, gathered_a_);
  whole_mass_ = mass_;
  d.halo.add_to_owners(whole_mass_.data(), 1);
  d.halo.copy_to_ghosts(whole_mass_.data(), 1);
  for (NodalVector* list : {&gathered_v_, &gathered_a_}) *list = project(d, std::move(*list));
}

/// Lumped: of order 1. Order k takes k - 1 steps of Richardson's iteration towards the consistent mass (FMPM).   [(19)]
NodalVector Newmark::project(const Discretisation& d, NodalVector momentum) const {
  const auto sum = [&](NodalVector& list) { d.halo.add_to_owners(list.data()->data(), 3); };
  const auto over_mass = [&](NodalVector list) {
    d.halo.copy_to_ghosts(list.data()->data(), 3);
    for (std::size_t i = 0; i < list.size(); ++i)
      if (whole_mass_[i] > 0.0) list[i] /= whole_mass_[i];
    return list;
  };
  sum(momentum);
  NodalVector v = over_mass(momentum);
  for (int k = 1; k < how_.projection_order; ++k) {
    NodalVector carried(v.size(), Vec3::Zero());
    d.add_inertia(0.0, v, carried, nullptr);
    sum(carried);
    for (std::size_t i = 0; i < v.size(); ++i) carried[i] = momentum[i] - carried[i];
    const NodalVector more = over_mass(std::move(carried));
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += more[i];
  }
  return v;
}

void Newmark::set_acceleration(const NodalVector& force) {
  for (std::size_t i = 0; i < force.size(); ++i)
    gathered_a_[i] = whole_mass_[i] > 0.0 ? Vec3(force[i] / whole_mass_[i]) : Vec3::Zero();
}

void Newmark::prescribe(double dt, const std::vector<char>& fixed, const std::vector<double>& v0,
                        const std::vector<double>& v1) {
  dt_ = dt;
  fixed_ = &fixed;
  v0_ = gathered_v_;
  a0_ = gathered_a_;
  fixed_v1_ = v1;
  fixed_a_.assign(fixed.size(), 0.0);
  for (std::size_t i = 0; i < v0_.size(); ++i)
    for (int c = 0; c < dimension_; ++c) {
      const std::size_t k = dimension_ * i + c;
      if (!fixed[k]) continue;
      fixed_a_[k] = (v1[k] - v0[k]) / dt;
      v0_[i][c] = v0[k];
      a0_[i][c] = fixed_a_[k];
    }
}

NodalVector Newmark::guess() const {
  NodalVector du(v0_.size());
  for (std::size_t i = 0; i < du.size(); ++i) du[i] = dt_ * v0_[i] + 0.5 * dt_ * dt_ * a0_[i];
  return du;
}

NodalVector Newmark::acceleration(const NodalVector& du) const {
  NodalVector a(du.size());
  for (std::size_t i = 0; i < du.size(); ++i) {
    a[i] = (du[i] - dt_ * v0_[i]) / (beta_ * dt_ * dt_) - (0.5 / beta_ - 1.0) * a0_[i];
    for (int c = 0; c < dimension_; ++c)
      if (is_fixed(i, c)) a[i][c] = fixed_a_[dimension_ * i + c];
  }
  return a;
}

NodalVector Newmark::velocity(const NodalVector& du) const {
  NodalVector v = acceleration(du);
  for (std::size_t i = 0; i < du.size(); ++i) {
    v[i] = v0_[i] + dt_ * ((1.0 - gamma_) * a0_[i] + gamma_ * v[i]);
    for (int c = 0; c < dimension_; ++c)
      if (is_fixed(i, c)) v[i][c] = fixed_v1_[dimension_ * i + c];
  }
  return v;
}

void Newmark::add_forces(const Discretisation& d, const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const {
  const double by_a = (1.0 - old_mass_) / (beta_ * dt_ * dt_),
               by_v = how_.rayleigh_mass * new_weight() * velocity_by_increment();
  NodalVector a = acceleration(du);
  const NodalVector v = velocity(du);
  for (std::size_t i = 0; i < a.size(); ++i)
    a[i] = (1.0 - old_mass_) * a[i] + old_mass_ * a0_[i] +
           how_.rayleigh_mass * (new_weight() * v[i] + old_weight() * v0_[i]);
  add_mass_times(d, by_a + by_v, a, f, matrix);
  if (how_.local_damping == 0.0) return;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < dimension_; ++c) f[i][c] += local_damping(i, c);
}

/// M a, and `factor` times M.   [(3)]
void Newmark::add_mass_times(const Discretisation& d, double factor, const NodalVector& a, NodalVector& f,
                             BlockAssembler* matrix) const {
  if (how_.mass == Dynamics::Mass::consistent) return d.add_inertia(factor, a, f, matrix);
  for (std::size_t i = 0; i < a.size(); ++i) {
    f[i] += mass_[i] * a[i];
    for (int c = 0; matrix && c < dimension_; ++c)
      matrix->add_diagonal(static_cast<int>(dimension_ * i) + c, factor * mass_[i]);
  }
}

/// The unbalanced force is mass times acceleration; that of t_n is taken, so that it does not change within the step.
double Newmark::local_damping(std::size_t i, int c) const {
  const double size = how_.local_damping * mass_[i] * std::abs(a0_[i][c]);
  return v0_[i][c] > 0.0 ? size : v0_[i][c] < 0.0 ? -size : 0.0;
}

NodalVector Newmark::inertia() const {
  NodalVector f(a0_.size());
  for (std::size_t i = 0; i < f.size(); ++i) f[i] = mass_[i] * a0_[i];
  return f;
}

NodalVector Newmark::damping(const Discretisation& d, NodalVector v) const {
  NodalVector f(v.size(), Vec3::Zero());
  for (Vec3& component : v) component *= how_.rayleigh_mass;
  add_mass_times(d, 0.0, v, f, nullptr);
  for (std::size_t i = 0; i < f.size(); ++i)
    for (int c = 0; c < dimension_; ++c) f[i][c] += local_damping(i, c);
  return f;
}

double Newmark::kinetic_energy(const Discretisation& d, const NodalVector& v) const {
  NodalVector momentum(v.size(), Vec3::Zero());
  add_mass_times(d, 0.0, v, momentum, nullptr);
  double sum = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) sum += 0.5 * momentum[i].dot(v[i]);
  return sum;
}

double Newmark::error(const Discretisation& d, const NodalVector& du) const {
  const NodalVector a = acceleration(du);
  double change = 0.0, size = 0.0;
  for (int i = 0; i < d.halo.n_owned; ++i) {
    change += whole_mass_[i] * (a[i] - a0_[i]).squaredNorm();
    size += whole_mass_[i] * du[i].squaredNorm();
  }
  change = d.comm().sum(change);
  size = d.comm().sum(size);
  return size > 0.0 ? std::abs(beta_ - 1.0 / 6.0) * dt_ * dt_ * std::sqrt(change / size) : 0.0;
}

}  // namespace berm
