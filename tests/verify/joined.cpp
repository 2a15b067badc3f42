/// Bodies that touch at the start and stay together: borders inside cells, meshes whose nodes do not match.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr const char* group = "Bodies joined across cells";

std::string elastic(const char* name, double youngs, double poisson) {
  return fmt::format("[material.{}]\nlaw = \"linear_elastic\"\ndensity = 1000.0\nyoungs_modulus = {}\npoisson_ratio = {}\n",
                     name, youngs, poisson);
}

std::string box(double x0, double y0, double x1, double y1) {
  return fmt::format("shape.box = {{ min = [{:.16g}, {:.16g}], max = [{:.16g}, {:.16g}] }}\n", x0, y0, x1, y1);
}

/// Two bars in series with the border at x, pulled by 1 mm: elastic, or the stiff one of concrete.
std::string bars(const std::string& functions, double x, const std::string& materials, int steps) {
  return fmt::format(R"toml(
[model]
plane = "stress"
kinematics = "small"
[grid]
origin = [0.0, 0.0]
cell_size = 0.1
cells = [10, 1]
shape_functions = "{}"
{}
[body.soft]
material = "soft"
{}
[body.stiff]
material = "stiff"
{}
[boundary.left]
where.box.max = [1e-6, 1e3]
ux = 0.0
uy = 0.0
[boundary.right]
where.box.min = [0.999999, -1.0]
ux = 0.001
[steps]
count = {}
)toml",
                     functions, materials, box(0.0, 0.0, x, 0.1), box(x, 0.0, 1.0, 0.1), steps);
}

/// Of all points, from the one that belongs to the force.
double worst_stress(const Model& model, double right) {
  double worst = 0.0;
  for (const auto& stress : model.material().stress) worst = std::max(worst, std::abs(stress[XX] / right - 1.0));
  return worst;
}

TEST(Joined, BarsInSeries) {
  struct Demand {
    const char* functions;
    double force, stress;
  };
  for (const Demand& want : {Demand{"linear", 2e-3, 0.02}, {"b2gimp", 2e-3, 0.02}, {"quadratic_bspline", 4e-3, 0.04}}) {
    double force = 0.0, stress = 0.0;
    for (int k = 0; k < 10; ++k) {
      const double x = 0.5 + 0.01 * k + 1e-4 * (k > 0);
      Model model(bars(want.functions, x, elastic("soft", 1e9, 0.0) + elastic("stiff", 1e11, 0.0), 1));
      ASSERT_TRUE(model.run());
      const double right = 1e-3 / (x / 1e9 + (1.0 - x) / 1e11);
      force = std::max(force, relative(model.step.balance().reactions.boundary[1].x(), 0.1 * right));
      stress = std::max(stress, worst_stress(model, right));
    }
    EXPECT_LT(force, want.force) << want.functions;
    EXPECT_LT(stress, want.stress) << want.functions;
    const std::string name = fmt::format("bars of E 1 : 100 in series, border at ten places of a cell, {}: ", want.functions);
    record({group, name + "force", force, "0", fmt::format("{}", want.force), "closed form"});
    record({group, name + "worst stress of a point", stress, "0", fmt::format("{}", want.stress), "closed form"});
  }
}

/// Bars tied on a line of the grid and pressed, so that the border moves into cells where one of them has no points. Held by the
/// stabilisation alone, anew in every step, the tie crept: the more steps the softer.
TEST(Joined, BorderThatLeavesItsCell) {
  constexpr double youngs = 1e6, shortening = 0.02;
  for (const auto& [functions, volumetric] : {std::pair("linear", "standard"), std::pair("linear", "mixed"), std::pair("cpgimp", "standard")})
    for (const int steps : {1, 20}) {
      std::string text = bars(functions, 0.5, elastic("soft", youngs, 0.0) + elastic("stiff", youngs, 0.0), steps);
      for (const auto& [from, to] : {std::pair<std::string, std::string>{"plane = \"stress\"\nkinematics = \"small\"", fmt::format("formulation = \"updated_lagrangian\"\nvolumetric = \"{}\"", volumetric)},
                                     {"[boundary.right]", "[boundary.right]\nbody = \"stiff\""},
                                     {"ux = 0.001", fmt::format("ux = {}", -shortening)}})
        text.replace(text.find(from), from.size(), to);
      Model model(text + "[contact.c]\nbody = \"soft\"\nother = \"stiff\"\nkind = \"tie\"\n");
      ASSERT_TRUE(model.run());
      const double right = 0.1 * youngs * std::log(1.0 - shortening) / (1.0 - shortening);  // Hencky, no lateral strain
      const double error = relative(model.step.balance().reactions.boundary[1].x(), right);
      EXPECT_LT(error, 0.01) << functions << " " << volumetric << " " << steps;
      record({group, fmt::format("bars tied on a line of the grid, pressed by 2 %, {}, {}, {} steps: force", functions, volumetric, steps), error, "0", "0.01", "closed form"});
    }
}

/// A layer of 0.4 cells between two stiff bars, pulled: in one layer of nodes these two were joined through it.
TEST(Joined, ThinLayerBetweenBars) {
  for (const char* functions : {"linear", "cpgimp", "b2gimp"}) {
    double force = 0.0;
    for (int k = 0; k < 10; ++k) {
      const double x = 0.5 + 0.01 * k + 1e-4, thickness = 0.04, length = 1.0, height = 0.1, youngs = 1e9, soft = 1e7;
      std::string text = bars(functions, x, elastic("soft", youngs, 0.0) + elastic("stiff", youngs, 0.0) + elastic("layer", soft, 0.0), 1);
      const std::string second = box(x, 0.0, length, height);
      text.replace(text.find(second), second.size(), box(x + thickness, 0.0, length, height));
      Model model(text + "[body.layer]\nmaterial = \"layer\"\n" + box(x, 0.0, x + thickness, height));
      ASSERT_TRUE(model.run());
      const double right = 1e-3 * height / ((length - thickness) / youngs + thickness / soft);
      force = std::max(force, relative(model.step.balance().reactions.boundary[1].x(), right));
    }
    EXPECT_LT(force, 0.01) << functions;
    record({group, fmt::format("layer of 0.4 cells, E 1 : 100, between two bars, at ten places of a cell, {}: force", functions), force, "0", "0.01", "closed form"});
  }
}

/// Concrete of 3 MPa behind a bar a tenth as stiff: nothing cracks before the whole section carries its strength. What comes
/// then snaps back, and the run ends.
TEST(Joined, ConcreteCracksAtItsStrength) {
  const std::string concrete =
      "[material.stiff]\nlaw = \"rankine\"\ntensile_strength = 3e6\nfracture_energy = 100.0\ndensity = 1000.0\n"
      "youngs_modulus = 30e9\npoisson_ratio = 0.0\n";
  for (const char* functions : {"linear", "b2gimp"}) {
    Model model(bars(functions, 0.53, elastic("soft", 3e9, 0.0) + concrete, 100), {"steps.min_fraction=0.1"});
    double peak = 0.0;
    model.run([&](const StepResult&) {
      const double force = model.step.balance().reactions.boundary[1].x();
      peak = std::max(peak, force);
      if (force < 0.98 * 0.3e6 && force == peak) {
        EXPECT_EQ(model.material().max_damage(), 0.0) << functions;
      }
    });
    EXPECT_NEAR(peak, 0.3e6, 0.01 * 0.3e6) << functions;
    record({group, fmt::format("crack behind a border in a cell, {}: peak load over strength", functions), peak / 0.3e6, "1",
            "0.01", "closed form"});
  }
}

/// What finite elements and material points make of two blocks that touch.
std::string blocks(const char* method, double size, const char* contact = "") {
  return fmt::format(R"toml(
method = "{0}"
[model]
plane = "stress"
kinematics = "small"
[grid]
origin = [0.0, 0.0]
cell_size = 0.1
cells = [10, 5]
{1}
[body.a]
material = "m"
{2}
mesh = {{ kind = "quads", size = 0.1, structured = true }}
[body.b]
material = "m"
{3}
mesh = {{ kind = "quads", size = {4}, structured = true }}
[boundary.left]
where.box.max = [1e-6, 1.0]
ux = 0.0
uy = 0.0
[boundary.right]
where.box.min = [0.999999, 0.0]
ux = 0.001
uy = 0.0
{5}
[steps]
count = 1
)toml",
                     method, elastic("m", 30e9, 0.2), box(0.0, 0.0, 0.5, 0.5), box(0.5, 0.0, 1.0, 0.5), size, contact);
}

double pull(const std::string& text) {
  Model model(text);
  EXPECT_TRUE(model.run());
  return model.step.balance().reactions.boundary[1].x();
}

TEST(Joined, FiniteElementsMeanTheSame) {
  const double shared = pull(blocks("mpm", 0.1)), matching = pull(blocks("fem", 0.1)), not_matching = pull(blocks("fem", 0.0625));
  const double tied = pull(blocks("mpm", 0.1, "[contact.c]\nbody = \"a\"\nother = \"b\"\nkind = \"tie\"\n"));
  EXPECT_LT(relative(matching, shared), 1e-3);
  EXPECT_LT(relative(tied, shared), 1e-3);
  EXPECT_LT(relative(not_matching, shared), 5e-3);
  record({group, "two blocks: fem with matching nodes over mpm with shared ones, less 1", relative(matching, shared), "0",
          "0.001", "the same mesh in one piece"});
  record({group, "two blocks: fem with other nodes over mpm, less 1", relative(not_matching, shared), "0", "0.005",
          "the same mesh in one piece"});
}

TEST(Joined, OnlyWhereBodiesTouch) {
  const std::string two = elastic("m", 1e9, 0.0) + elastic("n", 2e9, 0.0);
  const auto joints = [&](double a, double b, const char* other) {
    return Model(fmt::format(R"toml(
[model]
plane = "stress"
allow_glued = true
[grid]
origin = [0.0, 0.0]
cell_size = 0.1
cells = [10, 1]
{}
[body.a]
material = "m"
{}
[body.b]
material = "{}"
{}
[boundary.left]
where.box.max = [1e-6, 1e3]
ux = 0.0
uy = 0.0
[steps]
count = 1
)toml",
                             two, box(0.0, 0.0, a, 0.1), other, box(b, 0.0, 1.0, 0.1)))
        .world->neighbours.joints;
  };
  EXPECT_TRUE(joints(0.5, 0.55, "n").empty()) << "a gap of half a cell";
  ASSERT_EQ(joints(0.5, 0.5, "n").size(), 1u);
  EXPECT_TRUE(joints(0.5, 0.5, "n")[0].shared_nodes) << "on a grid line";
  ASSERT_EQ(joints(0.53, 0.53, "m").size(), 1u);
  EXPECT_TRUE(joints(0.53, 0.53, "m")[0].shared_nodes) << "of one material";
  ASSERT_EQ(joints(0.53, 0.53, "n").size(), 1u);
  EXPECT_FALSE(joints(0.53, 0.53, "n")[0].shared_nodes);
  EXPECT_NEAR(joints(0.53, 0.53, "n")[0].area(), 0.1, 1e-12);
}

/// A disc of another stiffness in an infinite plate under shear: u of the plate on the edge of the model, uniform stress
/// within (Goodier 1933; potentials phi = alpha S a2/z, psi = -S z + alpha S a4/z3, Muskhelishvili 1953).
struct Inclusion {
  double ratio;  ///< of the moduli
  static constexpr double youngs = 1e9, poisson = 0.3, shear = youngs / 2.6, kappa = 3.0 - 4.0 * poisson, load = 1e6;
  double alpha() const { return (1.0 - ratio) / (kappa * ratio + 1.0); }
  double inside() const { return (1.0 - alpha()) * load; }
  /// Displacement with radius 1, as expressions.
  std::string ux() const {
    return fmt::format("{:.16g}*t*(x*(1 + {:.16g}/(x^2+y^2)) + {:.16g}*(1/(x^2+y^2)^2 - 1/(x^2+y^2)^3)*(x^3 - 3*x*y^2))",
                       load / (2.0 * shear), kappa * alpha(), alpha());
  }
  std::string uy() const {
    return fmt::format("{:.16g}*t*(-y*(1 + {:.16g}/(x^2+y^2)) + {:.16g}*(1/(x^2+y^2)^2 - 1/(x^2+y^2)^3)*(3*x^2*y - y^3))",
                       load / (2.0 * shear), kappa * alpha(), alpha());
  }
  std::string text(const std::string& method, const std::string& functions, double h) const {
    const int n = static_cast<int>(std::lround(4.0 / h));
    return fmt::format(R"toml(
method = "{0}"
[model]
plane = "strain"
kinematics = "small"
[grid]
origin = [-2.0, -2.0]
cell_size = {1}
cells = [{2}, {2}]
shape_functions = "{3}"
{4}
[body.plate]
material = "plate"
shape.difference = [{{ box = {{ min = [-2.0, -2.0], max = [2.0, 2.0] }} }}, {{ disc = {{ centre = [0.0, 0.0], radius = 1.0 }} }}]
mesh = {{ kind = "quads", size = {1} }}
[body.disc]
material = "disc"
shape.disc = {{ centre = [0.0, 0.0], radius = 1.0 }}
mesh = {{ kind = "quads", size = {6} }}
{5}
[steps]
count = 1
)toml",
                       method, h, n, functions, elastic("plate", youngs, poisson) + elastic("disc", ratio * youngs, poisson),
                       edges(), 0.7 * h);
  }
  std::string edges() const {
    std::string all;
    for (const char* where : {"min = [1.999999, -9.0]", "max = [-1.999999, 9.0]", "min = [-9.0, 1.999999]", "max = [9.0, -1.999999]"})
      all += fmt::format("[boundary.e{}]\nwhere.box = {{ {} }}\nux = \"{}\"\nuy = \"{}\"\n", all.size(), where, ux(), uy());
    return all;
  }
};

/// L2 error of the stress within the disc, relative.
double error_inside(const Inclusion& problem, const std::string& method, const std::string& functions, double h) {
  Model model(problem.text(method, functions, h));
  EXPECT_TRUE(model.run());
  const MaterialState& m = model.material();
  double off = 0.0, all = 0.0;
  for (const Slice& s : m.slices)
    if (s.body == 1)
      for (int p = s.begin; p < s.end; ++p) {
        const auto& stress = m.stress[p];
        const double x = stress[XX] - problem.inside(), y = stress[YY] + problem.inside();
        off += m.volume[p] * (x * x + y * y + 2.0 * stress[XY] * stress[XY]);
        all += m.volume[p] * 2.0 * problem.inside() * problem.inside();
      }
  return std::sqrt(off / all);
}

TEST(Joined, InclusionInAPlate) {
  struct Demand {
    const char *method, *functions;
    double ratio, error;
  };
  for (const Demand& want : {Demand{"mpm", "linear", 10.0, 0.05}, {"mpm", "linear", 0.1, 0.05}, {"mpm", "b2gimp", 10.0, 0.05},
                             {"fem", "linear", 10.0, 0.05}}) {
    const double error = error_inside({want.ratio}, want.method, want.functions, 0.2);
    EXPECT_LT(error, want.error) << want.method << " " << want.functions << " " << want.ratio;
    const std::string with = want.method == std::string("fem") ? "fem" : want.functions;
    record({group, fmt::format("disc of {} times the stiffness in a plate, ten cells across, {}: L2 error of its stress", want.ratio, with),
            error, "0", fmt::format("{}", want.error), "Goodier 1933"});
  }
}

/// A linear field across an inclined tie: what the penalty gives way is all that is missing.
TEST(Joined, PatchAcrossAnInclinedTie) {
  for (const char* functions : {"linear", "b2gimp"}) {
    Model model(fmt::format(R"toml(
[model]
plane = "strain"
kinematics = "small"
[grid]
origin = [0.0, 0.0]
cell_size = 0.1
cells = [10, 10]
shape_functions = "{}"
{}
[body.a]
material = "m"
shape.polygon = [[0.0, 0.0], [0.37, 0.0], [0.72, 1.0], [0.0, 1.0]]
[body.b]
material = "m"
shape.polygon = [[0.37, 0.0], [1.0, 0.0], [1.0, 1.0], [0.72, 1.0]]
[contact.c]
body = "b"
other = "a"
kind = "tie"
[boundary.left]
where.box.max = [1e-6, 9.0]
ux = "t*(1e-3*x + 2e-4*y)"
uy = "t*(1e-4*x - 5e-4*y)"
[boundary.right]
where.box.min = [0.999999, -9.0]
ux = "t*(1e-3*x + 2e-4*y)"
uy = "t*(1e-4*x - 5e-4*y)"
[boundary.base]
where.box.max = [9.0, 1e-6]
ux = "t*(1e-3*x + 2e-4*y)"
uy = "t*(1e-4*x - 5e-4*y)"
[boundary.top]
where.box.min = [-9.0, 0.999999]
ux = "t*(1e-3*x + 2e-4*y)"
uy = "t*(1e-4*x - 5e-4*y)"
[steps]
count = 1
)toml",
                            functions, elastic("m", 1e6, 0.3)));
    ASSERT_TRUE(model.run());
    const double lambda = 1e6 * 0.3 / (1.3 * 0.4), mu = 1e6 / 2.6;
    const FieldErrors e = field_errors(
        model, [](const Vec3& x) { return Vec3(1e-3 * x.x() + 2e-4 * x.y(), 1e-4 * x.x() - 5e-4 * x.y(), 0.0); },
        [&](const Vec3&) {
          Voigt v = Voigt::Zero();
          v[XX] = lambda * 5e-4 + 2.0 * mu * 1e-3;
          v[YY] = lambda * 5e-4 - 2.0 * mu * 5e-4;
          v[ZZ] = lambda * 5e-4;
          v[XY] = mu * 3e-4;
          return v;
        });
    EXPECT_LT(e.displacement, 1e-3) << functions;
    EXPECT_LT(e.stress, 5e-3) << functions;
    record({group, fmt::format("linear field across an inclined tie, {}: L2 error of the stress", functions), e.stress, "0",
            "0.005", "exact"});
  }
}

/// What draws a rigid bar down in the hole that it fills [N].
double drawn_bar(const char* method, const char* mesh, const char* contact, double by) {
  Model model(fmt::format(R"toml(
method = "{}"
[model]
plane = "strain"
kinematics = "small"
[grid]
origin = [-2.0, -2.0]
cell_size = 0.1
cells = [40, 40]
{}
[body.soil]
material = "m"
shape.difference = [{{ box = {{ min = [-2.0, -2.0], max = [2.0, 2.0] }} }}, {{ disc = {{ centre = [0.0, 0.0], radius = 0.5 }} }}]
mesh = {{ kind = "{}", size = 0.15 }}
[body.bar]
rigid = true
shape.disc = {{ centre = [0.0, 0.0], radius = 0.5 }}
displacement = [0.0, {}]
[contact.c]
body = "soil"
rigid = "bar"
kind = "{}"
[boundary.base]
where.box.max = [9.0, -1.99999]
ux = 0.0
uy = 0.0
[boundary.top]
where.box.min = [-9.0, 1.99999]
ux = 0.0
uy = 0.0
[steps]
count = 1
)toml",
                          method, elastic("m", 1e7, 0.3), mesh, -by, contact));
  EXPECT_TRUE(model.run());
  return model.step.balance().reactions.rigid[1].y();
}

/// Chords of the mesh lie beside the arc that the rigid bar has; material points tie the same file.
TEST(Joined, RigidDiscInAMeshedHole) {
  const double fem = drawn_bar("fem", "quads", "tie", 0.01), mpm = drawn_bar("mpm", "quads", "tie", 0.01);
  EXPECT_LT(relative(fem, mpm), 0.03);
  record({group, "rigid disc tied in a hole, fem over mpm, less 1", relative(fem, mpm), "0", "0.03", "one file"});
}

/// Where a body fits without a gap the contact recedes: its extent does not depend on the load, which so is proportional to the
/// motion (Dundurs and Stippes 1970). Chords that counted as material inside of the bar gave 4e6 times the force of the smallest one.
TEST(Joined, RigidDiscThatFillsAMeshedHole) {
  for (const char* mesh : {"quads", "triangles"}) {
    const double little = drawn_bar("fem", mesh, "frictionless", 1e-9) / 1e-9, much = drawn_bar("fem", mesh, "frictionless", 1e-3) / 1e-3;
    const double points = drawn_bar("mpm", mesh, "frictionless", 1e-3) / 1e-3;
    EXPECT_LT(relative(little, much), 0.01) << mesh;
    EXPECT_LT(relative(much, points), 0.03) << mesh;
    record({group, fmt::format("rigid disc that fills a hole, frictionless, {}: force over motion at 1e-9 m and at 1e-3 m, less 1", mesh), relative(little, much), "0", "0.01",
            "Dundurs and Stippes 1970"});
  }
}

TEST(Joined, BodiesOfATieHaveToTouch) {
  std::string text = blocks("mpm", 0.1, "[contact.c]\nbody = \"b\"\nother = \"a\"\nkind = \"tie\"\n");
  text.replace(text.find(box(0.5, 0.0, 1.0, 0.5)), box(0.5, 0.0, 1.0, 0.5).size(), box(0.52, 0.0, 1.0, 0.5));
  try {
    Model model(text);
    FAIL() << "tied across a gap";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("[contact.c]: the surfaces of \"b\" and \"a\" do not touch"), std::string::npos);
  }
}

}  // namespace
}  // namespace berm::verify
