/// One cell, every law, tension, compression and shear, plane strain and plane stress, small and finite strain, MPM and
/// FEM: the curves are the closed forms of docs/theory/damage.md, sections 2 to 6.

#include <fmt/format.h>

#include "closed_forms.hpp"
#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double side = 0.1;  // of the cell; the crack-band length [m]

enum class Path { tension, compression, shear };

struct ElementCase {
  std::string law, method, plane, kinematics;
  Path path;
};

std::string boundary(const std::string& name, double x, double y, const std::string& motion) {
  const double d = 1e-6;
  return fmt::format("[boundary.{}]\nwhere.box = {{ min = [{}, {}], max = [{}, {}] }}\n{}\n", name, x - d, y - d, x + d,
                     y + d, motion);
}

/// `reach`: displacement gradient at time 1. Uniaxial: along x with the sides free; shear: u = reach (y, x).
std::string case_text(const ElementCase& s, double reach) {
  std::string text = fmt::format(R"(
method = "{}"
[model]
plane = "{}"
kinematics = "{}"
[grid]
cells = [1, 1]
cell_size = {}
[material.m]
density = 2400.0
youngs_modulus = 35.5e9
poisson_ratio = 0.2
{}
[body.b]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [{}, {}] }}
mesh = {{ kind = "quads", size = {}, structured = true }}
[solver]
relative_tolerance = 1e-12
absolute_tolerance = 1e-16
)",
                                 s.method, s.plane, s.kinematics, side, law_keys(s.law), side, side, side);
  const double u = reach * side;
  if (s.path == Path::shear)
    return text + boundary("n00", 0, 0, "ux = 0.0\nuy = 0.0") +
           boundary("n10", side, 0, fmt::format("ux = 0.0\nuy = {}", u)) +
           boundary("n01", 0, side, fmt::format("ux = {}\nuy = 0.0", u)) +
           boundary("n11", side, side, fmt::format("ux = {}\nuy = {}", u, u));
  return text + boundary("n00", 0, 0, "ux = 0.0\nuy = 0.0") + boundary("n01", 0, side, "ux = 0.0") +
         boundary("n10", side, 0, fmt::format("ux = {}\nuy = 0.0", u)) +
         boundary("n11", side, side, fmt::format("ux = {}", u));
}

/// Displacement gradient per step -> logarithmic or small principal strain after k of n steps. MPM starts every step
/// from the deformed state, FEM counts from the undeformed one.
double strain_after(const ElementCase& s, double reach, int k, int n) {
  if (s.kinematics == "small") return reach * k / n;
  return s.method == "mpm" ? k * std::log1p(reach / n) : std::log1p(reach * k / n);
}

Triple principal_strain(const ElementCase& s, double reach, int k, int n) {
  const double nu = Concrete{}.nu;
  Triple e{};
  e[0] = strain_after(s, reach, k, n);
  if (s.path == Path::shear)
    e[1] = strain_after(s, -reach, k, n);
  else
    e[1] = -(s.plane == "strain" ? nu / (1.0 - nu) : nu) * e[0];
  if (s.plane == "stress") e[2] = -nu / (1.0 - nu) * (e[0] + e[1]);
  return e;
}

/// Largest difference between the stresses of all points and the closed form along the path, over the largest stress.
double worst_error(const ElementCase& s) {
  const double reach = s.path == Path::compression ? -3.0e-3 : 1.0e-3;
  constexpr int steps = 25;
  Model model(case_text(s, reach), {fmt::format("steps.count={}", steps)});
  PathPoint reference(s.law, side);
  double worst = 0.0, largest = 0.0;
  for (int k = 1; k <= steps; ++k) {
    if (!model.advance(1.0 / steps).converged) return infinity;
    const Triple e = principal_strain(s, reach, k, steps), t = reference.stress(e);
    // The laws give Kirchhoff stress; points carry Cauchy stress.
    const double J = s.kinematics == "finite" ? std::exp(e[0] + e[1] + e[2]) : 1.0;
    Voigt expected = Voigt::Zero();
    if (s.path == Path::shear)
      expected << 0.5 * (t[0] + t[1]), 0.5 * (t[0] + t[1]), t[2], 0.5 * (t[0] - t[1]), 0.0, 0.0;
    else
      expected << t[0], t[1], t[2], 0.0, 0.0, 0.0;
    expected /= J;
    largest = std::max(largest, expected.norm());
    for (const Voigt& stress : model.material().stress)
      worst = std::max(worst, (stress - expected).norm() / expected.norm());
  }
  EXPECT_GT(largest, 1e6);  // the path is no walk through zero stress
  return worst;
}

class SingleElement : public ::testing::TestWithParam<std::string> {};

TEST_P(SingleElement, FollowsTheClosedForm) {
  const std::string law = GetParam();
  const char* names[] = {"tension", "compression", "shear"};
  for (const Path path : {Path::tension, Path::compression, Path::shear}) {
    double all = 0.0;
    for (const std::string method : {"mpm", "fem"})
      for (const std::string plane : {"strain", "stress"})
        for (const std::string kinematics : {"small", "finite"}) {
          const double error = worst_error({law, method, plane, kinematics, path});
          EXPECT_LT(error, 1e-8) << method << ", plane " << plane << ", " << kinematics << ", " << names[int(path)];
          all = std::max(all, error);
        }
    record({"Single element", fmt::format("{}, {}: largest stress error", law, names[int(path)]), all, "0", "1e-8",
            "closed forms, theory/damage.md 2-6"});
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, SingleElement,
                         ::testing::Values("linear_elastic", "simo_ju", "rankine", "mazars", "mazars_classic",
                                           "lemaitre_strain", "lemaitre_energy"));

/// Peaks of Simo-Ju by the table of docs/theory/damage.md, section 3 (p*/ft to six digits).
TEST(SingleElementPeaks, SimoJuTable) {
  struct Entry {
    Path path;
    const char* plane;
    double peak;
  };
  for (const Entry& entry : {Entry{Path::tension, "stress", 1.0},
                             {Path::tension, "strain", 1.02062},
                             {Path::compression, "stress", 12.3},
                             {Path::compression, "strain", 12.5536},
                             {Path::shear, "strain", 1.19393},
                             {Path::shear, "stress", 1.19393}}) {
    const Concrete c;
    const ElementCase s{"simo_ju", "mpm", entry.plane, "small", entry.path};
    // Strain at the peak: e* = p* C^-1 : S, eq. (15).
    const bool plane_strain = s.plane == "strain";
    const double modulus = s.path == Path::shear ? c.E / (1.0 + c.nu) : plane_strain ? c.E / (1.0 - c.nu * c.nu) : c.E;
    const double sign = s.path == Path::compression ? -1.0 : 1.0;
    const double at_peak = sign * entry.peak * c.ft / modulus;
    double peak = 0.0;
    Model model(case_text(s, 1.05 * at_peak), {"steps.count=105"});
    for (int k = 0; k < 105; ++k) {
      model.advance(1.0 / 105);
      const Voigt& t = model.material().stress[0];
      peak = std::max(peak, std::abs(s.path == Path::shear ? t[XY] : t[XX]));
    }
    EXPECT_NEAR(peak / c.ft, entry.peak, 1e-5 * entry.peak);
    const char* names[] = {"tension", "compression", "shear"};
    record({"Single element", fmt::format("simo_ju, {}, plane {}: peak over ft", names[int(s.path)], s.plane),
            peak / c.ft, fmt::format("{:.6g}", entry.peak), "1e-5 relative", "theory/damage.md, table of section 3"});
  }
}

}  // namespace
}  // namespace berm::verify
