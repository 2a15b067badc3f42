/// Elastic disc under two opposite pressures that do not fit the grid: stresses on the loaded diameter against the
/// exact solution (Hondros 1959).

#include <fmt/format.h>

#include <Eigen/QR>
#include <cmath>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double radius = 0.075, pressure = 1e6, alpha = 5.739 * std::numbers::pi / 180.0;

struct Stress {
  double xx, yy;
};

/// At the height y on the loaded diameter.
Stress exact(double y) {
  const double r2 = (y / radius) * (y / radius), c = std::cos(2.0 * alpha), s = std::sin(2.0 * alpha);
  const double first = (1.0 - r2) * s / (1.0 - 2.0 * r2 * c + r2 * r2);
  const double second = std::atan((1.0 + r2) / (1.0 - r2) * std::tan(alpha));
  const double f = 2.0 * pressure / std::numbers::pi;
  return {f * (first - second), -f * (first + second)};
}

struct Errors {
  double centre;     ///< of sigma_xx there
  double xx, yy;     ///< L2 over |y| <= 0.8 R, relative
  double load;       ///< of the total force of a pressure
  double centre_xx;  ///< in units of 2P/(pi D t)
};

/// Stress at (0, y): quadratic least-squares fit to the integration points within one cell size in x and in y.
class RecoveredStress {
public:
  RecoveredStress(const std::vector<Vec3>& x, const std::vector<Voigt>& stress, double reach)
      : x_(x), stress_(stress), reach_(reach) {}

  double operator()(double y, int component) const {
    Eigen::Matrix<double, 6, 6> moments = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t p = 0; p < x_.size(); ++p) {
      const Vec2 d = (in_plane(x_[p]) - Vec2(0.0, y)) / reach_;
      if (d.cwiseAbs().maxCoeff() > 1.0) continue;
      Eigen::Matrix<double, 6, 1> basis;
      basis << 1.0, d.x(), d.y(), d.x() * d.x(), d.x() * d.y(), d.y() * d.y();
      moments += basis * basis.transpose();
      right += basis * stress_[p][component];
    }
    return moments.completeOrthogonalDecomposition().solve(right)[0];
  }

private:
  const std::vector<Vec3>& x_;
  const std::vector<Voigt>& stress_;
  double reach_;
};

Errors solve(const std::vector<std::string>& overrides) {
  Model model(read_case(BERM_SOURCE_DIR "/tests/verify/brazilian_elastic.toml", overrides));
  const std::vector<Vec3> x = model.world->discretisation->point_positions();
  model.advance(1.0);
  const RecoveredStress at(x, model.material().stress, 1.01 * model.world->discretisation->cell_size());
  Errors e{};
  e.load = relative(model.step.balance().pressure_force[1].y(), 2.0 * pressure * radius * std::sin(alpha));
  const double centre = at(0.0, XX);
  e.centre = relative(centre, exact(0.0).xx);
  e.centre_xx = centre / (2.0 * pressure * std::sin(alpha) / std::numbers::pi);
  double size_xx = 0.0, size_yy = 0.0;
  for (int k = -80; k <= 80; ++k) {
    const double y = 0.01 * k * radius;
    const Stress s = exact(y);
    e.xx += std::pow(at(y, XX) - s.xx, 2);
    e.yy += std::pow(at(y, YY) - s.yy, 2);
    size_xx += s.xx * s.xx;
    size_yy += s.yy * s.yy;
  }
  e.xx = std::sqrt(e.xx / size_xx);
  e.yy = std::sqrt(e.yy / size_yy);
  return e;
}

TEST(BrazilianElastic, ExactSolutionHasTheKnownCentreValues) {
  // Values of the solution in units of 2P/(pi D t).
  const double unit = 2.0 * pressure * std::sin(alpha) / std::numbers::pi;
  EXPECT_NEAR(exact(0.0).xx / unit, 0.98830, 1e-4);
  EXPECT_NEAR(exact(0.0).yy / unit, -2.99165, 1e-4);
}

TEST(BrazilianElastic, StressesOnTheLoadedDiameter) {
  struct Variant {
    const char* name;
    double centre, xx;  ///< tolerances
    std::vector<std::string> overrides;
  };
  const std::string group = "Brazilian disc, elastic";
  for (const Variant& v :
       {Variant{"mpm, axis in mid-cell, h = 5 mm", 0.01, 0.03, {}},
        {"mpm, axis on a grid line, h = 5 mm", 0.015, 0.11, {"grid.origin=[-0.085,-0.085]", "grid.cells=[34,34]"}},
        {"mpm, grid turned by 20 deg, h = 5 mm",
         0.015,
         0.11,
         {"grid.origin=[-0.1,-0.1]", "grid.cells=[40,40]", "grid.angle=20"}},
        {"mpm, triangles, h = 2.5 mm",
         0.01,
         0.06,
         {"grid.kind=\"union_jack\"", "grid.cell_size=0.0025", "grid.cells=[66,66]"}},
        {"mpm, quads, h = 2.5 mm", 0.01, 0.03, {"grid.cell_size=0.0025", "grid.cells=[66,66]"}},
        {"fem, quad4, h = 5 mm", 0.01, 0.035, {"method=\"fem\"", "body.disc.mesh.structured=true"}},
        {"fem, quad8, h = 5 mm",
         0.01,
         0.03,
         {"method=\"fem\"", "body.disc.mesh.structured=true", "body.disc.mesh.order=2"}},
        {"fem, quad8 of Gmsh, h = 5 mm", 0.01, 0.03, {"method=\"fem\"", "body.disc.mesh.order=2"}}}) {
    SCOPED_TRACE(v.name);
    const Errors e = solve(v.overrides);
    EXPECT_LT(e.load, 1e-3);
    EXPECT_LT(e.centre, v.centre);
    EXPECT_LT(e.xx, v.xx);
    EXPECT_LT(e.yy, 0.035);
    const char* source = "exact solution of Hondros (1959)";
    record({group, fmt::format("{}: centre stress xx over 2P/(pi D t)", v.name), e.centre_xx, "0.98830",
            fmt::format("{} %", 100 * v.centre), source});
    record({group, fmt::format("{}: L2 error of stress xx, -0.8 R < y < 0.8 R", v.name), e.xx, "0",
            fmt::format("{:.2g} %", 100 * v.xx), source});
    record({group, fmt::format("{}: L2 error of stress yy, -0.8 R < y < 0.8 R", v.name), e.yy, "0", "3.5 %", source});
    record({group, fmt::format("{}: error of the total load", v.name), e.load, "0", "0.1 %", "2 p R t sin(alpha)"});
  }
}

/// Smooth functions against linear finite elements of the same size, which have as many unknowns and fit the disc.
TEST(BrazilianElastic, SmoothFunctionsBeatFiniteElements) {
  const Errors fem = solve({"method=\"fem\"", "body.disc.mesh.structured=true"});
  for (const char* functions : {"quadratic_bspline", "cubic_bspline", "b2gimp"})
    for (const bool on_line : {false, true}) {
      std::vector<std::string> overrides = {fmt::format("grid.shape_functions={}", functions)};
      if (on_line) overrides.insert(overrides.end(), {"grid.origin=[-0.085,-0.085]", "grid.cells=[34,34]"});
      const Errors e = solve(overrides);
      const std::string name =
          fmt::format("mpm, {}, {}, h = 5 mm", functions, on_line ? "axis on a grid line" : "axis in mid-cell");
      EXPECT_LT(e.centre, 0.002) << name;
      EXPECT_LT(e.xx, fem.xx) << name;
      EXPECT_LT(e.yy, fem.yy) << name;
      record({"Brazilian disc, elastic", name + ": L2 error of stress xx, -0.8 R < y < 0.8 R", e.xx, "0",
              fmt::format("that of quad4: {:.2g}", fem.xx), "exact solution of Hondros (1959)"});
      record({"Brazilian disc, elastic", name + ": L2 error of stress yy, -0.8 R < y < 0.8 R", e.yy, "0",
              fmt::format("that of quad4: {:.2g}", fem.yy), "exact solution of Hondros (1959)"});
    }
}

}  // namespace
}  // namespace berm::verify
