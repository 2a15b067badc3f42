/// Pressure that follows the deforming face (docs/theory/boundaries.md): a thick tube widened by 40 %, a
/// cantilever bent beyond the vertical, Archimedes' lift of a turned and stretched body, the matrix against
/// differences.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

const char* group = "Pressure that follows the face";

// ---- thick tube of Hencky's solid, its ends held: dP_r/dR = (P_t - P_r)/R with P_i = tau_i/stretch_i, shot from the
// inner radius by the fourth-order Runge-Kutta rule.

constexpr double inner = 0.05, outer = 0.1, youngs = 1e6, poisson = 0.3, inside = 1.2e5;

struct Tube {
  static constexpr double lambda = youngs * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
  static constexpr double mu = youngs / (2.0 * (1.0 + poisson));
  static constexpr int n = 200;

  std::vector<double> radius;  ///< at n + 1 places over the wall

  static double radial(double r, double t) { return lambda * std::log(r * t) + 2.0 * mu * std::log(r); }
  static double hoop(double r, double t) { return radial(t, r); }

  /// Radial stretch at which f, which grows, is 0.
  template <class F>
  static double root(F f, double low = 0.2, double high = 2.5) {
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (f(middle) > 0.0 ? high : low) = middle;
    }
    return 0.5 * (low + high);
  }

  /// Nominal radial stress at the outer radius if the inner one is stretched by s.
  double shoot(double s, double pressure) {
    const double h = (outer - inner) / n;
    const double first = root([&](double l) { return radial(l, s) + pressure * l * s; });
    double r = s * inner, P = radial(first, s) / first;
    radius.assign(1, r);
    const auto rates = [&](double R, double r_now, double P_now) {
      const double t = r_now / R;
      const double l = root([&](double x) { return radial(x, t) - P_now * x; });
      return std::pair(l, (hoop(l, t) / t - P_now) / R);
    };
    for (int k = 0; k < n; ++k) {
      const double R = inner + k * h;
      const auto [a, A] = rates(R, r, P);
      const auto [b, B] = rates(R + 0.5 * h, r + 0.5 * h * a, P + 0.5 * h * A);
      const auto [c, C] = rates(R + 0.5 * h, r + 0.5 * h * b, P + 0.5 * h * B);
      const auto [d, D] = rates(R + h, r + h * c, P + h * C);
      r += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
      P += h / 6.0 * (A + 2.0 * B + 2.0 * C + D);
      radius.push_back(r);
    }
    return P;
  }
  explicit Tube(double pressure) {
    const double s = root([&](double x) { return shoot(x, pressure); }, 1.0, 1.7);
    shoot(s, pressure);
  }
  double at(double R) const {
    const double x = std::clamp((R - inner) / (outer - inner), 0.0, 1.0) * n;
    const int k = std::min(n - 1, static_cast<int>(x));
    return radius[k] + (x - k) * (radius[k + 1] - radius[k]);
  }
};

std::string elastic(double E, double nu) {
  return fmt::format(
      "[material.m]\nlaw = \"linear_elastic\"\ndensity = 1000.0\nyoungs_modulus = {}\npoisson_ratio = {}\n", E, nu);
}

std::string tube(const std::string& method, const std::string& formulation, int n) {
  const double h = (outer - inner) / n;
  std::string text = fmt::format("method = \"{}\"\n[model]\nplane = \"axisymmetric\"\n{}", method, formulation);
  text += elastic(youngs, poisson);
  // Cells cut by a quarter.
  text += fmt::format("[grid]\norigin = [{}, 0.0]\ncell_size = {}\ncells = [{}, 2]\n", inner - 0.75 * h, h, 2 * n);
  text += fmt::format("[body.b]\nmaterial = \"m\"\nshape.box = {{ min = [{}, 0.0], max = [{}, {}] }}\n", inner, outer,
                      2.0 * h);
  text += fmt::format("mesh = {{ kind = \"quads\", size = {}, structured = true, order = 2 }}\n", h);
  text += fmt::format("[pressure.p]\nbody = \"b\"\nwhere.box.max = [{}, 1.0]\nvalue = {}\n", inner + 1e-6, inside);
  text += "[boundary.ends]\nwhere.box = { min = [-1.0, -1.0], max = [1.0, 1.0] }\nuy = 0.0\n";
  return text + "[steps]\ncount = 12\nadaptive = false\n";
}

/// Largest error of the place of a point, over the displacement of the inner wall.
double tube_error(const Model& model, const Tube& exact) {
  const Discretisation& d = *model.world->discretisation;
  const std::vector<Vec3> X = d.point_origins(), u = d.point_displacements();
  double worst = 0.0;
  for (std::size_t p = 0; p < X.size(); ++p)
    worst = std::max(worst, std::abs(X[p].x() + u[p].x() - exact.at(X[p].x())));
  return worst / (exact.at(inner) - inner);
}

void widen(const std::string& name, const std::string& text, int n, double tolerance) {
  const Tube exact(inside);
  ASSERT_GT(exact.at(inner), 1.35 * inner);
  Model model(text);
  ASSERT_TRUE(model.run());
  const double error = tube_error(model, exact);
  EXPECT_LT(error, tolerance);
  record(
      {group,
       fmt::format("{}: thick tube widened to {:.3f} of its bore, radial displacement", name, exact.at(inner) / inner),
       error, "0", fmt::format("{}", tolerance), "radial equation of Hencky's solid, Runge-Kutta"});
  // Force of the pressure on the inner wall around the whole axis: p 2 pi r h.
  const double height = 2.0 * (outer - inner) / n;
  const double force = inside * 2.0 * std::numbers::pi * exact.at(inner) * height;
  EXPECT_LT(relative(model.step.balance().pressure_force[0].x(), force), 2.0 * tolerance);
}

TEST(FollowingPressure, WidensATubeFem) { widen("fem, quad8", tube("fem", "", 10), 10, 1e-4); }
TEST(FollowingPressure, WidensATubeMpm) { widen("mpm, cut cells, 20 over the wall", tube("mpm", "", 20), 20, 0.02); }
TEST(FollowingPressure, WidensATubeTotalLagrangian) {
  widen("mpm, total Lagrangian, cut cells", tube("mpm", "formulation = \"total_lagrangian\"\n", 10), 10, 0.01);
}

/// With the matrix of the load Newton's method is quadratic in large steps: r_(k+1) < C r_k^2 with a C of the order
/// of 1. Without it every iteration only gains a digit (C of 1e3 and more for r_k = 1e-4).
TEST(FollowingPressure, NewtonIsQuadratic) {
  for (const std::string method : {"fem", "mpm"}) {
    double worst = 0.0;
    int seen = 0;
    Model model(tube(method, "", 10), {"steps.count=5", "solver.relative_tolerance=1e-12"});
    ASSERT_TRUE(model.run([&](const StepResult& result) {
      const std::vector<double>& r = result.residuals;
      for (std::size_t i = 1; i < r.size(); ++i)
        if (r[i - 1] > 1e-5 && r[i - 1] < 1e-2) {
          worst = std::max(worst, r[i] / (r[i - 1] * r[i - 1]));
          ++seen;
        }
    }));
    EXPECT_GE(seen, 5);
    EXPECT_LT(worst, 10.0);
    record({group, method + ": largest r_(k+1)/r_k^2 of Newton's method while the tube widens, 5 steps", worst,
            "of the order of 1", "10", "quadratic convergence"});
  }
}

/// A dead load on the reference bore widens the tube much less.
TEST(FollowingPressure, DeadLoadDiffers) {
  Model model(tube("fem", "", 10), {"pressure.p.direction=dead"});
  ASSERT_TRUE(model.run());
  EXPECT_GT(tube_error(model, Tube(inside)), 0.3);
}

/// The same state under gauge control: the load factor at the exact thinning of the wall is 1.
TEST(FollowingPressure, UnderGaugeControl) {
  const Tube exact(inside);
  const double change = (exact.at(outer) - exact.at(inner)) - (outer - inner);
  Model model(tube("fem", "", 10) + fmt::format("[gauge.wall]\nfrom = [{}, 0.0]\nto = [{}, 0.0]\n"
                                                "[control]\nkind = \"gauge\"\ngauge = \"wall\"\ntarget = {:.15g}\n",
                                                inner, outer, change));
  ASSERT_TRUE(model.run());
  EXPECT_NEAR(model.world->load_factor, 1.0, 1e-3);
  // Elastic: the work of the pressure is the stored energy.
  EXPECT_LT(relative(model.step.balance().external_work, model.material().stored_energy()), 0.01);
}

// ---- a cantilever under pressure on its upper face: an inextensible beam whose load stays normal to it. With N and Q
// the resultants along and across the beam, M = EI phi', phi the downward rotation: N' = Q phi', Q' = -N phi' - q,
// M' = -Q, all zero at the free end; q = p (1 + phi' h/2), since the upper fibre is longer than the middle one.

struct Beam {
  double x = 0.0, y = 0.0, rotation = 0.0;  ///< of the free end
  Beam(double length, double h, double E, double p) {
    constexpr int n = 20000;
    const double ds = length / n, EI = E * h * h * h / 12.0;
    double N = 0.0, Q = 0.0, M = 0.0;
    std::vector<double> curvature(n + 1, 0.0);
    const auto rates = [&](double axial, double shear, double moment) {
      const double k = moment / EI;
      return Vec3(shear * k, -axial * k - p * (1.0 + 0.5 * h * k), -shear);
    };
    for (int i = n; i > 0; --i) {  // the midpoint rule, from the free end backwards
      const Vec3 half = 0.5 * ds * rates(N, Q, M);
      const Vec3 step = ds * rates(N - half[0], Q - half[1], M - half[2]);
      N -= step[0], Q -= step[1], M -= step[2];
      curvature[i - 1] = M / EI;
    }
    for (int i = 0; i < n; ++i) {
      const double middle = rotation + 0.25 * ds * (curvature[i] + curvature[i + 1]);
      x += ds * std::cos(middle);
      y -= ds * std::sin(middle);
      rotation += 0.5 * ds * (curvature[i] + curvature[i + 1]);
    }
  }
};

TEST(FollowingPressure, BendsACantilever) {
  constexpr double h = 0.02, E = 1e6, length = 1.0, p = 9.0;
  const Beam exact(length, h, E, p);
  ASSERT_GT(exact.rotation, 0.6 * std::numbers::pi);  // beyond the vertical
  std::string text = "method = \"fem\"\n[model]\nplane = \"strain\"\n" + elastic(E, 0.0);
  text += fmt::format("[body.b]\nmaterial = \"m\"\nshape.box = {{ min = [0.0, {}], max = [{}, {}] }}\n", -h / 2, length,
                      h / 2);
  text += "mesh = { kind = \"quads\", size = 0.01, structured = true, order = 2 }\n";
  text += "[boundary.clamp]\nwhere.box.max = [1e-9, 1.0]\nux = 0.0\nuy = 0.0\n";
  text +=
      fmt::format("[pressure.top]\nbody = \"b\"\nwhere.box = {{ min = [-1.0, {}] }}\nvalue = {}\n", h / 2 - 1e-9, p);
  text += fmt::format("[gauge.tip]\nfrom = [0.0, 0.0]\nto = [{}, 0.0]\n", length);
  text += "[steps]\ncount = 30\nadaptive = false\n";
  Model model(text);
  ASSERT_TRUE(model.run());
  const Vec3 tip = model.gauge_end() + Vec3(length, 0.0, 0.0);
  const double error = std::hypot(tip.x() - exact.x, tip.y() - exact.y) / length;
  EXPECT_LT(error, 0.005);
  record({group,
          fmt::format("fem: end of a cantilever turned by {:.0f} degrees, over its length",
                      exact.rotation * 180.0 / std::numbers::pi),
          error, "0", "0.005", "inextensible beam under a load normal to it"});
}

// ---- hydrostatic pressure all around a body that is turned by 70 degrees, stretched and sunk in one step: Archimedes'
// lift is the weight of the displaced water, whatever the orientation.

void float_body(const std::string& method) {
  constexpr double a = 70.0 * std::numbers::pi / 180.0, water = 9810.0;
  const double c = std::cos(a), s = std::sin(a), stretch = 1.3;
  std::string text = fmt::format("method = \"{}\"\n[model]\nplane = \"strain\"\n", method) + elastic(1e6, 0.2);
  text += "[grid]\norigin = [-1.0, -1.0]\ncell_size = 0.23\ncells = [9, 9]\n";
  text += "[body.b]\nmaterial = \"m\"\nshape.polygon = [[-0.5, -0.4], [0.6, -0.3], [0.3, 0.5], [-0.4, 0.4]]\n";
  text += "mesh = { kind = \"quads\", size = 0.2 }\n";
  // F = R(a) diag(stretch, 1), then down by 2 m.
  text += "[boundary.all]\nwhere.box = { min = [-2.0, -2.0], max = [2.0, 2.0] }\n";
  text += fmt::format("ux = \"t*({:.16g}*x+{:.16g}*y)\"\nuy = \"t*({:.16g}*x+{:.16g}*y-2.0)\"\n", c * stretch - 1.0, -s,
                      s * stretch, c - 1.0);
  text +=
      fmt::format("[pressure.water]\nbody = \"b\"\nwhere.box = {{ min = [-2.0, -2.0] }}\nvalue = \"-{}*y\"\n", water);
  text += "[steps]\ncount = 1\nadaptive = false\n";
  Model model(text);
  const double area = model.world->bodies[0].measure;
  model.advance(1.0);
  const Vec3 force = model.step.balance().pressure_force[0];
  EXPECT_LT(std::abs(force.x()), 1e-9 * water * area);
  const double error = relative(force.y(), water * stretch * area);
  EXPECT_LT(error, 1e-9);
  record({group, method + ": lift of a body turned by 70 degrees and stretched", error, "0", "1e-9", "Archimedes"});
}

TEST(FollowingPressure, ArchimedesFem) { float_body("fem"); }
TEST(FollowingPressure, ArchimedesMpm) { float_body("mpm"); }

// ---- the matrix

double entry(const CsrMatrix& m, int row, int column) {
  for (int k = m.row_begin[row]; k < m.row_begin[row + 1]; ++k)
    if (m.column[k] == column) return m.value[k];
  return 0.0;
}

void compare_matrix(const std::string& text) {
  Model model(text);
  const Discretisation& d = *model.world->discretisation;
  const BoundaryConditions& bc = *model.world->boundary;
  const int dimension = d.dimension(), n = dimension * d.n_nodes();
  NodalVector du(d.n_nodes(), Vec3::Zero());
  for (int k = 0; k < n; ++k) du[k / dimension][k % dimension] = 0.02 * std::sin(3.7 * k + 0.4);
  BlockAssembler assembler;
  assembler.build(d.blocks, d.n_nodes(), dimension);
  assembler.zero(std::vector<char>(n, 0), d.n_nodes(), 1.0);
  NodalVector unused(d.n_nodes(), Vec3::Zero());
  bc.add_pressure(0.7, du, 1.5, unused, &assembler);
  double worst = 0.0, largest = 0.0, asymmetry = 0.0;
  for (int column = 0; column < n; ++column) {
    const double h = 1e-6;
    NodalVector f[2];
    for (int side = 0; side < 2; ++side) {
      NodalVector moved = du;
      moved[column / dimension][column % dimension] += side == 0 ? h : -h;
      f[side].assign(d.n_nodes(), Vec3::Zero());
      bc.add_pressure(0.7, moved, 1.5, f[side], nullptr);
    }
    for (int row = 0; row < n; ++row) {
      const double slope =
          (f[0][row / dimension][row % dimension] - f[1][row / dimension][row % dimension]) / (2.0 * h);
      const double value = entry(assembler.matrix(), row, column);
      worst = std::max(worst, std::abs(value + slope));
      largest = std::max(largest, std::abs(slope));
      asymmetry = std::max(asymmetry, std::abs(value - entry(assembler.matrix(), column, row)));
    }
  }
  EXPECT_GT(asymmetry, 1e-3 * largest);
  EXPECT_FALSE(bc.symmetric());
  EXPECT_LT(worst, 1e-7 * largest);
}

std::string matrix_case(const std::string& method, const std::string& model, int dimension) {
  std::string text = fmt::format("method = \"{}\"\n[model]\n{}\n", method, model) + elastic(1e6, 0.2);
  text += dimension == 3 ? "[grid]\norigin = [0.0, 0.0, 0.0]\ncell_size = 0.4\ncells = [3, 3, 3]\n"
                         : "[grid]\norigin = [0.0, 0.0]\ncell_size = 0.4\ncells = [3, 3]\n";
  text += dimension == 3 ? "[body.b]\nmaterial = \"m\"\nshape.box = { min = [0.3, 0.3, 0.3], max = [0.9, 0.9, 0.9] }\n"
                         : "[body.b]\nmaterial = \"m\"\nshape.box = { min = [0.3, 0.3], max = [0.9, 0.9] }\n";
  text += dimension == 3 ? "mesh = { kind = \"tetrahedra\", size = 0.4 }\n"
                         : "mesh = { kind = \"quads\", size = 0.4, structured = true, order = 2 }\n";
  text += dimension == 3 ? "[pressure.p]\nbody = \"b\"\nwhere.box.min = [0.0, 0.85, 0.0]\nvalue = \"1e3*(2+x-y*z)*t\"\n"
                         : "[pressure.p]\nbody = \"b\"\nwhere.box.min = [0.0, 0.35]\nvalue = \"1e3*(2+x-y*x)*t\"\n";
  return text;
}

TEST(FollowingPressure, MatrixAgainstDifferences) {
  for (const std::string method : {"mpm", "fem"}) {
    SCOPED_TRACE(method);
    compare_matrix(matrix_case(method, "plane = \"strain\"", 2));
    compare_matrix(matrix_case(method, "plane = \"axisymmetric\"", 2));
    compare_matrix(matrix_case(method, "dimension = 3", 3));
  }
  compare_matrix(matrix_case("mpm", "formulation = \"total_lagrangian\"", 2));
}

}  // namespace
}  // namespace berm::verify
