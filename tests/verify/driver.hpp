#pragma once
/// Runs a case inside a test through the whole program: reader, world, quasi-static step.

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "case/read_case.hpp"
#include "sim/implicit_step.hpp"
#include "sim/step_control.hpp"
#include "sim/world.hpp"

namespace berm::verify {

/// The case written in `text`, with overrides as on the command line. What it does not say of the way it is computed is
/// what these tests are about unless they say otherwise: linear functions, updated Lagrangian, each point's own strain.
Case case_of(const std::string& text, const std::vector<std::string>& overrides = {});
/// The same, computed as a case is by default.
Case case_by_default(const std::string& text, const std::vector<std::string>& overrides = {});

/// Path of a scratch file of this process.
std::string scratch_file(const std::string& name);

/// A world with its step driver.
struct Model {
  explicit Model(Case spec) : world(build_world(std::move(spec))), step(*world) {}
  explicit Model(const std::string& text, const std::vector<std::string>& overrides = {})
      : Model(case_of(text, overrides)) {}

  const MaterialState& material() const { return world->discretisation->material; }
  /// Displacement of the far end of a gauge [m].
  Vec3 gauge_end(int gauge = 0) const { return world->boundary->gauges()[gauge].to.u; }

  /// One step; fails the test if it does not converge.
  StepResult advance(double dt);
  /// All the steps of the case, cut and grown as in a run; `after` is called after each. False if no equilibrium was
  /// found with the smallest step.
  bool run(const std::function<void(const StepResult&)>& after = {});
  /// The steps of the present stage.
  bool run_stage(const std::function<void(const StepResult&)>& after = {});

  std::unique_ptr<World> world;
  ImplicitStep step;
};

/// Takes all `steps` of a run. Orders of Newton's method seen in the last three residuals of every damaging step that are
/// in the quadratic range: small already, but above the rounding of strains of 1e-4 next to deformation gradients of 1.
std::vector<double> newton_orders(Model& model, int steps);

/// |a - b| / |b|.
inline double relative(double a, double b) { return std::abs(a - b) / std::abs(b); }

/// Over the points, in L2, relative.
struct FieldErrors {
  double displacement, stress;
};
/// Against exact fields of the places at the start.
FieldErrors field_errors(const Model& model, const std::function<Vec3(const Vec3& X)>& displacement,
                         const std::function<Voigt(const Vec3& X)>& stress);

/// A row of docs/verification.md; written to the file named by BERM_VERIFICATION_RECORD, if it is set, and to the
/// test's properties.
struct Row {
  std::string group, quantity;
  double reached = 0.0;
  std::string reference;  ///< value it should have
  std::string tolerance;  ///< what the test demands, or "reported"
  std::string source;     ///< where the reference is from
};
void record(const Row& row);

}  // namespace berm::verify
