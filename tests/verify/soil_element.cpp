/// Laboratory tests of soil as runs of one cell, MPM and FEM: triaxial and biaxial compression under a confining
/// pressure, simple shear under a normal stress. Mohr-Coulomb; closed forms of docs/theory/plasticity.md, section 3.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double degree = std::numbers::pi / 180.0, youngs = 1e6, poisson = 0.29;

struct Soil {
  std::string name;
  double cohesion, friction, dilatancy;  ///< [Pa], [deg]

  double Kp() const { return std::pow(std::tan((45.0 + 0.5 * friction) * degree), 2); }
  double strength(double s3) const { return s3 * Kp() + 2.0 * cohesion * std::sqrt(Kp()); }
};
const Soil clay{"clay", 5e3, 25.0, 0.0}, rockfill{"rockfill", 0.0, 37.0, 0.0};

std::string side(const std::string& name, const std::string& min, const std::string& max, const std::string& motion) {
  return fmt::format("[boundary.{}]\nwhere.box = {{ min = {}, max = {} }}\n{}\n", name, min, max, motion);
}

/// A cell of 1 m on rollers below.
std::string cell(const std::string& method, const std::string& plane, const Soil& soil) {
  return fmt::format(R"(
method = "{}"
[model]
plane = "{}"
kinematics = "small"
[grid]
cells = [1, 1]
cell_size = 1.0
[material.soil]
law = "mohr_coulomb"
density = 2000.0
youngs_modulus = {}
poisson_ratio = {}
cohesion = {}
friction_angle = {}
dilatancy_angle = {}
[body.b]
material = "soil"
shape.box = {{ min = [0.0, 0.0], max = [1.0, 1.0] }}
mesh = {{ kind = "quads", size = 1.0, structured = true }}
[solver]
relative_tolerance = 1e-12
absolute_tolerance = 1e-16
)",
                     method, plane, youngs, poisson, soil.cohesion, soil.friction, soil.dilatancy) +
         side("bottom", "[-1.0, -1e-6]", "[2.0, 1e-6]", "uy = 0.0");
}

struct Compression {
  double s1 = 0.0;        ///< at the end [Pa]
  double yield = 0.0;     ///< axial strain since the confined state where the elastic line meets it
  double dilation = 0.0;  ///< volumetric over axial strain rate at the end
};

/// The confining pressure s3 comes up in half of the time, while the plate follows so that both stresses in the plane
/// are s3; then the plate compresses the cell to 1.6 times its strain at yield.
Compression compress(const std::string& method, const std::string& plane, const Soil& soil, double s3) {
  const bool triaxial = plane == "axisymmetric";
  const double q = soil.strength(s3) - s3;
  const double most = 1.6 * q / youngs * (triaxial ? 1.0 : 1.0 - poisson * poisson);
  const double confined = s3 / youngs * (1.0 - 2.0 * poisson) * (triaxial ? 1.0 : 1.0 + poisson);
  constexpr int half = 16;
  std::string text = cell(method, plane, soil);
  text += side("left", "[-1e-6, -1.0]", "[1e-6, 2.0]", "ux = 0.0");
  text += side("plate", "[-1.0, 0.999999]", "[2.0, 1.000001]",
               fmt::format("uy = \"-{}*min(2*t, 1) - {}*max(2*t - 1, 0)\"", confined, most));
  text += fmt::format(
      "[pressure.confining]\nbody = \"b\"\nwhere.box.min = [0.999999, -1.0]\nvalue = \"{}*min(2*t, 1)\"\n", s3);
  Model model(text, {fmt::format("steps.count={}", 2 * half), "steps.adaptive=false"});
  double stress[half + 1], volume[half + 1];
  for (int k = -half + 1; k <= half; ++k) {
    model.advance(0.5 / half);
    const MaterialState& m = model.material();
    for (const Voigt& s : m.stress) EXPECT_LT((s - m.stress[0]).norm(), 1e-6 * soil.strength(s3));
    if (k < 0) continue;
    stress[k] = -m.stress[0][YY];
    volume[k] = m.strain[0][XX] + m.strain[0][YY] + m.strain[0][ZZ];
  }
  EXPECT_NEAR(stress[0], s3, 1e-9 * soil.strength(s3));
  const double step = most / half, slope = (stress[half / 2] - stress[0]) / (0.5 * most);
  return {stress[half], (stress[half] - stress[0]) / slope, (volume[half] - volume[half - 1]) / -step};
}

double worse(double a, double b, double reference) { return std::abs(a - reference) > std::abs(b - reference) ? a : b; }

TEST(SoilElement, TriaxialAndBiaxial) {
  constexpr double demanded = 1e-8;
  const auto row = [](const std::string& quantity, double reached, double reference) {
    EXPECT_NEAR(reached, reference, demanded * reference) << quantity;
    record({"Soil in the laboratory (V20)", quantity, reached, fmt::format("{:.6g}", reference), "1e-8 relative",
            "theory/plasticity.md, table of section 3"});
  };
  for (const Soil& soil : {clay, rockfill})
    for (const double s3 : {0.0, 10e3, 50e3, 100e3}) {
      if (soil.strength(s3) == 0.0) continue;
      const double s1 = soil.strength(s3), q = s1 - s3;
      double reached = s1, triaxial = q / youngs, biaxial = triaxial * (1.0 - poisson * poisson);
      const double in_space = triaxial, in_plane = biaxial;
      for (const std::string method : {"mpm", "fem"}) {
        const Compression a = compress(method, "axisymmetric", soil, s3), b = compress(method, "strain", soil, s3);
        reached = worse(worse(a.s1, b.s1, s1), reached, s1);
        triaxial = worse(a.yield, triaxial, in_space);
        biaxial = worse(b.yield, biaxial, in_plane);
      }
      const std::string name = fmt::format("{}, lateral pressure {:.0f} kPa: ", soil.name, s3 * 1e-3);
      row(name + "strength, triaxial and biaxial [Pa]", reached, s1);
      row(name + "axial strain at yield, triaxial", triaxial, in_space);
      row(name + "axial strain at yield, biaxial", biaxial, in_plane);
    }
}

TEST(SoilElement, Dilation) {
  for (const double psi : {0.0, 7.0, 10.0}) {
    Soil soil = clay;
    soil.dilatancy = psi;
    const double exact = 1.0 - std::pow(std::tan((45.0 + 0.5 * psi) * degree), 2);
    double reached = exact;
    for (const std::string method : {"mpm", "fem"})
      for (const std::string plane : {"axisymmetric", "strain"})
        reached = worse(compress(method, plane, soil, 50e3).dilation, reached, exact);
    EXPECT_NEAR(reached, exact, 1e-8);
    record({"Soil in the laboratory (V20)",
            fmt::format("dilatancy {:.0f} deg: volumetric over axial plastic strain", psi), reached,
            fmt::format("{:.6g}", exact), "1e-8", "theory/plasticity.md, table of section 3"});
  }
}

/// Shear stress over normal stress at the end of simple shear. The cell can't widen; the lid compresses it to stresses
/// at rest in a fifth of the time, and then moves at the angle of dilatancy. What the stress comes to depends on where
/// it starts, the ratio does not.
double simple_shear(const std::string& method, const Soil& soil) {
  constexpr double normal = 100e3, shear = 3.0;
  const double constrained = youngs * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
  std::string text = cell(method, "strain", soil);
  text += side("base", "[-1.0, -1e-6]", "[2.0, 1e-6]", "ux = 0.0");
  text += side("lid", "[-1.0, 0.999999]", "[2.0, 1.000001]",
               fmt::format("ux = \"{0}*max(t - 0.2, 0)/0.8\"\nuy = \"{1}*max(t - 0.2, 0)/0.8 - {2}*min(5*t, 1)\"",
                           shear, shear * std::tan(soil.dilatancy * degree), normal / constrained));
  Model model(text, {"steps.count=100", "steps.adaptive=false"});
  for (int k = 0; k < 100; ++k) model.advance(0.01);
  const Voigt& s = model.material().stress[0];
  return -s[XY] / s[YY];
}

TEST(SoilElement, SimpleShear) {
  for (Soil soil : {clay, rockfill})
    for (const double psi : {0.0, 10.0}) {
      soil.cohesion = 0.0;
      soil.dilatancy = psi;
      const double phi = soil.friction * degree, s = std::sin(psi * degree);
      const double exact = std::sin(phi) * std::cos(psi * degree) / (1.0 - std::sin(phi) * s);
      const double reached = worse(simple_shear("mpm", soil), simple_shear("fem", soil), exact);
      EXPECT_NEAR(reached, exact, 1e-5 * exact);
      record(
          {"Soil in the laboratory (V20)",
           fmt::format("simple shear, friction {:.0f} deg, dilatancy {:.0f} deg, no cohesion: shear over normal stress",
                       soil.friction, psi),
           reached, fmt::format("{:.6g}", exact), "1e-5 relative", "Davis 1968"});
    }
}

}  // namespace
}  // namespace berm::verify
