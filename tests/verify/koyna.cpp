/// Natural frequencies of the Koyna dam: V18.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

using std::numbers::pi;

/// A short kick: the velocity of the crest.
const std::string koyna = R"toml(
[model]
plane = "stress"
kinematics = "small"
[grid]
origin = [0.0, 0.0]
cell_size = 3.5
cells = [20, 30]
[material.concrete]
law = "linear_elastic"
youngs_modulus = 31.027e9
poisson_ratio = 0.2
density = 2643
[body.dam]
material = "concrete"
shape.polygon = [[0.0, 0.0], [70.0, 0.0], [19.25, 66.5], [14.8, 103.0], [0.0, 103.0]]
velocity = ["if_crest", 0.0]
[boundary.base]
where = { box = { max = [1000.0, 0.001] } }
ux = 0.0
uy = 0.0
[steps]
analysis = "dynamic"
duration = 8.0
count = 3200
adaptive = false
)toml";

/// Frequency of the largest Fourier component between two bounds [rad/s], with a Hann window.
double peak_frequency(const std::vector<double>& signal, double dt, double from, double to) {
  const std::size_t n = signal.size();
  const auto power = [&](double omega) {
    std::complex<double> sum = 0.0;
    for (std::size_t k = 0; k < n; ++k)
      sum += signal[k] * (1.0 - std::cos(2.0 * pi * double(k) / double(n))) *
             std::polar(1.0, -omega * dt * double(k));
    return std::norm(sum);
  };
  double best = from, highest = 0.0;
  for (double step = (to - from) / 100.0, a = from, b = to; step > 1e-4; step *= 0.1) {
    for (double omega = a; omega <= b; omega += step)
      if (const double p = power(omega); p > highest) {
        highest = p;
        best = omega;
      }
    a = best - step;
    b = best + step;
  }
  return best;
}

struct Frequencies {
  double first, second;
};

Frequencies frequencies_of(const std::vector<std::string>& overrides) {
  std::string text = koyna;
  text.replace(text.find("if_crest"), 8, "y > 80 ? 0.1 : 0");
  Model model(text, overrides);
  const double dt = model.world->present_stage().steps.duration / model.world->present_stage().steps.count;
  // The crest's displacement by the point nearest to it.
  const Discretisation& d = *model.world->discretisation;
  const auto x = d.point_origins();
  std::size_t crest = 0;
  for (std::size_t p = 0; p < x.size(); ++p)
    if ((x[p] - Vec3(7.4, 103.0, 0.0)).norm() < (x[crest] - Vec3(7.4, 103.0, 0.0)).norm()) crest = p;
  std::vector<double> signal;
  EXPECT_TRUE(model.run([&](const StepResult&) { signal.push_back(d.point_displacements()[crest].x()); }));
  // What Newmark's relations make of a frequency (dynamics (16)): omega dt / 2 becomes its arctangent.
  const auto of_continuous_time = [&](double omega) { return 2.0 / dt * std::tan(0.5 * omega * dt); };
  return {of_continuous_time(peak_frequency(signal, dt, 14.0, 24.0)),
          of_continuous_time(peak_frequency(signal, dt, 40.0, 60.0))};
}

void check(const std::string& method, const Frequencies& f, double tolerance) {
  EXPECT_NEAR(f.first, 18.91, tolerance * 18.91) << method;
  EXPECT_NEAR(f.second, 50.20, tolerance * 50.20) << method;
  const std::string source = "converged FEM, plane stress; published 18.86, 49.97 (FEM), 19.27, 51.50 (Chopra)";
  const std::string text = fmt::format("{:g} %", 100.0 * tolerance);
  record({"Koyna dam (V18)", "first natural frequency, " + method + " [rad/s]", f.first, "18.91", text, source});
  record({"Koyna dam (V18)", "second natural frequency, " + method + " [rad/s]", f.second, "50.20", text, source});
}

TEST(Koyna, FrequenciesOfMpm) { check("MPM, h = 3.5 m", frequencies_of({}), 0.01); }

TEST(Koyna, FrequenciesOfFem) {
  check("FEM, quadratic triangles",
        frequencies_of({"method=\"fem\"", "body.dam.mesh={kind=\"triangles\",size=10.0,order=2}",
                        "dynamics.mass=\"consistent\""}),
        0.01);
}

}  // namespace
}  // namespace berm::verify
