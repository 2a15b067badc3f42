/// Blocks in space under pressure, a smooth platen and their own weight: closed forms of displacement, stress and
/// reaction.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double youngs = 30e9, poisson = 0.2;
const std::string group = "Blocks in space";

/// A block of that height over a square of unit side on the planes of symmetry x = y = z = 0, y along its axis, cells
/// of 0.25.
std::string block(const std::string& method, const std::string& mesh, double width, double height) {
  std::string text = fmt::format("method = \"{}\"\n[model]\ndimension = 3\nkinematics = \"small\"\n", method);
  text += "[grid]\ncell_size = 0.25\ncells = [6, 14, 6]\n";
  text +=
      fmt::format("[material.m]\nlaw = \"linear_elastic\"\ndensity = 2400.0\nyoungs_modulus = {}\npoisson_ratio = {}\n",
                  youngs, poisson);
  text +=
      fmt::format("[body.b]\nmaterial = \"m\"\nshape.box = {{ min = [0.0, 0.0, 0.0], max = [{0}, {1}, {0}] }}\n{2}\n",
                  width, height, mesh);
  for (int axis : {0, 1, 2}) {
    std::string low, high;
    for (int i = 0; i < 3; ++i) {
      low += fmt::format("{}{}", i ? ", " : "", i == axis ? -1e-6 : -9.0);
      high += fmt::format("{}{}", i ? ", " : "", i == axis ? 1e-6 : 9.0);
    }
    text +=
        fmt::format("[boundary.{0}]\nwhere.box = {{ min = [{1}], max = [{2}] }}\nu{0} = 0.0\n", "xyz"[axis], low, high);
  }
  return text +
         "[steps]\ncount = 1\nadaptive = false\n[solver]\nrelative_tolerance = 1e-10\nabsolute_tolerance = 1e-15\n";
}

struct Variant {
  std::string name, method, mesh;
  double width, height;
};

const std::vector<Variant> variants = {
    {"mpm, hexahedra", "mpm", "", 1.0, 1.0},
    {"mpm, hexahedra, free sides cut cells", "mpm", "", 0.9, 1.1},
    {"fem, hex8", "fem", "mesh = { kind = \"hexahedra\", size = 0.25 }", 1.0, 1.0},
    {"fem, hex20", "fem", "mesh = { kind = \"hexahedra\", size = 0.25, order = 2 }", 1.0, 1.0},
    {"fem, tet10", "fem", "mesh = { kind = \"tetrahedra\", size = 0.25, order = 2 }", 1.0, 1.0},
};

double base_reaction(const Model& m) { return m.step.balance().reactions.boundary[1].y(); }

/// Largest |u - exact| over the largest |exact| for a uniform strain along y.
double worst_displacement(const Model& m, double strain) {
  const std::vector<Vec3> X = m.world->discretisation->point_origins(),
                          u = m.world->discretisation->point_displacements();
  double worst = 0.0, size = 0.0;
  for (std::size_t p = 0; p < X.size(); ++p) {
    const Vec3 exact = strain * X[p].cwiseProduct(Vec3(-poisson, 1.0, -poisson));
    worst = std::max(worst, (u[p] - exact).norm());
    size = std::max(size, exact.norm());
  }
  return worst / size;
}

TEST(SolidLoads, UniformPressure) {
  constexpr double value = 1e6;
  for (const Variant& v : variants) {
    SCOPED_TRACE(v.name);
    Model m(block(v.method, v.mesh, v.width, v.height) +
            fmt::format("[pressure.top]\nbody = \"b\"\nwhere.box.min = [-9.0, {}, -9.0]\nvalue = {}\n", v.height - 1e-6,
                        value));
    m.advance(1.0);
    const double error = worst_displacement(m, -value / youngs);
    const double load = relative(base_reaction(m), value * v.width * v.width);
    EXPECT_LT(error, 0.01);
    EXPECT_LT(load, 1e-6);
    record(
        {group, v.name + ", uniform pressure: largest error of the displacement", error, "0", "1 %", "uniform stress"});
    record({group, v.name + ", uniform pressure: error of the reaction", load, "0", "1e-6", "pressure times area"});
  }
}

TEST(SolidLoads, SmoothPlaten) {
  constexpr double strain = 1e-4, penalty = 1000.0;  // in units of E over the cell size
  for (const Variant& v : variants) {
    SCOPED_TRACE(v.name);
    Model m(
        block(v.method, v.mesh, v.width, v.height) +
        fmt::format("[body.platen]\nrigid = true\nshape.box = {{ min = [-0.1, {0}, -0.1], max = [1.2, {1}, 1.2] }}\n"
                    "displacement = [0.0, {2}, 0.0]\n[contact.top]\nbody = \"b\"\nrigid = \"platen\"\n"
                    "kind = \"frictionless\"\nstiffness = {3}\n",
                    v.height, v.height + 0.25, -strain * v.height, penalty));
    m.advance(1.0);
    // Block and penalty in series.
    const double h = m.world->discretisation->cell_size();
    const double stress = youngs * strain / (1.0 + h / (penalty * v.height));
    const double load = relative(base_reaction(m), stress * v.width * v.width);
    const double error = worst_displacement(m, -stress / youngs);
    EXPECT_LT(load, 1e-4);
    EXPECT_LT(error, 1e-3);
    record(
        {group, v.name + ", smooth platen: error of the reaction", load, "0", "0.01 %", "block and penalty in series"});
    record(
        {group, v.name + ", smooth platen: largest error of the displacement", error, "0", "0.1 %", "uniform stress"});
  }
}

TEST(SolidLoads, ColumnUnderItsWeight) {
  constexpr double height = 3.0, weight = 2400.0 * 9.81;
  for (Variant v : variants) {
    SCOPED_TRACE(v.name);
    v.height = v.width < 1.0 ? height - 0.1 : height;
    Model m(block(v.method, v.mesh, v.width, v.height), {"model.gravity=[0.0,-9.81,0.0]"});
    m.advance(1.0);
    const double load = relative(base_reaction(m), weight * v.width * v.width * v.height);
    EXPECT_LT(load, 1e-8);
    record({group, v.name + ", own weight: error of the reaction", load, "0", "1e-8", "the weight"});
    // Mean stress of every layer of cells; linear elements know no more.
    const std::vector<Vec3> X = m.world->discretisation->point_origins();
    struct Layer {
      double volume = 0.0, moment = 0.0, stress = 0.0;
    };
    std::map<int, Layer> layers;
    for (std::size_t p = 0; p < X.size(); ++p) {
      Layer& l = layers[static_cast<int>(std::floor(X[p].y() / 0.25))];
      const double volume = m.material().volume[p];
      l.volume += volume;
      l.moment += volume * X[p].y();
      l.stress += volume * m.material().stress[p][YY];
    }
    double worst = 0.0;
    for (const auto& [index, l] : layers)
      worst = std::max(worst, std::abs(l.stress / l.volume + weight * (v.height - l.moment / l.volume)));
    worst /= weight * v.height;
    const bool exact = v.width == 1.0 && v.name != "fem, tet10";
    EXPECT_LT(worst, exact ? 1e-8 : 0.01);
    record({group, v.name + ", own weight: largest error of the mean stress of a layer over that at the base", worst,
            "0", exact ? "1e-8" : "1 %", "linear stress"});
  }
}

}  // namespace
}  // namespace berm::verify
