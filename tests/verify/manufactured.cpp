/// Manufactured solutions: the body force that makes a chosen motion the exact one, for Hencky's law. V8: a bar; V9: a
/// square that is stretched along its edges (Wallstedt and Guilkey 2008); V10: a ring that is sheared and turned
/// (Kamojjala, Brannon, Sadeghirad and Guilkey 2015).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

using std::numbers::pi;

struct Problem {
  std::string text;
  std::function<Vec3(const Vec3& X, double t)> displacement;
  double scale;  ///< of the errors [m]
};

/// Largest root mean square of the error of the displacement over all steps, over the scale; infinite if the run
/// failed.
double error_of(const Problem& problem, const std::vector<std::string>& overrides) {
  Model model(problem.text, overrides);
  double largest = 0.0;
  const bool done = model.run([&](const StepResult&) {
    const Discretisation& d = *model.world->discretisation;
    const std::vector<Vec3> X = d.point_origins(), u = d.point_displacements();
    double sum = 0.0, volume = 0.0;
    for (std::size_t p = 0; p < X.size(); ++p) {
      sum += model.material().volume[p] * (u[p] - problem.displacement(X[p], model.world->time)).squaredNorm();
      volume += model.material().volume[p];
    }
    largest = std::max(largest, std::sqrt(sum / volume) / problem.scale);
  });
  return done ? largest : std::numeric_limits<double>::infinity();
}

/// Hold x at 0 and at 1 m.
const std::string ends = R"(
[boundary.left]
where.box.max = [1e-6, 1e3]
ux = 0.0
[boundary.right]
where.box.min = [0.999999, -1e3]
ux = 0.0
)";

/// u = A sin(pi X) sin(c pi t) between fixed ends, c = 10 m/s, for a period of 0.2 s.
Problem bar(double A, int cells, int steps) {
  const std::string F = fmt::format("(1 + {}*pi*cos(pi*x)*sin(10*pi*t))", A);
  return {fmt::format(R"toml(
[model]
formulation = "updated_lagrangian"
[grid]
cells = [{0}, 1]
cell_size = {1}
[material.m]
law = "linear_elastic"
density = 1.0
youngs_modulus = 100.0
poisson_ratio = 0.0
[body.bar]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [1.0, {1}] }}
points.placement = "uniform"
acceleration = ["{2}*100*pi^2*sin(pi*x)*sin(10*pi*t)*((1 - ln({3}))/{3}^2 - 1)", 0.0]
velocity = ["{2}*10*pi*sin(pi*x)", 0.0]
{5}[boundary.walls]
where.box.max = [1e3, 1e3]
uy = 0.0
[steps]
analysis = "dynamic"
duration = 0.2
count = {4}
adaptive = false
)toml",
                      cells, 1.0 / cells, A, F, steps, ends),
          [A](const Vec3& X, double t) { return Vec3(A * std::sin(pi * X.x()) * std::sin(10.0 * pi * t), 0.0, 0.0); },
          A};
}

/// u_x = A sin(pi X) sin(c pi t), u_y = -A sin(pi Y) sin(c pi t) between planes of symmetry, c = 100 m/s, for a period.
Problem square(double A, int cells, int steps) {
  constexpr double E = 1e7, nu = 0.3, density = 1000.0;
  const double lame = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), shear = 0.5 * E / (1.0 + nu);
  const auto F = [&](const char* axis, const char* sign) {
    return fmt::format("(1 {} {}*pi*cos(pi*{})*sin(100*pi*t))", sign, A, axis);
  };
  const std::string Fx = F("x", "+"), Fy = F("y", "-");
  const auto force = [&](const char* axis, const char* sign, const std::string& f) {
    return fmt::format("{}{}*pi^2*sin(pi*{})*sin(100*pi*t)/{}*(({} - {}*ln({}*{}) - {}*ln({}))/{}^2 - {})", sign, A,
                       axis, density, lame + 2.0 * shear, lame, Fx, Fy, 2.0 * shear, f, f, E);
  };
  return {fmt::format(R"toml(
[model]
formulation = "updated_lagrangian"
[grid]
cells = [{0}, {0}]
cell_size = {1}
[material.m]
law = "linear_elastic"
density = {2}
youngs_modulus = {3}
poisson_ratio = {4}
[body.square]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [1.0, 1.0] }}
points.placement = "uniform"
acceleration = ["{5}", "{6}"]
velocity = ["{7}*100*pi*sin(pi*x)", "-{7}*100*pi*sin(pi*y)"]
{9}[boundary.base]
where.box.max = [1e3, 1e-6]
uy = 0.0
[boundary.top]
where.box.min = [-1e3, 0.999999]
uy = 0.0
[steps]
analysis = "dynamic"
duration = 0.02
count = {8}
adaptive = false
)toml",
                      cells, 1.0 / cells, density, E, nu, force("x", "", Fx), force("y", "-", Fy), A, steps, ends),
          [A](const Vec3& X, double t) {
            const double size = A * std::sin(100.0 * pi * t);
            return Vec3(size * std::sin(pi * X.x()), -size * std::sin(pi * X.y()), 0.0);
          },
          A};
}

/// theta = Theta + a(R, t), a = A sin(pi t) H(R), H = 1 - 32 (R - 1)^2 + 256 (R - 1)^4, in a ring with radii 0.75 and
/// 1.25, whose rims are held where they cut the cells: a simple shear by gamma = R da/dR in circles, up to 7 A, which a
/// neo-Hookean solid answers with the stresses mu gamma along and mu gamma^2 around the circles. (Hencky's solid is no
/// choice: its shear stress 2 mu asinh(gamma/2) / sqrt(1 + gamma^2/4) falls from gamma = 3.02 on.)
Problem vortex(double A, int cells_a_thickness, int steps) {
  constexpr double E = 1000.0, nu = 0.3;
  const double shear = 0.5 * E / (1.0 + nu), h = 0.5 / cells_a_thickness;
  const int cells = static_cast<int>(std::ceil(1.3 / h));
  std::string R = "sqrt(x^2 + y^2)", z = "(" + R + " - 1)";
  const std::string H = fmt::format("(1 - 32*{0}^2 + 256*{0}^4)", z), H1 = fmt::format("(1024*{0}^3 - 64*{0})", z),
                    H2 = fmt::format("(3072*{0}^2 - 64)", z);
  const std::string a = fmt::format("({}*sin(pi*t)*{})", A, H), at = fmt::format("({}*pi*cos(pi*t)*{})", A, H),
                    att = fmt::format("({}*pi^2*sin(pi*t)*{})", -A, H);
  const std::string gamma = fmt::format("({}*sin(pi*t)*{}*{})", A, R, H1),
                    gamma1 = fmt::format("({}*sin(pi*t)*({} + {}*{}))", A, H1, R, H2);
  const std::string radial = fmt::format("(-{0}*{1}^2 + {2}*{3}^2/{0})", R, at, shear, gamma),
                    along = fmt::format("({0}*{1} - {2}*{3} - 2*{2}*{4}/{0})", R, att, shear, gamma1, gamma);
  const std::string angle = fmt::format("(atan2(y, x) + {})", a);
  return {fmt::format(R"toml(
[model]
formulation = "updated_lagrangian"
[grid]
origin = [{0}, {0}]
cells = [{1}, {1}]
cell_size = {2}
[material.m]
law = "neo_hookean"
density = 1.0
youngs_modulus = {3}
poisson_ratio = {4}
[body.ring]
material = "m"
shape.difference = [{{ disc = {{ centre = [0.0, 0.0], radius = 1.25 }} }}, {{ disc = {{ centre = [0.0, 0.0], radius = 0.75 }} }}]
points.placement = "uniform"
acceleration = ["{5}*cos({7}) - {6}*sin({7})", "{5}*sin({7}) + {6}*cos({7})"]
velocity = ["-{8}*pi*y*{9}", "{8}*pi*x*{9}"]
[boundary.rims]
body = "ring"
where.box = {{ min = [-2.0, -2.0], max = [2.0, 2.0] }}
ux = 0.0
uy = 0.0
[steps]
analysis = "dynamic"
duration = 1.0
count = {10}
adaptive = false
)toml",
                      -cells * h, 2 * cells, h, E, nu, radial, along, angle, A, H, steps),
          [A](const Vec3& X, double t) {
            const double R0 = X.norm(), y = R0 - 1.0;
            const double turn = A * std::sin(pi * t) * (1.0 - 32.0 * y * y + 256.0 * y * y * y * y);
            const double theta = std::atan2(X.y(), X.x()) + turn;
            return Vec3(R0 * std::cos(theta) - X.x(), R0 * std::sin(theta) - X.y(), 0.0);
          },
          A};
}

constexpr const char *lumped = "dynamics.mass=lumped", *consistent = "dynamics.mass=consistent";
constexpr const char* total = "model.formulation=total_lagrangian";

/// The table of docs/verification.md has one grid more and more functions than what every run of the tests can afford.
bool whole_table() { return std::getenv("BERM_WHOLE_TABLES") != nullptr; }

/// `most`: of the error with the last number of cells. `order`: least one between the last two; 0: none asked.
struct Demand {
  double most, order = 0.0;
};
const auto all_functions = {"linear", "quadratic_bspline", "cubic_bspline", "ugimp", "cpgimp", "b2gimp", "cpdi"};
const Demand none = {std::numeric_limits<double>::infinity()};

template <class Make>
void study(const std::string& group, const Make& make, const std::string& functions, const char* mass, int projection,
           const std::vector<int>& cells, const Demand& demand, const std::vector<std::string>& more = {}) {
  std::vector<double> e;
  std::string list;
  for (const int n : cells) {
    std::vector<std::string> overrides = {"grid.shape_functions=" + functions, mass,
                                          fmt::format("dynamics.projection_order={}", projection)};
    overrides.insert(overrides.end(), more.begin(), more.end());
    e.push_back(error_of(make(n), overrides));
    list += fmt::format("{}{:.2g}", list.empty() ? "" : ", ", e.back());
  }
  const std::string name = fmt::format("{}{}, {} mass{}", functions, more.empty() ? "" : ", total Lagrangian",
                                       mass == lumped ? "lumped" : "consistent",
                                       projection == 1 ? "" : fmt::format(", projection of order {}", projection));
  fmt::print("  {}, {}: {}\n", group, name, list);
  if (std::isfinite(demand.most)) {  // else it is reported, finite or not
    EXPECT_LT(e.back(), demand.most) << name;
  }
  record({group, fmt::format("{}: error, {} cells ({} with {})", name, cells.back(), list, fmt::join(cells, ", ")),
          e.back(), "0", std::isfinite(demand.most) ? fmt::format("{:.2g}", demand.most) : "reported",
          "manufactured solution"});
  const double reached = std::log2(e[e.size() - 2] / e.back());
  if (demand.order > 0.0) {
    EXPECT_GT(reached, demand.order) << name;
  }
  record({group, name + ": order", reached, "2", demand.order > 0.0 ? fmt::format("> {}", demand.order) : "reported",
          "last two grids"});
}

const std::vector<int> bars = {8, 16, 32, 64};

/// What points that cross cells cost, and what the lumped mass does.
TEST(Manufactured, Bar) {
  constexpr const char* group = "Bar with cell crossing, manufactured (V8, A = 0.05)";
  const auto make = [](int cells) { return bar(0.05, cells, 1000); };
  const auto fine = [](int cells) { return bar(0.05, cells, 3000); };
  for (const char* mass : {lumped, consistent}) {
    study(group, make, "linear", mass, 1, bars, {1.0});
    for (const char* functions : {"cubic_bspline", "quadratic_bspline", "ugimp"})
      study(group, make, functions, mass, mass == lumped ? 1 : 20, bars, {0.02});
  }
  for (const char* functions : {"cpgimp", "cpdi", "b2gimp"})
    study(group, make, functions, lumped, 1, bars, {4e-3, 1.9});
  study(group, make, "cpgimp", consistent, 20, bars, {1e-3});
  study(group, make, "cpdi", consistent, 20, bars, {1e-3, 1.9});
  study(group, fine, "b2gimp", consistent, 20, bars, {1e-5, 1.7});
  for (const char* mass : {lumped, consistent}) study(group, make, "linear", mass, 1, bars, {4e-3, 1.9}, {total});
  study(group, fine, "quadratic_bspline", consistent, 20, bars, {2e-4, 1.9}, {total});
}

TEST(Manufactured, Square) {
  constexpr const char* group = "Square stretched along its edges, manufactured (V9, A = 0.05)";
  const std::vector<int> cells = whole_table() ? std::vector{4, 8, 16, 32} : std::vector{4, 8, 16};
  const auto make = [](int n) { return square(0.05, n, 400); };
  const auto fine = [](int n) { return square(0.05, n, 800); };
  study(group, make, "linear", consistent, 1, cells, {1.0});
  study(group, make, "quadratic_bspline", consistent, 20, cells, {0.02});
  study(group, make, "cpgimp", consistent, 20, cells, {5e-3, whole_table() ? 1.2 : 1.5});
  study(group, make, "cpdi", consistent, 20, cells, {0.01, 1.8});
  study(group, fine, "b2gimp", consistent, 20, {4, 8, 16, 32}, {1e-4, 1.8});
  if (!whole_table()) return;
  for (const char* functions : all_functions)
    study(group, make, functions, lumped, 1, cells, {1.0});
  study(group, make, "cubic_bspline", consistent, 20, cells, none);
  study(group, make, "ugimp", consistent, 20, cells, {0.02});
  study(group, make, "linear", consistent, 1, cells, {5e-3, 1.9}, {total});
  study(group, make, "quadratic_bspline", consistent, 20, cells, {1e-3, 1.8}, {total});
}

/// Boxes along the axes cannot follow a large shear; parallelograms do.
TEST(Manufactured, Vortex) {
  const std::string name = "Ring that is sheared and turned, manufactured (V10, A = ";
  const std::string slight = name + "0.1)", half = name + "0.5)", strong = name + "1)";
  const auto of = [](double A, int steps) { return [=](int n) { return vortex(A, n, steps); }; };
  const std::vector<int> cells = whole_table() ? std::vector{4, 8, 16, 32} : std::vector{8, 16};
  study(slight, of(0.1, 50), "b2gimp", consistent, 20, cells, {2e-3, 1.7});
  study(slight, of(0.1, 50), "cpdi", consistent, 20, cells, {6e-3, 1.8});
  study(half, of(0.5, 50), "cpdi", consistent, 20, {4, 8}, {0.02, 1.5});
  if (!whole_table()) return;
  for (const char* functions : {"linear", "quadratic_bspline", "cubic_bspline", "ugimp", "cpgimp"})
    study(slight, of(0.1, 50), functions, consistent, functions == std::string("linear") ? 1 : 20, cells, none);
  for (const char* functions : all_functions)
    study(slight, of(0.1, 50), functions, lumped, 1, cells, none);
  study(half, of(0.5, 50), "b2gimp", consistent, 20, {4, 8}, none);
  study(strong, of(1.0, 100), "cpdi", consistent, 20, {4, 8, 16}, {0.01, 1.5});
}

}  // namespace
}  // namespace berm::verify
