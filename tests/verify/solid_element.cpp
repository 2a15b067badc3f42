/// One cell in space and one around the axis, every law, along paths that have closed forms: MPM and FEM, small and
/// logarithmic strain (docs/theory/damage.md, sections 2 to 6).

#include <fmt/format.h>

#include "closed_forms.hpp"
#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double side = 0.1;  // of the cell; the crack-band length [m]
constexpr int steps = 25;

enum class Path { tension, compression, shear, biaxial };
constexpr const char* path_names[] = {"tension", "compression", "shear", "biaxial tension"};

struct ElementCase {
  std::string law, method, kinematics;
  Path path;
  double reach;  ///< displacement gradient at time 1
};

double reach_of(Path path) { return path == Path::compression ? -3.0e-3 : 1.0e-3; }

std::string material(const std::string& law) {
  return fmt::format("[material.m]\ndensity = 2400.0\nyoungs_modulus = 35.5e9\npoisson_ratio = 0.2\n{}", law_keys(law));
}

std::string rest(const ElementCase& s, const std::string& shape, const std::string& mesh) {
  return fmt::format(R"(
{}
[body.b]
material = "m"
shape.box = {}
mesh = {{ kind = "{}", size = {}, structured = true }}
[steps]
count = {}
[solver]
relative_tolerance = 1e-11
absolute_tolerance = 1e-16
)",
                     material(s.law), shape, mesh, side, steps);
}

/// Holds one displacement where coordinate `axis` has the value `at`.
std::string face(const std::string& name, int dimension, int axis, double at, const std::string& motion) {
  const double d = 1e-6;
  std::string low, high;
  for (int i = 0; i < dimension; ++i) {
    low += fmt::format("{}{}", i ? ", " : "", i == axis ? at - d : -1.0);
    high += fmt::format("{}{}", i ? ", " : "", i == axis ? at + d : 1.0);
  }
  return fmt::format("[boundary.{}]\nwhere.box = {{ min = [{}], max = [{}] }}\n{}\n", name, low, high, motion);
}

/// Uniaxial along x and biaxial along x and y with the other sides free; shear: u = reach (y, x, 0).
std::string solid_text(const ElementCase& s) {
  std::string text = fmt::format(
      "method = \"{}\"\n[model]\ndimension = 3\nkinematics = \"{}\"\n[grid]\ncells = [1, 1, 1]\ncell_size = {}\n",
      s.method, s.kinematics, side);
  text += rest(s, fmt::format("{{ min = [0.0, 0.0, 0.0], max = [{0}, {0}, {0}] }}", side), "hexahedra");
  const double u = s.reach * side;
  if (s.path == Path::shear) {
    for (int i : {0, 1})
      for (int j : {0, 1})
        text += fmt::format(
            "[boundary.n{}{}]\nwhere.box = {{ min = [{}, {}, -1.0], max = [{}, {}, 1.0] }}\nux = {}\nuy = {}\nuz = "
            "0.0\n",
            i, j, i * side - 1e-6, j * side - 1e-6, i * side + 1e-6, j * side + 1e-6, j * u, i * u);
    return text;
  }
  text += face("x0", 3, 0, 0.0, "ux = 0.0") + face("x1", 3, 0, side, fmt::format("ux = {}", u));
  text += face("y0", 3, 1, 0.0, "uy = 0.0") + face("z0", 3, 2, 0.0, "uz = 0.0");
  if (s.path == Path::biaxial) text += face("y1", 3, 1, side, fmt::format("uy = {}", u));
  return text;
}

/// A cylinder, or a ring whose inner radius is the side of the cell: uniaxial along its axis with the sides free, or
/// widened by the same strain in every direction across the axis.
std::string axisymmetric_text(const ElementCase& s, double inner) {
  std::string text = fmt::format(
      "method = \"{}\"\n[model]\nplane = \"axisymmetric\"\nkinematics = \"{}\"\n[grid]\norigin = [{}, 0.0]\ncells = "
      "[1, "
      "1]\ncell_size = {}\n",
      s.method, s.kinematics, inner, side);
  text += rest(s, fmt::format("{{ min = [{}, 0.0], max = [{}, {}] }}", inner, inner + side, side), "quads");
  text += face("low", 2, 1, 0.0, "uy = 0.0");
  if (s.path == Path::biaxial)
    return text + face("inner", 2, 0, inner, fmt::format("ux = {}", s.reach * inner)) +
           face("outer", 2, 0, inner + side, fmt::format("ux = {}", s.reach * (inner + side)));
  text += face("high", 2, 1, side, fmt::format("uy = {}", s.reach * side));
  return inner > 0.0 ? text : text + face("axis", 2, 0, 0.0, "ux = 0.0");
}

/// Displacement gradient per step -> logarithmic or small principal strain after k of n steps. MPM starts every step
/// from the deformed state, FEM counts from the undeformed one.
double strain_after(const ElementCase& s, double reach, int k) {
  if (s.kinematics == "small") return reach * k / steps;
  return s.method == "mpm" ? k * std::log1p(reach / steps) : std::log1p(reach * k / steps);
}

/// Loaded directions first.
Triple principal_strain(const ElementCase& s, int k) {
  const double nu = Concrete{}.nu, e = strain_after(s, s.reach, k);
  if (s.path == Path::shear) return {e, strain_after(s, -s.reach, k), 0.0};
  if (s.path == Path::biaxial) return {e, e, -2.0 * nu / (1.0 - nu) * e};
  return {e, -nu * e, -nu * e};
}

/// Principal stresses as components; around the axis x is the radius, y the axis and z the direction around it.
Voigt components(const ElementCase& s, const Triple& t, bool axisymmetric) {
  Voigt out = Voigt::Zero();
  if (s.path == Path::shear)
    out << 0.5 * (t[0] + t[1]), 0.5 * (t[0] + t[1]), t[2], 0.5 * (t[0] - t[1]), 0.0, 0.0;
  else if (!axisymmetric)
    out << t[0], t[1], t[2], 0.0, 0.0, 0.0;
  else if (s.path == Path::biaxial)
    out << t[0], t[2], t[1], 0.0, 0.0, 0.0;
  else
    out << t[1], t[0], t[2], 0.0, 0.0, 0.0;
  return out;
}

/// Largest difference between the stresses of all points and the closed form along the path, over the stress.
double worst_error(const ElementCase& s, const std::string& text, bool axisymmetric) {
  Model model(text);
  PathPoint reference(s.law, side);
  double worst = 0.0, largest = 0.0;
  for (int k = 1; k <= steps; ++k) {
    if (!model.advance(1.0 / steps).converged) return infinity;
    const Triple e = principal_strain(s, k);
    // The laws give Kirchhoff stress; points carry Cauchy stress.
    const double J = s.kinematics == "finite" ? std::exp(e[0] + e[1] + e[2]) : 1.0;
    const Voigt expected = components(s, reference.stress(e), axisymmetric) / J;
    largest = std::max(largest, expected.norm());
    for (const Voigt& stress : model.material().stress)
      worst = std::max(worst, (stress - expected).norm() / expected.norm());
  }
  EXPECT_GT(largest, 1e6);  // the path is no walk through zero stress
  return worst;
}

class SolidElement : public ::testing::TestWithParam<std::string> {};

TEST_P(SolidElement, FollowsTheClosedForm) {
  const std::string law = GetParam();
  for (const Path path : {Path::tension, Path::compression, Path::shear, Path::biaxial}) {
    double all = 0.0;
    for (const std::string method : {"mpm", "fem"})
      for (const std::string kinematics : {"small", "finite"}) {
        const ElementCase s{law, method, kinematics, path, reach_of(path)};
        const double error = worst_error(s, solid_text(s), false);
        EXPECT_LT(error, 1e-8) << method << ", " << kinematics << ", " << path_names[int(path)];
        all = std::max(all, error);
      }
    record({"Single element in space", fmt::format("{}, {}: largest stress error", law, path_names[int(path)]), all,
            "0", "1e-8", "closed forms, theory/damage.md 2-6"});
  }
}

TEST_P(SolidElement, FollowsTheClosedFormAroundTheAxis) {
  const std::string law = GetParam();
  for (const Path path : {Path::tension, Path::compression, Path::biaxial}) {
    double all = 0.0;
    for (const double inner : {0.0, side})
      for (const std::string method : {"mpm", "fem"})
        for (const std::string kinematics : {"small", "finite"}) {
          const ElementCase s{law, method, kinematics, path, reach_of(path)};
          const double error = worst_error(s, axisymmetric_text(s, inner), true);
          EXPECT_LT(error, 1e-8) << method << ", " << kinematics << ", " << path_names[int(path)] << ", inner "
                                 << inner;
          all = std::max(all, error);
        }
    record({"Single element around the axis",
            fmt::format("{}, {}: largest stress error", law,
                        path == Path::biaxial ? "radial expansion" : path_names[int(path)]),
            all, "0", "1e-8", "closed forms, theory/damage.md 2-6"});
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, SolidElement,
                         ::testing::Values("linear_elastic", "simo_ju", "rankine", "mazars", "mazars_classic",
                                           "lemaitre_strain", "lemaitre_energy"));

}  // namespace
}  // namespace berm::verify
