#pragma once
/// Case files for tests: written to a fresh folder, read back, compared.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "case/read_case.hpp"

namespace berm {

/// A folder of its own for every test, removed at the end.
class CaseFiles : public ::testing::Test {
protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    const std::string name =
        std::string("berm_") + info->test_suite_name() + "_" + info->name() + "_" + std::to_string(getpid());
    folder_ = std::filesystem::temp_directory_path() / name;
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
    std::ofstream(path(name), std::ios::binary) << text;
    return path(name);
  }

  Case read(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    return read_case(write("case.toml", text), overrides);
  }

  /// What is wrong with a case file, without the folder; "" if nothing is.
  std::string errors_of_file(const std::string& name, const std::vector<std::string>& overrides = {}) const {
    try {
      read_case(path(name), overrides);
    } catch (const InputError& error) {
      std::string text = error.what();
      const std::string prefix = folder_.string() + "/";
      for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix)) {
        text.erase(at, prefix.size());
      }
      return text;
    }
    return "";
  }
  std::string errors(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    write("case.toml", text);
    return errors_of_file("case.toml", overrides);
  }

  std::filesystem::path folder_;
};

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A block of clay under its own weight: the shortest complete case.
inline const std::string small_case = R"([model]
gravity = [0.0, -9.81]

[grid]
cell_size = 0.1
cells = [10, 20]

[material.clay]
law = "linear_elastic"
density = 1900.0
youngs_modulus = 1e7
poisson_ratio = 0.3

[body.block]
material = "clay"
shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }
)";

/// Every kind of table and key form.
inline const std::string full_case = R"(title = "Splitting \"test\""
method = "mpm"

[model]
plane = "stress"
kinematics = "small"
thickness = "50 mm"
gravity = [0, "-9.81 m/s2"]

[grid]
kind = "union_jack"
origin = ["-10 cm", -0.1]
cells = [40, 44]
size = [0.2, 0.22]
angle = 20

[material.concrete]
law = "simo_ju"
density = "2.41 t/m3"
youngs_modulus = "35.5 GPa"
poisson_ratio = 0.2
tensile_strength = "3.05 MPa"
strength_ratio = 12.3
fracture_energy = "100 N/m"
crack_band = "5 mm"

[material.steel]
law = "linear_elastic"
density = 7850
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
crack_band = "equal_circle"

[body.disc]
material = "concrete"
points = { mesh = "triangles", size = 0.005, per_element = 6, order = 2 }
mesh = { kind = "triangles", size = "5 mm", order = 2 }

[body.disc.shape]
difference = [
  { disc = { centre = [0, 0], radius = "75 mm" } },
  { union = [{ box = { min = [-0.01, -0.01], max = [0.01, 0.01] } }, { polygon = [[0, 0], [0.02, 0], [0, 0.02]] }] },
]

[body.frame]
material = "steel"
file = "mesh/frame.msh"
group = "core"
points = { per_element = 4 }

[body.platen]
rigid = true
shape.box = { min = [-0.05, 0.08], max = [0.05, 0.09] }
displacement = [0.0, "-0.1 mm"]

[boundary.left]
where.group = "side"
where.box.max = [0.0, 1.0]
ux = 0.0

[pin.centre]
body = "disc"
at = [0.0, 0.0]
fix = "y"

[pressure.top]
body = "disc"
where.sector = { centre = [0, 0], from = "84.261 deg", to = 95.739 }
value = "1 MPa"

[contact.top]
body = "disc"
rigid = "platen"
kind = "frictionless"
stiffness = 500

[control]
kind = "gauge"
gauge = "lateral"
target = "30 um"

[steps]
count = 150
adaptive = false
max_fraction = 2.0

[solver]
integration = "impl_ex"
snap_back = "impl_ex"
line_search = false
petsc = "-ksp_view"

[output]
vtk_every = 10
references = ["curve.csv"]
nominal = { load = "top", displacement = "lateral", direction = [3.0, 4.0], area = 0.0075, length = "15 cm" }

[gauge.lateral]
from = [-0.075, 0.0]
to = [0.075, 0.0]

[probe.centre]
at = [0.0, 0.0]
quantity = "damage"

[probe.edge]
at = [0.05, 0.0]
quantity = "displacement_y"
)";

/// A block of clay in space under its own weight.
inline const std::string small_solid_case = R"([model]
dimension = 3
gravity = [0.0, 0.0, -9.81]

[grid]
cell_size = 0.1
cells = [10, 20, 30]

[material.clay]
law = "linear_elastic"
density = 1900.0
youngs_modulus = 1e7
poisson_ratio = 0.3

[body.block]
material = "clay"
shape.box = { min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 2.0] }
)";

/// A closed surface: the tetrahedron of the origin and the unit vectors.
inline const std::string tetrahedron_stl = R"(solid tetrahedron
facet normal 0 0 -1 outer loop vertex 0 0 0 vertex 0 1 0 vertex 1 0 0 endloop endfacet
facet normal 0 -1 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 0 1 endloop endfacet
facet normal -1 0 0 outer loop vertex 0 0 0 vertex 0 0 1 vertex 0 1 0 endloop endfacet
facet normal 1 1 1 outer loop vertex 1 0 0 vertex 0 1 0 vertex 0 0 1 endloop endfacet
endsolid tetrahedron
)";

/// What models in space can say beyond full_case. The file mesh/rock.stl is tetrahedron_stl.
inline const std::string full_solid_case = R"([model]
dimension = 3
kinematics = "small"
formulation = "total_lagrangian"
gravity = [0, 0, "-9.81 m/s2"]

[grid]
kind = "tetrahedra"
origin = ["-10 cm", -0.2, -0.3]
cells = [4, 5, 6]
size = [0.4, 0.5, "120 cm"]
angle = 30

[material.rock]
law = "linear_elastic"
density = 2500
youngs_modulus = "10 GPa"
poisson_ratio = 0.2

[body.core]
material = "rock"
shape.cylinder = { from = [0, 0, "-5 cm"], to = [0, 0, 0.05], radius = "25 mm" }
points = { mesh = "hexahedra", size = 0.005 }
mesh = { size = "5 mm", structured = true }

[body.ball]
material = "rock"
shape.sphere = { centre = [0.1, 0.2, 0.3], radius = 0.05 }
points = { mesh = "tetrahedra", size = 0.01, order = 2, per_element = 1 }
mesh = { size = 0.01 }

[body.rock]
material = "rock"
shape.surface = "mesh/rock.stl"

[body.frame]
material = "rock"
file = "mesh/frame.msh"
group = "core"
points = { per_element = 27 }

[body.part]
material = "rock"
points = { per_direction = 3, placement = "uniform" }

[body.part.shape]
difference = [
  { extrusion = { polygon = [[0, 0], [0.4, 0], ["10 cm", 0.3]], from = -0.1, to = "20 cm" } },
  { union = [
    { box = { min = [0.1, 0.1, -0.2], max = [0.2, 0.2, 0.3] } },
    { sphere = { centre = [0, 0, 0], radius = 0.01 } },
  ] },
]

[body.platen]
rigid = true
shape.box = { min = [-0.05, -0.05, 0.05], max = [0.05, 0.05, 0.06] }
displacement = [0.0, "1 mm", "-0.1 mm"]

[boundary.base]
where.box = { min = [-1, -1, -0.06], max = [1, 1, -0.04] }
ux = 0.0
uz = "-2 mm"

[boundary.side]
where.group = "side"
uy = 0.0

[pin.centre]
body = "core"
at = [0.0, 0.0, 0.01]
fix = "xz"

[pressure.mantle]
body = "core"
where.sector = { centre = [0, 0], from = 10, to = 20 }
value = "1 MPa"

[contact.top]
body = "core"
rigid = "platen"
kind = "shared_nodes"

[solver]
linear = "iterative"
linear_tolerance = 1e-9

[checkpoint]
every_steps = 5
every_minutes = 2.5

[parallel]
rebalance = 1.5

[output]
nominal = { load = "platen", displacement = "platen", direction = [0, 0, -2] }

[gauge.height]
from = [0, 0, -0.05]
to = [0, 0, "5 cm"]

[probe.middle]
at = [0.0, 0.0, 0.01]
quantity = "stress_zx"

[probe.top]
at = [0.0, 0.0, 0.04]
quantity = "displacement_z"
)";

/// A cylinder of clay turned about the y axis, pressed from above.
inline const std::string axisymmetric_case = R"([grid]
cell_size = 0.1
cells = [6, 12]

[material.clay]
law = "linear_elastic"
density = 1900.0
youngs_modulus = 1e7
poisson_ratio = 0.3

[body.specimen]
material = "clay"
shape.box = { min = [0.0, 0.0], max = [0.5, 1.0] }

[probe.hoop]
at = [0.25, 0.5]
quantity = "strain_zz"

[model]
plane = "axisymmetric"
)";

}  // namespace berm
