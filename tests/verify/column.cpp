/// Column of Hencky's solid under its own weight between smooth walls, nu = 0 (Coombs and Augarde, AMPLE, 2020): stress
/// and displacement in closed form, a slightly and a strongly compressed column, MPM and FEM, orders of convergence.

#include <fmt/format.h>

#include <cmath>

#include "driver.hpp"
#include "lambert_w.hpp"

namespace berm::verify {
namespace {

struct Column {
  std::string name;
  double height, youngs;  ///< [m], [Pa]
  int steps;
  double down[4];  ///< displacement at the quarters of the height, from elsewhere, six digits [m]

  static constexpr double density = 80.0, gravity = 10.0;
  double weight() const { return density * gravity * height; }  ///< stress at the base [Pa]
  double stress(double Y) const { return -density * gravity * (height - Y); }
  /// Place at the end: integral of the stretch W(x)/x, x = stress over E.
  double place(double Y) const {
    const auto primitive = [](double x) { return lambert_w(x) + 0.5 * std::pow(lambert_w(x), 2); };
    return youngs / (density * gravity) * (primitive(weight() / youngs) - primitive(-stress(Y) / youngs));
  }
};
const Column slight{"50 m, E = 1 MPa", 50.0, 1e6, 20, {0.415739, 0.716879, 0.900125, 0.962009}},
    large{"10 m, E = 10 kPa", 10.0, 1e4, 40, {0.900490, 1.639637, 2.162890, 2.373111}};

struct Variant {
  std::string name, method, formulation;
  int order = 1;
  std::string functions = "linear";   ///< mpm
  std::string quadrature = "points";  ///< mpm
};
const Variant updated{"mpm, updated Lagrangian", "mpm", "updated_lagrangian"},
    total{"mpm, total Lagrangian", "mpm", "total_lagrangian"}, quad4{"fem, quad4", "fem", "updated_lagrangian"},
    quad8{"fem, quad8", "fem", "updated_lagrangian", 2},
    quadratic{"mpm, updated Lagrangian, quadratic B-splines", "mpm", "updated_lagrangian", 1, "quadratic_bspline"},
    cubic{"mpm, updated Lagrangian, cubic B-splines", "mpm", "updated_lagrangian", 1, "cubic_bspline"},
    ugimp{"mpm, updated Lagrangian, uGIMP", "mpm", "updated_lagrangian", 1, "ugimp"},
    cpgimp{"mpm, updated Lagrangian, cpGIMP", "mpm", "updated_lagrangian", 1, "cpgimp"},
    b2gimp{"mpm, updated Lagrangian, B2-GIMP", "mpm", "updated_lagrangian", 1, "b2gimp"},
    cpdi{"mpm, updated Lagrangian, CPDI", "mpm", "updated_lagrangian", 1, "cpdi"};

struct Errors {
  double stress = 0.0, displacement = 0.0;  ///< AMPLE's norm over the stress at the base; L2, relative
  double top = 0.0;                         ///< of the settlement of the top, relative
};

/// Points at the quarters of their cells, as in AMPLE.
Errors solve(const Column& c, const Variant& v, int cells) {
  const double h = c.height / cells;
  Model model(fmt::format(R"(
method = "{}"
[model]
formulation = "{}"
quadrature = "{}"
gravity = [0.0, {}]
[grid]
shape_functions = "{}"
cells = [1, {}]
cell_size = {}
[material.m]
law = "linear_elastic"
density = {}
youngs_modulus = {}
poisson_ratio = 0.0
[body.column]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [{}, {}] }}
points.placement = "uniform"
mesh = {{ kind = "quads", size = {}, order = {}, structured = true }}
[boundary.base]
where.box.max = [1e3, 1e-6]
uy = 0.0
[boundary.walls]
where.box.max = [1e3, 1e3]
ux = 0.0
[gauge.top]
from = [{}, 0.0]
to = [{}, {}]
[steps]
count = {}
adaptive = false
)",
                          v.method, v.formulation, v.quadrature, -Column::gravity, v.functions, cells, h, Column::density, c.youngs, h, c.height,
                          h, v.order, 0.5 * h, 0.5 * h, c.height, c.steps));
  for (int k = 0; k < c.steps; ++k)
    if (!model.advance(1.0 / c.steps).converged) return {INFINITY, INFINITY, INFINITY};
  const std::vector<Vec3> X = model.world->discretisation->point_origins(),
                          u = model.world->discretisation->point_displacements();
  const MaterialState& m = model.material();
  Errors e;
  double volume = 0.0, size = 0.0;
  for (std::size_t p = 0; p < X.size(); ++p) {
    const double exact = c.place(X[p].y()) - X[p].y();
    e.stress += m.volume[p] * std::abs(m.stress[p][YY] - c.stress(X[p].y())) / c.weight();
    e.displacement += m.volume[p] * std::pow(u[p].y() - exact, 2);
    size += m.volume[p] * exact * exact;
    volume += m.volume[p];
  }
  e.stress /= volume;
  e.displacement = std::sqrt(e.displacement / size);
  e.top = std::abs(model.gauge_end().y() / (c.place(c.height) - c.height) - 1.0);
  return e;
}

/// Displacements at the quarters of the height, computed elsewhere with six digits.
TEST(SelfWeightColumn, ClosedForm) {
  for (const Column& c : {slight, large})
    for (int k = 1; k <= 4; ++k) {
      const double Y = 0.25 * k * c.height;
      EXPECT_NEAR(Y - c.place(Y), c.down[k - 1], 5e-7) << c.name << ", " << Y;
    }
}

/// Demands on the finest grid and on the orders between the two finest ones; order 0: the error is that of the solver.
struct Demand {
  double stress, displacement, top, order_stress, order_displacement, order_top;
};

std::vector<Errors> study(const Column& c, const Variant& v, const std::vector<int>& cells) {
  std::vector<Errors> e;
  for (int n : cells) {
    e.push_back(solve(c, v, n));
    fmt::print("  {}, {}: {} cells: stress {:.3e}, displacement {:.3e}, top {:.3e}\n", c.name, v.name, n,
               e.back().stress, e.back().displacement, e.back().top);
  }
  return e;
}

std::string list(const std::vector<Errors>& e, double Errors::*which) {
  std::string text;
  for (const Errors& k : e) text += fmt::format("{}{:.2g}", text.empty() ? "" : ", ", k.*which);
  return text;
}

const std::vector<int> grids = {8, 16, 32, 64, 128};
constexpr const char* group = "Column under its own weight (V11)";

void converges(const Column& c, const Variant& v, const Demand& demand) {
  const std::vector<Errors> e = study(c, v, grids);
  const Errors &last = e.back(), &before = e[e.size() - 2];
  const auto row = [&](const std::string& quantity, double Errors::*which, double most, double order) {
    const std::string name = fmt::format("{}, {}: {}", c.name, v.name, quantity);
    EXPECT_LT(last.*which, most) << name;
    record({group, fmt::format("{}, 128 cells ({} with 8, 16, 32, 64, 128)", name, list(e, which)), last.*which, "0",
            fmt::format("{:.2g}", most), "Hencky's solid (Lambert's W)"});
    if (order == 0.0) return;
    const double reached = std::log2(before.*which / last.*which);
    EXPECT_GT(reached, order) << name;
    record({group, name + ": order", reached, order < 1.0 ? "1" : "2 or more", fmt::format("> {}", order),
            "128 against 64 cells"});
  };
  row("stress", &Errors::stress, demand.stress, demand.order_stress);
  row("displacement", &Errors::displacement, demand.displacement, demand.order_displacement);
  row("settlement of the top", &Errors::top, demand.top, demand.order_top);
}

constexpr Demand linear = {2.5e-3, 2e-5, 2e-5, 0.95, 1.9, 1.9};

TEST(SelfWeightColumn, TotalLagrangian) {
  for (const Column& c : {slight, large}) converges(c, total, linear);
}

/// The stress of quadratic elements at their Gauss points follows from equilibrium alone: it is that of the solver.
TEST(SelfWeightColumn, Fem) {
  for (const Column& c : {slight, large}) {
    converges(c, quad4, linear);
    converges(c, quad8, {1e-8, 1e-7, 1e-8, 0.0, 1.9, 0.0});
  }
}

/// Linear functions whose gradient jumps where a point crosses a cell's edge do not converge: the stress stays off by
/// some per cent, and with it everything else.
TEST(SelfWeightColumn, UpdatedLagrangianDoesNotConverge) {
  const auto report = [](const Column& c, double most_stress, double most_displacement) {
    const std::vector<Errors> e = study(c, updated, grids);
    const auto row = [&](const std::string& quantity, double Errors::*which, double most) {
      for (const Errors& k : e) EXPECT_LT(k.*which, most) << c.name << ": " << quantity;
      record({group,
              fmt::format("{}, {}: {}, 128 cells ({} with 8, 16, 32, 64, 128)", c.name, updated.name, quantity,
                          list(e, which)),
              e.back().*which, "0", fmt::format("reported, < {}", most), "points cross cells of linear functions"});
    };
    row("stress", &Errors::stress, most_stress);
    row("displacement", &Errors::displacement, most_displacement);
    row("settlement of the top", &Errors::top, most_displacement);
  };
  report(slight, 0.04, 0.06);
  report(large, 0.13, 0.3);
}

/// Smooth functions lose nothing where points cross cells. What is left is the quadrature by points that have moved: it
/// falls slowly, but from a thirtieth to a thousandth of what linear functions have.
TEST(SelfWeightColumn, SmoothFunctionsOfPoints) {
  const auto report = [](const Column& c, const Variant& v, double most_stress, double most_displacement) {
    const std::vector<Errors> e = study(c, v, grids);
    const auto row = [&](const std::string& quantity, double Errors::*which, double most) {
      EXPECT_LT(e.back().*which, most) << c.name << ", " << v.name << ": " << quantity;
      record({group,
              fmt::format("{}, {}: {}, 128 cells ({} with 8, 16, 32, 64, 128)", c.name, v.name, quantity, list(e, which)),
              e.back().*which, "0", fmt::format("{}", most), "Hencky's solid (Lambert's W)"});
    };
    row("stress", &Errors::stress, most_stress);
    row("displacement", &Errors::displacement, most_displacement);
    row("settlement of the top", &Errors::top, most_displacement);
  };
  report(slight, quadratic, 1e-3, 1e-4);
  report(slight, cubic, 2e-3, 3e-4);
  report(large, quadratic, 0.01, 0.01);
  report(large, cubic, 0.003, 3e-4);
  report(slight, ugimp, 1e-3, 1e-4);
  report(large, ugimp, 0.015, 0.01);
}

/// Stresses at Gauss points: an even quadrature again in cells that points have crossed, and linear functions converge. What
/// is left is the weight, which is that of the points.   [formulation (66), (67)]
TEST(SelfWeightColumn, GaussPoints) {
  Variant v = updated;
  v.name += ", Gauss points";
  v.quadrature = "gauss";
  converges(slight, v, {4e-4, 4e-4, 3e-4, 1.3, 1.3, 1.3});
  converges(large, v, {2.5e-4, 1e-4, 1.5e-4, 1.2, 1.3, 1.3});
}

/// Domains that go with the body fill it at any time: second order returns.
TEST(SelfWeightColumn, DomainsThatFollow) {
  for (const Variant& v : {cpgimp, cpdi}) {
    converges(slight, v, {3e-4, 1e-5, 1e-6, 1.5, 1.9, 1.6});
    converges(large, v, {2e-4, 1e-5, 1e-5, 1.0, 1.9, 1.9});
  }
  converges(slight, b2gimp, {3e-5, 3e-6, 3e-6, 1.8, 1.9, 1.9});
  converges(large, b2gimp, {2e-5, 3e-6, 3e-6, 1.2, 1.9, 1.9});
}

}  // namespace
}  // namespace berm::verify
