#pragma once
/// Mohr-Coulomb plasticity with dilatancy, tension cut-off and softening. docs/theory/plasticity.md.

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "law/isotropic_return.hpp"
#include "law/polyhedral_return.hpp"

namespace berm {

struct MohrCoulomb : YieldingElastic {
  static constexpr double no_cut_off = 1e30;  ///< a number that case files and schemas can hold

  double cohesion = 0.0;                   ///< [Pa]
  double friction_angle = 0.0;             ///< [rad]
  double dilatancy_angle = 0.0;            ///< [rad]
  double tensile_strength = no_cut_off;    ///< cut-off; larger than c cot(phi): none [Pa]
  double residual_cohesion = -1.0;         ///< negative: as at the start [Pa]
  double residual_friction_angle = -1.0;   ///< negative: as at the start [rad]
  double residual_dilatancy_angle = -1.0;  ///< negative: as at the start [rad]
  double softening_start = 0.0;            ///< accumulated plastic strain [-]
  double softening_end = 0.0;              ///< accumulated plastic strain; 0: no softening [-]

  static constexpr std::string_view name = "mohr_coulomb";
  static constexpr std::string_view doc =
      "Mohr-Coulomb plasticity of soil and rock, non-associated, with all edges and the apex (Clausen, Damkilde and "
      "Andersen 2006), Rankine tension cut-off and linear softening; friction angle 0: Tresca.";
  static constexpr int n_state = 7;
  static constexpr int elastic_strain = 0;
  static constexpr bool no_plane_stress = true;
  static constexpr int accumulated = 6;  ///< place of the accumulated plastic strain in the state
  /// Share of the elastic stiffness in the tangent of a point at a vertex, where the true tangent is zero: the same
  /// as of a broken point of the damage laws.
  static constexpr double residual_stiffness = 1e-5;

  static std::vector<Parameter<MohrCoulomb>> parameters() {
    using L = MohrCoulomb;
    const double right = 0.5 * std::numbers::pi, none = -1.0, degree = std::numbers::pi / 180.0;
    const Range angle{0.0, right, false, true}, any_angle{-degree, right, false, true}, any{-1.0, infinity};
    auto p = elastic_parameters<L>();
    p.push_back({"cohesion", &L::cohesion, Unit::stress, non_negative(), {}, "cohesion"});
    p.push_back(
        {"friction_angle", &L::friction_angle, Unit::angle, angle, {}, "angle of internal friction; 0: Tresca"});
    p.push_back({"dilatancy_angle", &L::dilatancy_angle, Unit::angle, angle, 0.0, "at most the friction angle"});
    p.push_back({"tensile_strength", &L::tensile_strength, Unit::stress, non_negative(), no_cut_off,
                 "tension cut-off; without it (or larger than that): cohesion / tan(friction_angle)"});
    p.push_back({"residual_cohesion", &L::residual_cohesion, Unit::stress, any, none,
                 "cohesion from `softening_end` on; negative: unchanged"});
    p.push_back({"residual_friction_angle", &L::residual_friction_angle, Unit::angle, any_angle, -degree,
                 "friction angle from `softening_end` on; negative: unchanged"});
    p.push_back({"residual_dilatancy_angle", &L::residual_dilatancy_angle, Unit::angle, any_angle, -degree,
                 "dilatancy angle from `softening_end` on; negative: unchanged"});
    p.push_back({"softening_start", &L::softening_start, Unit::none, non_negative(), 0.0,
                 "accumulated plastic strain at which the strength starts to change"});
    p.push_back({"softening_end", &L::softening_end, Unit::none, non_negative(), 0.0,
                 "accumulated plastic strain from which it is the residual one; 0: it never changes"});
    return p;
  }

  std::string check(double) const {
    const Strength first = strength(0.0), last = strength(infinity);
    if (first.psi > first.phi) return "dilatancy_angle is larger than friction_angle";
    if (last.psi > last.phi) return "the residual dilatancy angle is larger than the residual friction angle";
    if ((first.c == 0.0 && first.phi == 0.0) || (last.c == 0.0 && last.phi == 0.0))
      return "cohesion and friction_angle are both zero: no strength at all";
    const bool changes = residual_cohesion >= 0.0 || residual_friction_angle >= 0.0 || residual_dilatancy_angle >= 0.0;
    if (changes && !softens()) return "softening_end must be larger than softening_start, as a residual value is given";
    return {};
  }

  void initial_state(double* state) const { std::fill(state, state + n_state, 0.0); }

  /// Cohesion and angles at an accumulated plastic strain, and their derivatives by it, eq. (28).
  struct Strength {
    double c, phi, psi, c_rate, phi_rate, psi_rate;
  };

  bool softens() const { return softening_end > softening_start; }

  Strength strength(double kappa) const {
    if (!softens()) return {cohesion, friction_angle, dilatancy_angle, 0.0, 0.0, 0.0};
    const double range = softening_end - softening_start;
    const double t = kappa >= softening_end ? 1.0 : positive_part((kappa - softening_start) / range);
    const double t_rate = kappa >= softening_start && kappa < softening_end ? 1.0 / range : 0.0;
    const auto change = [](double from, double to) { return to >= 0.0 ? to - from : 0.0; };
    const double dc = change(cohesion, residual_cohesion), dphi = change(friction_angle, residual_friction_angle),
                 dpsi = change(dilatancy_angle, residual_dilatancy_angle);
    return {cohesion + t * dc, friction_angle + t * dphi, dilatancy_angle + t * dpsi, t_rate * dc, t_rate * dphi,
            t_rate * dpsi};
  }

  /// Planes that sorted principal stresses can touch.
  enum Plane { mc13, mc12, mc23, cut1, cut2, cut3, n_planes };
  /// Where a point returned to: the place in `sets`, or one of these.
  enum Region { elastic = -1, plane, edge_23, edge_12, first_cut, apex = 10 };
  /// Sets of active planes in the order in which they are tried. 7 and 8 are the same point, where four planes meet:
  /// what the other two triples of these planes take is not sorted.
  static constexpr std::array<ActiveSet, 10> sets = {{{1, {mc13}},
                                                      {2, {mc13, mc12}},
                                                      {2, {mc13, mc23}},
                                                      {1, {cut1}},
                                                      {2, {cut1, mc13}},
                                                      {2, {cut1, cut2}},
                                                      {3, {cut1, mc13, mc12}},
                                                      {3, {cut1, cut2, mc13}},
                                                      {3, {cut1, mc13, mc23}},
                                                      {3, {cut1, cut2, cut3}}}};

  struct Returned : PolyhedralReturn {
    int region = elastic;
  };

  using Planes = std::array<YieldPlane, n_planes>;

  bool cut_off(const Strength& y) const {
    return tensile_strength < no_cut_off && tensile_strength * std::sin(y.phi) < y.c * std::cos(y.phi);
  }

  /// Eqs. (20) and (21).
  Planes planes(const Strength& y) const {
    const double sin_phi = std::sin(y.phi), cos_phi = std::cos(y.phi), sin_psi = std::sin(y.psi);
    const double phi_rate = cos_phi * y.phi_rate, psi_rate = std::cos(y.psi) * y.psi_rate;
    Planes p;
    const int pairs[3][2] = {{0, 2}, {0, 1}, {1, 2}};
    for (int k = 0; k < 3; ++k) {
      const Vec3 i = Vec3::Unit(pairs[k][0]), j = Vec3::Unit(pairs[k][1]);
      p[k] = {(1.0 + sin_phi) * i - (1.0 - sin_phi) * j,
              (1.0 + sin_psi) * i - (1.0 - sin_psi) * j,
              2.0 * y.c * cos_phi,
              phi_rate * (i + j),
              psi_rate * (i + j),
              2.0 * (y.c_rate * cos_phi - y.c * sin_phi * y.phi_rate)};
      p[cut1 + k] = {Vec3::Unit(k), Vec3::Unit(k), tensile_strength};
    }
    return p;
  }

  /// Of the sorted stress over the planes mc13 and cut1, which no other plane exceeds: most points are elastic.
  double largest_excess(const Strength& y, const Vec3& s) const {
    const double sin_phi = std::sin(y.phi), limit = 2.0 * y.c * std::cos(y.phi);
    return std::max((1.0 + sin_phi) * s[0] - (1.0 - sin_phi) * s[2] - limit, s[0] - tensile_strength);
  }

  /// Return of the sorted trial stress to the surface of that strength and these planes. Without a cut-off, the apex
  /// takes what neither the plane nor one of the two edges does.
  Returned return_to(const Strength& y, const Planes& p, const Mat3& c, const Vec3& trial, bool derivatives) const {
    const bool cut = cut_off(y);
    const double rounding = 1e-15 * trial.cwiseAbs().maxCoeff();
    Returned best;
    for (int k = 0; k < (cut ? int(sets.size()) : int(first_cut)); ++k) {
      const PolyhedralReturn r = return_to_set(p, cut ? n_planes : cut1, sets[k], c, trial, derivatives);
      if (r.violation < best.violation) best = {r, k};
      if (best.violation <= rounding) return best;
    }
    const bool has_apex = !cut && y.phi > 0.0;
    if (has_apex && best.violation > 1e3 * rounding) return return_to_apex(y);
    return best;
  }

  /// Eq. (27). All three stresses are c cot(phi), exactly 0 without cohesion.
  static Returned return_to_apex(const Strength& y) {
    Returned r;
    const double sin_phi = std::sin(y.phi), cot = std::cos(y.phi) / sin_phi;
    r.stress.setConstant(y.c * cot);
    r.by_hardening.setConstant(y.c_rate * cot - y.c * y.phi_rate / (sin_phi * sin_phi));
    r.vertex = true;
    r.region = apex;
    return r;
  }

  Vec3 compliance(const Vec3& s) const {
    return ((1.0 + poisson_ratio) * s - Vec3::Constant(poisson_ratio * s.sum())) / youngs_modulus;
  }

  static Mat3 principal_stiffness(const Lame& c) {
    return Mat3::Constant(c.lambda) + Mat3((2.0 * c.mu * Vec3::Ones()).asDiagonal());
  }

  /// What the principal strains return to. kappa: accumulated plastic strain, old in, new out. Without `derivatives`
  /// those of the stress may be missing. False if the iteration for kappa fails.
  bool return_map(const Vec3& strain, double& kappa, Returned& r, bool derivatives = true) const {
    const Lame lame_constants = lame();
    const Mat3 c = principal_stiffness(lame_constants);
    const Vec3 trial = c * strain;
    // What the rounding of a stress on the surface amounts to, when Hooke's law makes it from the strain again.
    const double rounding = 2e-14 * 3.0 * lame_constants.bulk() * strain.cwiseAbs().maxCoeff();
    r.region = elastic;
    const Strength y = strength(kappa);
    if (largest_excess(y, trial) <= rounding) return true;
    return solve_softening(strain, c, trial, planes(y), derivatives || softens(), kappa, r);
  }

  /// kappa = old + |plastic strain of the step|(kappa), eqs. (28) and (29): Newton's method between brackets. p: the
  /// planes at old.
  bool solve_softening(const Vec3& strain, const Mat3& c, const Vec3& trial, Planes p, bool derivatives, double& kappa,
                       Returned& r) const {
    constexpr int max_iterations = 100, newton_iterations = 30;
    const double old = kappa;
    double low = old, high = infinity;
    for (int i = 0; i < max_iterations; ++i) {
      r = return_to(strength(kappa), p, c, trial, derivatives);
      const Vec3 flow = strain - compliance(r.stress);
      const double amount = plastic_measure(flow), gap = old + amount - kappa;
      if (!softens() || std::abs(gap) <= 1e-14 * (old + amount)) {
        kappa = old + amount;
        return std::isfinite(kappa);
      }
      (gap > 0.0 ? low : high) = kappa;
      const double slope = 1.0 + measure_gradient(flow, amount).dot(compliance(r.by_hardening));
      double next = kappa + gap / slope;
      const bool trusted = slope > 0.0 && next > low && next < high && i < newton_iterations;
      if (!trusted) next = std::isfinite(high) ? 0.5 * (low + high) : old + amount;
      if (next == kappa || next == low || next == high) return true;  // the bracket has no number left inside
      kappa = next;
      p = planes(strength(kappa));
    }
    return false;
  }

  /// sqrt(2/3 e:e), eq. (7), and its gradient.
  static double plastic_measure(const Vec3& flow) { return std::sqrt(2.0 / 3.0) * flow.norm(); }
  static Vec3 measure_gradient(const Vec3& flow, double amount) {
    return amount > 0.0 ? Vec3(2.0 / 3.0 / amount * flow) : Vec3(Vec3::Zero());
  }

  /// d stress / d strain in principal values with the change of strength, eq. (30).
  Mat3 principal_tangent(const Vec3& strain, const Returned& r) const {
    const Vec3 flow = strain - compliance(r.stress);
    const Vec3 n = measure_gradient(flow, plastic_measure(flow));
    Mat3 plastic_share = Mat3::Identity();
    for (int j = 0; j < 3; ++j) plastic_share.col(j) -= compliance(r.by_strain.col(j));
    const Vec3 kappa_rate = plastic_share.transpose() * n / (1.0 + n.dot(compliance(r.by_hardening)));
    return r.by_strain + r.by_hardening * kappa_rate.transpose();
  }

  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    if (!in.strain.allFinite()) return Status::not_admissible;
    const SortedPrincipal axes(in.strain);
    double kappa = old_state[accumulated];
    Returned r;
    if (!return_map(axes.value, kappa, r, in.want_tangent)) return Status::not_converged;
    new_state[accumulated] = out.plastic_strain = kappa;
    const Lame c = lame();
    if (r.region == elastic) {
      elastic_step(c, in, new_state, out);
    } else {
      plastic_step(c, in, engineering_shear(axes.assemble(compliance(r.stress))), new_state, out);
      if (in.want_tangent) {
        axes.tangent(r.stress, principal_tangent(axes.value, r), out.tangent);
        if (r.vertex) add_residual(c, out.tangent);
      }
    }
    return std::isfinite(out.stored_energy) ? Status::ok : Status::not_admissible;
  }

  static void add_residual(const Lame& c, Voigt66& tangent) {
    Voigt66 residual;
    c.stiffness(residual_stiffness, residual);
    tangent += residual;
  }
};

}  // namespace berm
