#include "sim/newmark.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace berm {

/// Bossak: alpha weighs inertia (Wood, Bossak and Zienkiewicz 1980); HHT: forces (Hilber, Hughes and Taylor 1977). The
/// same beta and gamma make both accurate to second order and unconditionally stable.
Newmark::Newmark(const Dynamics& how, bool at_nodes) : how_(how), at_nodes_(at_nodes) {
  if (how.integrator == Dynamics::Integrator::newmark) return;  // half and half: no acceleration at t_n is asked for
  old_ = old_mass_ = 0.0;
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
  momentum_.assign(n, Vec3::Zero());
  gathered_a_.assign(n, Vec3::Zero());
  d.add_motion(mass_, momentum_, gathered_a_);
  whole_mass_ = mass_;
  d.halo.add_to_owners(whole_mass_.data(), 1);
  d.halo.copy_to_ghosts(whole_mass_.data(), 1);
  sum_at_owners(d, momentum_);
  sum_at_owners(d, gathered_a_);
  gathered_v_ = project(d, momentum_);
  gathered_a_ = project(d, gathered_a_);
}

void Newmark::sum_at_owners(const Discretisation& d, NodalVector& list) const {
  d.halo.add_to_owners(list.data()->data(), 3);
}

/// Complete at owned nodes; out: everywhere.
NodalVector Newmark::over_mass(const Discretisation& d, NodalVector list) const {
  d.halo.copy_to_ghosts(list.data()->data(), 3);
  for (std::size_t i = 0; i < list.size(); ++i)
    if (whole_mass_[i] > 0.0) list[i] /= whole_mass_[i];
  return list;
}

/// Lumped: of order 1. Order k takes k - 1 steps of Richardson's iteration towards the consistent mass (FMPM).   [(19)]
NodalVector Newmark::project(const Discretisation& d, const NodalVector& momentum) const {
  NodalVector v = over_mass(d, momentum);
  for (int k = 1; k < how_.projection_order; ++k) {
    NodalVector carried(v.size(), Vec3::Zero());
    d.add_inertia(0.0, v, carried, nullptr);
    sum_at_owners(d, carried);
    for (std::size_t i = 0; i < v.size(); ++i) carried[i] = momentum[i] - carried[i];
    const NodalVector more = over_mass(d, std::move(carried));
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += more[i];
  }
  return v;
}

/// Points that carry a gradient have the lumped mass's momentum, M_lumped v in one dimension; FEM keeps velocities. Bossak
/// and HHT carry accelerations, which go to the nodes by (2), and their velocities with them.
bool Newmark::fits() const {
  return means() && how_.mass == Dynamics::Mass::consistent && how_.transfer != Dynamics::Transfer::apic &&
         how_.projection_order == 1 && !at_nodes_;
}

/// M v0 = P at the unknowns that are not prescribed, by conjugate gradients from the smooth velocities on, with the lumped
/// mass as preconditioner. P is in the range of M, so the directions in which M is singular stay as they are.   [(20)]
void Newmark::fit(const Discretisation& d) {
  constexpr int most = 500;
  constexpr double tolerance = 1e-11;
  const std::size_t n = v0_.size();
  const auto times_mass = [&](const NodalVector& v) {
    NodalVector f(n, Vec3::Zero());
    d.add_inertia(0.0, v, f, nullptr);
    sum_at_owners(d, f);
    return f;
  };
  const auto dot = [&](const NodalVector& a, const NodalVector& b) {
    double sum = 0.0;
    for (int i = 0; i < d.halo.n_owned; ++i) sum += a[i].dot(b[i]);
    return d.comm().sum(sum);
  };
  const auto free_part = [&](NodalVector list) {
    for (std::size_t i = 0; i < n; ++i)
      for (int c = 0; c < dimension_; ++c)
        if (is_fixed(i, c)) list[i][c] = 0.0;
    return list;
  };
  NodalVector r = times_mass(v0_);
  for (std::size_t i = 0; i < n; ++i) r[i] = momentum_[i] - r[i];
  r = free_part(std::move(r));
  NodalVector z = over_mass(d, r), p = z;
  double rz = dot(r, z);
  // Of a body at rest whose supports move there is nothing but what they give it.
  const double enough = tolerance * tolerance * std::max(rz, dot(momentum_, over_mass(d, momentum_)));
  for (int k = 0; k < most && rz > enough; ++k) {
    const NodalVector q = free_part(times_mass(p));
    const double pq = dot(p, q);
    if (!(pq > 0.0)) break;
    const double step = rz / pq;
    for (std::size_t i = 0; i < n; ++i) {
      v0_[i] += step * p[i];
      r[i] -= step * q[i];
    }
    z = over_mass(d, r);
    const double before = rz;
    rz = dot(r, z);
    for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + rz / before * p[i];
  }
}

void Newmark::set_acceleration(const NodalVector& force) {
  for (std::size_t i = 0; i < force.size(); ++i)
    gathered_a_[i] = whole_mass_[i] > 0.0 ? Vec3(force[i] / whole_mass_[i]) : Vec3::Zero();
}

void Newmark::prescribe(const Discretisation& d, double dt, const std::vector<char>& fixed, const std::vector<double>& v0,
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
  smooth_v0_ = v0_;
  if (fits()) fit(d);
}

NodalVector Newmark::guess() const {
  NodalVector du(v0_.size());
  for (std::size_t i = 0; i < du.size(); ++i) du[i] = dt_ * smooth_v0_[i] + 0.5 * dt_ * dt_ * a0_[i];
  return du;
}

/// Newmark asks for none; what is carried on, for the guess and the error of the next step, is the mean one.
NodalVector Newmark::acceleration(const NodalVector& du) const {
  const double by_du = means() ? 2.0 / (dt_ * dt_) : 1.0 / (beta_ * dt_ * dt_),
               by_a = means() ? 0.0 : 1.0 - 0.5 / beta_;
  NodalVector a(du.size());
  for (std::size_t i = 0; i < du.size(); ++i) {
    a[i] = by_du * (du[i] - dt_ * v0_[i]) + by_a * a0_[i];
    for (int c = 0; c < dimension_; ++c)
      if (is_fixed(i, c)) a[i][c] = fixed_a_[dimension_ * i + c];
  }
  return a;
}

/// (5) with (4): without any acceleration where gamma = 2 beta.
NodalVector Newmark::velocity(const NodalVector& du) const {
  const double by_du = velocity_by_increment(), by_a = dt_ * (1.0 - 0.5 * gamma_ / beta_);
  NodalVector v(du.size());
  for (std::size_t i = 0; i < du.size(); ++i) {
    v[i] = v0_[i] + by_du * (du[i] - dt_ * v0_[i]) + by_a * a0_[i];
    for (int c = 0; c < dimension_; ++c)
      if (is_fixed(i, c)) v[i][c] = fixed_v1_[dimension_ * i + c];
  }
  return v;
}

NodalVector Newmark::weighed_velocity(const NodalVector& du) const {
  NodalVector v = velocity(du);
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = new_weight() * v[i] + old_weight() * v0_[i];
  return v;
}

void Newmark::add_forces(const Discretisation& d, const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const {
  const double by_du = (1.0 - old_mass_) / (beta_ * dt_ * dt_),
               by_a = old_mass_ - (1.0 - old_mass_) * (0.5 / beta_ - 1.0);
  NodalVector a = weighed_velocity(du);
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] *= how_.rayleigh_mass;
    for (int c = 0; c < dimension_; ++c)
      a[i][c] += is_fixed(i, c) ? fixed_a_[dimension_ * i + c]
                                : by_du * (du[i][c] - dt_ * v0_[i][c]) + by_a * a0_[i][c];
  }
  add_mass_times(d, by_du + how_.rayleigh_mass * weighed_velocity_by_increment(), a, f, matrix);
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

Newmark::Resolution Newmark::resolution(const Discretisation& d, const NodalVector& du) const {
  const NodalVector a = acceleration(du);
  double change = 0.0, back = 0.0, size = 0.0;
  for (int i = 0; i < d.halo.n_owned; ++i) {
    change += whole_mass_[i] * (a[i] - a0_[i]).squaredNorm();
    back -= whole_mass_[i] * (a[i] - a0_[i]).dot(du[i]);
    size += whole_mass_[i] * du[i].squaredNorm();
  }
  change = d.comm().sum(change);
  back = d.comm().sum(back);
  size = d.comm().sum(size);
  if (!(size > 0.0)) return {};
  return {std::abs(beta_ - 1.0 / 6.0) * dt_ * dt_ * std::sqrt(change / size), back > 0.0 ? 2.0 * std::numbers::pi / (std::sqrt(back / size) * dt_) : 0.0};
}

}  // namespace berm
