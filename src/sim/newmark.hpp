#pragma once
/// Newmark's relations between the displacement, velocity and acceleration of the nodes over a step, with Bossak's and
/// HHT's numerical damping; inertia and damping forces.   [docs/theory/dynamics.md]

#include "case/case.hpp"
#include "method/discretisation.hpp"

namespace berm {

class Newmark {
public:
  /// at_nodes: the motion is kept at the nodes (fem).
  Newmark(const Dynamics& how, bool at_nodes);

  /// Mass, momentum and acceleration of the nodes from those of the material at t_n. Collective.   [(1), (2)]
  void gather(const Discretisation& d);
  /// Accelerations at t_n from the forces there, in place of those that the material carries.   [(10)]
  void set_acceleration(const NodalVector& force);
  /// Motion of the prescribed unknowns over the step: their velocities at its ends.   [(6)]
  void prescribe(const Discretisation& d, double dt, const std::vector<char>& fixed, const std::vector<double>& v0,
                 const std::vector<double>& v1);

  /// A first guess of the increment: with the acceleration at t_n.
  NodalVector guess() const;
  NodalVector velocity(const NodalVector& du) const;       ///< at t_{n+1}   [(5)]
  NodalVector acceleration(const NodalVector& du) const;   ///< that the material carries on   [(4)]
  const NodalVector& velocity() const { return v0_; }      ///< at t_n
  const NodalVector& acceleration() const { return a0_; }  ///< likewise
  /// At t_n, smooth: finite where nodes have barely any mass.   [(1)]
  const NodalVector& smooth_velocity() const { return smooth_v0_; }
  /// That of all nodes before any is prescribed.
  const NodalVector& gathered_acceleration() const { return gathered_a_; }

  /// With which forces that depend on the velocity are taken, and its derivative by du.   [(11)]
  NodalVector weighed_velocity(const NodalVector& du) const;
  double weighed_velocity_by_increment() const { return new_weight() * velocity_by_increment(); }

  /// Reactions are means over the step, not those of t_{n+1}.
  bool means() const { return how_.integrator == Dynamics::Integrator::newmark; }
  /// The weight of the internal and external forces of t_{n+1} in the equation of motion, and of those of t_n; the
  /// internal ones with Rayleigh's stiffness damping.   [(11), (13)]
  double new_weight() const { return 1.0 - old_; }
  double old_weight() const { return old_; }
  double new_internal_weight() const { return new_weight() + how_.rayleigh_stiffness / dt_; }
  double old_internal_weight() const { return old_weight() - how_.rayleigh_stiffness / dt_; }

  /// Inertia and damping that resist du, of this process, added to f; their matrix, if wanted.   [(12)]
  void add_forces(const Discretisation& d, const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const;
  /// Mass times acceleration at t_n of this process: a measure of the forces in play.
  NodalVector inertia() const;
  /// Damping forces at the velocity v that are no stiffness damping, of this process.   [(14), (15)]
  NodalVector damping(const Discretisation& d, NodalVector v) const;
  /// Of nodes with the velocities v, of this process [J].
  double kinetic_energy(const Discretisation& d, const NodalVector& v) const;
  /// How well a step follows the motion.
  struct Resolution {
    double error = 0.0;           ///< of the mean acceleration, relative to the displacement of the step   [(16)]
    double steps_a_period = 0.0;  ///< of what moves, by its kinetic energy; 0 if nothing swings   [(16a)]
  };
  /// Collective.
  Resolution resolution(const Discretisation& d, const NodalVector& du) const;

private:
  double velocity_by_increment() const { return gamma_ / (beta_ * dt_); }  ///< dv/du at t_{n+1}
  void sum_at_owners(const Discretisation& d, NodalVector& list) const;
  NodalVector over_mass(const Discretisation& d, NodalVector list) const;
  NodalVector project(const Discretisation& d, const NodalVector& momentum) const;
  bool fits() const;
  void fit(const Discretisation& d);
  double local_damping(std::size_t i, int c) const;
  void add_mass_times(const Discretisation& d, double factor, const NodalVector& a, NodalVector& f,
                      BlockAssembler* matrix) const;
  bool is_fixed(std::size_t i, int c) const { return (*fixed_)[dimension_ * i + c]; }

  Dynamics how_;
  bool at_nodes_;
  double beta_ = 0.25, gamma_ = 0.5;
  double old_ = 0.5;       ///< weight of the forces at t_n
  double old_mass_ = 0.5;  ///< weight of the inertia at t_n (Bossak: not positive)
  double dt_ = 1.0;
  int dimension_ = 2;
  std::vector<double> mass_;        ///< of this process
  std::vector<double> whole_mass_;  ///< of all processes
  NodalVector momentum_;                    ///< of the material, complete at owned nodes
  NodalVector gathered_v_, gathered_a_, v0_, a0_, smooth_v0_;
  const std::vector<char>* fixed_ = nullptr;
  std::vector<double> fixed_v1_, fixed_a_;  ///< of prescribed unknowns
};

}  // namespace berm
