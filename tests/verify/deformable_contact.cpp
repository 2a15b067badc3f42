/// Contact between deformable bodies: touches where bodies touch, in every kinematics, pulls nothing back, and heats only
/// what slides.

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "driver.hpp"
#include "sim/meeting.hpp"
#include "transfer/mpm.hpp"

namespace berm::verify {
namespace {

/// A block on or above another one of the same width, held at its base.
std::string two_blocks(double distance, double cell, const std::string& model, const std::string& top,
                       const std::string& steps) {
  return fmt::format(R"toml(
method = "mpm"
model = {{ plane = "stress", {3} }}
grid = {{ origin = [{0}, 0.0], cell_size = {1}, cells = [{2}, {4}] }}
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e6
poisson_ratio = 0.0
[body.low]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [1.0, 1.0] }}
[body.up]
material = "m"
shape.box = {{ min = [0.0, {5}], max = [1.0, {6}] }}
[boundary.base]
where.box = {{ max = [1e3, 1e-6] }}
ux = 0.0
uy = 0.0
[contact.c]
body = "up"
other = "low"
kind = "frictionless"
)toml",
                     -cell, cell, static_cast<int>(1.0 / cell) + 2, model, static_cast<int>(3.0 / cell), 1.0 + distance,
                     2.0 + distance) +
         top + steps;
}

std::string moved_top(double distance, const std::string& motion) {
  return fmt::format("[boundary.top]\nbody = \"up\"\nwhere.box = {{ min = [-1.0, {}] }}\nux = 0.0\nuy = \"{}\"\n",
                     1.999 + distance, motion);
}

double base_force(const Model& m) { return m.step.balance().reactions.boundary[0].y(); }

/// Hencky's law, each block shortened by half of what the motion leaves after the gap: force per width.
double force_of_blocks(double shortening) { return -1e6 * std::log(1.0 - 0.5 * shortening) / (1.0 - 0.5 * shortening); }

/// Gaps came from positions that small strain never moves: the blocks passed through each other.
TEST(DeformableContact, BlocksMeetWhereTheGridDoesNotMove) {
  struct Of { std::string model; double right; };
  for (const Of& of : {Of{"kinematics = \"small\"", 50e3}, Of{"formulation = \"total_lagrangian\"", force_of_blocks(0.1)}}) {
    Model m(two_blocks(0.02, 0.25, of.model, moved_top(0.02, "-0.12*t"), "[steps]\ncount = 10\n"));
    ASSERT_TRUE(m.run());
    EXPECT_NEAR(base_force(m), of.right, 0.05 * of.right) << of.model;
  }
}

TEST(DeformableContact, BlocksThatStartApartMeet) {
  Model m(case_by_default(two_blocks(0.15, 0.25, "kinematics = \"finite\"", moved_top(0.15, "-0.3*t"), "[steps]\ncount = 10\n")));
  ASSERT_TRUE(m.run());
  const double right = force_of_blocks(0.15);
  record({"Contact on the grid", "blocks 0.6 cell apart pushed together [N/m]", base_force(m), "-E ln(l)/l", "3 %", "closed form"});
  EXPECT_NEAR(base_force(m), right, 0.03 * right);
}

/// Those that start more than a tenth of a cell apart pressed on nodes of cells that are cut (59 kN in the place of 75), or never
/// met, where the grid sees them where they start.
TEST(DeformableContact, BodiesApartAreRefusedWhereTheGridDoesNotMove) {
  for (const double cell : {0.05, 0.25})
    for (const std::string model : {"kinematics = \"small\"", "formulation = \"total_lagrangian\""})
      EXPECT_THROW(Model(two_blocks(0.15, cell, model, moved_top(0.15, "-0.1*t"), "[steps]\ncount = 1\n")), InputError);
  EXPECT_NO_THROW(Model(two_blocks(0.15, 0.05, "kinematics = \"finite\"", moved_top(0.15, "-0.1*t"), "[steps]\ncount = 1\n")));
}

/// Blocks that had been parted pushed each other as soon as they came back.
TEST(DeformableContact, PartedBlocksComeBackWithoutForce) {
  for (const std::string model : {"kinematics = \"small\"", "kinematics = \"finite\""}) {
    Model m(two_blocks(0.0, 0.125, model, moved_top(0.0, "0.04*min(t,1-t)"), "[steps]\ncount = 20\n"));
    double largest = 0.0;
    ASSERT_TRUE(m.run([&](const StepResult&) { largest = std::max(largest, std::abs(base_force(m))); }));
    EXPECT_LT(largest, 50.0) << model;  // half a percent of what 2 cm of closing cost
  }
}

/// Bodies touched a quarter of a cell early.
TEST(DeformableContact, BlocksTouchWhereTheyAre) {
  Model m(two_blocks(0.05, 0.125, "kinematics = \"finite\"", moved_top(0.05, "-0.048*t"), "[steps]\ncount = 8\n"));
  ASSERT_TRUE(m.run());
  EXPECT_LT(std::abs(base_force(m)), 1.0);
}

/// The energy of the penalty of a block that is laid on another one was called heat of sliding.
TEST(DeformableContact, NothingSlidesNothingHeats) {
  Model m(two_blocks(0.0, 0.25, "gravity = [0.0, \"-9.81*t\"]", "",
                     "[steps]\nanalysis = \"dynamic\"\nduration = 0.5\ncount = 50\n"),
          {"contact.c.kind=friction", "contact.c.friction=0.5"});
  ASSERT_TRUE(m.run());
  const Balance& balance = m.step.balance();
  EXPECT_GT(balance.contact_work, 0.0);
  EXPECT_LT(std::abs(balance.friction_work), 1e-3 * balance.external_work);
}

/// A block on a longer one is pushed sideways by its end. Normals that are slanted where the end of the block is made it climb.
std::string dragged(double border) {
  return fmt::format(R"toml(
model.gravity = [0.0, -10.0]
grid = {{ origin = [-0.25, 0.0], cell_size = 0.125, cells = [22, 12] }}
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = "2 GPa"
poisson_ratio = 0.3
[body.base]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [2.0, {0}] }}
[body.block]
material = "m"
shape.box = {{ min = [0.27, {0}], max = [1.02, 1.0] }}
[boundary.floor]
where.box.max = [9.0, 1e-6]
ux = 0.0
uy = 0.0
[boundary.push]
body = "block"
where.box = {{ max = [0.2701, 2.0], min = [0.0, 0.7] }}
ux = "0.3*max(t - 1, 0)"
[contact.c]
body = "block"
other = "base"
kind = "frictionless"
[stage.weight]
count = 2
[stage.pull]
count = 30
)toml",
                     border);
}

TEST(DeformableContact, BlockIsDraggedByItsFriction) {
  for (const double border : {0.5, 0.53})
    for (const std::string shape : {"", "linear", "cpdi"}) {
      const double weight = 0.75 * (1.0 - border) * 1000.0 * 10.0;
      for (const double mu : {0.0, 0.3}) {
        std::vector<std::string> sets;
        if (!shape.empty()) sets.push_back("grid.shape_functions=" + shape);
        if (mu > 0.0) sets.insert(sets.end(), {"contact.c.kind=friction", fmt::format("contact.c.friction={}", mu)});
        Model m(case_by_default(dragged(border), sets));
        double largest = 0.0, smallest = 1e9;
        ASSERT_TRUE(m.run([&](const StepResult&) {
          const double force = m.step.balance().reactions.boundary[1].x();
          if (m.world->time < 1.3) return;
          largest = std::max(largest, force);
          smallest = std::min(smallest, force);
        }));
        EXPECT_LT(largest, (mu + 0.01) * weight) << border << shape;
        EXPECT_GT(smallest, (mu - 0.01) * weight) << border << shape;
        if (shape.empty() && mu > 0.0)
          record({"Contact on the grid", fmt::format("force that drags a block over another, border at {} m, cells of 0.125 m [N]", border),
                  largest, fmt::format("{:g}", mu * weight), "1 %", "Coulomb"});
      }
    }
}

/// Weight and shear come at once: bodies that have not borne anything stick all the same. A column of two blocks is one beam.
TEST(DeformableContact, BlocksStickFromTheFirstStepOn) {
  const std::string text = R"toml(
model.kinematics = "small"
grid = { origin = [-0.2, -0.2], cell_size = 0.1, cells = [16, 24] }
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = "1 MPa"
poisson_ratio = 0.0
[body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }
[body.c]
material = "m"
shape.box = { min = [0.0, 1.0], max = [1.0, 2.0] }
[contact.t]
body = "b"
other = "c"
kind = "friction"
friction = 0.5
[boundary.base]
where.box.max = [9.0, 1e-6]
ux = 0.0
uy = 0.0
[pressure.p]
body = "c"
where.box.min = [-9.0, 1.9999]
traction = ["1e3*t", "-1e4*t"]
[gauge.top]
from = [0.5, 0.1]
to = [0.5, 2.0]
[steps]
count = 5
)toml";
  Model m(case_by_default(text));
  ASSERT_TRUE(m.run());
  // Timoshenko's cantilever: F l^3 / 3 E I + F l / kappa G A.
  const double force = 1e3, length = 2.0, sway = force * std::pow(length, 3) / (3.0 * 1e6 / 12.0) + force * length / (5.0 / 6.0 * 0.5e6);
  EXPECT_LT(relative(m.gauge_end().x(), sway), 0.015);
  record({"Contact on the grid", "sway of two blocks on each other, weight and shear at once [mm]", 1e3 * m.gauge_end().x(), fmt::format("{:.3g}", 1e3 * sway),
          "1.5 %", "Timoshenko's cantilever"});
  // Beyond Coulomb's limit nothing holds the upper one.
  Model slides(case_by_default(text, {"contact.t.friction=0.09"}));
  EXPECT_FALSE(slides.run());
}

/// Friction at 0.6 of its limit, and at the limit beside an edge of the blocks: after the first step no equilibrium was found.
TEST(DeformableContact, BlocksDrawnSidewaysStandInAnyNumberOfSteps) {
  const std::string text = R"toml(
model = { kinematics = "finite", gravity = ["0.3*9.81*t", "-9.81*t"] }
grid = { origin = [-0.4, -0.2], cell_size = 0.1, cells = [30, 26] }
[material.m]
law = "linear_elastic"
density = 2000.0
youngs_modulus = 1e8
poisson_ratio = 0.2
[body.a]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }
[body.b]
material = "m"
shape.box = { min = [0.0, 1.0], max = [1.0, 2.0] }
[contact.c]
body = "a"
other = "b"
kind = "friction"
friction = 0.5
[boundary.base]
where.box = { max = [9.0, 1e-6] }
ux = 0.0
uy = 0.0
[gauge.top]
from = [0.5, 0.1]
to = [0.5, 2.0]
)toml";
  double sway = 0.0;
  for (const int count : {1, 2, 5, 20}) {
    Model m(case_by_default(text, {fmt::format("steps.count={}", count)}));
    ASSERT_TRUE(m.run()) << count;
    EXPECT_LT(relative(-m.step.balance().reactions.boundary[0].x(), 0.3 * 9.81 * 4000.0), 1e-6) << count;
    if (count == 1) sway = m.gauge_end().x();
    EXPECT_LT(relative(m.gauge_end().x(), sway), 0.02) << count;
  }
}

/// What is drawn sideways by a growing share of its weight slides where that is the coefficient of friction: it stood up to 16 % longer.
TEST(DeformableContact, FrictionEndsAtItsLimitInAnyNumberOfSteps) {
  const std::string text = R"toml(
model = { kinematics = "finite", gravity = ["6*max(0, 2*t - 1)", "-10*min(1, 2*t)"] }
grid = { origin = [-0.2, -0.2], cell_size = 0.1, cells = [23, 16] }
[material.m]
law = "linear_elastic"
density = 2000.0
youngs_modulus = 1e7
poisson_ratio = 0.2
[body.base]
material = "m"
shape.box = { min = [0.0, 0.0], max = [2.0, 0.4] }
[body.block]
material = "m"
shape.box = { min = [0.6, 0.4], max = [1.2, 1.0] }
[boundary.l]
where.box.max = [10.0, 1e-6]
ux = 0.0
uy = 0.0
[contact.c]
body = "block"
other = "base"
kind = "friction"
friction = 0.5
)toml";
  for (const int count : {4, 10, 20}) {
    Model m(case_by_default(text, {fmt::format("steps.count={}", count)}));
    EXPECT_FALSE(m.run()) << count;
    const double limit = 0.6 * (2.0 * m.world->time - 1.0);
    EXPECT_NEAR(limit, 0.5, 0.005) << count;
    if (count == 10) record({"Contact on the grid", "horizontal force over weight at which a block slides on another, 10 steps", limit, "0.5", "0.005", "Coulomb"});
  }
}

/// A square cut in two along its diagonal, steeper than nothing and rougher than need be: one body. Friction was limited by the
/// pressure of the step before: 1.50 mm with 4 steps, 1.01 with 20.
TEST(DeformableContact, WedgesThatCannotSlideAreOneBodyInAnyNumberOfSteps) {
  const std::string head = R"toml(
model = { kinematics = "small", gravity = [0.0, "-10*min(t,1)"] }
grid = { origin = [-0.5, -0.5], cell_size = 0.1, cells = [30, 30] }
[material.m]
law = "linear_elastic"
density = 2000.0
youngs_modulus = "10 MPa"
poisson_ratio = 0.3
[boundary.base]
where.box.max = [9.0, 1e-6]
ux = 0.0
uy = 0.0
[gauge.top]
from = [0.5, 0.01]
to = [0.5, 0.99]
)toml";
  const std::string whole = "[body.a]\nmaterial = \"m\"\nshape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }\n[steps]\ncount = 1\n";
  const std::string halves = R"toml(
[body.a]
material = "m"
shape.polygon = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]
[body.b]
material = "m"
shape.polygon = [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
[contact.t]
body = "a"
other = "b"
kind = "friction"
friction = 2.0
[steps]
count = 4
)toml";
  Model one(case_by_default(head + whole));
  ASSERT_TRUE(one.run());
  for (const int count : {1, 4, 20}) {
    Model m(case_by_default(head + halves, {fmt::format("steps.count={}", count)}));
    ASSERT_TRUE(m.run());
    EXPECT_LT(relative(m.gauge_end().y(), one.gauge_end().y()), 0.02) << count;
  }
}

/// Bodies that somebody lays on another leave a gap of rounding, or one that nobody sees: nothing held them in the first guess.
TEST(DeformableContact, BodiesAreLaidDownAcrossAGap) {
  const std::string text = R"toml(
model.gravity = [0.0, "-10*min(t,1)"]
grid = {{ origin = [-0.5, -0.5], cell_size = 0.1, cells = [30, 30] }}
[material.m]
law = "linear_elastic"
density = 2000.0
youngs_modulus = "10 MPa"
poisson_ratio = 0.3
[body.a]
material = "m"
shape.{}
[body.floor]
rigid = true
shape.box = {{ min = [-0.4, -0.4], max = [1.4, 0.0] }}
[contact.c]
body = "a"
rigid = "floor"
kind = "friction"
friction = 0.3
[steps]
count = 4
)toml";
  for (const double gap : {1e-11, 1e-6, 9.9e-4})
    for (const std::string& shape : {fmt::format("box = {{ min = [0.0, {0}], max = [1.0, 0.5] }}", gap),
                                     fmt::format("polygon = [[0.0, {0}], [1.0, {0}], [0.5, 0.5]]", gap)}) {
      Model m(case_by_default(fmt::format(fmt::runtime(text), shape)));
      ASSERT_TRUE(m.run()) << gap << shape;
      const double weight = m.world->bodies[0].mass * 10.0;
      EXPECT_LT(relative(m.step.balance().reactions.rigid[1].y(), weight), 1e-6) << gap << shape;
    }
}

/// Sides of a slot one and a half cells wide that close; a soft pad between stiff plates, which is in the way of what meets.
TEST(DeformableContact, SidesThatMeetAreSeen) {
  const std::string head = R"toml(
grid = { origin = [-0.4, -0.2], cell_size = 0.05, cells = [36, 32] }
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e7
poisson_ratio = 0.2
[boundary.base]
where.box = { max = [9.0, 1e-6] }
ux = 0.0
uy = 0.0
[steps]
count = 5
)toml";
  const std::string slot = R"toml(
[body.a]
material = "m"
shape.difference = [ { box = { min = [0.0, 0.0], max = [1.0, 1.0] } }, { box = { min = [0.2, 0.45], max = [2.0, 0.55] } } ]
[boundary.top]
body = "a"
where.box = { min = [0.8, 0.9999] }
uy = -0.08
)toml";
  const std::string pad = R"toml(
[material.soft]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e5
poisson_ratio = 0.2
[body.low]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 0.45] }
[body.pad]
material = "soft"
shape.box = { min = [0.0, 0.45], max = [1.0, 0.55] }
[body.high]
material = "m"
shape.box = { min = [0.0, 0.55], max = [1.0, 1.0] }
[boundary.top]
body = "high"
where.box = { min = [-9.0, 0.9999] }
ux = 0.0
uy = -0.025
)toml";
  Model closes(case_by_default(head + slot));
  ASSERT_TRUE(closes.run());
  const auto found = find_meeting(*closes.world);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->body_a, found->body_b);
  EXPECT_GT(found->closer, 0.25 * 0.05);
  EXPECT_NEAR(found->where.y(), 0.5, 0.15);
  Model presses(case_by_default(head + pad));
  ASSERT_TRUE(presses.run());
  EXPECT_FALSE(find_meeting(*presses.world));
}

/// Nothing else tells where contact does not see that bodies are in one another.
TEST(DeformableContact, BodiesInOneAnotherAreSeen) {
  const auto overlap = [](double distance) {
    // The upper block is let into the lower one by a contact that hardly resists.
    const std::string motion = fmt::format("{}*t", std::min(distance, 0.0));
    Model m(two_blocks(std::max(distance, 0.0), 0.25, "kinematics = \"small\"", moved_top(std::max(distance, 0.0), motion), "[steps]\ncount = 1\n"),
            {"contact.c.stiffness=1e-9"});
    EXPECT_TRUE(m.run());
    return dynamic_cast<const MpmDiscretisation&>(*m.world->discretisation).overlap();
  };
  EXPECT_FALSE(overlap(0.02));
  EXPECT_FALSE(overlap(0.0));
  EXPECT_FALSE(overlap(-0.1));
  const auto found = overlap(-0.5);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->body_a + found->body_b, 1);
  EXPECT_NEAR(found->fill, 2.0, 1e-3);
  EXPECT_GT(found->where.y(), 0.5);
  EXPECT_LT(found->where.y(), 1.0);
}

}  // namespace
}  // namespace berm::verify
