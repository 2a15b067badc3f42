/// What is noticed while a run goes on, and steps in which nothing happens. [docs/checks.md]

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/error.hpp"
#include "driver.hpp"
#include "sim/run.hpp"
#include "sim/watch.hpp"

namespace berm::verify {
namespace {

const std::string soft = R"(
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e6
poisson_ratio = 0.3
)";

const std::string block = R"(
grid = { origin = [-0.2, 0.0], cell_size = 0.1, cells = [14, 16] }
)" + soft + R"([body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }
mesh = { kind = "quads", size = 0.1, structured = true }
[boundary.base]
where.box = { min = [-9.0, -9.0], max = [9.0, 1e-6] }
ux = 0.0
uy = 0.0
)";

/// A plate pressed in through a contact as soft as butter: material gets into it.
const std::string soft_contact = block + R"(
[body.plate]
rigid = true
shape.box = { min = [-0.1, 1.0], max = [1.1, 1.4] }
displacement = [0.0, "-0.3*t"]
[contact.c]
body = "b"
rigid = "plate"
kind = "frictionless"
stiffness = 0.05
[steps]
count = 30
)";

struct Told {
  std::vector<std::string> warnings;
  Watched seen;
  std::string error;
};
Told run_watched(const std::string& text, const std::vector<std::string>& overrides = {}) {
  Told told;
  Model m(case_of(text, overrides));
  Watch watch(*m.world, [&](const std::string& warning) { told.warnings.push_back(warning); });
  int n = 0;
  try {
    EXPECT_TRUE(m.run([&](const StepResult&) { watch.look(m.step, ++n); }));
    watch.look_last();
  } catch (const RunError& error) {
    told.error = error.what();
  }
  told.seen = watch.seen;
  return told;
}

TEST(Watch, MaterialInARigidBody) {
  const Told told = run_watched(soft_contact);
  ASSERT_GE(told.warnings.size(), 1u);
  EXPECT_NE(told.warnings[0].find("deep inside of rigid body \"plate\""), std::string::npos) << told.warnings[0];
  EXPECT_NE(told.error.find("shared_nodes"), std::string::npos) << told.error;
  EXPECT_GT(told.seen.penetration, 0.1);  // a cell
  // The remedy is accepted, and the default does not need it.
  const auto shared = case_of(soft_contact, {"contact.c={body=\"b\",rigid=\"plate\",kind=\"shared_nodes\"}"});
  EXPECT_NO_THROW(build_world(shared));
  const Told hard = run_watched(soft_contact, {"contact.c.stiffness=1000.0", "body.plate.displacement=[0.0,\"-0.1*t\"]"});
  EXPECT_EQ(hard.error, "");
  EXPECT_TRUE(hard.warnings.empty()) << hard.warnings[0];
  EXPECT_LT(hard.seen.penetration, 0.01);
}

/// Depth by hand: points are seen in small strain too, where they stay in their places of the grid, and beside a moved body.
TEST(Watch, DepthInSmallStrain) {
  const Told told = run_watched(soft_contact, {"model.kinematics=small", "body.plate.displacement=[0.0,\"-0.1*t\"]"});
  Model m(case_of(soft_contact, {"model.kinematics=small", "body.plate.displacement=[0.0,\"-0.1*t\"]"}));
  ASSERT_TRUE(m.run());
  double deepest = 0.0;
  const auto X = m.world->discretisation->point_origins(), u = m.world->discretisation->point_displacements();
  for (std::size_t p = 0; p < X.size(); ++p) deepest = std::max(deepest, (X[p] + u[p]).y() - 0.9);
  EXPECT_GT(deepest, 0.0);
  EXPECT_NEAR(told.seen.penetration, deepest, 1e-9);
}

const std::string dilating = R"(
model = { plane = "strain" }
grid = { origin = [0.0, 0.0], cell_size = 0.5, cells = [2, 4] }
[material.m]
law = "mohr_coulomb"
density = 2000.0
youngs_modulus = 1e7
poisson_ratio = 0.3
cohesion = 1e3
friction_angle = 35.0
dilatancy_angle = 30.0
[body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [0.5, 1.0] }
[boundary.base]
where.box = { max = [9.0, 1e-6] }
uy = 0.0
[boundary.left]
where.box = { max = [1e-6, 9.0] }
ux = 0.0
[boundary.top]
body = "b"
where.box = { min = [-9.0, 0.999] }
uy = "-0.3*t"
[steps]
count = 30
)";

TEST(Watch, SoilThatSwellsWithoutEnd) {
  const Told told = run_watched(dilating);
  ASSERT_EQ(told.warnings.size(), 1u);
  EXPECT_NE(told.warnings[0].find("residual_dilatancy_angle"), std::string::npos) << told.warnings[0];
  EXPECT_GT(told.seen.swelling, 1.1);
  const Told ends = run_watched(dilating, {"material.m.residual_dilatancy_angle=0.0", "material.m.softening_end=0.05"});
  EXPECT_TRUE(ends.warnings.empty()) << ends.warnings[0];
}

TEST(Watch, ReactionsThatJump) {
  Model m(case_of(soft_contact));
  // Forces of the plate as they come in ten steps each: growing, then as said.
  const auto jumps = [&](const std::vector<double>& then) {
    Watch watch(*m.world, [](const std::string&) {});
    Reactions forces{std::vector<Vec3>(2, Vec3::Zero()), {}, {}};
    double time = 0.0;
    const auto next = [&](double force) {
      forces.rigid[1].y() = force;
      watch.look_for_jumps(forces, time += 0.02);
    };
    for (int k = 1; k <= 10; ++k) next(-100.0 * k);
    for (const double force : then) next(force);
    return watch.seen.jumps;
  };
  EXPECT_EQ(jumps({-1100.0, -1200.0}), 0.0);
  EXPECT_EQ(jumps({-1010.0, -1015.0, -1016.0}), 0.0);          // yields
  EXPECT_EQ(jumps({-1010.0, -1015.0, -800.0, -805.0}), 1.0);   // loses a fifth
  EXPECT_EQ(jumps({-1010.0, -1015.0, -0.0, -1015.0}), 1.0);    // lets go; touching again is no jump of its own
  // The same fall while a pressure grows has another cause.
  Model loaded(case_of(soft_contact + "[pressure.p]\nbody = \"b\"\nwhere.box = { max = [1e-6, 9.0] }\nvalue = \"1e3*t\"\n"));
  Watch watch(*loaded.world, [](const std::string&) {});
  Reactions forces{std::vector<Vec3>(2, Vec3::Zero()), {}, {}};
  double time = 0.0;
  for (const double force : {-100.0, -200.0, -300.0, -400.0, -405.0, -300.0}) {
    forces.rigid[1].y() = force;
    watch.look_for_jumps(forces, time += 0.02);
  }
  EXPECT_EQ(watch.seen.jumps, 0.0);
  // After a restart what is there counts, not zero.
  Watch again(*m.world, [](const std::string&) {});
  forces.rigid[1].y() = -1000.0;
  again.resume({}, forces);
  for (const double force : {-1010.0, -1020.0, -1030.0}) {
    forces.rigid[1].y() = force;
    again.look_for_jumps(forces, time += 0.02);
  }
  EXPECT_EQ(again.seen.jumps, 0.0);
  const Told smooth = run_watched(soft_contact, {"contact.c.stiffness=1000.0", "body.plate.displacement=[0.0,\"-0.05*t\"]"});
  EXPECT_EQ(smooth.seen.jumps, 0.0);
}

/// What is seen at the very end is in the summary too.
TEST(Watch, MetricsOfAShortRun) {
  const std::filesystem::path folder = scratch_file("swells");
  run_case(case_of(dilating, {"steps.count=15", "grid.cells=[6,6]"}), {.folder = folder, .quiet = true, .restart = {}});
  std::ifstream in(folder / "summary.json");
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  EXPECT_NE(text.find("\"swelling [-]\": "), std::string::npos) << text;
}

/// A stage in which nothing changes moves nothing; one in which a support goes does.
TEST(Watch, LargeMotionInSmallStrain) {
  const std::string beam = R"toml(
model.kinematics = "small"
grid = { origin = [-0.2, -3.0], cell_size = 0.1, cells = [26, 40] }
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e6
poisson_ratio = 0.0
[body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [2.0, 0.4] }
[boundary.wall]
where.box.max = [1e-6, 9.0]
ux = 0.0
uy = 0.0
[pressure.p]
body = "b"
where.box.min = [-9.0, 0.3999]
value = "1e3*t"
[steps]
count = 2
)toml";
  const auto said = [&](const std::vector<std::string>& overrides) {
    Model m(case_by_default(beam, overrides));
    std::string text;
    Watch watch(*m.world, [&](const std::string& warning) { text += warning; });
    EXPECT_TRUE(m.run());
    watch.look_last();
    return text;
  };
  EXPECT_NE(said({}).find("kinematics = \"finite\""), std::string::npos);
  EXPECT_EQ(said({"model.kinematics=\"finite\""}), "");
  EXPECT_EQ(said({"pressure.p.value=\"50*t\""}), "");
}

TEST(AtRest, NothingMovesWhereNothingChanges) {
  const std::string text = R"toml(
[stage.load]
analysis = "quasi_static"
count = 4
[stage.rest]
analysis = "quasi_static"
count = 3
[pressure.top]
body = "b"
where.box = { min = [-9.0, 0.9999], max = [9.0, 9.0] }
value = "1e4*min(t, 1)"
[boundary.side]
where.box = { min = [-9.0, -9.0], max = [1e-6, 9.0] }
ux = 0.0
)toml";
  for (const char* method : {"mpm", "fem"})
    for (const bool lets_go : {false, true}) {
      std::vector<std::string> overrides = {fmt::format("method=\"{}\"", method)};
      if (lets_go) overrides.push_back("boundary.side.stages=[\"load\"]");
      Model m(case_by_default(block + text, overrides));
      ASSERT_TRUE(m.run_stage());
      const std::vector<Vec3> before = m.world->discretisation->point_positions();
      ++m.world->stage;
      m.step.begin_stage();
      int iterations = 0;
      ASSERT_TRUE(m.run_stage([&](const StepResult& r) { iterations += r.iterations; }));
      double moved = 0.0;
      const std::vector<Vec3> after = m.world->discretisation->point_positions();
      for (std::size_t p = 0; p < before.size(); ++p) moved = std::max(moved, (after[p] - before[p]).norm());
      if (lets_go) {
        EXPECT_GT(moved, 1e-5) << method;
      } else {
        EXPECT_EQ(iterations, 0) << method;
        EXPECT_EQ(moved, 0.0) << method;
      }
    }
}

/// Loads that go on, however slowly, are no rest.
TEST(AtRest, SlowLoadsAreFollowed) {
  Model m(case_of(block + "[steps]\ncount = 10\n[boundary.top]\nwhere.box = { min = [-9.0, 0.9999], max = [9.0, 9.0] }\nuy = \"-1e-3*min(t, 0.5) - 1e-9*t\"\n"));
  const double before = -5e-4;
  ASSERT_TRUE(m.run([&](const StepResult& r) { EXPECT_EQ(r.at_rest, 0.0); }));
  double top = 0.0;
  const auto X = m.world->discretisation->point_origins(), u = m.world->discretisation->point_displacements();
  for (std::size_t p = 0; p < X.size(); ++p) top = std::min(top, u[p].y() / X[p].y());
  EXPECT_LT(top, before - 0.9e-9);
}

/// A prescribed displacement that is there at t = 0 comes with the first step.
TEST(Start, ConstantDisplacementCounts) {
  for (const char* where : {"", "body = \"b\"\n"}) {
    const std::string top = fmt::format("[steps]\ncount = 2\n[boundary.top]\n{}where.box = {{ min = [-9.0, 0.9999], max = [9.0, 9.0] }}\nuy = ", where);
    Model constant(case_of(block + top + "\"-0.001 + 0.0*t\"\n")), number(case_of(block + top + "-0.001\n"));
    ASSERT_TRUE(constant.run() && number.run());
    EXPECT_NEAR(constant.step.balance().reactions.boundary[1].y(), number.step.balance().reactions.boundary[1].y(), 1e-3 * std::abs(number.step.balance().reactions.boundary[1].y()));
    EXPECT_LT(number.step.balance().reactions.boundary[1].y(), -500.0);
  }
}

TEST(Start, RigidBodyThatIsDisplacedFromTheStart) {
  const std::string text = soft_contact;
  Model constant(case_of(text, {"body.plate.displacement=[0.0,\"-0.01 + 0.0*t\"]", "contact.c.stiffness=100.0"})),
      number(case_of(text, {"body.plate.displacement=[0.0,-0.01]", "contact.c.stiffness=100.0"}));
  ASSERT_TRUE(constant.run() && number.run());
  const double right = number.step.balance().reactions.rigid[1].y();
  EXPECT_LT(right, -5000.0);
  EXPECT_NEAR(constant.step.balance().reactions.rigid[1].y(), right, 0.01 * std::abs(right));
}

// Far from the origin.

std::string shifted(double x, double y, const std::string& method) {
  const auto pair = [&](double a, double b) { return fmt::format("[{:.17g}, {:.17g}]", x + a, y + b); };
  return fmt::format("method = \"{}\"\nmodel = {{ kinematics = \"finite\", gravity = [0.0, \"-9.81*t*(1 + 0*t)\"] }}\n", method) +
         "grid = { origin = " + pair(-0.015, -0.005) + ", cell_size = 0.005, cells = [26, 26] }\n" + soft + R"([body.b]
material = "m"
mesh = { kind = "triangles", size = 0.01 }
shape.difference = [ { polygon = [)" +
         pair(0, 0) + ", " + pair(0.1, 0) + ", " + pair(0.1, 0.1) + ", " + pair(0, 0.08) + "] }, { disc = { centre = " + pair(0.05, 0.04) +
         ", radius = 0.02 } } ]\n[boundary.base]\nwhere.box.max = " + pair(1, 1e-6) + "\nux = 0.0\nuy = 0.0\n[boundary.side]\nwhere.box.min = " +
         pair(0.0999, 0.011) + fmt::format("\nux = \"1e-2*t*(x - {:.17g}) + 1e-2*t*(y - {:.17g})\"\n", x, y) +
         "[pressure.top]\nbody = \"b\"\nwhere.beyond = { at = " + pair(0, 0.0799) + ", normal = [-0.2, 1.0] }\nvalue = \"1e4*t\"\n" +
         "[pin.p]\nbody = \"b\"\nat = " + pair(0.02, 0.06) + "\nfix = \"x\"\n[probe.p]\nat = " + pair(0.08, 0.07) +
         "\nquantity = \"stress_yy\"\n[gauge.g]\nfrom = " + pair(0.02, 0.02) + "\nto = " + pair(0.02, 0.06) + "\n[steps]\ncount = 4\n";
}

/// Bodies from STL files are moved like all others.
TEST(FarFromTheOrigin, SurfacesFromFiles) {
  const std::string file = scratch_file("cube.stl");
  const auto cube = [&](double x, double y) {
    std::ofstream out(file);
    out.precision(17);
    out << "solid cube\n";
    const auto corner = [&](int k) { return Vec3(x + 0.4 * (k & 1), y + 0.4 * (k >> 1 & 1), 0.4 * (k >> 2 & 1)); };
    for (const auto& [a, b, c, d] : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
      for (const auto& t : {std::array{a, b, c}, std::array{a, c, d}}) {
        out << "facet normal 0 0 0\nouter loop\n";
        for (const int k : t) out << "vertex " << corner(k).x() << ' ' << corner(k).y() << ' ' << corner(k).z() << '\n';
        out << "endloop\nendfacet\n";
      }
    out << "endsolid cube\n";
  };
  for (const double far : {0.0, 5e5}) {
    cube(far, 2.0 * far);
    const auto w = build_world(case_of(fmt::format("model.dimension = 3\ngrid = {{ kind = \"hexahedra\", origin = [{0}, {1}, -0.1], cell_size = 0.1, cells = [6, 6, 6] "
                                                   "}}\n{3}[body.b]\nmaterial = \"m\"\nshape.surface = \"{2}\"\n[steps]\ncount = 1\n",
                                                   far - 0.1, 2.0 * far - 0.1, file, soft)));
    EXPECT_NEAR(w->bodies[0].measure, 0.064, 1e-9) << far;
    EXPECT_EQ(w->bodies[0].points, 512) << far;
  }
}

std::vector<std::vector<double>> history(const std::filesystem::path& folder) {
  std::ifstream in(folder / "history.csv");
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::stringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::atof(cell.c_str()));
  }
  return rows;
}

TEST(FarFromTheOrigin, AnswersAreThoseAtTheOrigin) {
  for (const std::string method : {"mpm", "fem"}) {
    std::vector<std::vector<std::vector<double>>> rows;
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {5e5, 5.4e6}}) {
      const std::filesystem::path folder = scratch_file(fmt::format("far_{}_{}", method, x > 0.0));
      run_case(case_of(shifted(x, y, method)), {.folder = folder, .quiet = true, .restart = {}});
      rows.push_back(history(folder));
      if (x == 0.0) continue;
      // Messages and files have the user's coordinates.
      try {
        build_world(case_of(shifted(x, y, method), {fmt::format("probe.p.at=[{}, {}]", x + 9.0, y + 9.0)}));
        ADD_FAILURE() << "a probe far from the body";
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("(500009, 5400009)"), std::string::npos) << error.what();
      }
    }
    ASSERT_EQ(rows[0].size(), rows[1].size());
    for (std::size_t k = 0; k < rows[0].size(); ++k)
      for (std::size_t i = 0; i < rows[0][k].size(); ++i) {
        if (i >= 11 && i <= 15) continue;  // errors and iterations, which are rounding themselves
        double scale = 1e-12;
        for (const auto& row : rows[0]) scale = std::max(scale, std::abs(row[i]));
        EXPECT_NEAR(rows[0][k][i], rows[1][k][i], 1e-5 * scale) << method << " column " << i;  // places of the file have 1e-9 m
      }
  }
}

}  // namespace
}  // namespace berm::verify
